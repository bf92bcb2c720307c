#include "surface/index_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "surface/formulas.h"
#include "surface/metals.h"
#include "core/number.h"
#include "core/text.h"

/* ---- curves ---- */

hetab_status hetab_curve_alloc(hetab_context *ctx, hetab_curve *curve, size_t count) {
  *curve = (hetab_curve){.count = count};
  curve->lambda_um = hetab_alloc(ctx, count, sizeof *curve->lambda_um);
  curve->values = hetab_alloc(ctx, count, sizeof *curve->values);
  return curve->lambda_um && curve->values ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_curve_set_range(hetab_curve *curve) {
  curve->min_um = curve->lambda_um[0];
  curve->max_um = curve->lambda_um[curve->count - 1];
}

static void curve_free(hetab_curve *curve) {
  free(curve->lambda_um);
  free(curve->values);
}

/* The end values are held outside the nodes. */
static double table_at(const hetab_curve *curve, double lambda_um) {
  const double *lambda = curve->lambda_um, *value = curve->values;
  size_t low = 0, high = curve->count - 1;
  if (lambda_um <= lambda[low])
    return value[low];
  if (lambda_um >= lambda[high])
    return value[high];
  while (high - low > 1) {
    size_t middle = low + (high - low) / 2;
    if (lambda[middle] <= lambda_um)
      low = middle;
    else
      high = middle;
  }
  double part = (lambda_um - lambda[low]) / (lambda[high] - lambda[low]);
  return value[low] + part * (value[high] - value[low]);
}

static double curve_at(const hetab_curve *curve, double lambda_um) {
  if (curve->formula)
    return hetab_formula_at(curve->formula, curve->values, curve->count, lambda_um);
  return curve->count ? table_at(curve, lambda_um) : 0;
}

/* ---- making an index ---- */

hetab_status hetab_index_new(hetab_context *ctx, hetab_index_origin origin, const char *source,
                             hetab_index **out) {
  hetab_index *index = hetab_alloc(ctx, 1, sizeof *index);
  char *copy = hetab_alloc(ctx, strlen(source) + 1, 1);
  if (!index || !copy) {
    free(index);
    free(copy);
    return HETAB_ERR_MEMORY;
  }
  strcpy(copy, source);
  *index = (hetab_index){.origin = origin, .source = copy};
  index->k.max_um = HUGE_VAL;
  *out = index;
  return HETAB_OK;
}

void hetab_index_free(hetab_index *index) {
  if (!index)
    return;
  curve_free(&index->n);
  curve_free(&index->k);
  free(index->source);
  free(index);
}

static hetab_status fill_constant(hetab_context *ctx, hetab_curve *curve, double value) {
  HETAB_TRY(hetab_curve_alloc(ctx, curve, 1));
  curve->values[0] = value;
  curve->max_um = HUGE_VAL;
  return HETAB_OK;
}

hetab_status hetab_index_constant(hetab_context *ctx, double n, double k, hetab_index **out) {
  *out = NULL;
  HETAB_TRY(hetab_number_check(ctx, &hetab_rule_n, n));
  HETAB_TRY(hetab_number_check(ctx, &hetab_rule_k, k));
  hetab_index *index;
  HETAB_TRY(hetab_index_new(ctx, HETAB_INDEX_CONSTANT, "constant", &index));
  hetab_status status = fill_constant(ctx, &index->n, n);
  if (status == HETAB_OK)
    status = fill_constant(ctx, &index->k, k);
  *out = index;
  HETAB_MADE(hetab_index, out, status);
}

static hetab_status copy_curve(hetab_context *ctx, const hetab_curve *from, hetab_curve *to) {
  size_t bytes = from->count * sizeof *from->values;
  if (!from->count)
    return HETAB_OK;
  HETAB_TRY(hetab_curve_alloc(ctx, to, from->count));
  memcpy(to->values, from->values, bytes);
  if (from->lambda_um)
    memcpy(to->lambda_um, from->lambda_um, bytes);
  to->formula = from->formula;
  to->min_um = from->min_um;
  to->max_um = from->max_um;
  return HETAB_OK;
}

hetab_status hetab_index_copy(hetab_context *ctx, const hetab_index *index, hetab_index **out) {
  hetab_index *copy;
  *out = NULL;
  HETAB_TRY(hetab_index_new(ctx, index->origin, index->source, &copy));
  copy->symbol = index->symbol;
  copy->k.max_um = index->k.max_um;
  hetab_status status = copy_curve(ctx, &index->n, &copy->n);
  if (status == HETAB_OK)
    status = copy_curve(ctx, &index->k, &copy->k);
  *out = copy;
  HETAB_MADE(hetab_index, out, status);
}

/* column: 1 for n, 2 for k. */
static hetab_status fill_metal(hetab_context *ctx, const hetab_metal *metal, int column,
                               hetab_curve *curve) {
  HETAB_TRY(hetab_curve_alloc(ctx, curve, metal->count));
  for (size_t i = 0; i < curve->count; i++) {
    curve->lambda_um[i] = metal->rows[3 * i];
    curve->values[i] = metal->rows[3 * i + (size_t)column];
  }
  hetab_curve_set_range(curve);
  return HETAB_OK;
}

static hetab_status fail_unknown_metal(hetab_context *ctx, const char *symbol) {
  char all[256] = "";
  for (size_t i = 0; i < hetab_metal_count(); i++)
    hetab_append_word(all, sizeof all, hetab_metal_symbol(i));
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "no built-in metal '%.40s': choose %s, or give {file: PATH} or {n: N, k: K}",
                    symbol, all);
}

