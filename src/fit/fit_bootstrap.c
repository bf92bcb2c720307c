/* Intervals from resampling the pairs of directions. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/number.h"
#include "core/random.h"
#include "core/scope.h"
#include "core/student.h"
#include "fit/fit_curvature.h"

enum { BOOTSTRAP_STEPS = 3 };

typedef struct resampling {
  hetab_fit_curvature *c;
  hetab_fit_state state;
  unsigned *times; /* [pairs] */
  double *values;  /* [estimate][sample] */
  size_t samples;
  uint64_t random;
} resampling;

static void draw(resampling *r) {
  size_t count = r->c->p->data.count;
  memset(r->times, 0, count * sizeof *r->times);
  for (size_t i = 0; i < count; i++)
    r->times[(size_t)(hetab_random_unit(&r->random) * (double)count)]++;
}

/* The constraint's room, linear about the best. */
static void move_room(resampling *r) {
  const hetab_fit_curvature *c = r->c;
  for (size_t g = 0; g < c->p->groups; g++) {
    r->state.room[g] = c->best->room[g];
    for (size_t m = 0; m < c->moving && c->p->constrained; m++) {
      size_t f = c->unknown[m];
      r->state.room[g] +=
          c->room[g * HETAB_FIT_MOST_FREE + m] * c->per_x[m] * (r->state.x[f] - c->best->x[f]);
    }
  }
}

/* A Gauss-Newton step with the Jacobian of the best. */
static void step(resampling *r) {
  hetab_fit_curvature *c = r->c;
  hetab_fit_number_columns(c, &r->state);
  hetab_fit_add_normal(c, &r->state, r->times);
  hetab_fit_invert(c);
  for (size_t m = 0; m < c->moving; m++) {
    double change = 0;
    for (size_t k = 0; k < c->size; k++)
      change -= c->inverse[m * c->size + k] * c->score[k];
    double *x = &r->state.x[c->unknown[m]];
    *x = fmin(fmax(*x + fmin(fmax(change, -0.5), 0.5) / c->per_x[m], 0), 1);
  }
}

/* problem->dd at the state. */
static hetab_status evaluate(resampling *r) {
  hetab_fit_problem *p = r->c->p;
  hetab_fit_values_at(p, r->state.x, r->state.value);
  hetab_fit_model_set(&p->model, r->state.value[HETAB_FIT_SIGMA0], r->state.value[HETAB_FIT_TAU],
                      r->state.value[HETAB_FIT_N]);
  return hetab_fit_model_dd(p->ctx, &p->model, p->data.pairs, p->data.count, p->dd);
}

static void record(resampling *r, size_t sample) {
  hetab_fit_problem *p = r->c->p;
  size_t n = 0;
  for (int q = HETAB_FIT_SLOPE; q <= HETAB_FIT_TAU; q++)
    r->values[n++ * r->samples + sample] = r->state.value[q];
  if (p->options.parameters[HETAB_FIT_N].free)
    r->values[n++ * r->samples + sample] = r->state.value[HETAB_FIT_N];
  for (size_t g = 0; g < p->groups; g++)
    r->values[n++ * r->samples + sample] = r->state.diffuse[g];
}

static hetab_status resample(resampling *r, size_t sample) {
  hetab_fit_problem *p = r->c->p;
  draw(r);
  hetab_fit_state_copy(p, r->c->best, &r->state);
  memcpy(p->dd, r->c->dd, p->data.count * p->data.bands * sizeof *p->dd);
  for (int k = 0; k <= BOOTSTRAP_STEPS; k++) {
    if (k > 0)
      HETAB_TRY(evaluate(r));
    move_room(r);
    hetab_fit_solve_diffuse(p, r->times, &r->state);
    if (k == BOOTSTRAP_STEPS || r->c->moving == 0)
      break;
    step(r);
  }
  record(r, sample);
  return hetab_progress(p->ctx, (double)(sample + 1), (double)r->samples);
}

static double quantile(const double *sorted, size_t count, double part) {
  double at = part * (double)(count - 1);
  size_t below = (size_t)at;
  double over = at - (double)below;
  return below + 1 < count ? (1 - over) * sorted[below] + over * sorted[below + 1] : sorted[below];
}

/* Resamplings of few pairs spread too little, by what Student's quantile has over the normal one:
 * a resampling's value is moved away from the best so. */
static double stretched(const hetab_fit_estimate *e, double value, double stretch) {
  if (e->quantity == HETAB_FIT_DIFFUSE)
    return fmax(e->value + stretch * (value - e->value), 0);
  return e->value > 0 && value > 0 ? e->value * pow(value / e->value, stretch) : value;
}

hetab_status hetab_fit_bootstrap(hetab_fit_curvature *c, hetab_fit *fit) {
  hetab_fit_problem *p = c->p;
  resampling r = {.c = c, .samples = p->options.bootstrap, .random = p->options.seed ^ 0x5bd1e995};
  HETAB_FREED double *stretch = hetab_alloc(p->ctx, fit->estimate_count, sizeof *stretch);
  hetab_status status;
  HETAB_GOTO(hetab_fit_state_create(p, &r.state));
  r.times = hetab_alloc(p->ctx, p->data.count, sizeof *r.times);
  r.values = hetab_alloc(p->ctx, fit->estimate_count, r.samples * sizeof *r.values);
  HETAB_GOTO(r.times && r.values && stretch ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t e = 0, group = 0; e < fit->estimate_count; e++) {
    hetab_fit_quantity quantity = fit->estimates[e].quantity;
    stretch[e] = hetab_fit_quantile(c, quantity, group) / hetab_student_95(HUGE_VAL);
    group += quantity == HETAB_FIT_DIFFUSE;
  }
  for (size_t s = 0; s < r.samples; s++)
    HETAB_GOTO(resample(&r, s));
  for (size_t e = 0; e < fit->estimate_count; e++) {
    double *values = &r.values[e * r.samples];
    hetab_sort(values, r.samples);
    hetab_fit_estimate *of = &fit->estimates[e];
    of->bootstrap_low = stretched(of, quantile(values, r.samples, 0.025), stretch[e]);
    of->bootstrap_high = stretched(of, quantile(values, r.samples, 0.975), stretch[e]);
  }
  fit->bootstrap_count = r.samples;
done:
  hetab_fit_state_clear(&r.state);
  free(r.times);
  free(r.values);
  return status;
}
