/* The parameters of a surface from its measured BRDF.
 *
 * Objective. Over all pairs of directions and wavelengths used,
 *
 *   E^2 = sum w (f - f_measured)^2 / sum w f_measured^2
 *
 * E is relative, 0.02 being 2 %. w = cos^2(theta_r) is the report's (Li & Torrance, TR PCG-05-02,
 * 2005, Eq. 5 as printed), made for scans of the incidence plane, where it is the default. Of
 * scattered directions the default is the energy that a direction carries, w = cos(theta_i)
 * cos(theta_r) dOmega: dOmega is the solid angle that a measurement stands for: at each incidence,
 * rings about the normal with borders half way between the measured theta_r, shared equally among a
 * ring's measurements. f = f_dd + f_ud of the model: the specular delta is not in it (see
 * exclude_mirror).
 *
 * Method. At given roughness and index the diffuse part is the only linear unknown: its best value
 * within its bounds and the constraint is found exactly (variable projection), so that at most
 * three unknowns are left. From each start: the lowest dips of a lattice through it over the
 * bounds, then NLopt's COBYLA; from the distinct ends NLopt's SLSQP with central differences. The
 * search variables are logarithms.
 *
 * Constraint. rho_dh(theta_i, lambda) <= bound at every incidence and wavelength used, within 1e-5.
 * The model alone, without a diffuse part, exceeds the reflectance of some polished materials a
 * little (hetab_audit_surface() says where): with HETAB_FIT_AUTO up to 0.5 % of the bound is not
 * held against a metal's roughness, which then has no diffuse part. Of dielectrics that is more,
 * and what enters a paint comes back: they need HETAB_FIT_ENERGY.
 *
 * Errors (tests/test_fit.c): the report's five surfaces with a = 0.05 and 2 % noise, measured as a
 * gonioreflectometer does at 1440 pairs: slope within 0.5 %, a within 0.006 (2e-4 with relative
 * weights), the same from every start to 1e-7. From 324 pairs in the incidence plane, energy
 * weights leave `a` of the smoothest, beside a peak of 140 / sr, to within 0.1. Of such
 * sets of GGAL120 with 5 % noise, as aluminium and as a paint (n 1.5, a 0.3), the 95 % intervals of
 * the slope held the truth in 93 to 96 % of 250, those of `a` in 91 to 96 %, with energy and with
 * equal weights (`make coverage`); with relative ones `a` of the paint comes out biased. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/index.h>
#include <hetab/measurements.h>
#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_fit_weights {
  HETAB_FIT_WEIGHTS_AUTO,     /* REPORT if all pairs used lie in the incidence plane, else ENERGY */
  HETAB_FIT_WEIGHTS_REPORT,   /* cos^2(theta_r): Eq. 5 as printed */
  HETAB_FIT_WEIGHTS_ENERGY,   /* cos(theta_i) cos(theta_r) dOmega */
  HETAB_FIT_WEIGHTS_EQUAL,    /* 1 */
  HETAB_FIT_WEIGHTS_RELATIVE, /* 1 / f_measured^2, no smaller f than 1e-3 of the wavelength's mean
                               */
  HETAB_FIT_WEIGHTS_LOG /* E^2 = mean (ln f - ln f_measured)^2, a hundredth of the wavelength's
                         * mean added to both; values of 0 are left out */
} hetab_fit_weights;

typedef enum hetab_fit_constraint {
  HETAB_FIT_AUTO, /* POLISHED, less the model's own excess, if k > 0 at any wavelength, else ENERGY
                   */
  HETAB_FIT_POLISHED, /* the report's: rho_dh <= reflectance of the polished material */
  HETAB_FIT_ENERGY,   /* rho_dh <= 1 */
  HETAB_FIT_UNCONSTRAINED
} hetab_fit_constraint;

/* What can be fitted. */
typedef enum hetab_fit_quantity {
  HETAB_FIT_SLOPE,  /* sigma0 / tau */
  HETAB_FIT_SIGMA0, /* um */
  HETAB_FIT_TAU,    /* um */
  HETAB_FIT_N,      /* real part of a constant index */
  HETAB_FIT_DIFFUSE /* `a` as a reflectance, pi * BRDF */
} hetab_fit_quantity;
enum { HETAB_FIT_QUANTITIES = 5 };

