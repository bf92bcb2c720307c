#include "roughness/heights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- handles ------------------------------------------------------------------------------- */

hetab_status hetab_heights_new(hetab_context *ctx, const char *name, size_t columns, size_t rows,
                               hetab_heights **out) {
  *out = NULL;
  if (columns < 2 || rows < 1 || columns > HETAB_MOST_HEIGHTS / rows)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "%s: %zu x %zu heights: a scan has at least 2, and all together at most 2^27",
                      name, columns, rows);
  hetab_heights *heights = hetab_alloc(ctx, 1, sizeof *heights);
  HETAB_NEED(heights);
  heights->name = strdup(name);
  heights->z_um = hetab_alloc(ctx, columns * rows, sizeof *heights->z_um);
  heights->columns = columns;
  heights->rows = rows;
  if (!heights->name || !heights->z_um) {
    hetab_heights_free(heights);
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "%s: out of memory for %zu x %zu heights", name,
                      columns, rows);
  }
  *out = heights;
  return HETAB_OK;
}

static hetab_status check_spacing(hetab_context *ctx, const char *name, double spacing_um) {
  if (spacing_um >= 1e-6 && spacing_um <= 1e4)
    return HETAB_OK;
  return hetab_fail(
      ctx, HETAB_ERR_RANGE,
      "%s: a spacing of %g um: it has to be from 1e-6 to 1e4 um; are the units right?", name,
      spacing_um);
}

/* What a reader leaves: spacings in range, heights finite or NaN, and not beyond a metre. */
static hetab_status check_heights(hetab_context *ctx, const hetab_heights *h) {
  HETAB_TRY(check_spacing(ctx, h->name, h->spacing_um));
  if (h->kind == HETAB_HEIGHTS_MAP)
    HETAB_TRY(check_spacing(ctx, h->name, h->spacing_y_um));
  for (size_t i = 0; i < h->rows * h->columns; i++)
    if (fabs(h->z_um[i]) > 1e6)
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%s: row %zu, point %zu: a height of %g um is no roughness; are the units "
                        "right?",
                        h->name, i / h->columns + 1, i % h->columns + 1, h->z_um[i]);
  return HETAB_OK;
}

hetab_status hetab_heights_keep(hetab_context *ctx, hetab_status status, hetab_heights **out) {
  if (status == HETAB_OK)
    status = check_heights(ctx, *out);
  HETAB_MADE(hetab_heights, out, status);
}

hetab_status hetab_heights_create(hetab_context *ctx, const char *name, hetab_heights_kind kind,
                                  const double *z_um, size_t columns, size_t rows,
                                  double spacing_um, double spacing_y_um, hetab_heights **out) {
  HETAB_TRY(hetab_heights_new(ctx, name, columns, rows, out));
  hetab_heights *h = *out;
  h->kind = kind;
  h->spacing_um = spacing_um;
  h->spacing_y_um = kind == HETAB_HEIGHTS_MAP ? spacing_y_um : 0;
  for (size_t i = 0; i < rows * columns; i++)
    h->z_um[i] = isfinite(z_um[i]) ? z_um[i] : (double)NAN;
  return hetab_heights_keep(ctx, HETAB_OK, out);
}

hetab_status hetab_heights_note(hetab_context *ctx, hetab_heights *heights, const char *note) {
  heights->note = strdup(note);
  return heights->note ? HETAB_OK : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for a note");
}

void hetab_heights_free(hetab_heights *heights) {
  if (!heights)
    return;
  free(heights->name);
  free(heights->z_um);
  free(heights->note);
  free(heights);
}

const char *hetab_heights_name(const hetab_heights *heights) {
  return heights->name;
}

hetab_heights_kind hetab_heights_kind_of(const hetab_heights *heights) {
  return heights->kind;
}

size_t hetab_heights_column_count(const hetab_heights *heights) {
  return heights->columns;
}

size_t hetab_heights_row_count(const hetab_heights *heights) {
  return heights->rows;
}

double hetab_heights_spacing_um(const hetab_heights *heights) {
  return heights->spacing_um;
}

double hetab_heights_spacing_y_um(const hetab_heights *heights) {
  return heights->spacing_y_um;
}

const double *hetab_heights_z_um(const hetab_heights *heights) {
  return heights->z_um;
}
