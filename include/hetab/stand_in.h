/* A microfacet material in place of a surface, for renderers without the model, and how far it is
 * from the model. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_microfacets { HETAB_BECKMANN, HETAB_GGX } hetab_microfacets;

/* At one incidence. */
typedef struct hetab_stand_in {
  double specular_share; /* of what the model reflects, diffuse part apart: rho_s / (dd + rho_s) */
  double error;          /* integral of |stand-in - f_dd| cos over that of f_dd cos */
  double energy;         /* the stand-in's reflectance over dd + rho_s */
} hetab_stand_in;

/* The surface's roughness in such materials: alpha = 2 sigma0 / tau, which the model tends to for
 * sigma0 far above the wavelength (Beckmann's distribution). */
double hetab_stand_in_alpha(const hetab_surface *surface);

/* out[count] at theta_i[count] in [0, pi/2): F D G / (4 cos cos) with the surface's n and k at
 * lambda_um, Smith's separable masking, as Mitsuba's roughconductor has it. On the host; the
 * integrals are good to 1 % (tests/test_stand_in.c). */
hetab_status hetab_stand_in_compare(hetab_context *ctx, const hetab_surface *surface,
                                    hetab_microfacets distribution, double lambda_um,
                                    const double *theta_i, size_t count, hetab_stand_in *out);

HETAB_END
