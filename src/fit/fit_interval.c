/* How well the measurements determine the answer: intervals and correlation. */
#include "core/student.h"
#include "fit/fit_curvature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double WIDE_DIFFUSE = 0.5; /* half widths of what is not determined */

/* ---- estimates ------------------------------------------------------------------------------- */

static double follows_moving(const hetab_fit_curvature *c, hetab_fit_quantity quantity, size_t m) {
  return hetab_fit_follows(c, quantity, c->p->free[c->unknown[m]]);
}

static int is_singular(const hetab_fit_curvature *c, hetab_fit_quantity quantity) {
  for (size_t m = 0; m < c->moving; m++)
    if (c->singular[m] && follows_moving(c, quantity, m) != 0)
      return 1;
  return 0;
}

static double log_error(const hetab_fit_curvature *c, hetab_fit_quantity quantity) {
  double variance = 0;
  for (size_t a = 0; a < c->moving; a++)
    for (size_t b = 0; b < c->moving; b++)
      variance += follows_moving(c, quantity, a) * follows_moving(c, quantity, b) *
                  c->covariance[a * c->size + b];
  return sqrt(fmax(variance, 0));
}

static hetab_fit_end end_of(const hetab_fit_curvature *c, hetab_fit_quantity quantity) {
  const hetab_fit_parameter *o = &c->p->options.parameters[quantity];
  if (c->p->apart && quantity == HETAB_FIT_SIGMA0)
    return c->best->value[quantity] <= o->low    ? HETAB_FIT_END_LOW
           : c->best->value[quantity] >= o->high ? HETAB_FIT_END_HIGH
                                                 : HETAB_FIT_END_INSIDE;
  for (size_t f = 0; f < c->p->free_count; f++)
    if (c->p->free[f] == quantity)
      return c->best->x[f] < HETAB_FIT_EDGE       ? HETAB_FIT_END_LOW
             : c->best->x[f] > 1 - HETAB_FIT_EDGE ? HETAB_FIT_END_HIGH
             : c->held && c->moving == 1          ? HETAB_FIT_END_CONSTRAINT
                                                  : HETAB_FIT_END_INSIDE;
  return HETAB_FIT_END_FIXED;
}

/* How far ln(quantity) can go up (sign 1) or down (-1) with all unknowns within their bounds. */
static double reach(const hetab_fit_curvature *c, hetab_fit_quantity quantity, int sign) {
  double sum = 0;
  for (size_t m = 0; m < c->moving; m++) {
    double x = c->best->x[c->unknown[m]], follow = sign * follows_moving(c, quantity, m);
    sum += follow * c->per_x[m] * (follow > 0 ? 1 - x : -x);
  }
  return sum;
}

static void estimate_quantity(const hetab_fit_curvature *c, hetab_fit_quantity quantity,
                              hetab_fit_estimate *e) {
  const hetab_fit_parameter *o = &c->p->options.parameters[quantity];
  double error = hetab_fit_quantile(c, quantity, 0) * log_error(c, quantity);
  *e = (hetab_fit_estimate){.quantity = quantity, .value = c->best->value[quantity]};
  e->end = end_of(c, quantity);
  e->undetermined = !(error <= HETAB_FIT_WIDE) || is_singular(c, quantity);
  if (is_singular(c, quantity))
    error = HUGE_VAL;
  e->low = e->value * exp(-(e->undetermined ? fmin(error, reach(c, quantity, -1)) : error));
  e->high = e->value * exp(e->undetermined ? fmin(error, reach(c, quantity, 1)) : error);
  if (e->undetermined && o->free) { /* sigma0 is bounded beside slope and tau */
    e->low = fmax(e->low, o->low);
    e->high = fmin(e->high, o->high);
  }
}

