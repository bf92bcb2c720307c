/* From many starts to one answer. */
#include "fit/fit_internal.h"

#include <math.h>
#include <nlopt.h>
#include <stdlib.h>
#include <string.h>

#include "core/random.h"

/* In x, which runs from 0 to 1 between the logarithms of the bounds. The first step is about half
 * the spacing of a lattice (1/12). A start ends COARSE, near enough for SLSQP, which ends FINE: the
 * objective is flat to rounding there. Ends of starts within ten COARSE are polished once. BESIDE:
 * of a run with one unknown held, which only an interval hangs on. */
static const double FIRST_STEP = 0.05, COARSE = 1e-3, FINE = 1e-8, BESIDE = 1e-5, SAME_END = 1e-2;
/* Answers that a user would call one: far above FINE, a hundredth of SAME_END. */
static const double SAME_ANSWER = 1e-4;
/* E^2 below this is as good as 0: its logarithm is what is minimised. */
static const double LEAST_Q = 1e-10;
static const double BROKEN = 1e3; /* of a scan: above every objective */
/* Stops for what never settles: five times what COBYLA takes for three unknowns; SLSQP takes its
 * derivatives by differences. */
enum { COARSE_EVALUATIONS = 300, FINE_EVALUATIONS = 2000 };
/* How many minima are looked into: each costs a run. */
enum { MOST_POLISHED = 4, MOST_PROBES = 3, MOST_DIPS = 4 };
enum { MOST_LATTICE = 144 }; /* points, {12, 4, 3} */

typedef struct search {
  hetab_fit_problem *problem;
  nlopt_opt optimizer;
  hetab_status status;
  hetab_fit_state at;    /* the last evaluation */
  hetab_fit_state best;  /* feasible, of the current run */
  hetab_fit_state least; /* the nearest to feasible, of all */
  double derivative_step;
  size_t starts;
  size_t fixed; /* of the unknowns, one that stays where it is; free_count: none */
} search;

/* ---- evaluations ----------------------------------------------------------------------------- */

static int is_better(const hetab_fit_state *a, const hetab_fit_state *b) {
  return hetab_fit_feasible(a) && (a->q < b->q || !hetab_fit_feasible(b));
}

/* How many evaluations there will be in all, about: COBYLA takes some 20 an unknown. */
static double expected(const search *s) {
  static const double lattices[HETAB_FIT_MOST_FREE] = {12, 96, 144};
  double each = lattices[s->problem->free_count - 1] + 20 * (double)s->problem->free_count;
  double all = (double)(s->starts + MOST_PROBES) * each * (s->problem->constrained ? 2 : 1) + 50;
  return fmax(all, (double)s->problem->evaluations + 1);
}

static void evaluate_at(search *s, const double *x) {
  hetab_fit_problem *p = s->problem;
  if (s->status != HETAB_OK || memcmp(x, s->at.x, p->free_count * sizeof *x) == 0)
    return;
  for (size_t f = 0; f < p->free_count; f++)
    if (!isfinite(x[f])) { /* SLSQP does not always notice that it has no step left */
      nlopt_force_stop(s->optimizer);
      return;
    }
  memcpy(s->at.x, x, p->free_count * sizeof *x);
  s->status = hetab_fit_evaluate(p, &s->at);
  if (s->status == HETAB_OK)
    s->status = hetab_progress(p->ctx, (double)p->evaluations, expected(s));
  if (s->optimizer && (s->status != HETAB_OK || p->evaluations >= p->options.max_evaluations))
    nlopt_force_stop(s->optimizer);
  if (s->status != HETAB_OK)
    return;
  if (is_better(&s->at, &s->best))
    hetab_fit_state_copy(p, &s->at, &s->best);
  if (s->at.spare > s->least.spare)
    hetab_fit_state_copy(p, &s->at, &s->least);
}

static double objective_of(const hetab_fit_state *state) {
  return log(state->q + LEAST_Q);
}

