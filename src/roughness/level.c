#include "roughness/level.h"
#include "core/number.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { WINDOW = 7, MOST_SAMPLES = 1024, MOST_PASSES = 5 };

/* ---- least squares ------------------------------------------------------------------------- */

typedef struct plane {
  double x, y, z;          /* the middle */
  double slope_x, slope_y; /* per index */
} plane;

static plane middle_of(const double *z, size_t columns, size_t rows) {
  plane p = {0};
  size_t count = 0;
  for (size_t i = 0; i < rows * columns; i++)
    if (!isnan(z[i])) {
      p.x += (double)(i % columns);
      p.y += (double)(i / columns);
      p.z += z[i];
      count++;
    }
  double n = (double)(count ? count : 1);
  return (plane){p.x / n, p.y / n, p.z / n, 0, 0};
}

/* With one row, or heights along one line only, the slope across it is 0. */
static plane fit_plane(const double *z, size_t columns, size_t rows) {
  plane p = middle_of(z, columns, rows);
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
  for (size_t i = 0; i < rows * columns; i++) {
    if (isnan(z[i]))
      continue;
    double x = (double)(i % columns) - p.x, y = (double)(i / columns) - p.y, d = z[i] - p.z;
    xx += x * x;
    xy += x * y;
    yy += y * y;
    xz += x * d;
    yz += y * d;
  }
  double determinant = xx * yy - xy * xy;
  if (determinant > 1e-9 * xx * yy) {
    p.slope_x = (xz * yy - yz * xy) / determinant;
    p.slope_y = (yz * xx - xz * xy) / determinant;
  } else if (xx > 0) {
    p.slope_x = xz / xx;
  }
  return p;
}

static void subtract_plane(double *z, size_t columns, size_t rows) {
  plane p = fit_plane(z, columns, rows);
  for (size_t i = 0; i < rows * columns; i++)
    z[i] -=
        p.z + p.slope_x * ((double)(i % columns) - p.x) + p.slope_y * ((double)(i / columns) - p.y);
}

/* ---- outliers ------------------------------------------------------------------------------ */

static double median(double *values, size_t count) {
  hetab_sort(values, count);
  return count ? 0.5 * (values[(count - 1) / 2] + values[count / 2]) : 0;
}

/* 1.4826 times the median distance from the median, of some heights throughout; where more than
 * half of them are equal, the standard deviation. */
static double robust_deviation(const double *z, size_t count) {
  double values[MOST_SAMPLES];
  size_t stride = count / MOST_SAMPLES + 1, kept = 0;
  for (size_t i = 0; i < count; i += stride)
    if (!isnan(z[i]))
      values[kept++] = z[i];
  double middle = median(values, kept), squares = 0;
  for (size_t i = 0; i < kept; i++) {
    values[i] = fabs(values[i] - middle);
    squares += values[i] * values[i];
  }
  double deviation = 1.4826 * median(values, kept);
  return deviation > 0 ? deviation : sqrt(squares / (double)(kept ? kept : 1));
}

/* Of the heights about z[i]. Insertion: there are few, and this is done for every height. */
static double local_median(const double *z, size_t count, size_t i) {
  double values[WINDOW];
  size_t kept = 0, from = i < WINDOW / 2 ? 0 : i - WINDOW / 2;
  for (size_t j = from; j < count && j <= i + WINDOW / 2; j++) {
    if (isnan(z[j]))
      continue;
    size_t at = kept++;
    for (; at > 0 && values[at - 1] > z[j]; at--)
      values[at] = values[at - 1];
    values[at] = z[j];
  }
  return 0.5 * (values[(kept - 1) / 2] + values[kept / 2]);
}

/* With three neighbours near it z[i] is among the majority of the seven, and near their median. */
static bool is_with_neighbours(const double *z, size_t count, size_t i, double limit) {
  return i > 0 && i + 2 < count && fabs(z[i] - z[i - 1]) <= limit &&
         fabs(z[i] - z[i + 1]) <= limit && fabs(z[i] - z[i + 2]) <= limit;
}

static size_t mark_outliers(const double *z, size_t count, double limit, unsigned char *marked) {
  size_t found = 0;
  for (size_t i = 0; i < count; i++)
    if (!isnan(z[i]) && !is_with_neighbours(z, count, i, limit) &&
        fabs(z[i] - local_median(z, count, i)) > limit) {
      marked[i] = 1;
      found++;
    }
  return found;
}

static size_t drop_outliers(double *z, size_t columns, size_t rows, double factor,
                            unsigned char *marked) {
  size_t found = 0;
  double limit = factor * robust_deviation(z, rows * columns);
  if (!(limit > 0))
    return 0;
  for (size_t row = 0; row < rows; row++)
    found += mark_outliers(z + row * columns, columns, limit, marked + row * columns);
  for (size_t i = 0; found && i < rows * columns; i++)
    if (marked[i])
      z[i] = (double)NAN;
  return found;
}

/* ---- all ----------------------------------------------------------------------------------- */

/* A spike tilts the fit, and its shadow hides smaller ones: repeated until nothing is found. */
static void level_part(double *z, size_t columns, size_t rows,
                       const hetab_roughness_options *options, unsigned char *marked) {
  double factor = options->outlier > 0 ? options->outlier : options->outlier < 0 ? 0 : 6;
  size_t found = 1;
  for (int pass = 0; pass < MOST_PASSES && found; pass++) {
    if (options->level == HETAB_LEVEL_FIT)
      subtract_plane(z, columns, rows);
    found = factor > 0 ? drop_outliers(z, columns, rows, factor, marked) : 0;
  }
}

hetab_status hetab_level_heights(hetab_context *ctx, const hetab_heights *heights,
                                 const hetab_roughness_options *options, hetab_levelled *out) {
  size_t columns = hetab_heights_column_count(heights), rows = hetab_heights_row_count(heights);
  out->z_um = hetab_alloc(ctx, rows * columns, sizeof *out->z_um);
  out->marked = hetab_alloc(ctx, rows * columns, 1);
  if (!out->z_um || !out->marked) {
    hetab_levelled_free(out);
    return HETAB_ERR_MEMORY;
  }
  memcpy(out->z_um, hetab_heights_z_um(heights), rows * columns * sizeof *out->z_um);
  bool map = hetab_heights_kind_of(heights) == HETAB_HEIGHTS_MAP;
  size_t part_rows = map ? rows : 1;
  for (size_t row = 0; row < rows; row += part_rows)
    level_part(out->z_um + row * columns, columns, part_rows, options, out->marked + row * columns);
  return HETAB_OK;
}

void hetab_levelled_free(hetab_levelled *levelled) {
  free(levelled->z_um);
  free(levelled->marked);
  *levelled = (hetab_levelled){0};
}
