#include "model/limits.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include <hetab/host_model.h>

typedef struct field {
  const char *name, *unit;
  double value, low, high;
} field;

/* What a point's numbers may be, one by one. */
static const struct {
  const char *name;
  size_t offset;
  double low, high;
  const char *unit; /* where the name does not say it */
} numbers[] = {
    {"lambda_um", offsetof(hetab_point, lambda_um), 1e-6, 1e6, ""},
    {"theta_i", offsetof(hetab_point, theta_i), 0.0, M_PI_2, " radians"},
    {"theta_r", offsetof(hetab_point, theta_r), 0.0, M_PI_2, " radians"},
    {"phi", offsetof(hetab_point, phi), -1e6, 1e6, " radians"},
    {"sigma0_um", offsetof(hetab_point, sigma0_um), 1e-9, 1e6, ""},
    {"tau_um", offsetof(hetab_point, tau_um), 1e-9, 1e6, ""},
    {"n", offsetof(hetab_point, n), 1e-6, 1e3, ""},
    {"k", offsetof(hetab_point, k), 0.0, 1e3, ""},
    {"diffuse_brdf", offsetof(hetab_point, diffuse_brdf), 0.0, 1e3, ""},
};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

void hetab_point_limits(size_t offset, double *low, double *high) {
  size_t i = 0;
  while (i + 1 < NUMBERS && numbers[i].offset != offset)
    i++;
  *low = numbers[i].low;
  *high = numbers[i].high;
}

/* sigma0 / lambda at most: beyond, amplitudes leave float's range; in tables g is up to 10^8 then,
 * and the literal reference, which they are checked against, loses its digits and its speed. */
static const double MOST_ROUGH_POINT = 3e6, MOST_ROUGH_TABLE = 1e3;

/* NULL if all are within their ranges. tau / lambda: with both amplitudes stay in range. */
static const field *first_outside(const hetab_point *p, double most_rough, field *out) {
  field ratios[] = {{"sigma0 / lambda", "", p->sigma0_um / p->lambda_um, 1e-9, most_rough},
                    {"tau / lambda", "", p->tau_um / p->lambda_um, 1e-9, 1e8}};
  for (size_t i = 0; i < NUMBERS + 2; i++) {
    if (i >= NUMBERS)
      *out = ratios[i - NUMBERS];
    else {
      *out = (field){numbers[i].name, numbers[i].unit, 0.0, numbers[i].low, numbers[i].high};
      memcpy(&out->value, (const char *)p + numbers[i].offset, sizeof out->value);
    }
    if (!(out->value >= out->low && out->value <= out->high))
      return out;
  }
  return NULL;
}

hetab_status hetab_check_point(hetab_context *ctx, const hetab_point *point) {
  field wrong;
  if (first_outside(point, MOST_ROUGH_POINT, &wrong))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s = %g: give a value from %g to %g%s", wrong.name,
                      wrong.value, wrong.low, wrong.high, wrong.unit);
  return HETAB_OK;
}

hetab_status hetab_check_points(hetab_context *ctx, const hetab_point *points, size_t count) {
  field wrong;
  for (size_t i = 0; i < count; i++)
    if (first_outside(&points[i], MOST_ROUGH_POINT, &wrong))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "point %zu: %s = %g: give a value from %g to %g%s",
                        i, wrong.name, wrong.value, wrong.low, wrong.high, wrong.unit);
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
                        "surface '%s' at %g nm: %s = %g: give a value from %g to %g%s",
                        hetab_surface_name(surface), 1e3 * band->lambda_um, wrong.name, wrong.value,
                        wrong.low, wrong.high, wrong.unit);
  }
  return HETAB_OK;
}
