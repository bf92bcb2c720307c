/* Lists of points x, y, z: the grid that they lie on. */
#include <math.h>
#include <stdlib.h>
#include "roughness/heights.h"
#include "core/number.h"

/* The distinct places along one axis: start + step times 0..count-1. */
typedef struct axis {
  double start, step;
  size_t count;
} axis;

/* From values[i * stride]. The usual step is the median of those between neighbours that differ;
 * where all fit a count of them, the mean step has more digits. */
static hetab_status find_axis(hetab_context *ctx, const double *values, size_t stride, size_t count,
                              axis *a) {
  double *sorted = hetab_alloc(ctx, 2 * count, sizeof *sorted), *steps = sorted + count;
  if (!sorted)
    return HETAB_ERR_MEMORY;
  size_t different = 0;
  for (size_t i = 0; i < count; i++)
    sorted[i] = values[i * stride];
  hetab_sort(sorted, count);
  double span = sorted[count - 1] - sorted[0];
  for (size_t i = 1; i < count; i++)
    if (sorted[i] - sorted[i - 1] > 1e-7 * span)
      steps[different++] = sorted[i] - sorted[i - 1];
  hetab_sort(steps, different);
  *a = (axis){sorted[0], different ? steps[different / 2] : 0, 1};
  if (different) {
    double cells = round(span / a->step);
    a->step = span / cells;
    a->count = cells < (double)HETAB_MOST_HEIGHTS ? (size_t)cells + 1 : HETAB_MOST_HEIGHTS;
  }
  free(sorted);
  return HETAB_OK;
}

/* The cell of a value; false if it lies between cells. */
static bool cell_of(const axis *a, double value, size_t *cell) {
  double at = a->count > 1 ? (value - a->start) / a->step : 0;
  *cell = (size_t)llround(at);
  return fabs(at - round(at)) < 0.3 && *cell < a->count;
}

/* Puts the points on the grid of both axes; false if they are on none: between its places, two on
 * one, or three quarters of it empty. */
static bool fill(const axis axes[2], const double *x, const double *y, const double *z,
                 size_t stride, size_t count, double *grid) {
  size_t cells = axes[0].count * axes[1].count, column, row;
  for (size_t i = 0; i < cells; i++)
    grid[i] = HUGE_VAL;
  for (size_t i = 0; i < count; i++) {
    if (!cell_of(&axes[0], x[i * stride], &column) || !cell_of(&axes[1], y[i * stride], &row))
      return false;
    double *place = &grid[row * axes[0].count + column];
    if (*place != HUGE_VAL)
      return false;
    *place = z[i * stride];
  }
  for (size_t i = 0; i < cells; i++)
    if (grid[i] == HUGE_VAL)
      grid[i] = (double)NAN;
  return true;
}

static bool is_grid(const axis axes[2], size_t count) {
  return axes[0].count > 1 && axes[1].count > 1 && axes[0].count <= 4 * count / axes[1].count;
}

bool hetab_are_points(const double *xyz, size_t count) {
  hetab_context *ctx;
  axis axes[2];
  double *grid = NULL;
  bool points = false;
  for (size_t i = 0; i < 3 * count; i += 3)
    if (isnan(xyz[i]) || isnan(xyz[i + 1]))
      return false;
  if (count < 4 || hetab_context_create(&ctx) != HETAB_OK)
    return false;
  if (find_axis(ctx, xyz, 3, count, &axes[0]) == HETAB_OK &&
      find_axis(ctx, xyz + 1, 3, count, &axes[1]) == HETAB_OK && is_grid(axes, count))
    grid = hetab_alloc(ctx, axes[0].count * axes[1].count, sizeof *grid);
  if (grid)
    points = fill(axes, xyz, xyz + 1, xyz + 2, 3, count, grid);
  free(grid);
  hetab_context_free(ctx);
  return points;
}

hetab_status hetab_heights_from_points(hetab_context *ctx, const char *name, const double *x_um,
                                       const double *y_um, const double *z_um, size_t count,
                                       double resample_um, hetab_heights **out) {
  axis axes[2];
  *out = NULL;
  HETAB_TRY(find_axis(ctx, x_um, 1, count, &axes[0]));
  HETAB_TRY(find_axis(ctx, y_um, 1, count, &axes[1]));
  if (axes[0].count == 1 || axes[1].count == 1)
    return hetab_heights_from_places(ctx, name, axes[1].count == 1 ? x_um : y_um, z_um, count, 1,
                                     resample_um, out);
  if (is_grid(axes, count)) {
    HETAB_TRY(hetab_heights_new(ctx, name, axes[0].count, axes[1].count, out));
    (*out)->kind = HETAB_HEIGHTS_MAP;
    (*out)->spacing_um = axes[0].step;
    (*out)->spacing_y_um = axes[1].step;
    if (fill(axes, x_um, y_um, z_um, 1, count, (*out)->z_um))
      return HETAB_OK;
    hetab_heights_free(*out);
    *out = NULL;
  }
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "%s: the list of points lies on no grid of x and y: export a map, or choose "
                    "one scan of it by --columns x,z",
                    name);
}