const char *hetab_fit_quantity_name(hetab_fit_quantity quantity); /* "slope", "sigma0_um", ... */
const char *hetab_fit_weights_name(hetab_fit_weights weights);    /* "report" */
const char *hetab_fit_constraint_name(hetab_fit_constraint constraint); /* "polished" */

/* One quantity: free within [low, high], or given (value > 0; DIFFUSE: >= 0). A free one may have a
 * value: one more start. Bounds of 0 and 0 are the defaults: slope 0.005 to 1, sigma0 0.01 to 10
 * um, tau 0.3 to 100 um, n 1.05 to 3, diffuse 0 to 1; sigma0 and tau both free keep sigma0 / tau to
 * 0.005 to 1. */
typedef struct hetab_fit_parameter {
  int free;
  double value;
  double low, high;
} hetab_fit_parameter;

typedef struct hetab_fit_options {
  size_t size; /* of the struct; 0: of this header's */
  /* Of slope, sigma0 and tau exactly two are free or given (value not 0). */
  hetab_fit_parameter parameters[HETAB_FIT_QUANTITIES];
  int one_diffuse;          /* `a`, if free, is one number for all wavelengths, not one for each */
  const hetab_index *index; /* not NULL; with n free, its k and its n as the first start */
  int extrapolate_index;

  /* What is used: NULL or 0 stands for all. Wavelengths within 0.1 nm, incidences within 0.1
   * degrees of one named; each named one has to be there. */
  const double *lambda_um;
  size_t lambda_count;
  const double *theta_i;
  size_t theta_i_count;
  int plane;             /* the incidence plane alone: phi within 0.5 degrees of 0 or 180 */
  double exclude_mirror; /* leave out views this near the mirror direction */
  size_t max_points;     /* pairs used at most, evenly out of all; 0: 100000 */

  hetab_fit_weights weights;
  hetab_fit_constraint constraint;
  size_t starts; /* random starts within the bounds, beside the given one; 0: 4 */
  unsigned long long seed;
  int derivative_free;    /* COBYLA alone, to its tolerance, without SLSQP */
  size_t max_evaluations; /* of the objective, in all; 0: 20000 */
  int robust;             /* a Cauchy loss of the relative residuals, its scale from the median of
                           * their sizes: values that are wrong do not pull, and are listed */
  size_t bootstrap;       /* resamplings of the pairs; 0: none */
  double asked_diffuse;   /* what would this `a` (reflectance) need? 0: no question */
} hetab_fit_options;

typedef enum hetab_fit_stop {
  HETAB_FIT_STOP_TOLERANCE, /* converged */
  HETAB_FIT_STOP_BUDGET,    /* max_evaluations: the best so far */
  HETAB_FIT_STOP_INFEASIBLE /* nothing within the bounds keeps the constraint: the values are the
                             * nearest found, not a result */
} hetab_fit_stop;
const char *hetab_fit_stop_name(hetab_fit_stop stop); /* "tolerance" */

/* Where an estimate ended. */
typedef enum hetab_fit_end {
  HETAB_FIT_END_INSIDE,
  HETAB_FIT_END_LOW,        /* on its lower bound */
  HETAB_FIT_END_HIGH,       /* on its upper bound */
  HETAB_FIT_END_CONSTRAINT, /* held by the constraint on rho_dh */
  HETAB_FIT_END_FIXED       /* given, or computed from what is free and given */
} hetab_fit_end;
const char *hetab_fit_end_name(hetab_fit_end end); /* "inside" */

/* A number with its 95 % interval. From the curvature: the Jacobian and the residuals, allowing for
 * unequal noise and for residuals that are alike at one pair of directions across wavelengths
 * (cluster-robust, HC3). Where the objective levels off within a factor of e of an unknown, or the
 * unknown is on its bound, from its profile instead: the others fitted again with it held. What
 * the constraint holds where it is has low = high = value. What the data do not determine has an
 * interval that ends at its bounds at the latest. */
