/* The fit's inside: what is fitted to what, the model on the device, and one evaluation of the
 * objective with the diffuse part eliminated. */
#pragma once

#include <hetab/fit.h>
#include <hetab/reflectance.h>

#include "core/angle.h"
#include "core/context.h"
#include "engine/points.h"

enum { HETAB_FIT_MOST_FREE = 3 }; /* unknowns but the diffuse part: two of roughness, and n */
enum { HETAB_FIT_MOST_BANDS = 1024, HETAB_FIT_MOST_DIFFUSE = 256 };

/* How far rho_dh may be above the bound: include/hetab/fit.h says why. */
#define HETAB_FIT_SLACK 1e-5

/* ---- the options (fit_options.c) ------------------------------------------------------------- */

/* Fills in the defaults. */
hetab_status hetab_fit_options_check(hetab_context *ctx, hetab_fit_options *options);
/* Whether the model can be computed everywhere within the bounds. */
hetab_status hetab_fit_bounds_check(hetab_context *ctx, const hetab_fit_options *options,
                                    double least_lambda_um);

/* ---- the measurements in the fit (fit_data.c) ------------------------------------------------ */

typedef struct hetab_fit_data {
  size_t count, bands;
  size_t *pair_of;         /* [count] places in the measurements */
  hetab_directions *pairs; /* [count] */
  size_t *band_of;         /* [bands] places in the measurements, by wavelength */
  double *lambda_um;       /* [bands] ascending */
  double *measured;        /* [count][bands] */
  double *weight;          /* [count][bands], 0: not in the fit */
  size_t *incidence;       /* [count] */
  double *mean;            /* [bands] weighted */
  double *theta_i;         /* [incidence_count] */
  size_t incidence_count;
  double scale; /* of the objective: sum w f^2, or sum w for logarithms */
  size_t values, missing, negative, below_horizon, thinned;
} hetab_fit_data;

hetab_status hetab_fit_data_select(hetab_context *ctx, const hetab_measurements *measurements,
                                   const hetab_fit_options *options, hetab_fit_data *data);
/* *weights: AUTO becomes what it stands for. */
hetab_status hetab_fit_data_weigh(hetab_context *ctx, hetab_fit_weights *weights,
                                  hetab_fit_data *data);
void hetab_fit_data_clear(hetab_fit_data *data);

/* ---- the model (fit_model.c) ----------------------------------------------------------------- */

typedef struct hetab_fit_model {
  double
      own_excess; /* how far the model alone may be above the bound, of that; see HETAB_FIT_AUTO */
  hetab_engine *engine;
  hetab_places *places;
  hetab_surface *surface; /* its roughness and n are set before each evaluation */
  hetab_reflectance *reflectances;
  double *theta_i; /* of the active incidences */
} hetab_fit_model;

hetab_status hetab_fit_model_create(hetab_context *ctx, hetab_engine *engine,
                                    const hetab_fit_options *options, const hetab_fit_data *data,
                                    hetab_fit_model *model);
void hetab_fit_model_clear(hetab_fit_model *model);
/* n = 0: the index as it is. */
void hetab_fit_model_set(hetab_fit_model *model, double sigma0_um, double tau_um, double n);
/* f_dd, 1/sr: dd[count][bands]. */
hetab_status hetab_fit_model_dd(hetab_context *ctx, hetab_fit_model *model,
                                const hetab_directions *pairs, size_t count, double *dd);
/* What the bound leaves for the diffuse part at the active incidences (NULL: all):
 * room[incidence][band], infinite elsewhere. Of all, model->reflectances holds [band][incidence].
 */
hetab_status hetab_fit_model_room(hetab_context *ctx, hetab_fit_model *model,
                                  const hetab_fit_data *data, hetab_fit_constraint constraint,
                                  const unsigned char *active, double *room);

/* ---- the problem ----------------------------------------------------------------------------- */