/* Positive where the constraint is broken. */
static double constraint_of(const hetab_fit_state *state) {
  return -0.5 * HETAB_FIT_SLACK - state->spare;
}

typedef double (*value_of)(const hetab_fit_state *state);

/* Central differences, one-sided at the bounds. */
static double value_and_gradient(search *s, value_of value, const double *x, double *gradient) {
  double moved[HETAB_FIT_MOST_FREE];
  size_t n = s->problem->free_count;
  memcpy(moved, x, n * sizeof *x);
  for (size_t f = 0; gradient && f < n; f++) {
    double above = fmin(x[f] + s->derivative_step, 1), below = fmax(x[f] - s->derivative_step, 0);
    moved[f] = above;
    evaluate_at(s, moved);
    gradient[f] = value(&s->at);
    moved[f] = below;
    evaluate_at(s, moved);
    gradient[f] = (gradient[f] - value(&s->at)) / (above - below);
    moved[f] = x[f];
  }
  evaluate_at(s, x);
  return value(&s->at);
}

static double nlopt_objective(unsigned n, const double *x, double *gradient, void *user) {
  return value_and_gradient(user, objective_of, x, gradient);
}

static double nlopt_constraint(unsigned n, const double *x, double *gradient, void *user) {
  return value_and_gradient(user, constraint_of, x, gradient);
}

/* ---- one run --------------------------------------------------------------------------------- */

/* From x to the best feasible point that the run meets, in s->best; x moves to where it ended. */
static hetab_status run(search *s, nlopt_algorithm algorithm, double tolerance, int evaluations,
                        double *x) {
  unsigned n = (unsigned)s->problem->free_count;
  double error;
  s->optimizer = nlopt_create(algorithm, n);
  if (!s->optimizer)
    return hetab_fail(s->problem->ctx, HETAB_ERR_MEMORY, "out of memory for the optimiser");
  for (unsigned f = 0; f < n; f++) {
    nlopt_set_lower_bound(s->optimizer, (int)f, f == s->fixed ? x[f] : 0);
    nlopt_set_upper_bound(s->optimizer, (int)f, f == s->fixed ? x[f] : 1);
  }
  nlopt_set_min_objective(s->optimizer, nlopt_objective, s);
  if (s->problem->constrained)
    nlopt_add_inequality_constraint(s->optimizer, nlopt_constraint, s, 0);
  nlopt_set_xtol_abs1(s->optimizer, tolerance);
  nlopt_set_maxeval(s->optimizer, evaluations);
  nlopt_set_initial_step1(s->optimizer, FIRST_STEP);
  s->best.q = HUGE_VAL;
  s->best.spare = -HUGE_VAL;
  s->at.x[0] = (double)NAN;
  nlopt_optimize(s->optimizer, x, &error); /* what it says is in s->best and the evaluations left */
  nlopt_destroy(s->optimizer);
  s->optimizer = NULL;
  return s->status;
}

/* ---- starts ---------------------------------------------------------------------------------- */

/* The given start, if all that is free has one. */
static int given_start(const hetab_fit_problem *p, double *x) {
  for (size_t f = 0; f < p->free_count; f++) {
    const hetab_fit_parameter *o = &p->options.parameters[p->free[f]];
    if (!(o->value > 0))
      return 0;
    x[f] = fmin(fmax(log(o->value / o->low) / log(o->high / o->low), 0), 1);
  }
  return 1;
}

static void record(const hetab_fit_problem *p, const double *x, double *values) {
  double all[HETAB_FIT_QUANTITIES];
  hetab_fit_values_at(p, x, all);
  for (size_t f = 0; f < p->free_count; f++)
    values[p->free[f]] = all[p->free[f]];
}

static int near(const hetab_fit_problem *p, const double *a, const double *b, double tolerance) {
  for (size_t f = 0; f < p->free_count; f++)
    if (!(fabs(a[f] - b[f]) <= tolerance))
      return 0;
  return 1;
}

/* ---- lattices -------------------------------------------------------------------------------- */

