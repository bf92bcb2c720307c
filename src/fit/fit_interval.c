/* How well the measurements determine the answer: curvature, correlation, bootstrap. Roughness and
 * index are unknowns by their logarithms, diffuse parts as they are. */
#include "core/student.h"
#include "fit/fit_curvature.h"
#include "fit/fit_matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double EDGE = 1e-6;        /* of x: nearer to 0 or 1 is on the bound */
static const double WIDE_DIFFUSE = 0.5; /* half widths of what is not determined */

static void clear(hetab_fit_curvature *c) {
  free(c->dd);
  free(c->jacobian);
  free(c->room);
  free(c->column);
  free(c->normal);
  free(c->inverse);
  free(c->meat);
  free(c->covariance);
  free(c->scratch);
  free(c->score);
  free(c->singular);
}

static hetab_status allocate(hetab_fit_curvature *c) {
  hetab_context *ctx = c->p->ctx;
  size_t values = c->p->data.count * c->p->data.bands, groups = c->p->groups;
  size_t most = groups + HETAB_FIT_MOST_FREE, square = most * most;
  c->dd = hetab_alloc(ctx, values, sizeof *c->dd);
  c->jacobian = hetab_alloc(ctx, values, HETAB_FIT_MOST_FREE * sizeof *c->jacobian);
  c->room = hetab_alloc(ctx, groups, HETAB_FIT_MOST_FREE * sizeof *c->room);
  c->column = hetab_alloc(ctx, groups, sizeof *c->column);
  c->normal = hetab_alloc(ctx, square, sizeof *c->normal);
  c->inverse = hetab_alloc(ctx, square, sizeof *c->inverse);
  c->meat = hetab_alloc(ctx, square, sizeof *c->meat);
  c->covariance = hetab_alloc(ctx, square, sizeof *c->covariance);
  c->scratch = hetab_alloc(ctx, square, sizeof *c->scratch);
  c->score = hetab_alloc(ctx, most, sizeof *c->score);
  c->singular = hetab_alloc(ctx, most, sizeof *c->singular);
  return c->dd && c->jacobian && c->room && c->column && c->normal && c->inverse && c->meat &&
                 c->covariance && c->scratch && c->score && c->singular
             ? HETAB_OK
             : HETAB_ERR_MEMORY;
}

/* ---- derivatives ------------------------------------------------------------------------------
 */

static void choose_unknowns(hetab_fit_curvature *c) {
  for (size_t f = 0; f < c->p->free_count; f++) {
    const hetab_fit_parameter *o = &c->p->options.parameters[c->p->free[f]];
    if (c->best->x[f] < EDGE || c->best->x[f] > 1 - EDGE)
      continue;
    c->per_x[c->moving] = log(o->high / o->low);
    c->unknown[c->moving++] = f;
  }
}

/* sign = 1 stores what the step has changed, -1 takes the opposite step's from it. */
static void add_difference(hetab_fit_curvature *c, size_t m, const hetab_fit_state *state,
                           double sign, double width) {
  size_t values = c->p->data.count * c->p->data.bands;
  for (size_t i = 0; i < values; i++)
    c->jacobian[i * HETAB_FIT_MOST_FREE + m] += sign * c->p->dd[i] / width;
  for (size_t g = 0; c->p->constrained && g < c->p->groups; g++)
    c->room[g * HETAB_FIT_MOST_FREE + m] += sign * state->room[g] / width;
  if (c->p->constrained)
    c->spare[m] += sign * state->spare / width;
}

static hetab_status differentiate(hetab_fit_curvature *c, hetab_fit_state *state) {
  int exact = hetab_engine_precision(c->p->model.engine) == HETAB_DOUBLE;
  double step = exact ? 1e-4 : 3e-3;
  for (size_t m = 0; m < c->moving; m++)
    for (int sign = -1; sign <= 1; sign += 2) {
      memcpy(state->x, c->best->x, sizeof state->x);
      state->x[c->unknown[m]] += sign * step;
      HETAB_TRY(hetab_fit_evaluate(c->p, state));
      add_difference(c, m, state, sign, 2 * step * c->per_x[m]);
    }
  memcpy(state->x, c->best->x, sizeof state->x);
  HETAB_TRY(hetab_fit_evaluate(c->p, state));
  memcpy(c->dd, c->p->dd, c->p->data.count * c->p->data.bands * sizeof *c->dd);
  return HETAB_OK;
}