/* One evaluation. The diffuse parts are reflectances, pi * BRDF. */
typedef struct hetab_fit_state {
  double x[HETAB_FIT_MOST_FREE]; /* 0 to 1 between the logarithms of the bounds */
  double value[HETAB_FIT_QUANTITIES];
  double q;        /* E^2 */
  double spare;    /* what the constraint leaves at the least diffuse part; infinite without one */
  double *diffuse; /* [groups] */
  double *room;    /* [groups] the most that the constraint allows; infinite without one */
  hetab_fit_end *end; /* [groups] */
} hetab_fit_state;

/* What the fit without the constraint would do to it. */
typedef struct hetab_fit_wish {
  double q, value[HETAB_FIT_QUANTITIES];
  double excess, theta_i, lambda_um; /* of rho_dh over the bound, where it is largest */
} hetab_fit_wish;

typedef struct hetab_fit_problem {
  hetab_context *ctx;
  hetab_fit_options options; /* with the defaults filled in */
  hetab_fit_data data;
  hetab_fit_model model;
  hetab_fit_quantity free[HETAB_FIT_MOST_FREE];
  size_t free_count;
  int apart; /* sigma0 and tau both free: slope and tau are searched, sigma0 kept to its bounds */
  size_t groups; /* diffuse parts: 1, or one for each wavelength */
  int constrained;
  /* The integrals of the constraint take most of the time: what is worse than this without it is
   * not looked at with it (spare: minus infinity). Infinite but for scans. */
  double dull;
  size_t evaluations;
  hetab_fit_wish wish;
  double *dd;   /* [count][bands] of the last evaluation */
  double *room; /* [incidence][band] likewise */
  /* [incidence] where the constraint is looked at; NULL: everywhere. An optimum under some of it
   * that keeps all of it is the optimum under all of it. */
  unsigned char *active;
  unsigned char *distrusted; /* [count][bands], of a robust fit; else NULL */
  size_t distrusted_count;
} hetab_fit_problem;

hetab_status hetab_fit_state_create(const hetab_fit_problem *problem, hetab_fit_state *state);
void hetab_fit_state_copy(const hetab_fit_problem *problem, const hetab_fit_state *from,
                          hetab_fit_state *to);
void hetab_fit_state_clear(hetab_fit_state *state);

/* Everything at state->x (fit_objective.c). */
hetab_status hetab_fit_evaluate(hetab_fit_problem *problem, hetab_fit_state *state);
/* All but the model: the diffuse part and q for problem->dd and state->room. times: how often each
 * pair counts; NULL: once. */
void hetab_fit_solve_diffuse(const hetab_fit_problem *problem, const unsigned *times,
                             hetab_fit_state *state);
/* Model and residual of a value: (f - f_measured), or the logarithms' difference, and the
 * residual's derivative by f. */
double hetab_fit_residual(const hetab_fit_problem *problem, size_t i, double f, double *slope);
/* The quantities that follow from state->x. */
void hetab_fit_values_at(const hetab_fit_problem *problem, const double *x, double *value);
/* Whether the constraint holds, within the slack. */
int hetab_fit_feasible(const hetab_fit_state *state);
static inline size_t hetab_fit_group(const hetab_fit_problem *p, size_t band) {
  return p->groups == 1 ? 0 : band;
}

/* ---- the search (fit_search.c) --------------------------------------------------------------- */

/* The best value of everything else with one unknown, problem->free[fixed], held where it is in
 * state->x, from there on. */
hetab_status hetab_fit_search_beside(hetab_fit_problem *problem, size_t fixed,
                                     hetab_fit_state *state);
/* The best state from all starts; those go to fit->starts. */
hetab_status hetab_fit_search(hetab_fit_problem *problem, hetab_fit_state *best, hetab_fit *fit);

/* Sets data.weight so that the least squares of all that follows are the least Cauchy loss, and
 * problem->distrusted (fit_robust.c). */
hetab_status hetab_fit_make_robust(hetab_fit_problem *problem, hetab_fit_state *best,
                                   hetab_fit *fit);

/* ---- intervals (fit_interval.c), sentences (fit_notes.c) ------------------------------------- */

hetab_status hetab_fit_intervals(hetab_fit_problem *problem, const hetab_fit_state *best,
                                 hetab_fit *fit);
hetab_status hetab_fit_add_notes(const hetab_fit_problem *problem, hetab_fit *fit);
