/* Hemispherical reflectances of a surface, each with an error estimate.
 *
 * rho_dh(theta_i, lambda) = integral over the hemisphere of f cos(theta_r) dOmega (Eq. 4), split
 * into directional-diffuse, specular and uniform-diffuse. The integrand is evaluated on the
 * engine's device, in the plane of direction cosines, polar about the mirror point. */
#ifndef HETAB_REFLECTANCE_H
#define HETAB_REFLECTANCE_H

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hetab_stop {
  HETAB_STOP_TOLERANCE, /* the error estimate is below the tolerance */
  HETAB_STOP_ROUNDOFF,  /* the arithmetic's own rounding is reached */
  HETAB_STOP_BUDGET     /* too many evaluations: value and error are the best so far */
} hetab_stop;

const char *hetab_stop_name(hetab_stop stop); /* "tolerance" */

/* A number that was integrated: |value - truth| <= error. */
typedef struct hetab_integral {
  double value, error;
  size_t evaluations;
  hetab_stop stop;
} hetab_integral;

typedef struct hetab_reflectance {
  hetab_integral dd; /* directional-diffuse */
  double specular;   /* rho_s of Eq. 10 */
  double ud;         /* pi * diffuse_brdf */
  double dh;         /* dd + specular + ud */
  double fresnel;    /* of the polished material: the report's upper bound */
} hetab_reflectance;

/* out[band][theta_i] for theta_i_deg[count] in [0, 90] and every wavelength of the surface.
 * tolerance: relative, of dd; 0: 1e-6 float, 1e-9 double. Error against golden/reflectance.csv:
 * tests/test_reflectance.c. At exactly 90 degrees dd and specular are 0. */
hetab_status hetab_reflectance_dh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, const double *theta_i_deg,
                                  size_t count, double tolerance, hetab_reflectance *out);

/* Hemispherical-hemispherical (white-sky) reflectance, out[band]: 2 * integral of rho_dh
 * cos(theta) sin(theta) dtheta. The parts stand as in hetab_reflectance; dd.error covers the whole
 * sum. */
hetab_status hetab_reflectance_hh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, double tolerance,
                                  hetab_reflectance *out);

#ifdef __cplusplus
}
#endif
#endif
