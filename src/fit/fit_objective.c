/* One evaluation of the objective: the model from the device, the diffuse part exactly. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a wavelength's mean, added before logarithms are taken: what a model has 10^-12 of where the
 * measurements have a hundredth would outweigh all else. */
static const double LOG_FLOOR = 1e-2;
enum { MOST_NEWTON = 60 };

/* ---- states ---------------------------------------------------------------------------------- */

hetab_status hetab_fit_state_create(const hetab_fit_problem *problem, hetab_fit_state *state) {
  *state = (hetab_fit_state){.q = HUGE_VAL, .spare = -HUGE_VAL};
  state->diffuse = hetab_alloc(problem->ctx, problem->groups, sizeof *state->diffuse);
  state->room = hetab_alloc(problem->ctx, problem->groups, sizeof *state->room);
  state->end = hetab_alloc(problem->ctx, problem->groups, sizeof *state->end);
  if (state->diffuse && state->room && state->end)
    return HETAB_OK;
  hetab_fit_state_clear(state);
  return HETAB_ERR_MEMORY;
}

void hetab_fit_state_copy(const hetab_fit_problem *problem, const hetab_fit_state *from,
                          hetab_fit_state *to) {
  double *diffuse = to->diffuse, *room = to->room;
  hetab_fit_end *end = to->end;
  memcpy(diffuse, from->diffuse, problem->groups * sizeof *diffuse);
  memcpy(room, from->room, problem->groups * sizeof *room);
  memcpy(end, from->end, problem->groups * sizeof *end);
  *to = *from;
  to->diffuse = diffuse;
  to->room = room;
  to->end = end;
}

void hetab_fit_state_clear(hetab_fit_state *state) {
  free(state->diffuse);
  free(state->room);
  free(state->end);
  *state = (hetab_fit_state){0};
}

int hetab_fit_feasible(const hetab_fit_state *state) {
  return state->spare >= -HETAB_FIT_SLACK;
}

/* ---- quantities ------------------------------------------------------------------------------ */

void hetab_fit_values_at(const hetab_fit_problem *problem, const double *x, double *value) {
  const hetab_fit_parameter *p = problem->options.parameters;
  for (int k = 0; k < HETAB_FIT_QUANTITIES; k++)
    value[k] = p[k].free ? 0 : p[k].value;
  for (size_t f = 0; f < problem->free_count; f++) {
    const hetab_fit_parameter *at = &p[problem->free[f]];
    value[problem->free[f]] = at->low * pow(at->high / at->low, x[f]);
  }
  if (problem->apart) {
    const hetab_fit_parameter *sigma0 = &p[HETAB_FIT_SIGMA0];
    double wanted = value[HETAB_FIT_SLOPE] * value[HETAB_FIT_TAU];
    value[HETAB_FIT_SIGMA0] = fmin(fmax(wanted, sigma0->low), sigma0->high);
    value[HETAB_FIT_SLOPE] = value[HETAB_FIT_SIGMA0] / value[HETAB_FIT_TAU];
  } else if (value[HETAB_FIT_SIGMA0] == 0)
    value[HETAB_FIT_SIGMA0] = value[HETAB_FIT_SLOPE] * value[HETAB_FIT_TAU];
  else if (value[HETAB_FIT_TAU] == 0)
    value[HETAB_FIT_TAU] = value[HETAB_FIT_SIGMA0] / value[HETAB_FIT_SLOPE];
  else
    value[HETAB_FIT_SLOPE] = value[HETAB_FIT_SIGMA0] / value[HETAB_FIT_TAU];
}

double hetab_fit_residual(const hetab_fit_problem *problem, size_t i, double f, double *slope) {
  *slope = 1;
  if (problem->options.weights != HETAB_FIT_WEIGHTS_LOG)
    return f - problem->data.measured[i];
  double floor = LOG_FLOOR * problem->data.mean[i % problem->data.bands];
  *slope = 1 / (f + floor);
  return log((f + floor) / (problem->data.measured[i] + floor));
}

/* ---- the diffuse part ------------------------------------------------------------------------ */

/* Sums over a group's values at the diffuse part a: of the squares, and of the normal equation for
 * a step of a. */
typedef struct sums {
  double squares, gradient, curvature;
} sums;

static void add_value(const hetab_fit_problem *p, size_t i, double a, double times, sums *s) {
  double slope, w = times * p->data.weight[i];
  if (w == 0)
    return;
  double r = hetab_fit_residual(p, i, p->dd[i] + a / M_PI, &slope);
  slope /= M_PI;
  s->squares += w * r * r;
  s->gradient += w * r * slope;
  s->curvature += w * slope * slope;
}

