/* The fit as a whole: first without the constraint, and only if that breaks it, with. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "surface/index_parts.h"
#include "surface/surface_parts.h"

#include "core/option_size.h"

void hetab_fit_free(hetab_fit *fit) {
  if (!fit)
    return;
  for (size_t i = 0; i < fit->note_count; i++)
    free(fit->notes[i]);
  free(fit->notes);
  free(fit->estimates);
  free(fit->free_estimates);
  free(fit->correlation);
  free(fit->incidences);
  free(fit->starts);
  free(fit->band_of);
  free(fit->lambda_um);
  free(fit->diffuse);
  free(fit->model);
  free(fit->used);
  free(fit->distrusted);
  hetab_surface_free(fit->surface);
  free(fit);
}

/* Of sigma0 and tau apart: a slope's bounds by default. */
static const double LEAST_SLOPE = 0.005, MOST_SLOPE = 1;

/* ---- the problem ----------------------------------------------------------------------------- */

static void clear_problem(hetab_fit_problem *p) {
  hetab_fit_data_clear(&p->data);
  hetab_fit_model_clear(&p->model);
  free(p->dd);
  free(p->room);
  free(p->active);
  free(p->distrusted);
}

/* sigma0 and tau apart: the objective is a valley along a constant slope, so that is what is
 * searched. */
static void take_slope(hetab_fit_problem *p) {
  hetab_fit_parameter *o = p->options.parameters, *slope = &o[HETAB_FIT_SLOPE];
  const hetab_fit_parameter *sigma0 = &o[HETAB_FIT_SIGMA0], *tau = &o[HETAB_FIT_TAU];
  if (!sigma0->free || !tau->free)
    return;
  *slope = (hetab_fit_parameter){.free = 1};
  slope->low = sigma0->low / tau->high;
  slope->high = sigma0->high / tau->low;
  if (slope->low < MOST_SLOPE && slope->high > LEAST_SLOPE) {
    slope->low = fmax(slope->low, LEAST_SLOPE);
    slope->high = fmin(slope->high, MOST_SLOPE);
  }
  if (sigma0->value > 0 && tau->value > 0)
    slope->value = sigma0->value / tau->value;
  p->apart = 1;
}

static hetab_status choose_unknowns(hetab_fit_problem *p) {
  const hetab_fit_parameter *o = p->options.parameters;
  take_slope(p);
  for (int q = 0; q < HETAB_FIT_DIFFUSE; q++)
    if (o[q].free && !(p->apart && q == HETAB_FIT_SIGMA0))
      p->free[p->free_count++] = (hetab_fit_quantity)q;
  p->groups = o[HETAB_FIT_DIFFUSE].free && !p->options.one_diffuse ? p->data.bands : 1;
  if (p->groups > HETAB_FIT_MOST_DIFFUSE)
    return hetab_fail(p->ctx, HETAB_ERR_ARGUMENT,
                      "a diffuse part for each of %zu wavelengths: choose at most %d wavelengths, "
                      "or one diffuse part for all",
                      p->groups, HETAB_FIT_MOST_DIFFUSE);
  size_t unknowns = p->free_count + (o[HETAB_FIT_DIFFUSE].free ? p->groups : 0);
  if (p->data.values <= unknowns || p->data.count <= p->free_count + 1)
    return hetab_fail(p->ctx, HETAB_ERR_RANGE,
                      "%zu measured values at %zu pairs of directions do not determine %zu "
                      "unknowns: use more measurements or fix something",
                      p->data.values, p->data.count, unknowns);
  return HETAB_OK;
}

/* Dielectrics return what enters them: the report's bound is for metals. What the model alone is
 * above it by is the model's fault, and another roughness would not describe the surface. */
static void choose_constraint(hetab_fit_problem *p) {
  const hetab_surface *surface = p->model.surface;
  if (p->options.constraint != HETAB_FIT_AUTO)
    return;
  p->options.constraint = HETAB_FIT_ENERGY;
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++)
    if (hetab_surface_bands(surface)[b].k > 0) {
      p->options.constraint = HETAB_FIT_POLISHED;
      p->model.own_excess = 5e-3;
    }
}

