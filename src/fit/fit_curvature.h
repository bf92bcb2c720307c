/* The curvature of the objective at the answer, for intervals and for the bootstrap. Roughness and
 * index are unknowns by their logarithms, diffuse parts as they are. */
#pragma once

#include "fit/fit_internal.h"

/* What the intervals are computed from. */
typedef struct hetab_fit_curvature {
  hetab_fit_problem *p;
  const hetab_fit_state *best;
  size_t moving;                       /* unknowns of roughness and index that are not on a bound */
  size_t unknown[HETAB_FIT_MOST_FREE]; /* their places in problem->free */
  double per_x[HETAB_FIT_MOST_FREE];   /* d ln(value) / dx of each */
  double *dd;                          /* [values] f_dd at the best */
  double *jacobian;                    /* [values][MOST_FREE] of f, with diffuse parts that the
                                        * constraint holds */
  double *room;                        /* [groups][MOST_FREE] derivative of state->room */
  double spare[HETAB_FIT_MOST_FREE];   /* of state->spare */
  int held;                            /* the constraint holds the roughness itself */

  size_t size;    /* unknowns in all, diffuse parts after the others */
  size_t *column; /* [groups] of the diffuse parts; size: not an unknown */
  double *normal, *inverse, *meat, *covariance, *scratch; /* [size][size] */
  double *score;                                          /* [size] */
  unsigned char *singular;                                /* [size] */
} hetab_fit_curvature;

/* Clear it whatever the outcome. */
hetab_status hetab_fit_curvature_create(hetab_fit_problem *problem, const hetab_fit_state *best,
                                        hetab_fit_curvature *c);
void hetab_fit_curvature_clear(hetab_fit_curvature *c);

/* Diffuse parts that are unknowns at a state. */
void hetab_fit_number_columns(hetab_fit_curvature *c, const hetab_fit_state *state);
/* The normal matrix and the gradient, c->score, for problem->dd and the state. times: how often
 * each pair counts; NULL: once. */
void hetab_fit_add_normal(hetab_fit_curvature *c, const hetab_fit_state *state,
                          const unsigned *times);
/* The normal matrix's inverse, less the direction in which the constraint holds. */
void hetab_fit_invert(hetab_fit_curvature *c);

/* Of x: nearer to 0 or 1 is on the bound. */
#define HETAB_FIT_EDGE 1e-6

/* Half width, of a logarithm, of what the data do not determine. */
#define HETAB_FIT_WIDE 1.0

/* d ln(quantity) / d ln(unknown). */
double hetab_fit_follows(const hetab_fit_curvature *c, hetab_fit_quantity quantity,
                         hetab_fit_quantity from);
/* Degrees of freedom: residuals of one pair are not independent. */
double hetab_fit_freedom(const hetab_fit_curvature *c);
/* Half the width of a quantity's 95 % interval, in standard errors: Student's, of the pairs that
 * say something of it; of a group's diffuse part. */
double hetab_fit_quantile(const hetab_fit_curvature *c, hetab_fit_quantity quantity, size_t group);

/* Widens the estimates' intervals where the profile says so (fit_profile.c). */
hetab_status hetab_fit_check_profiles(hetab_fit_curvature *c, hetab_fit *fit);

/* Fills in the estimates' bootstrap intervals (fit_bootstrap.c). */
hetab_status hetab_fit_bootstrap(hetab_fit_curvature *c, hetab_fit *fit);