hetab_status hetab_index_metal(hetab_context *ctx, const char *symbol, hetab_index **out) {
  *out = NULL;
  const hetab_metal *metal = hetab_metal_find(symbol);
  if (!metal)
    return fail_unknown_metal(ctx, symbol);
  hetab_index *index;
  HETAB_TRY(hetab_index_new(ctx, HETAB_INDEX_METAL, metal->citation, &index));
  index->symbol = metal->symbol;
  hetab_status status = fill_metal(ctx, metal, 1, &index->n);
  if (status == HETAB_OK)
    status = fill_metal(ctx, metal, 2, &index->k);
  *out = index;
  HETAB_MADE(hetab_index, out, status);
}

/* ---- reading it ---- */

void hetab_index_range(const hetab_index *index, double *min_um, double *max_um) {
  *min_um = fmax(index->n.min_um, index->k.min_um);
  *max_um = fmin(index->n.max_um, index->k.max_um);
}

const char *hetab_index_source(const hetab_index *index) {
  return index->source;
}

static const char *short_name(const hetab_index *index) {
  return index->symbol ? index->symbol : index->source;
}

static hetab_status check_range(hetab_context *ctx, const hetab_index *index, double lambda_um) {
  /* Wavelengths come in nm and in um: rounding in the conversion does not leave the range. */
  const double slack = 1e-12;
  double min_um, max_um;
  hetab_index_range(index, &min_um, &max_um);
  if (lambda_um >= min_um * (1 - slack) && lambda_um <= max_um * (1 + slack))
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "%g um (%g nm) is outside the index data of %s, %g to %g um (%g to %g nm): "
                    "choose wavelengths within, or allow it with extrapolate_index: true",
                    lambda_um, lambda_um * 1e3, short_name(index), min_um, max_um, min_um * 1e3,
                    max_um * 1e3);
}

/* Formulas and extrapolation can end anywhere: what leaves here is an index, or an error. */
static hetab_status check_value(hetab_context *ctx, const hetab_index *index, double lambda_um,
                                double n, double k) {
  if (n >= hetab_rule_n.min && n <= hetab_rule_n.max && k >= hetab_rule_k.min &&
      k <= hetab_rule_k.max)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "%s gives n = %g, k = %g at %g um, which is no index: choose other wavelengths "
                    "or other data",
                    short_name(index), n, k, lambda_um);
}

hetab_status hetab_index_at(hetab_context *ctx, const hetab_index *index, double lambda_um,
                            int extrapolate, double *n, double *k) {
  HETAB_TRY(hetab_number_check(ctx, &hetab_rule_length, lambda_um));
  if (!extrapolate)
    HETAB_TRY(check_range(ctx, index, lambda_um));
  double n_here = curve_at(&index->n, lambda_um);
  double k_here = curve_at(&index->k, lambda_um);
  HETAB_TRY(check_value(ctx, index, lambda_um, n_here, k_here));
  *n = n_here;
  *k = k_here;
  return HETAB_OK;
}