static hetab_status prepare(hetab_fit_problem *p, hetab_engine *engine,
                            const hetab_measurements *measurements) {
  HETAB_TRY(hetab_fit_options_check(p->ctx, &p->options));
  HETAB_TRY(hetab_fit_data_select(p->ctx, measurements, &p->options, &p->data));
  HETAB_TRY(hetab_fit_data_weigh(p->ctx, &p->options.weights, &p->data));
  HETAB_TRY(hetab_fit_bounds_check(p->ctx, &p->options, p->data.lambda_um[0]));
  HETAB_TRY(choose_unknowns(p));
  HETAB_TRY(hetab_fit_model_create(p->ctx, engine, &p->options, &p->data, &p->model));
  choose_constraint(p);
  p->dd = hetab_alloc(p->ctx, p->data.count * p->data.bands, sizeof *p->dd);
  p->room = hetab_alloc(p->ctx, p->data.incidence_count * p->data.bands, sizeof *p->room);
  return p->dd && p->room ? HETAB_OK : HETAB_ERR_MEMORY;
}

/* ---- two stages ------------------------------------------------------------------------------ */

/* What the fit without the constraint would exceed it by, from problem->room. */
static void record_wish(hetab_fit_problem *p, const hetab_fit_state *wished) {
  hetab_fit_wish *wish = &p->wish;
  wish->q = wished->q;
  memcpy(wish->value, wished->value, sizeof wish->value);
  wish->excess = -HUGE_VAL;
  for (size_t i = 0; i < p->data.incidence_count * p->data.bands; i++) {
    size_t band = i % p->data.bands;
    double excess = wished->diffuse[hetab_fit_group(p, band)] - p->room[i];
    if (excess > wish->excess) {
      wish->excess = excess;
      wish->theta_i = p->data.theta_i[i / p->data.bands];
      wish->lambda_um = p->data.lambda_um[band];
    }
  }
}

/* The incidences with the least room for each wavelength become active, where the state breaks the
 * constraint by problem->room; returns whether there are any. */
static int activate(hetab_fit_problem *p, const hetab_fit_state *state, unsigned char *active) {
  int any = 0;
  for (size_t b = 0; b < p->data.bands; b++) {
    size_t least = 0;
    for (size_t t = 1; t < p->data.incidence_count; t++)
      if (p->room[t * p->data.bands + b] < p->room[least * p->data.bands + b])
        least = t;
    double room = p->room[least * p->data.bands + b];
    if (state->diffuse[hetab_fit_group(p, b)] - room > HETAB_FIT_SLACK && !active[least])
      any = active[least] = 1;
  }
  return any;
}

/* Under the constraint where it was broken, until it is nowhere. */
static hetab_status search_constrained(hetab_fit_problem *p, hetab_fit_state *best,
                                       hetab_fit_state *whole, hetab_fit *fit) {
  unsigned char *active = hetab_alloc(p->ctx, p->data.incidence_count, 1);
  hetab_status status = active ? HETAB_OK : HETAB_ERR_MEMORY;
  while (status == HETAB_OK && activate(p, best, active)) {
    p->active = active;
    free(fit->starts);
    fit->starts = NULL;
    status = hetab_fit_search(p, best, fit);
    if (status != HETAB_OK || !hetab_fit_feasible(best))
      break;
    p->active = NULL;
    memcpy(whole->x, best->x, sizeof whole->x);
    status = hetab_fit_evaluate(p, whole);
  }
  p->active = active;
  return status;
}

/* best holds the unconstrained optimum, which is the constrained one too if it keeps to it. */
static hetab_status constrain(hetab_fit_problem *p, hetab_fit_state *best, hetab_fit *fit) {
  hetab_fit_state same;
  HETAB_TRY(hetab_fit_state_create(p, &same));
  p->constrained = 1;
  memcpy(same.x, best->x, sizeof same.x);
  hetab_status status = hetab_fit_evaluate(p, &same);
  if (status == HETAB_OK) {
    record_wish(p, best);
    fit->on_constraint = p->wish.excess > HETAB_FIT_SLACK;
    if (!fit->on_constraint)
      hetab_fit_state_copy(p, &same, best);
  }
  if (status == HETAB_OK && fit->on_constraint)
    status = search_constrained(p, best, &same, fit);
  hetab_fit_state_clear(&same);
  return status;
}

