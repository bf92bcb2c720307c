#include "surface/index_table.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include "core/number.h"

static int by_wavelength(const void *a, const void *b) {
  const hetab_row *left = a, *right = b;
  if (left->lambda_um != right->lambda_um)
    return left->lambda_um < right->lambda_um ? -1 : 1;
  return left->line < right->line ? -1 : left->line > right->line;
}

/* Two rows of a wavelength that agree this well are one, printed twice or where two series meet. */
static const double seam = 0.05, nothing = 1e-6;

static bool agree(const hetab_row *a, const hetab_row *b) {
  return hypot(a->values[0] - b->values[0], a->values[1] - b->values[1]) <=
         seam * hypot(a->values[0], a->values[1]) + nothing;
}

hetab_status hetab_rows_sort(hetab_context *ctx, const char *path, hetab_row *rows, size_t *count) {
  size_t kept = 0;
  qsort(rows, *count, sizeof *rows, by_wavelength);
  for (size_t i = 0; i < *count; i++) {
    hetab_row *r = &rows[i], *last = kept ? &rows[kept - 1] : NULL;
    if (!last || r->lambda_um != last->lambda_um) {
      rows[kept++] = *r;
      continue;
    }
    if (!agree(r, last))
      return hetab_fail(ctx, HETAB_ERR_PARSE,
                        "%s:%zu: wavelength %g um (%g nm) is in line %zu already, with other "
                        "values (%g %g; here %g %g): keep one row",
                        path, r->line, r->lambda_um, r->lambda_um * 1e3, last->line,
                        last->values[0], last->values[1], r->values[0], r->values[1]);
    for (int c = 0; c < 2; c++)
      last->values[c] = (last->values[c] + r->values[c]) / 2;
  }
  *count = kept;
  return HETAB_OK;
}

/* Values that are no index may stand in rows that nobody asks for, but not in all. */
hetab_status hetab_rows_to_curve(hetab_context *ctx, const char *path, const hetab_row *rows,
                                 size_t count, int column, bool is_k, hetab_curve *curve) {
  const hetab_rule *rule = is_k ? &hetab_rule_k : &hetab_rule_n;
  size_t good = 0;
  HETAB_TRY(hetab_curve_alloc(ctx, curve, count));
  for (size_t i = 0; i < count; i++) {
    curve->lambda_um[i] = rows[i].lambda_um;
    double value = rows[i].values[column];
    curve->values[i] = is_k && value < 0 && value >= -1e-3 ? 0 : value;
    good += curve->values[i] >= rule->min;
  }
  if (count && !good)
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%s:%zu: %c = %g, and no row is better: give %s", path,
                      rows[0].line, "nk"[is_k], rows[0].values[column], rule->wanted);
  hetab_curve_set_range(curve);
  return HETAB_OK;
}
