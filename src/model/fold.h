/* The specular delta folded into a BRDF: a lobe of half vectors within `cone` of the normal,
 *   f(i, r) = K(theta_h) s(theta_i) s(theta_r),
 * reciprocal, whose directional-hemispherical reflectance is rho_s at every incidence, what is cut
 * off at the horizon included: s solves s(i) int K s(r) cos(r) dr = rho_s(i) (Sinkhorn's
 * iteration). K is (1 - y)^2, y = sin^2(theta_h) / sin^2(cone): smooth, for readers that
 * interpolate lose what a step has, and those that truncate find it too.
 *
 * Energy of the smooth lobe, integrated by another rule: rho_s above 1e-3 within 0.2 % from 0 to 85
 * degrees for cones of 0.5 and 2 degrees, 1 % at 5, and at 20 where it does not rise by orders
 * within the cone (tests/test_fold.c). */
#pragma once

#include <stdbool.h>

#include "core/context.h"
#include "model/model.h"

typedef struct hetab_fold hetab_fold;

/* HETAB_ERR_RANGE for a cone above 0 that is below `least`, two spacings of the table named. */
hetab_status hetab_fold_check(hetab_context *ctx, double cone, double least, const char *table);

/* Of these bands of a surface; cone in radians, (0, pi/2]. */
hetab_status hetab_fold_create(hetab_context *ctx, const hetab_surface *surface,
                               const hetab_band *bands, size_t count, double cone,
                               hetab_fold **out);
void hetab_fold_free(hetab_fold *fold); /* NULL is fine */

/* Adds the lobe, 1/sr, to values[bands] at a pair of directions with this sin^2(theta_h). */
void hetab_fold_add(const hetab_fold *fold, double theta_i, double theta_r, double sin2_h,
                    double *values);

double hetab_fold_of_band(const hetab_fold *fold, size_t band, double theta_i, double theta_r,
                          double sin2_h);

/* sin^2(theta_h) of a pair. */
double hetab_sin2_h(const hetab_pair *pair, double one_plus_cos);