/* A lattice over the bounds that holds a start: the objective has other minima far from the best,
 * lobes much narrower than the measurements' spacing for one. */
typedef struct lattice {
  size_t side[HETAB_FIT_MOST_FREE], count;
  double base[HETAB_FIT_MOST_FREE];
  double values[MOST_LATTICE];
} lattice;

/* Finest in the first unknown, the one that sets the width of the lobes. */
static lattice lattice_through(const hetab_fit_problem *p, const double *x) {
  static const size_t sides[HETAB_FIT_MOST_FREE][HETAB_FIT_MOST_FREE] = {
      {12, 1, 1}, {12, 8, 1}, {12, 4, 3}};
  lattice l = {.count = 1};
  for (size_t f = 0; f < p->free_count; f++) {
    l.side[f] = sides[p->free_count - 1][f];
    l.base[f] = fmod(x[f], 1.0 / (double)l.side[f]);
    l.count *= l.side[f];
  }
  return l;
}

static void lattice_point(const lattice *l, size_t i, size_t n, double *x) {
  for (size_t f = 0; f < n; i /= l->side[f++])
    x[f] = l->base[f] + (double)(i % l->side[f]) / (double)l->side[f];
}

static hetab_status scan(search *s, lattice *l) {
  for (size_t i = 0; i < l->count && s->status == HETAB_OK; i++) {
    double x[HETAB_FIT_MOST_FREE];
    l->values[i] = HUGE_VAL;
    if (s->problem->evaluations >= s->problem->options.max_evaluations)
      continue;
    lattice_point(l, i, s->problem->free_count, x);
    evaluate_at(s, x);
    double broken = s->problem->constrained && isfinite(s->at.spare) ? constraint_of(&s->at) : 0;
    l->values[i] = broken > 0 ? BROKEN + broken : objective_of(&s->at);
    if (hetab_fit_feasible(&s->at))
      s->problem->dull = fmin(s->problem->dull, s->at.q);
  }
  s->problem->dull = HUGE_VAL;
  return s->status;
}

static int is_dip(const lattice *l, size_t i, size_t n) {
  for (size_t f = 0, step = 1; f < n; step *= l->side[f++]) {
    size_t j = i / step % l->side[f];
    if ((j > 0 && l->values[i - step] < l->values[i]) ||
        (j + 1 < l->side[f] && l->values[i + step] <= l->values[i]))
      return 0;
  }
  return 1;
}

/* The lowest dip that is above the value `least`; count: none. */
static size_t next_dip(const lattice *l, size_t n, double least) {
  size_t best = l->count;
  for (size_t i = 0; i < l->count; i++)
    if (l->values[i] > least && is_dip(l, i, n) &&
        (best == l->count || l->values[i] < l->values[best]))
      best = i;
  return best;
}

/* ---- runs ------------------------------------------------------------------------------------ */

static hetab_status run_one(search *s, double *x, hetab_fit_start *start, hetab_fit_state *end) {
  double tolerance = s->problem->options.derivative_free ? FINE : COARSE;
  HETAB_TRY(run(s, NLOPT_LN_COBYLA, tolerance, COARSE_EVALUATIONS, x));
  hetab_fit_state_copy(s->problem, &s->best, end);
  start->feasible = hetab_fit_feasible(end);
  return HETAB_OK;
}

/* The other dips of a lattice: the answer of no start, unless they are as good. */
static hetab_status run_probes(search *s, const lattice *l, hetab_fit *fit, hetab_fit_state *ends) {
  size_t n = s->problem->free_count, dip = next_dip(l, n, -HUGE_VAL);
  for (int k = 0; k < MOST_PROBES && dip < l->count; k++) {
    double x[HETAB_FIT_MOST_FREE];
    dip = next_dip(l, n, l->values[dip]);
    if (dip == l->count)
      break;
    hetab_fit_start *start = &fit->starts[fit->start_count];
    lattice_point(l, dip, n, x);
    record(s->problem, x, start->start);
    start->probe = 1;
    HETAB_TRY(run_one(s, x, start, &ends[fit->start_count++]));
  }
  return HETAB_OK;
}