/* A diffuse part that the constraint holds moves with the roughness. */
static void add_held_diffuse(hetab_fit_curvature *c) {
  size_t bands = c->p->data.bands;
  for (size_t i = 0; i < c->p->data.count * bands; i++) {
    size_t g = hetab_fit_group(c->p, i % bands);
    for (size_t m = 0; m < c->moving && c->best->end[g] == HETAB_FIT_END_CONSTRAINT; m++)
      c->jacobian[i * HETAB_FIT_MOST_FREE + m] += c->room[g * HETAB_FIT_MOST_FREE + m] / M_PI;
  }
}

/* ---- sums -------------------------------------------------------------------------------------
 */

void hetab_fit_number_columns(hetab_fit_curvature *c, const hetab_fit_state *state) {
  size_t most = HETAB_FIT_MOST_FREE + c->p->groups;
  c->size = c->moving;
  for (size_t g = 0; g < c->p->groups; g++)
    c->column[g] = state->end[g] == HETAB_FIT_END_INSIDE ? c->size++ : most;
}

/* The entries of a value's row: columns[n] and derivatives[n] of its residual. */
static size_t row_of(const hetab_fit_curvature *c, size_t i, double slope, size_t *columns,
                     double *row) {
  size_t n = 0, column = c->column[hetab_fit_group(c->p, i % c->p->data.bands)];
  for (size_t m = 0; m < c->moving; m++) {
    columns[n] = m;
    row[n++] = slope * c->jacobian[i * HETAB_FIT_MOST_FREE + m];
  }
  if (column < c->size) {
    columns[n] = column;
    row[n++] = slope / M_PI;
  }
  return n;
}

static double residual_at(const hetab_fit_curvature *c, const hetab_fit_state *state, size_t i,
                          double *slope) {
  double a = state->diffuse[hetab_fit_group(c->p, i % c->p->data.bands)];
  return hetab_fit_residual(c->p, i, c->p->dd[i] + a / M_PI, slope);
}

void hetab_fit_add_normal(hetab_fit_curvature *c, const hetab_fit_state *state,
                          const unsigned *times) {
  size_t columns[HETAB_FIT_MOST_FREE + 1], bands = c->p->data.bands;
  double row[HETAB_FIT_MOST_FREE + 1], slope;
  memset(c->normal, 0, c->size * c->size * sizeof *c->normal);
  memset(c->score, 0, c->size * sizeof *c->score);
  for (size_t i = 0; i < c->p->data.count * bands; i++) {
    double w = c->p->data.weight[i] * (times ? times[i / bands] : 1);
    if (w == 0)
      continue;
    double r = residual_at(c, state, i, &slope);
    size_t n = row_of(c, i, slope, columns, row);
    for (size_t a = 0; a < n; a++) {
      c->score[columns[a]] += w * r * row[a];
      for (size_t b = 0; b < n; b++)
        c->normal[columns[a] * c->size + columns[b]] += w * row[a] * row[b];
    }
  }
}

void hetab_fit_invert(hetab_fit_curvature *c) {
  double *direction = &c->scratch[c->size];
  hetab_matrix_invert(c->size, c->normal, c->scratch, c->inverse, c->singular);
  if (!c->held || c->size < 2) {
    if (c->held)
      memset(c->inverse, 0, c->size * c->size * sizeof *c->inverse);
    return;
  }
  memset(c->scratch, 0, 2 * c->size * sizeof *c->scratch);
  memcpy(direction, c->spare, c->moving * sizeof *direction);
  hetab_matrix_project(c->size, c->inverse, direction, c->scratch);
}

/* One pair's share of the score, its residuals enlarged by 1 / (1 - leverage). */
static void pair_score(hetab_fit_curvature *c, size_t pair) {
  size_t columns[HETAB_FIT_MOST_FREE + 1], bands = c->p->data.bands;
  double row[HETAB_FIT_MOST_FREE + 1], slope;
  memset(c->score, 0, c->size * sizeof *c->score);
  for (size_t i = pair * bands; i < (pair + 1) * bands; i++) {
    double w = c->p->data.weight[i], leverage = 0;
    if (w == 0)
      continue;
    double r = residual_at(c, c->best, i, &slope);
    size_t n = row_of(c, i, slope, columns, row);
    for (size_t a = 0; a < n; a++)
      for (size_t b = 0; b < n; b++)
        leverage += w * row[a] * row[b] * c->inverse[columns[a] * c->size + columns[b]];
    for (size_t a = 0; a < n; a++)
      c->score[columns[a]] += w * r * row[a] / (1 - fmin(leverage, 0.99));
  }
}

