#include "model/limits.h"

#include <math.h>
#include <stdio.h>

typedef struct field {
  const char *name;
  double value, low, high;
} field;

/* sigma0 / lambda at most: beyond, amplitudes leave float's range; in tables g is up to 10^8 then,
 * and the literal reference, which they are checked against, loses its digits and its speed. */
static const double MOST_ROUGH_POINT = 3e6, MOST_ROUGH_TABLE = 1e3;

/* NULL if all are within their ranges. tau / lambda: with both amplitudes stay in range. */
static const field *first_outside(const hetab_point *p, double most_rough, field *out) {
  const field fields[] = {
      {"lambda_um", p->lambda_um, 1e-6, 1e6},
      {"theta_i", p->theta_i, 0.0, M_PI_2},
      {"theta_r", p->theta_r, 0.0, M_PI_2},
      {"phi", p->phi, -1e6, 1e6},
      {"sigma0_um", p->sigma0_um, 1e-9, 1e6},
      {"tau_um", p->tau_um, 1e-9, 1e6},
      {"n", p->n, 1e-6, 1e3},
      {"k", p->k, 0.0, 1e3},
      {"diffuse_brdf", p->diffuse_brdf, 0.0, 1e3},
      {"sigma0 / lambda", p->sigma0_um / p->lambda_um, 1e-9, most_rough},
      {"tau / lambda", p->tau_um / p->lambda_um, 1e-9, 1e8},
  };
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
    if (!(fields[i].value >= fields[i].low && fields[i].value <= fields[i].high)) {
      *out = fields[i];
      return out;
    }
  return NULL;
}

hetab_status hetab_check_point(hetab_context *ctx, const hetab_point *point) {
  field wrong;
  if (first_outside(point, MOST_ROUGH_POINT, &wrong))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s = %g: give a value from %g to %g", wrong.name,
                      wrong.value, wrong.low, wrong.high);
  return HETAB_OK;
}

hetab_status hetab_check_points(hetab_context *ctx, const hetab_point *points, size_t count) {
  field wrong;
  for (size_t i = 0; i < count; i++)
    if (first_outside(&points[i], MOST_ROUGH_POINT, &wrong))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "point %zu: %s = %g: give a value from %g to %g",
                        i, wrong.name, wrong.value, wrong.low, wrong.high);
  return HETAB_OK;
}

hetab_status hetab_check_surface(hetab_context *ctx, const hetab_surface *surface) {
  field wrong;
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++) {
    const hetab_band *band = &hetab_surface_bands(surface)[b];
    hetab_point point = {.lambda_um = band->lambda_um,
                         .sigma0_um = hetab_surface_sigma0_um(surface),
                         .tau_um = hetab_surface_tau_um(surface),
                         .n = band->n,
                         .k = band->k,
                         .diffuse_brdf = band->diffuse_brdf};
    if (first_outside(&point, MOST_ROUGH_TABLE, &wrong))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "surface '%s' at %g nm: %s = %g: give a value from %g to %g",
                        hetab_surface_name(surface), 1e3 * band->lambda_um, wrong.name, wrong.value,
                        wrong.low, wrong.high);
  }
  return HETAB_OK;
}
