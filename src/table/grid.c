#include <hetab/grid.h>

#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "core/context.h"

enum { MAX_COUNT = 100000 };

/* Entries and bytes of a wavelength cannot overflow, whatever the axes. */
_Static_assert(8ULL * MAX_COUNT * MAX_COUNT * MAX_COUNT <= SIZE_MAX, "MAX_COUNT is too large");

struct hetab_grid {
  double *deg[HETAB_AXIS_COUNT], *radians[HETAB_AXIS_COUNT];
  size_t count[HETAB_AXIS_COUNT];
};

static const char *const axis_names[HETAB_AXIS_COUNT] = {"theta_i", "theta_r", "phi"};
static const double axis_stop[HETAB_AXIS_COUNT] = {90, 90, 180};
static const char *const axis_default[HETAB_AXIS_COUNT] = {"0:90:90", "0:90:90", "0:180:181"};

const char *hetab_axis_name(hetab_axis axis) {
  return axis_names[axis];
}

size_t hetab_grid_count(const hetab_grid *grid, hetab_axis axis) {
  return grid->count[axis];
}

const double *hetab_grid_deg(const hetab_grid *grid, hetab_axis axis) {
  return grid->deg[axis];
}

const double *hetab_grid_radians(const hetab_grid *grid, hetab_axis axis) {
  return grid->radians[axis];
}

void hetab_grid_free(hetab_grid *grid) {
  if (!grid)
    return;
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    free(grid->deg[axis]);
    free(grid->radians[axis]);
  }
  free(grid);
}

hetab_status hetab_grid_create(hetab_context *ctx, hetab_grid **out) {
  *out = NULL;
  hetab_grid *grid = hetab_alloc(ctx, 1, sizeof *grid);
  hetab_status status = grid ? HETAB_OK : HETAB_ERR_MEMORY;
  for (hetab_axis axis = 0; status == HETAB_OK && axis < HETAB_AXIS_COUNT; axis++)
    status = hetab_grid_set_axis(ctx, grid, axis, axis_default[axis]);
  *out = grid;
  HETAB_MADE(hetab_grid, out, status);
}

/* --- values --------------------------------------------------------------------------------- */

/* What messages call the values at hand: "axis phi", or "axis phi '0:200:5'". */
typedef struct label {
  char text[128];
} label;

static label make_label(hetab_axis axis, const char *spec) {
  label made;
  if (!spec)
    snprintf(made.text, sizeof made.text, "axis %s", axis_names[axis]);
  else
    snprintf(made.text, sizeof made.text, "axis %s '%.60s%s'", axis_names[axis], spec,
             strlen(spec) > 60 ? "..." : "");
  return made;
}

static hetab_status check_count(hetab_context *ctx, const label *what, double count, int least) {
  if (!(count >= least && count <= MAX_COUNT && count == floor(count)))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s: the count is %g; give a whole number, %d to %d",
                      what->text, count, least, MAX_COUNT);
  return HETAB_OK;
}

static hetab_status check_values(hetab_context *ctx, const label *what, double stop,
                                 const double *deg, size_t count) {
  for (size_t i = 0; i < count; i++) {
    if (!(deg[i] >= 0 && deg[i] <= stop))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "%s: %g is off the axis; give values from 0 to %g degrees", what->text,
                        deg[i], stop);
    if (i && !(deg[i] > deg[i - 1]))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "%s: %.10g comes after %.10g; give ascending values, each once", what->text,
                        deg[i], deg[i - 1]);
  }
  return HETAB_OK;
}

/* Takes deg over, or frees it; deg may be NULL for want of memory. */
static hetab_status set_owned(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                              const label *what, double *deg, size_t count) {
  double *radians = deg ? hetab_alloc(ctx, count, sizeof *radians) : NULL;
  hetab_status status =
      radians ? check_values(ctx, what, axis_stop[axis], deg, count) : HETAB_ERR_MEMORY;
  if (status != HETAB_OK) {
    free(deg);
    free(radians);
    return status;
  }
  for (size_t i = 0; i < count; i++)
    radians[i] = hetab_radians(deg[i]);
  free(grid->deg[axis]);
  free(grid->radians[axis]);
  grid->deg[axis] = deg;
  grid->radians[axis] = radians;
  grid->count[axis] = count;
  return HETAB_OK;
}