/* From the lattice's lowest dip, with several unknowns from the lowest few: valleys hide between
 * its points. */
static hetab_status run_start(search *s, const lattice *l, hetab_fit_start *start,
                              hetab_fit_state *end) {
  size_t n = s->problem->free_count, dip = next_dip(l, n, -HUGE_VAL);
  size_t most = n == 1 ? 1 : MOST_DIPS;
  hetab_fit_state found;
  hetab_status status = hetab_fit_state_create(s->problem, &found);
  for (size_t k = 0; k < most && dip < l->count && status == HETAB_OK; k++) {
    double x[HETAB_FIT_MOST_FREE];
    lattice_point(l, dip, n, x);
    status = run_one(s, x, start, &found);
    if (k == 0 || is_better(&found, end))
      hetab_fit_state_copy(s->problem, &found, end);
    dip = next_dip(l, n, l->values[dip]);
  }
  start->feasible = hetab_fit_feasible(end);
  hetab_fit_state_clear(&found);
  return status;
}

/* ends[start_count]: the best feasible state of each run. */
static hetab_status run_starts(search *s, hetab_fit *fit, hetab_fit_state *ends) {
  hetab_fit_problem *p = s->problem;
  uint64_t seed = p->options.seed;
  double given[HETAB_FIT_MOST_FREE];
  int have_given = given_start(p, given);
  lattice first;
  for (size_t i = 0; i < s->starts; i++) {
    double x[HETAB_FIT_MOST_FREE];
    for (size_t f = 0; f < p->free_count; f++)
      x[f] = i == 0 && have_given ? given[f] : hetab_random_unit(&seed);
    record(p, x, fit->starts[i].start);
    lattice l = lattice_through(p, x);
    HETAB_TRY(scan(s, &l));
    HETAB_TRY(run_start(s, &l, &fit->starts[i], &ends[i]));
    fit->start_count++;
    if (i == 0)
      first = l;
  }
  return run_probes(s, &first, fit, ends);
}

/* ---- the distinct ends, to the last digit ---------------------------------------------------- */

/* The best end that is not near one of the polished; start_count: none. */
static size_t next_end(const hetab_fit_problem *p, const hetab_fit_state *ends, size_t count,
                       const unsigned char *done) {
  size_t best = count;
  for (size_t i = 0; i < count; i++)
    if (!done[i] && hetab_fit_feasible(&ends[i]) && (best == count || ends[i].q < ends[best].q))
      best = i;
  return best;
}

/* Ends near `from` become the polished state. */
static void share(const hetab_fit_problem *p, const double *from, const hetab_fit_state *polished,
                  hetab_fit_state *ends, size_t count, unsigned char *done) {
  for (size_t i = 0; i < count; i++)
    if (!done[i] && hetab_fit_feasible(&ends[i]) && near(p, ends[i].x, from, SAME_END)) {
      hetab_fit_state_copy(p, polished, &ends[i]);
      done[i] = 1;
    }
}

