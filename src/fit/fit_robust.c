/* A Cauchy loss in place of squares, by fitting again with weights that follow the residuals: a
 * value u robust standard deviations off counts 1 / (1 + (u / 2.385)^2) (95 % efficient for normal
 * noise). Residuals are relative to the model, whose noise is, so that a lobe is not an outlier. */
#include "fit/fit_internal.h"
#include "core/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TUNING = 2.385, DISTRUST = 5, MAD = 1.4826;
static const double LEAST = 1e-3; /* of a wavelength's mean: below it noise is no longer relative */
static const double LEAST_SCALE = 1e-9, CONVERGED = 1e-6;
enum { MOST_ROUNDS = 40 };

typedef struct loss {
  double *base;     /* [values] weights of the squares */
  double *residual; /* [values] */
  double *sorted;   /* [values] sizes of those in the fit */
} loss;

static void find_residuals(const hetab_fit_problem *p, const hetab_fit_state *s, loss *l) {
  size_t bands = p->data.bands;
  for (size_t b = 0; b < bands; b++) {
    double a = s->diffuse[hetab_fit_group(p, b)] / M_PI, mean = 0, slope;
    for (size_t i = b; i < p->data.count * bands; i += bands)
      mean += (p->dd[i] + a) / (double)p->data.count;
    for (size_t i = b; i < p->data.count * bands; i += bands) {
      double f = p->dd[i] + a, r = l->base[i] > 0 ? hetab_fit_residual(p, i, f, &slope) : 0;
      bool relative = p->options.weights == HETAB_FIT_WEIGHTS_LOG;
      l->residual[i] = relative ? r : r / (f + LEAST * mean);
    }
  }
}

/* 1.4826 times the median of their sizes. */
static double robust_scale(const hetab_fit_problem *p, loss *l) {
  size_t used = 0;
  for (size_t i = 0; i < p->data.count * p->data.bands; i++)
    if (l->base[i] > 0)
      l->sorted[used++] = fabs(l->residual[i]);
  hetab_sort(l->sorted, used);
  return fmax(MAD * l->sorted[used / 2], LEAST_SCALE);
}

static void weigh(hetab_fit_problem *p, loss *l) {
  double scale = robust_scale(p, l);
  hetab_fit_data *d = &p->data;
  d->scale = 0;
  p->distrusted_count = 0;
  for (size_t i = 0; i < d->count * d->bands; i++) {
    double u = fabs(l->residual[i]) / scale, f = d->measured[i];
    d->weight[i] = l->base[i] / (1 + u * u / (TUNING * TUNING));
    d->scale += d->weight[i] * (p->options.weights == HETAB_FIT_WEIGHTS_LOG ? 1 : f * f);
    p->distrusted[i] = l->base[i] > 0 && u > DISTRUST;
    p->distrusted_count += p->distrusted[i];
  }
}

/* From where `best` is. */
static hetab_status fit_again(hetab_fit_problem *p, hetab_fit_state *best, hetab_fit *fit) {
  for (size_t f = 0; f < p->free_count; f++)
    p->options.parameters[p->free[f]].value = best->value[p->free[f]];
  free(fit->starts);
  fit->starts = NULL;
  fit->start_count = p->evaluations = 0;
  return hetab_fit_search(p, best, fit);
}

static hetab_status iterate(hetab_fit_problem *p, loss *l, hetab_fit_state *best, hetab_fit *fit) {
  memcpy(l->base, p->data.weight, p->data.count * p->data.bands * sizeof *l->base);
  HETAB_TRY(hetab_fit_search(p, best, fit));
  p->options.starts = 0;
  for (int round = 0; round < MOST_ROUNDS; round++) {
    double before[HETAB_FIT_MOST_FREE], moved = 0;
    memcpy(before, best->x, sizeof before);
    HETAB_TRY(hetab_fit_evaluate(p, best));
    find_residuals(p, best, l);
    weigh(p, l);
    HETAB_TRY(fit_again(p, best, fit));
    for (size_t f = 0; f < p->free_count; f++)
      moved = fmax(moved, fabs(best->x[f] - before[f]));
    if (round > 0 && moved < CONVERGED)
      break;
  }
  return HETAB_OK;
}

hetab_status hetab_fit_make_robust(hetab_fit_problem *p, hetab_fit_state *best, hetab_fit *fit) {
  size_t values = p->data.count * p->data.bands, starts = p->options.starts;
  loss l = {.base = hetab_alloc(p->ctx, 3 * values, sizeof *l.base)};
  p->distrusted = hetab_alloc(p->ctx, values, 1);
  if (!l.base || !p->distrusted) {
    free(l.base);
    return HETAB_ERR_MEMORY;
  }
  l.residual = l.base + values;
  l.sorted = l.residual + values;
  hetab_status status = iterate(p, &l, best, fit);
  free(l.base);
  free(fit->starts);
  fit->starts = NULL;
  fit->start_count = p->evaluations = 0;
  p->options.starts = starts;
  return status;
}
