#include "surface/index_table.h"

#include <stdlib.h>

static int by_wavelength(const void *a, const void *b) {
  const hetab_row *left = a, *right = b;
  if (left->lambda_um != right->lambda_um)
    return left->lambda_um < right->lambda_um ? -1 : 1;
  return left->line < right->line ? -1 : left->line > right->line;
}

hetab_status hetab_rows_sort(hetab_context *ctx, const char *path, hetab_row *rows, size_t count) {
  qsort(rows, count, sizeof *rows, by_wavelength);
  for (size_t i = 1; i < count; i++)
    if (rows[i].lambda_um == rows[i - 1].lambda_um)
      return hetab_fail(ctx, HETAB_ERR_PARSE,
                        "%s:%zu: wavelength %g um (%g nm) is in line %zu already: keep one row",
                        path, rows[i].line, rows[i].lambda_um, rows[i].lambda_um * 1e3,
                        rows[i - 1].line);
  return HETAB_OK;
}

hetab_status hetab_rows_to_curve(hetab_context *ctx, const hetab_row *rows, size_t count,
                                 int column, hetab_curve *curve) {
  HETAB_TRY(hetab_curve_alloc(ctx, curve, count));
  for (size_t i = 0; i < count; i++) {
    curve->lambda_um[i] = rows[i].lambda_um;
    curve->values[i] = rows[i].values[column];
  }
  hetab_curve_set_range(curve);
  return HETAB_OK;
}