static double diffuse_error(const hetab_fit_curvature *c, size_t g) {
  double variance = 0;
  size_t column = c->column[g];
  if (column < c->size)
    return sqrt(fmax(c->covariance[column * c->size + column], 0));
  for (size_t a = 0; a < c->moving && c->best->end[g] == HETAB_FIT_END_CONSTRAINT; a++)
    for (size_t b = 0; b < c->moving; b++)
      variance += c->room[g * HETAB_FIT_MOST_FREE + a] * c->room[g * HETAB_FIT_MOST_FREE + b] *
                  c->covariance[a * c->size + b];
  return sqrt(fmax(variance, 0));
}

static void estimate_diffuse(const hetab_fit_curvature *c, double t, size_t g,
                             hetab_fit_estimate *e) {
  const hetab_fit_parameter *o = &c->p->options.parameters[HETAB_FIT_DIFFUSE];
  double error = t * diffuse_error(c, g);
  *e = (hetab_fit_estimate){.quantity = HETAB_FIT_DIFFUSE, .value = c->best->diffuse[g]};
  e->lambda_um = c->p->groups == 1 ? 0 : c->p->data.lambda_um[g];
  e->end = c->best->end[g];
  e->undetermined = !(error <= WIDE_DIFFUSE);
  e->low = fmax(e->value - error, 0);
  e->high = e->value + error;
  if (e->undetermined && o->free) {
    e->low = fmax(e->low, o->low);
    e->high = fmin(e->high, o->high);
  }
}

static void fill_estimates(const hetab_fit_curvature *c, hetab_fit *fit) {
  double t = hetab_student_95(hetab_fit_freedom(c));
  size_t n = 0;
  for (int q = HETAB_FIT_SLOPE; q <= HETAB_FIT_TAU; q++)
    estimate_quantity(c, (hetab_fit_quantity)q, &fit->estimates[n++]);
  if (c->p->options.parameters[HETAB_FIT_N].free)
    estimate_quantity(c, HETAB_FIT_N, &fit->estimates[n++]);
  for (size_t g = 0; g < c->p->groups; g++)
    estimate_diffuse(c, t, g, &fit->estimates[n++]);
  fit->estimate_count = n;
  for (size_t i = 0; i < n; i++)
    fit->estimates[i].bootstrap_low = fit->estimates[i].bootstrap_high = (double)NAN;
}

/* ---- correlation ----------------------------------------------------------------------------- */

static size_t place_of(const hetab_fit_curvature *c, size_t column) {
  size_t first = 3 + (size_t)(c->p->options.parameters[HETAB_FIT_N].free != 0);
  if (column < c->moving)
    return (size_t)c->p->free[c->unknown[column]];
  for (size_t g = 0; g < c->p->groups; g++)
    if (c->column[g] == column)
      return first + g;
  return 0;
}

static hetab_status fill_correlation(const hetab_fit_curvature *c, hetab_fit *fit) {
  size_t n = c->size;
  fit->free_count = n;
  fit->free_estimates = hetab_alloc(c->p->ctx, n, sizeof *fit->free_estimates);
  fit->correlation = hetab_alloc(c->p->ctx, n, n * sizeof *fit->correlation);
  HETAB_NEED(fit->free_estimates && fit->correlation);
  for (size_t i = 0; i < n; i++) {
    fit->free_estimates[i] = place_of(c, i);
    for (size_t j = 0; j < n; j++) {
      double scale = sqrt(c->covariance[i * n + i] * c->covariance[j * n + j]);
      fit->correlation[i * n + j] = scale > 0 ? c->covariance[i * n + j] / scale : i == j;
    }
  }
  return HETAB_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

hetab_status hetab_fit_intervals(hetab_fit_problem *problem, const hetab_fit_state *best,
                                 hetab_fit *fit) {
  HETAB_ENDS(hetab_fit_curvature_clear) hetab_fit_curvature c = {0};
  HETAB_TRY(hetab_fit_curvature_create(problem, best, &c));
  fill_estimates(&c, fit);
  HETAB_TRY(fill_correlation(&c, fit));
  HETAB_TRY(hetab_fit_check_profiles(&c, fit));
  return problem->options.bootstrap ? hetab_fit_bootstrap(&c, fit) : HETAB_OK;
}