static hetab_status polish(search *s, hetab_fit_state *ends, size_t count) {
  hetab_fit_problem *p = s->problem;
  HETAB_FREED unsigned char *done = hetab_alloc(p->ctx, count, 1);
  HETAB_NEED(done);
  for (int n = 0; n < MOST_POLISHED; n++) {
    size_t at = next_end(p, ends, count, done);
    double from[HETAB_FIT_MOST_FREE], x[HETAB_FIT_MOST_FREE];
    if (at == count)
      break;
    memcpy(from, ends[at].x, sizeof from);
    memcpy(x, ends[at].x, sizeof x);
    HETAB_TRY(run(s, NLOPT_LD_SLSQP, FINE, FINE_EVALUATIONS, x));
    share(p, from, is_better(&s->best, &ends[at]) ? &s->best : &ends[at], ends, count, done);
    done[at] = 1;
  }
  return HETAB_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void choose(const search *s, const hetab_fit_state *ends, hetab_fit *fit,
                   hetab_fit_state *best) {
  const hetab_fit_problem *p = s->problem;
  const hetab_fit_state *chosen = &s->least;
  for (size_t i = 0; i < fit->start_count; i++)
    if (is_better(&ends[i], chosen))
      chosen = &ends[i];
  hetab_fit_state_copy(p, chosen, best);
  for (size_t i = 0; i < fit->start_count; i++) {
    hetab_fit_start *start = &fit->starts[i];
    start->error = start->feasible ? sqrt(ends[i].q) : (double)NAN;
    if (!start->feasible)
      continue;
    record(p, ends[i].x, start->end);
    start->best = near(p, ends[i].x, best->x, SAME_ANSWER);
  }
}

/* Without unknowns but the diffuse part one evaluation says all. */
static hetab_status evaluate_once(search *s, hetab_fit *fit, hetab_fit_state *best) {
  HETAB_TRY(hetab_fit_evaluate(s->problem, &s->at));
  hetab_fit_state_copy(s->problem, &s->at, best);
  return HETAB_OK;
}

static hetab_status search_all(search *s, hetab_fit *fit, hetab_fit_state *best) {
  hetab_status status;
  size_t most = s->starts + MOST_PROBES, made = 0;
  if (s->problem->free_count == 0)
    return evaluate_once(s, fit, best);
  hetab_fit_state *ends = hetab_alloc(s->problem->ctx, most, sizeof *ends);
  HETAB_NEED(ends);
  for (; made < most; made++)
    HETAB_GOTO(hetab_fit_state_create(s->problem, &ends[made]));
  HETAB_GOTO(run_starts(s, fit, ends));
  if (!s->problem->options.derivative_free)
    HETAB_GOTO(polish(s, ends, fit->start_count));
  choose(s, ends, fit, best);
done:
  for (size_t i = 0; i < made; i++)
    hetab_fit_state_clear(&ends[i]);
  free(ends);
  return status;
}

static void clear(search *s) {
  hetab_fit_state_clear(&s->at);
  hetab_fit_state_clear(&s->best);
  hetab_fit_state_clear(&s->least);
}

static hetab_status create(hetab_fit_problem *problem, search *s) {
  int exact = hetab_engine_precision(problem->model.engine) == HETAB_DOUBLE;
  *s = (search){
      .problem = problem, .derivative_step = exact ? 1e-5 : 1e-3, .fixed = problem->free_count};
  HETAB_TRY(hetab_fit_state_create(problem, &s->at));
  HETAB_TRY(hetab_fit_state_create(problem, &s->best));
  return hetab_fit_state_create(problem, &s->least);
}

hetab_status hetab_fit_search(hetab_fit_problem *problem, hetab_fit_state *best, hetab_fit *fit) {
  search s;
  double given[HETAB_FIT_MOST_FREE];
  hetab_status status = create(problem, &s);
  s.starts = problem->options.starts + (size_t)given_start(problem, given);
  fit->start_count = 0;
  fit->starts = hetab_alloc(problem->ctx, s.starts + MOST_PROBES, sizeof *fit->starts);
  if (!fit->starts)
    status = HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = search_all(&s, fit, best);
  clear(&s);
  return status;
}

hetab_status hetab_fit_search_beside(hetab_fit_problem *problem, size_t fixed,
                                     hetab_fit_state *state) {
  search s;
  double x[HETAB_FIT_MOST_FREE];
  hetab_status status = create(problem, &s);
  s.fixed = fixed;
  memcpy(x, state->x, sizeof x);
  if (status == HETAB_OK)
    status = run(&s, NLOPT_LN_COBYLA, BESIDE, COARSE_EVALUATIONS, x);
  if (status == HETAB_OK)
    hetab_fit_state_copy(problem, &s.best, state);
  clear(&s);
  return status;
}