static hetab_status search(hetab_fit_problem *p, hetab_fit_state *best, hetab_fit_state *wished,
                           hetab_fit *fit) {
  HETAB_TRY(hetab_fit_search(p, best, fit));
  hetab_fit_state_copy(p, best, wished);
  if (p->options.constraint != HETAB_FIT_UNCONSTRAINED)
    HETAB_TRY(constrain(p, best, fit));
  fit->stop = !hetab_fit_feasible(best)                      ? HETAB_FIT_STOP_INFEASIBLE
              : p->evaluations >= p->options.max_evaluations ? HETAB_FIT_STOP_BUDGET
                                                             : HETAB_FIT_STOP_TOLERANCE;
  return HETAB_OK;
}

/* ---- the result ------------------------------------------------------------------------------ */

/* Another end, outside the interval of this one, that the data do not tell from it. */
static void find_ambiguity(const hetab_fit_problem *p, hetab_fit *fit) {
  double freedom = fmax((double)p->data.count - (double)p->free_count - 1, 1);
  double most = fit->error * sqrt(1 + 3.84 / freedom);
  for (size_t i = 0; i < fit->start_count; i++)
    for (size_t f = 0; f < p->free_count; f++) {
      const hetab_fit_start *start = &fit->starts[i];
      const hetab_fit_estimate *e = &fit->estimates[p->free[f]];
      double end = start->end[p->free[f]];
      if (start->feasible && !start->best && start->error <= most &&
          fabs(log(end / e->value)) > 0.01 && (end < e->low || end > e->high))
        fit->ambiguous = 1;
    }
}

static void fill_numbers(const hetab_fit_problem *p, const hetab_fit_state *best,
                         const hetab_fit_state *wished, hetab_fit *fit) {
  fit->slope = best->value[HETAB_FIT_SLOPE];
  fit->sigma0_um = best->value[HETAB_FIT_SIGMA0];
  fit->tau_um = best->value[HETAB_FIT_TAU];
  fit->error = sqrt(best->q);
  fit->weights = p->options.weights;
  fit->constraint = p->options.constraint;
  fit->used_pairs = p->data.count;
  fit->used_values = p->data.values;
  fit->missing = p->data.missing;
  fit->thinned = p->data.thinned;
  fit->distrusted_values = p->distrusted_count;
  size_t first = fit->estimate_count - p->groups;
  for (size_t i = 0; i < fit->estimate_count; i++)
    fit->estimates[i].wanted =
        i < first ? wished->value[fit->estimates[i].quantity] : wished->diffuse[i - first];
  find_ambiguity(p, fit);
}

static hetab_status allocate_fit(hetab_fit_problem *p, const hetab_measurements *m,
                                 hetab_fit *fit) {
  size_t bands = fit->bands = p->data.bands, count = hetab_measurements_pair_count(m);
  fit->estimates = hetab_alloc(p->ctx, 4 + p->groups, sizeof *fit->estimates);
  fit->incidences = hetab_alloc(p->ctx, p->data.incidence_count, sizeof *fit->incidences);
  fit->band_of = hetab_alloc(p->ctx, bands, sizeof *fit->band_of);
  fit->lambda_um = hetab_alloc(p->ctx, bands, sizeof *fit->lambda_um);
  fit->diffuse = hetab_alloc(p->ctx, bands, sizeof *fit->diffuse);
  fit->model = hetab_alloc(p->ctx, count, bands * sizeof *fit->model);
  fit->used = hetab_alloc(p->ctx, count, bands);
  fit->distrusted = hetab_alloc(p->ctx, count, bands);
  return fit->estimates && fit->incidences && fit->band_of && fit->lambda_um && fit->diffuse &&
                 fit->model && fit->used && fit->distrusted
             ? HETAB_OK
             : HETAB_ERR_MEMORY;
}