hetab_status hetab_grid_set_values(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                                   const double *deg, size_t count) {
  label what = make_label(axis, NULL);
  HETAB_TRY(check_count(ctx, &what, (double)count, 1));
  double *copy = hetab_alloc(ctx, count, sizeof *copy);
  if (copy)
    memcpy(copy, deg, count * sizeof *copy);
  return set_owned(ctx, grid, axis, &what, copy, count);
}

/* --- text ----------------------------------------------------------------------------------- */

/* Reads a finite number and moves *text past it; 0 if there is none. In the C locale: a program's
 * own must not turn 20.5 into 20. */
static int read_number(const char **text, double *value) {
  locale_t c = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
  if (!c)
    return 0;
  char *end;
  *value = strtod_l(*text, &end, c);
  freelocale(c);
  int found = end != *text && isfinite(*value);
  *text = end;
  return found;
}

static int read_range(const char *text, double *start, double *stop, double *count) {
  return read_number(&text, start) && *text++ == ':' && read_number(&text, stop) &&
         *text++ == ':' && read_number(&text, count) && !*text;
}

static int read_cells(const char *text, double *count) {
  static const char prefix[] = "cells:";
  size_t length = strlen(prefix);
  if (strncmp(text, prefix, length) != 0)
    return 0;
  text += length;
  return read_number(&text, count) && !*text;
}

/* The numbers of a list into values, or only counted if that is NULL; 0 if it is malformed. */
static size_t read_list(const char *text, double *values) {
  for (size_t count = 0;; text++) {
    double value;
    if (!read_number(&text, &value) || (*text && *text != ','))
      return 0;
    if (values)
      values[count] = value;
    count++;
    if (!*text)
      return count;
  }
}

/* Both ends exact: the last value is `stop` itself, not what the division makes of it. */
static hetab_status set_range(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                              const label *what, double start, double stop, double count) {
  HETAB_TRY(check_count(ctx, what, count, 2));
  size_t n = (size_t)count;
  double *deg = hetab_alloc(ctx, n, sizeof *deg);
  if (deg) {
    for (size_t i = 0; i < n; i++)
      deg[i] = start + (stop - start) * (double)i / (count - 1);
    deg[n - 1] = stop;
  }
  return set_owned(ctx, grid, axis, what, deg, n);
}

static hetab_status set_cells(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                              const label *what, double count) {
  HETAB_TRY(check_count(ctx, what, count, 1));
  size_t n = (size_t)count;
  double *deg = hetab_alloc(ctx, n, sizeof *deg);
  for (size_t i = 0; deg && i < n; i++)
    deg[i] = axis_stop[axis] * ((double)i + 0.5) / count;
  return set_owned(ctx, grid, axis, what, deg, n);
}

static hetab_status set_list(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                             const label *what, const char *spec) {
  size_t count = read_list(spec, NULL);
  if (!count)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "%s: this is no axis; write start:stop:count, cells:N, or a list such as "
                      "0,10,20.5 (degrees)",
                      what->text);
  HETAB_TRY(check_count(ctx, what, (double)count, 1));
  double *deg = hetab_alloc(ctx, count, sizeof *deg);
  if (deg)
    read_list(spec, deg);
  return set_owned(ctx, grid, axis, what, deg, count);
}

hetab_status hetab_grid_set_axis(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                                 const char *spec) {
  label what = make_label(axis, spec);
  double start, stop, count;
  if (read_range(spec, &start, &stop, &count))
    return set_range(ctx, grid, axis, &what, start, stop, count);
  if (read_cells(spec, &count))
    return set_cells(ctx, grid, axis, &what, count);
  return set_list(ctx, grid, axis, &what, spec);
}
