/* Hemispherical reflectances of a surface, each with an error estimate.
 *
 * rho_dh(theta_i, lambda) = integral over the hemisphere of f cos(theta_r) dOmega (Eq. 4), split
 * into directional-diffuse, specular and uniform-diffuse. The integrand is evaluated on the
 * engine's device, in the plane of direction cosines, polar about the mirror point. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_stop {
  HETAB_STOP_TOLERANCE, /* the error estimate is below the tolerance */
  HETAB_STOP_ROUNDOFF,  /* the arithmetic's own rounding is reached */
  HETAB_STOP_BUDGET     /* too many evaluations: value and error are the best so far */
} hetab_stop;

const char *hetab_stop_name(hetab_stop stop); /* "tolerance" */

/* A number that was integrated: |value - truth| <= error, rounding included. The estimate held in
 * every case of tests/test_reflectance.c: needles, mirrors, steep and sub-wavelength surfaces,
 * total reflection (n < 1), 0 to 89.9 degrees. At the default tolerances it is four times too large
 * or more (golden cases). */
typedef struct hetab_integral {
  double value, error;
  size_t evaluations; /* of the model */
  hetab_stop stop;
} hetab_integral;

typedef struct hetab_reflectance {
  hetab_integral dd; /* directional-diffuse */
  double specular;   /* rho_s of Eq. 10 */
  double ud;         /* pi * diffuse_brdf */
  double dh;         /* dd + specular + ud */
  double fresnel;    /* of the polished material: the report's upper bound */
} hetab_reflectance;

/* out[band][theta_i] for theta_i[count] in [0, pi/2] and every wavelength of the surface.
 * tolerance: relative, of dd; 0: 1e-5 float, 1e-9 double. Below the rounding of the arithmetic
 * (1e-6 float, 2e-11 double) it cannot be met: HETAB_STOP_ROUNDOFF. Runs on the engine's first
 * device; the literal method has none (HETAB_ERR_UNSUPPORTED).
 *
 * Shape: rays across the disc at steps that do not depend on grazing, nodes crowded at both ends of
 * each (src/model/hemisphere.h).
 * Error: relative, of dd <= 3e-7 float, 1e-11 double in every case of golden/reflectance.csv, which
 * scripts/golden makes (tests/test_reflectance.c).
 * Edge: at exactly 90 degrees dd and specular are 0. Slopes sigma0 / tau above 1 converge slowly
 * beyond 88 degrees, where double may end with HETAB_STOP_BUDGET. */
hetab_status hetab_reflectance_dh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, const double *theta_i, size_t count,
                                  double tolerance, hetab_reflectance *out);

/* Hemispherical-hemispherical (white-sky) reflectance, out[band]: 2 * integral of rho_dh
 * cos(theta) sin(theta) dtheta. The parts stand as in hetab_reflectance. tolerance: relative, of dd
 * + specular, and dd.error covers both. */
hetab_status hetab_reflectance_hh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, double tolerance,
                                  hetab_reflectance *out);

/* A spectrum of reflectances under D65, seen by the CIE 1931 observer: 1 is the perfect white. */
typedef struct hetab_reflectance_colour {
  double rgb[3];    /* linear sRGB, negative outside its gamut */
  double luminance; /* Y */
  double error;     /* of each of the four, from the errors of dd */
} hetab_reflectance_colour;

/* Colours of reflectances[band][count], as the two functions above return them (the latter with
 * count = 1): of dh, and of the polished material (fresnel, error 0). Either may be NULL. The
 * surface's wavelengths have to cover 400-700 nm in steps of 10 nm or less (HETAB_ERR_RANGE). */
hetab_status hetab_reflectance_rgb(hetab_context *ctx, const hetab_surface *surface,
                                   const hetab_reflectance *reflectances, size_t count,
                                   hetab_reflectance_colour *dh, hetab_reflectance_colour *fresnel);

HETAB_END
