/* The model at single points, on the device, by the kernels that make the tables. */
#ifndef HETAB_EVALUATE_H
#define HETAB_EVALUATE_H

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One evaluation: everything that the model depends on. Angles in radians. */
typedef struct hetab_point {
  double lambda_um;        /* > 0 */
  double theta_i, theta_r; /* [0, pi/2] */
  double phi;              /* any finite azimuth */
  double sigma0_um;        /* > 0 */
  double tau_um;           /* > 0 */
  double n, k;             /* n > 0, k >= 0 */
  double diffuse_brdf;     /* >= 0, 1/sr */
} hetab_point;

typedef struct hetab_value {
  double dd;       /* directional-diffuse BRDF, Eq. 8, 1/sr */
  double specular; /* specular reflectance rho_s(theta_i), Eq. 10, dimensionless */
  double ud;       /* uniform-diffuse BRDF, Eq. 9, 1/sr */
  double total;    /* dd + ud, 1/sr: what tables hold (the specular delta is apart) */
  double g;        /* roughness phase parameter, Eq. 12 */
  double x;        /* v_xy^2 tau^2 / 4 */
} hetab_value;

/* values[count] for points[count]. Bad points: HETAB_ERR_ARGUMENT naming the index and the field.
 * Error against 40-digit values (tests/test_golden.c): relative <= 1e-5 float, <= 1e-10 double
 * where dd >= 1e-9 / sr; absolute <= 1e-14 below. Except around the critical angle of n < 1 with
 * k near 0 (total reflection), where Fresnel's square root has float lose digits: up to 6e-3 within
 * 0.01 degrees of it. Never NaN, infinite or negative. The rows
 * method has no rows here: it evaluates the series, as HETAB_METHOD_SERIES. */
hetab_status hetab_evaluate(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, hetab_value *values);

/* The printed equations (Eqs. 6-25) in double on the calling thread, limits where they divide
 * zero by zero: the executable specification. No device needed. */
hetab_status hetab_evaluate_literal(hetab_context *ctx, const hetab_point *points, size_t count,
                                    hetab_value *values);

/* rho_s(theta_i, lambda), Eq. 10: out[band_count][count], theta_i_deg[count], double, on the host.
 */
hetab_status hetab_specular_reflectance(hetab_context *ctx, const hetab_surface *surface,
                                        const double *theta_i_deg, size_t count, double *out);

#ifdef __cplusplus
}
#endif
#endif
