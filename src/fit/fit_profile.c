/* Intervals where the curvature misleads.
 *
 * The curvature at the answer says nothing of where the objective levels off: towards great sigma0
 * and tau, for one, where only the slope matters. So with several unknowns each is also held at e
 * times and 1/e of its value with the others free; where that is no worse than the 95 % point of
 * the interval, the interval's end is looked for. Of an unknown on its bound the other end is. */
#include <math.h>
#include <string.h>

#include "fit/fit_curvature.h"

enum { PROFILE_STEPS = 6 };

typedef struct profile {
  hetab_fit_curvature *c;
  hetab_fit_state state;
  size_t f;     /* the unknown, in problem->free */
  size_t m;     /* among those that move; moving: it is on its bound */
  double per_x; /* d ln(value) / dx */
  double most;  /* q at the 95 % point */
} profile;

/* Whether the unknown can be change (of its logarithm) away. The others start where the
 * correlation sends them. */
static hetab_status is_as_good(profile *p, double change, int *good) {
  hetab_fit_curvature *c = p->c;
  memcpy(p->state.x, c->best->x, sizeof p->state.x);
  for (size_t k = 0; k < c->moving && p->m < c->moving; k++) {
    double variance = c->covariance[p->m * c->size + p->m];
    double follow = variance > 0 ? c->covariance[k * c->size + p->m] / variance : 0;
    double x = c->best->x[c->unknown[k]] + follow * change / c->per_x[k];
    p->state.x[c->unknown[k]] = fmin(fmax(x, 0), 1);
  }
  p->state.x[p->f] = fmin(fmax(c->best->x[p->f] + change / p->per_x, 0), 1);
  HETAB_TRY(hetab_fit_search_beside(c->p, p->f, &p->state));
  *good = hetab_fit_feasible(&p->state) && p->state.q <= p->most;
  return HETAB_OK;
}

/* The distance at which it is no longer as good, between one that is and one that is not. */
static hetab_status bisect(profile *p, int sign, double *near, double far) {
  for (int k = 0; k < PROFILE_STEPS; k++) {
    double middle = 0.5 * (*near + far);
    int good;
    HETAB_TRY(is_as_good(p, sign * middle, &good));
    *(good ? near : &far) = middle;
  }
  return HETAB_OK;
}

/* How far the unknown can go to one side, if that is further than a factor of e; wide: it is. */
static hetab_status find_distance(profile *p, int sign, double *distance, int *wide) {
  double x = p->c->best->x[p->f], bound = (sign > 0 ? 1 - x : x) * p->per_x;
  int good;
  *distance = fmin(HETAB_FIT_WIDE, bound);
  HETAB_TRY(is_as_good(p, sign * *distance, wide));
  if (!*wide || *distance == bound)
    return HETAB_OK;
  HETAB_TRY(is_as_good(p, sign * bound, &good));
  if (!good)
    return bisect(p, sign, distance, bound);
  *distance = bound;
  return HETAB_OK;
}

/* The estimate's end on one side, and those of what follows from it: sigma0 goes with tau. */
static void move_ends(const profile *p, hetab_fit *fit, int sign, double distance, int wide) {
  hetab_fit_quantity from = p->c->p->free[p->f];
  for (int q = HETAB_FIT_SLOPE; q <= (from == HETAB_FIT_N ? HETAB_FIT_N : HETAB_FIT_TAU); q++) {
    double power = q == (int)from ? 1 : hetab_fit_follows(p->c, (hetab_fit_quantity)q, from);
    hetab_fit_estimate *e = &fit->estimates[q];
    if (power == 0 || (q != (int)from && from == HETAB_FIT_SLOPE && p->c->p->apart))
      continue;
    *(sign * power > 0 ? &e->high : &e->low) = e->value * exp(sign * power * distance);
    e->undetermined |= wide;
  }
}

/* An unknown that moves: further than the curvature says? */
static hetab_status check_moving(profile *p, hetab_fit *fit) {
  hetab_fit_curvature *c = p->c;
  size_t at = p->m * c->size + p->m;
  if (c->moving < 2 || !(c->inverse[at] > 0))
    return HETAB_OK;
  p->most = c->best->q + 3.84 * c->covariance[at] / c->inverse[at] / c->p->data.scale;
  for (int sign = -1; sign <= 1; sign += 2) {
    double distance = 0;
    int wide = 0;
    HETAB_TRY(find_distance(p, sign, &distance, &wide));
    if (wide)
      move_ends(p, fit, sign, distance, wide);
  }
  return HETAB_OK;
}

/* An unknown on its bound: how far from it is as good? */
static hetab_status check_bound(profile *p, hetab_fit *fit) {
  int sign = p->c->best->x[p->f] < 0.5 ? 1 : -1, wide = 0;
  double distance = 0, near = 0;
  p->most = p->c->best->q * (1 + 3.84 / fmax(hetab_fit_freedom(p->c), 1));
  HETAB_TRY(find_distance(p, sign, &distance, &wide));
  if (!wide) {
    HETAB_TRY(bisect(p, sign, &near, distance));
    distance = near;
  }
  move_ends(p, fit, sign, distance, wide);
  return HETAB_OK;
}

hetab_status hetab_fit_check_profiles(hetab_fit_curvature *c, hetab_fit *fit) {
  profile p = {.c = c};
  hetab_status status;
  HETAB_TRY(hetab_fit_state_create(c->p, &p.state));
  status = HETAB_OK;
  for (p.f = 0; p.f < c->p->free_count && status == HETAB_OK; p.f++) {
    const hetab_fit_parameter *o = &c->p->options.parameters[c->p->free[p.f]];
    p.per_x = log(o->high / o->low);
    for (p.m = 0; p.m < c->moving && c->unknown[p.m] != p.f;)
      p.m++;
    status = p.m < c->moving ? check_moving(&p, fit) : check_bound(&p, fit);
  }
  hetab_fit_state_clear(&p.state);
  return status;
}