static sums sums_at(const hetab_fit_problem *p, const unsigned *times, size_t group, double a) {
  sums s = {0};
  size_t bands = p->data.bands, first = p->groups == 1 ? 0 : group;
  size_t end = p->groups == 1 ? bands : group + 1;
  for (size_t i = 0; i < p->data.count; i++)
    for (size_t b = first; b < end && (!times || times[i]); b++)
      add_value(p, i * bands + b, a, times ? times[i] : 1, &s);
  return s;
}

/* Logarithms: Newton's steps, halved until they help. */
static double improve(const hetab_fit_problem *p, const unsigned *times, size_t group, double low,
                      double high, double a) {
  sums s = sums_at(p, times, group, a);
  for (int n = 0; n < MOST_NEWTON && s.curvature > 0; n++) {
    double step = -s.gradient / s.curvature, next = a;
    sums tried = s;
    for (int half = 0; half < 30; half++, step *= 0.5) {
      next = fmin(fmax(a + step, low), high);
      tried = sums_at(p, times, group, next);
      if (tried.squares <= s.squares)
        break;
    }
    int done = !(tried.squares < s.squares) || fabs(next - a) <= 1e-12 * high;
    if (tried.squares <= s.squares) {
      a = next;
      s = tried;
    }
    if (done)
      break;
  }
  return a;
}

static double best_diffuse(const hetab_fit_problem *p, const unsigned *times, size_t group,
                           double low, double high) {
  sums s = sums_at(p, times, group, low);
  double a = s.curvature > 0 ? low - s.gradient / s.curvature : low;
  a = fmin(fmax(a, low), high);
  return p->options.weights == HETAB_FIT_WEIGHTS_LOG
             ? improve(p, times, group, low, high, fmin(fmax(0.01, low), high))
             : a;
}

void hetab_fit_solve_diffuse(const hetab_fit_problem *problem, const unsigned *times,
                             hetab_fit_state *state) {
  const hetab_fit_parameter *o = &problem->options.parameters[HETAB_FIT_DIFFUSE];
  state->q = 0;
  state->spare = HUGE_VAL;
  for (size_t g = 0; g < problem->groups; g++) {
    double low = o->free ? o->low : o->value, high = o->free ? o->high : o->value;
    double most = fmax(low, fmin(high, state->room[g]));
    double a = o->free ? best_diffuse(problem, times, g, low, most) : low;
    state->diffuse[g] = a;
    state->end[g] = !o->free                                 ? HETAB_FIT_END_FIXED
                    : a > low && a < most                    ? HETAB_FIT_END_INSIDE
                    : a == most && most < high && low < most ? HETAB_FIT_END_CONSTRAINT
                    : a == low                               ? HETAB_FIT_END_LOW
                                                             : HETAB_FIT_END_HIGH;
    state->spare = fmin(state->spare, state->room[g] - low);
    state->q += sums_at(problem, times, g, a).squares / problem->data.scale;
  }
}

/* ---- evaluation ------------------------------------------------------------------------------ */

static hetab_status find_room(hetab_fit_problem *p, hetab_fit_state *state) {
  HETAB_TRY(
      hetab_fit_model_room(p->ctx, &p->model, &p->data, p->options.constraint, p->active, p->room));
  for (size_t i = 0; i < p->data.incidence_count * p->data.bands; i++) {
    double *least = &state->room[hetab_fit_group(p, i % p->data.bands)];
    *least = fmin(*least, p->room[i]);
  }
  return HETAB_OK;
}

hetab_status hetab_fit_evaluate(hetab_fit_problem *problem, hetab_fit_state *state) {
  hetab_fit_values_at(problem, state->x, state->value);
  int n_free = problem->options.parameters[HETAB_FIT_N].free;
  hetab_fit_model_set(&problem->model, state->value[HETAB_FIT_SIGMA0], state->value[HETAB_FIT_TAU],
                      n_free ? state->value[HETAB_FIT_N] : 0);
  HETAB_TRY(hetab_fit_model_dd(problem->ctx, &problem->model, problem->data.pairs,
                               problem->data.count, problem->dd));
  for (size_t g = 0; g < problem->groups; g++)
    state->room[g] = HUGE_VAL;
  hetab_fit_solve_diffuse(problem, NULL, state);
  problem->evaluations++;
  if (!problem->constrained)
    return HETAB_OK;
  if (state->q >= problem->dull) {
    state->spare = -HUGE_VAL;
    return HETAB_OK;
  }
  HETAB_TRY(find_room(problem, state));
  hetab_fit_solve_diffuse(problem, NULL, state);
  return HETAB_OK;
}
