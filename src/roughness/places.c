/* Heights at places of their own, on an even grid. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "roughness/heights.h"
#include "core/number.h"

typedef struct places {
  hetab_context *ctx;
  const char *name;
  const double *x_um; /* [count] */
  const double *z_um; /* [rows][count] */
  size_t count, rows;
} places;

/* The usual step; then the mean of the steps that are like it, which has more digits. */
static hetab_status usual_step(const places *p, double *step) {
  const double *x_um = p->x_um;
  size_t count = p->count;
  double *steps = hetab_alloc(p->ctx, count, sizeof *steps), sum = 0;
  HETAB_NEED(steps);
  for (size_t i = 0; i + 1 < count; i++)
    steps[i] = x_um[i + 1] - x_um[i];
  hetab_sort(steps, count - 1);
  double median = steps[(count - 2) / 2], least = steps[0];
  size_t like = 0;
  for (size_t i = 0; i + 1 < count; i++)
    if (fabs(steps[i] - median) < 0.25 * median) {
      sum += steps[i];
      like++;
    }
  free(steps);
  if (!(least > 0))
    return hetab_fail(
        p->ctx, HETAB_ERR_PARSE,
        "%s: x does not always increase: sort the points, and leave out repeated ones", p->name);
  *step = sum / (double)like;
  return HETAB_OK;
}

/* The last decimal that the places have: 0.1, 0.001 ... of a um; 0: too many. */
static double last_decimal(const places *p) {
  for (double quantum = 1; quantum > 1e-7; quantum /= 10) {
    size_t i = 0;
    while (i < p->count && fabs(p->x_um[i] / quantum - round(p->x_um[i] / quantum)) < 1e-4)
      i++;
    if (i == p->count)
      return quantum;
  }
  return 0;
}

/* Whether even places, rounded to their last decimal, give these: several steps differ (one would
 * be a gap), and none is off the line by more than the rounding. *step is that line's slope. */
static bool are_rounded(const places *p, double *step) {
  enum { LEAST = 32, LEAST_DIFFERENT = 4 };
  double n = (double)p->count, quantum = last_decimal(p), sum = 0, moment = 0;
  size_t shorter = 0;
  if (p->count < LEAST || quantum == 0)
    return false;
  for (size_t i = 0; i < p->count; i++) {
    sum += p->x_um[i];
    moment += ((double)i - (n - 1) / 2) * p->x_um[i];
  }
  double slope = 12 * moment / (n * (n * n - 1)), first = sum / n - slope * (n - 1) / 2;
  for (size_t i = 0; i < p->count; i++) {
    if (fabs(p->x_um[i] - first - slope * (double)i) > 0.6 * quantum)
      return false;
    shorter += i > 0 && p->x_um[i] - p->x_um[i - 1] < slope;
  }
  *step = slope;
  return shorter >= LEAST_DIFFERENT && p->count - 1 - shorter >= LEAST_DIFFERENT;
}

static hetab_status put_in_order(const places *p, double step_um, hetab_heights **out) {
  HETAB_TRY(hetab_heights_new(p->ctx, p->name, p->count, p->rows, out));
  (*out)->spacing_um = step_um;
  memcpy((*out)->z_um, p->z_um, p->rows * p->count * sizeof *p->z_um);
  return HETAB_OK;
}

/* A grid of missing heights over all places. */
static hetab_status new_grid(const places *p, double step_um, hetab_heights **out) {
  double span = (p->x_um[p->count - 1] - p->x_um[0]) / step_um;
  *out = NULL;
  if (!(span < (double)HETAB_MOST_HEIGHTS))
    return hetab_fail(p->ctx, HETAB_ERR_RANGE, "%s: x spans %g steps of %g um: more than 2^27",
                      p->name, span, step_um);
  HETAB_TRY(hetab_heights_new(p->ctx, p->name, (size_t)llround(span) + 1, p->rows, out));
  (*out)->spacing_um = step_um;
  for (size_t i = 0; i < (*out)->columns * p->rows; i++)
    (*out)->z_um[i] = (double)NAN;
  return HETAB_OK;
}

static hetab_status put_on_grid(const places *p, hetab_heights *h) {
  double step = h->spacing_um;
  for (size_t i = 0, cell = 0; i < p->count; i++) {
    double jump = i ? (p->x_um[i] - p->x_um[i - 1]) / step : 0;
    cell += (size_t)llround(jump);
    if (fabs(jump - round(jump)) > 0.02 ||
        fabs((p->x_um[i] - p->x_um[0]) / step - (double)cell) > 0.5)
      return hetab_fail(
          p->ctx, HETAB_ERR_PARSE,
          "%s: points are unequally spaced: a step of %g um before x = %g um, usually "
          "%g um: give --resample %.2g, or resample the scan yourself",
          p->name, jump * step, p->x_um[i], step, step);
    for (size_t row = 0; row < p->rows; row++)
      h->z_um[row * h->columns + cell] = p->z_um[row * p->count + i];
  }
  return HETAB_OK;
}

/* Linear between neighbours that are not further apart than `gap_um`. */
static void interpolate(const places *p, double gap_um, hetab_heights *h) {
  size_t right = 1;
  for (size_t cell = 0; cell < h->columns; cell++) {
    double x = p->x_um[0] + (double)cell * h->spacing_um;
    while (right + 1 < p->count && p->x_um[right] < x)
      right++;
    double step = p->x_um[right] - p->x_um[right - 1], at = (x - p->x_um[right - 1]) / step;
    if (step > gap_um || at > 1 + 1e-9)
      continue;
    for (size_t row = 0; row < p->rows; row++) {
      const double *z = p->z_um + row * p->count + right;
      h->z_um[row * h->columns + cell] = z[-1] + at * (z[0] - z[-1]);
    }
  }
}

hetab_status hetab_heights_from_places(hetab_context *ctx, const char *name, const double *x_um,
                                       const double *z_um, size_t count, size_t rows,
                                       double resample_um, hetab_heights **out) {
  const places p = {ctx, name, x_um, z_um, count, rows};
  double step = 0;
  *out = NULL;
  if (count < 2)
    return hetab_heights_new(ctx, name, count, rows, out); /* which says what is missing */
  if (!(resample_um > 0) && are_rounded(&p, &step))
    return put_in_order(&p, step, out);
  HETAB_TRY(usual_step(&p, &step));
  HETAB_TRY(new_grid(&p, resample_um > 0 ? resample_um : step, out));
  if (resample_um > 0) {
    interpolate(&p, 3 * step, *out);
    return HETAB_OK;
  }
  HETAB_MADE(hetab_heights, out, put_on_grid(&p, *out));
}