static void find_covariance(hetab_fit_curvature *c) {
  hetab_fit_number_columns(c, c->best);
  hetab_fit_add_normal(c, c->best, NULL);
  hetab_fit_invert(c);
  memset(c->meat, 0, c->size * c->size * sizeof *c->meat);
  for (size_t pair = 0; pair < c->p->data.count; pair++) {
    pair_score(c, pair);
    for (size_t a = 0; a < c->size; a++)
      for (size_t b = 0; b < c->size; b++)
        c->meat[a * c->size + b] += c->score[a] * c->score[b];
  }
  hetab_matrix_sandwich(c->size, c->inverse, c->meat, c->scratch, c->covariance);
}

/* ---- estimates --------------------------------------------------------------------------------
 */

double hetab_fit_follows(const hetab_fit_curvature *c, hetab_fit_quantity quantity,
                         hetab_fit_quantity from) {
  static const double of[3][3] = {/* slope, sigma0, tau from slope, sigma0, tau */
                                  {0, 1, -1},
                                  {1, 0, 1},
                                  {-1, 1, 0}};
  const hetab_fit_parameter *o = &c->p->options.parameters[quantity];
  int given = o->free || o->value > 0;
  if (quantity == from)
    return 1;
  if (c->p->apart && quantity == HETAB_FIT_SIGMA0)
    given = 0;
  return given || quantity > HETAB_FIT_TAU || from > HETAB_FIT_TAU ? 0 : of[quantity][from];
}

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
      return c->best->x[f] < EDGE        ? HETAB_FIT_END_LOW
             : c->best->x[f] > 1 - EDGE  ? HETAB_FIT_END_HIGH
             : c->held && c->moving == 1 ? HETAB_FIT_END_CONSTRAINT
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

static void estimate_quantity(const hetab_fit_curvature *c, double t, hetab_fit_quantity quantity,
                              hetab_fit_estimate *e) {
  const hetab_fit_parameter *o = &c->p->options.parameters[quantity];
  double error = t * log_error(c, quantity);
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

double hetab_fit_freedom(const hetab_fit_curvature *c) {
  return (double)c->p->data.count - (double)c->moving - 1;
}

static void fill_estimates(const hetab_fit_curvature *c, hetab_fit *fit) {
  double t = hetab_student_95(hetab_fit_freedom(c));
  size_t n = 0;
  for (int q = HETAB_FIT_SLOPE; q <= HETAB_FIT_TAU; q++)
    estimate_quantity(c, t, (hetab_fit_quantity)q, &fit->estimates[n++]);
  if (c->p->options.parameters[HETAB_FIT_N].free)
    estimate_quantity(c, t, HETAB_FIT_N, &fit->estimates[n++]);
  for (size_t g = 0; g < c->p->groups; g++)
    estimate_diffuse(c, t, g, &fit->estimates[n++]);
  fit->estimate_count = n;
  for (size_t i = 0; i < n; i++)
    fit->estimates[i].bootstrap_low = fit->estimates[i].bootstrap_high = NAN;
}

/* ---- correlation ------------------------------------------------------------------------------
 */

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
  if (!fit->free_estimates || !fit->correlation)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < n; i++) {
    fit->free_estimates[i] = place_of(c, i);
    for (size_t j = 0; j < n; j++) {
      double scale = sqrt(c->covariance[i * n + i] * c->covariance[j * n + j]);
      fit->correlation[i * n + j] = scale > 0 ? c->covariance[i * n + j] / scale : i == j;
    }
  }
  return HETAB_OK;
}

/* ---- the whole --------------------------------------------------------------------------------
 */

hetab_status hetab_fit_intervals(hetab_fit_problem *problem, const hetab_fit_state *best,
                                 hetab_fit *fit) {
  hetab_fit_curvature c = {.p = problem, .best = best};
  hetab_fit_state state = {0};
  hetab_status status;
  HETAB_GOTO(allocate(&c));
  HETAB_GOTO(hetab_fit_state_create(problem, &state));
  choose_unknowns(&c);
  HETAB_GOTO(differentiate(&c, &state));
  add_held_diffuse(&c);
  c.held = problem->constrained && best->spare < 0.1 * HETAB_FIT_SLACK && c.moving > 0;
  find_covariance(&c);
  fill_estimates(&c, fit);
  HETAB_GOTO(fill_correlation(&c, fit));
  HETAB_GOTO(hetab_fit_check_profiles(&c, fit));
  if (problem->options.bootstrap)
    HETAB_GOTO(hetab_fit_bootstrap(&c, fit));
done:
  hetab_fit_state_clear(&state);
  clear(&c);
  return status;
}