static hetab_status fill_model(hetab_fit_problem *p, const hetab_measurements *m,
                               const hetab_fit_state *best, hetab_fit *fit) {
  size_t bands = fit->bands, count = hetab_measurements_pair_count(m);
  memcpy(fit->band_of, p->data.band_of, bands * sizeof *fit->band_of);
  memcpy(fit->lambda_um, p->data.lambda_um, bands * sizeof *fit->lambda_um);
  for (size_t b = 0; b < bands; b++)
    fit->diffuse[b] = best->diffuse[hetab_fit_group(p, b)];
  hetab_fit_model_set(&p->model, best->value[HETAB_FIT_SIGMA0], best->value[HETAB_FIT_TAU],
                      best->value[HETAB_FIT_N]);
  HETAB_TRY(hetab_fit_model_dd(p->ctx, &p->model, hetab_measurements_pairs(m), count, fit->model));
  for (size_t i = 0; i < count * bands; i++)
    fit->model[i] += fit->diffuse[i % bands] / M_PI;
  for (size_t i = 0; i < p->data.count; i++)
    for (size_t b = 0; b < bands; b++) {
      size_t place = p->data.pair_of[i] * bands + b;
      fit->used[place] = p->data.weight[i * bands + b] > 0;
      fit->distrusted[place] = p->distrusted && p->distrusted[i * bands + b];
    }
  return HETAB_OK;
}

/* ---- incidences ------------------------------------------------------------------------------ */

typedef struct incidence_sums {
  double squares, scale, plain, values, measured, bias;
} incidence_sums;

static void add_residual(const hetab_fit_problem *p, const hetab_fit *fit, size_t pair, size_t b,
                         incidence_sums *s) {
  size_t i = pair * fit->bands + b;
  double slope, w = p->data.weight[i], measured = p->data.measured[i];
  if (w == 0)
    return;
  double model = fit->model[p->data.pair_of[pair] * fit->bands + b];
  double r = hetab_fit_residual(p, i, model, &slope);
  s->squares += w * r * r;
  s->scale += w * (p->options.weights == HETAB_FIT_WEIGHTS_LOG ? 1 : measured * measured);
  s->plain += (model - measured) * (model - measured);
  s->values++;
  s->measured += measured;
  s->bias += model - measured;
}

static hetab_status fill_residuals(const hetab_fit_problem *p, hetab_fit *fit) {
  HETAB_FREED incidence_sums *sums = hetab_alloc(p->ctx, p->data.incidence_count, sizeof *sums);
  double plain = 0;
  HETAB_NEED(sums);
  for (size_t i = 0; i < p->data.count; i++)
    for (size_t b = 0; b < fit->bands; b++)
      add_residual(p, fit, i, b, &sums[p->data.incidence[i]]);
  for (size_t t = 0; t < p->data.incidence_count; t++) {
    const incidence_sums *s = &sums[t];
    double values = fmax(s->values, 1);
    fit->incidences[t] =
        (hetab_fit_incidence){.theta_i = p->data.theta_i[t],
                              .values = (size_t)s->values,
                              .error = s->scale > 0 ? sqrt(s->squares / s->scale) : 0,
                              .rms = sqrt(s->plain / values),
                              .mean = s->measured / values,
                              .bias = s->bias / values};
    plain += s->plain;
  }
  fit->rms = sqrt(plain / (double)p->data.values);
  return HETAB_OK;
}

static void fill_margin(const hetab_fit_problem *p, const hetab_fit *fit, size_t t,
                        hetab_fit_incidence *in) {
  in->margin = in->room = in->polished_margin = HUGE_VAL;
  for (size_t b = 0; b < fit->bands; b++) {
    const hetab_reflectance *r = &p->model.reflectances[b * p->data.incidence_count + t];
    double dh = r->dd.value + r->specular + fit->diffuse[b];
    double bound = fit->constraint == HETAB_FIT_ENERGY ? 1 : r->fresnel;
    in->room = fmin(in->room, bound - r->dd.value - r->specular);
    in->polished_margin = fmin(in->polished_margin, r->fresnel - dh);
    if (bound - dh < in->margin) {
      in->margin = bound - dh;
      in->margin_lambda_um = fit->lambda_um[b];
      in->rho_dh = dh;
      in->bound = bound;
    }
  }
  if (p->options.asked_diffuse > 0)
    in->excess = fmax(p->options.asked_diffuse - in->room, 0);
}