typedef struct hetab_fit_estimate {
  hetab_fit_quantity quantity;
  double lambda_um; /* of DIFFUSE at one wavelength; 0: all */
  double value, low, high;
  /* 95 % of the resamplings, as far beyond them as few pairs ask for; NaN without bootstrap */
  double bootstrap_low, bootstrap_high;
  hetab_fit_end end;
  int undetermined; /* the data do not fix it: the interval spans more than a factor of 2.7 (a:
                     * more than 0.5) or the curvature is singular */
  double wanted;    /* the value of the best fit without the constraint */
} hetab_fit_estimate;

/* One incidence, or 5 degrees of them where there are more than 40. */
typedef struct hetab_fit_incidence {
  double theta_i;
  size_t values; /* pairs times wavelengths used */
  double error;  /* E of these alone */
  double rms;    /* unweighted, 1/sr */
  double mean;   /* of the measured values, 1/sr */
  double bias;   /* of model - measured, 1/sr */
  /* Over the wavelengths, where bound - rho_dh is least; the bound is the polished material's under
   * HETAB_FIT_UNCONSTRAINED. */
  double margin, margin_lambda_um, rho_dh, bound;
  double polished_margin; /* the least of polished - rho_dh, whatever the constraint */
  double room;   /* the largest `a` (reflectance) that would keep the bound here; may be < 0 */
  double excess; /* of asked_diffuse over room; 0 without a question */
} hetab_fit_incidence;

/* What became of a start. */
typedef struct hetab_fit_start {
  double start[HETAB_FIT_QUANTITIES - 1], end[HETAB_FIT_QUANTITIES - 1]; /* 0 where not free */
  double error;                                                          /* E at the end */
  int feasible;
  int best;  /* the same answer as the result's */
  int probe; /* not a start, but another dip of the first one's lattice: is it as good? */
} hetab_fit_start;

typedef struct hetab_fit {
  /* Slope, sigma0, tau, n if it is free, then the diffuse part: one or [bands]. */
  hetab_fit_estimate *estimates;
  size_t estimate_count;
  double sigma0_um, tau_um, slope;

  /* Of the free estimates that ended inside (or moving along the constraint); [free][free]. */
  size_t free_count;
  size_t *free_estimates; /* [free]: places in estimates */
  double *correlation;

  double error;                    /* E */
  double rms;                      /* unweighted, 1/sr */
  hetab_fit_weights weights;       /* those in force, never AUTO */
  hetab_fit_constraint constraint; /* likewise */
  hetab_fit_stop stop;
  int on_constraint; /* the constraint holds the result back */
  int ambiguous;     /* another minimum is as good: see notes and starts */
  double margin;     /* the least of the incidences' margins */

  hetab_fit_incidence *incidences;
  size_t incidence_count;
  hetab_fit_start *starts;
  size_t start_count;
  size_t evaluations; /* of the objective */
  size_t bootstrap_count;

  /* The wavelengths fitted, as places in the measurements; n, k and diffuse part are the surface's
   * bands. */
  size_t bands;
  size_t *band_of;     /* [bands] */
  double *lambda_um;   /* [bands] */
  double *diffuse;     /* [bands], reflectance pi * BRDF */
  double *model;       /* [pairs of the measurements][bands]: f_dd + f_ud, 1/sr, used or not */
  unsigned char *used; /* [pairs][bands]: in the fit */
  size_t used_pairs, used_values;
  unsigned char *distrusted; /* [pairs][bands]: robust fit, more than 5 robust deviations off */
  size_t distrusted_values;
  size_t missing; /* values chosen but NaN */
  size_t thinned; /* pairs left out by max_points */

  hetab_surface *surface; /* the fitted surface; NULL if infeasible */

  char **notes; /* plain sentences: what a reader of the numbers has to know */
  size_t note_count;
} hetab_fit;

/* Fits. HETAB_ERR_ARGUMENT: options that make no sense; HETAB_ERR_RANGE: no measurements left to
 * fit, or fewer than there are unknowns, or wavelengths outside the index data. A fit that does not
 * converge, or has no feasible point, is a result: see stop. */
hetab_status hetab_fit_create(hetab_context *ctx, hetab_engine *engine,
                              const hetab_measurements *measurements,
                              const hetab_fit_options *options, hetab_fit **out);
void hetab_fit_free(hetab_fit *fit);

HETAB_END
