/* The curvature of the objective at the answer, by finite differences of the model. */
#include "fit/fit_curvature.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/student.h"
#include "fit/fit_matrix.h"

void hetab_fit_curvature_clear(hetab_fit_curvature *c) {
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

/* ---- derivatives ----------------------------------------------------------------------------- */

static void choose_unknowns(hetab_fit_curvature *c) {
  for (size_t f = 0; f < c->p->free_count; f++) {
    const hetab_fit_parameter *o = &c->p->options.parameters[c->p->free[f]];
    if (c->best->x[f] < HETAB_FIT_EDGE || c->best->x[f] > 1 - HETAB_FIT_EDGE)
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

/* ---- sums ------------------------------------------------------------------------------------ */

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
static void pair_score(const hetab_fit_curvature *c, size_t pair) {
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

/* ---- the whole ------------------------------------------------------------------------------- */

hetab_status hetab_fit_curvature_create(hetab_fit_problem *problem, const hetab_fit_state *best,
                                        hetab_fit_curvature *c) {
  HETAB_ENDS(hetab_fit_state_clear) hetab_fit_state state = {0};
  *c = (hetab_fit_curvature){.p = problem, .best = best};
  HETAB_TRY(allocate(c));
  HETAB_TRY(hetab_fit_state_create(problem, &state));
  choose_unknowns(c);
  HETAB_TRY(differentiate(c, &state));
  add_held_diffuse(c);
  c->held = problem->constrained && best->spare < 0.1 * HETAB_FIT_SLACK && c->moving > 0;
  find_covariance(c);
  return HETAB_OK;
}

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

double hetab_fit_freedom(const hetab_fit_curvature *c) {
  return (double)c->p->data.count - (double)c->moving - 1;
}

/* The same of the variance along a direction[size]: where few pairs say most, their residuals are
 * few to take a variance from. Of shares s = sigma^2 chi^2 sum(s)^2 and sum(s^2) are S^2 + 2 Q and
 * 3 Q on average, with the sums S of sigma^2 and Q of sigma^4; Satterthwaite's number is S^2 / Q.
 */
static double freedom_along(const hetab_fit_curvature *c, const double *direction) {
  double sum = 0.0, squares = 0.0, *from = c->scratch;
  for (size_t a = 0; a < c->size; a++) {
    from[a] = 0.0;
    for (size_t b = 0; b < c->size; b++)
      from[a] += c->inverse[a * c->size + b] * direction[b];
  }
  for (size_t pair = 0; pair < c->p->data.count; pair++) {
    double move = 0.0;
    pair_score(c, pair);
    for (size_t a = 0; a < c->size; a++)
      move += from[a] * c->score[a];
    sum += move * move;
    squares += pow(move, 4.0);
  }
  double few = squares > 0.0 ? 3.0 * sum * sum / squares - 2.0 : HUGE_VAL;
  return fmin(fmax(few, 1.0), hetab_fit_freedom(c));
}

double hetab_fit_quantile(const hetab_fit_curvature *c, hetab_fit_quantity quantity, size_t group) {
  double *direction = &c->scratch[c->size]; /* of the room in its second half */
  memset(direction, 0, c->size * sizeof *direction);
  if (quantity == HETAB_FIT_DIFFUSE && c->column[group] < c->size)
    direction[c->column[group]] = 1;
  for (size_t m = 0; m < c->moving && quantity != HETAB_FIT_DIFFUSE; m++)
    direction[m] = hetab_fit_follows(c, quantity, c->p->free[c->unknown[m]]);
  return hetab_student_95(freedom_along(c, direction));
}