static hetab_status fill_incidences(hetab_fit_problem *p, hetab_fit *fit) {
  HETAB_TRY(fill_residuals(p, fit));
  HETAB_TRY(
      hetab_fit_model_room(p->ctx, &p->model, &p->data, p->options.constraint, NULL, p->room));
  fit->incidence_count = p->data.incidence_count;
  fit->margin = HUGE_VAL;
  for (size_t t = 0; t < fit->incidence_count; t++) {
    fill_margin(p, fit, t, &fit->incidences[t]);
    fit->margin = fmin(fit->margin, fit->incidences[t].margin);
  }
  return HETAB_OK;
}

/* ---- the surface ----------------------------------------------------------------------------- */

/* "cayman" of "data/cayman.brdf". */
static hetab_status take_name(hetab_context *ctx, const char *path, hetab_surface *surface) {
  const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
  const char *dot = strrchr(base, '.');
  size_t length = dot && dot > base ? (size_t)(dot - base) : strlen(base);
  char *name = hetab_alloc(ctx, length + 1, 1);
  HETAB_NEED(name);
  memcpy(name, base, length);
  free(surface->name);
  surface->name = name;
  return HETAB_OK;
}

static hetab_status take_fitted_index(hetab_context *ctx, double n, hetab_surface *surface) {
  hetab_index *fitted;
  double k = surface->index->k.count ? surface->index->k.values[0] : 0;
  HETAB_TRY(hetab_index_constant(ctx, n, k, &fitted));
  hetab_index_free(surface->index);
  surface->index = fitted;
  return HETAB_OK;
}

/* The model's surface, with the diffuse part, becomes the result's. */
static hetab_status take_surface(hetab_fit_problem *p, const char *name, hetab_fit *fit) {
  hetab_surface *surface = p->model.surface;
  if (fit->stop == HETAB_FIT_STOP_INFEASIBLE)
    return HETAB_OK;
  double *diffuse = hetab_alloc(p->ctx, p->groups, sizeof *diffuse);
  HETAB_NEED(diffuse);
  memcpy(diffuse, fit->diffuse, p->groups * sizeof *diffuse);
  free(surface->diffuse);
  surface->diffuse = diffuse;
  surface->diffuse_count = p->groups;
  HETAB_TRY(take_name(p->ctx, name, surface));
  if (p->options.parameters[HETAB_FIT_N].free)
    HETAB_TRY(take_fitted_index(p->ctx, fit->estimates[3].value, surface));
  HETAB_TRY(hetab_surface_sample(p->ctx, surface, fit->lambda_um, fit->bands));
  fit->surface = surface;
  p->model.surface = NULL;
  return HETAB_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static hetab_status run(hetab_fit_problem *p, hetab_engine *engine, const hetab_measurements *m,
                        hetab_fit *fit) {
  hetab_fit_state best = {0}, wished = {0};
  hetab_status status;
  HETAB_GOTO(prepare(p, engine, m));
  HETAB_GOTO(hetab_fit_state_create(p, &best));
  HETAB_GOTO(hetab_fit_state_create(p, &wished));
  HETAB_GOTO(allocate_fit(p, m, fit));
  if (p->options.robust)
    HETAB_GOTO(hetab_fit_make_robust(p, &best, fit));
  HETAB_GOTO(search(p, &best, &wished, fit));
  HETAB_GOTO(hetab_fit_intervals(p, &best, fit));
  fill_numbers(p, &best, &wished, fit);
  HETAB_GOTO(fill_model(p, m, &best, fit));
  HETAB_GOTO(fill_incidences(p, fit));
  HETAB_GOTO(hetab_fit_add_notes(p, fit));
  HETAB_GOTO(take_surface(p, hetab_measurements_name(m), fit));
  fit->evaluations = p->evaluations;
done:
  hetab_fit_state_clear(&best);
  hetab_fit_state_clear(&wished);
  return status;
}

hetab_status hetab_fit_create(hetab_context *ctx, hetab_engine *engine,
                              const hetab_measurements *measurements,
                              const hetab_fit_options *options, hetab_fit **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_fit_options, own, options);
  hetab_fit_problem problem = {.ctx = ctx, .options = own, .dull = HUGE_VAL};
  hetab_fit *fit = hetab_alloc(ctx, 1, sizeof *fit);
  HETAB_NEED(fit);
  hetab_status status = run(&problem, engine, measurements, fit);
  clear_problem(&problem);
  *out = fit;
  HETAB_MADE(hetab_fit, out, status);
}
