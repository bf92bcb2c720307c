/* What is asked for makes sense, and its defaults. */
#include "fit/fit_internal.h"

#include <math.h>

#include "surface/index_parts.h"

typedef struct rule {
  const char *name;
  double least, most; /* of a value, and of bounds */
  double low, high;   /* bounds by default */
} rule;

static const rule rules[HETAB_FIT_QUANTITIES] = {{"slope", 1e-4, 10, 0.005, 1},
                                                 {"sigma0_um", 1e-4, 1e3, 0.01, 10},
                                                 {"tau_um", 1e-3, 1e4, 0.3, 100},
                                                 {"n", 0.05, 10, 1.05, 3},
                                                 {"diffuse_reflectance", 0, 10, 0, 1}};
static const double MOST_ROUGH = 1e3; /* sigma0 / lambda of a reflectance */
enum { MOST_EVALUATIONS = 20000, STARTS = 4, MOST_STARTS = 10000, MOST_BOOTSTRAP = 100000 };

static const char *name_in(const char *const *names, size_t count, size_t i) {
  return i < count ? names[i] : "unknown";
}

const char *hetab_fit_quantity_name(hetab_fit_quantity quantity) {
  return (size_t)quantity < HETAB_FIT_QUANTITIES ? rules[quantity].name : "unknown";
}

const char *hetab_fit_weights_name(hetab_fit_weights weights) {
  static const char *const names[] = {"auto", "report", "energy", "equal", "relative", "log"};
  return name_in(names, 6, (size_t)weights);
}

const char *hetab_fit_constraint_name(hetab_fit_constraint constraint) {
  static const char *const names[] = {"auto", "polished", "energy", "none"};
  return name_in(names, 4, (size_t)constraint);
}

const char *hetab_fit_stop_name(hetab_fit_stop stop) {
  static const char *const names[] = {"tolerance", "budget", "infeasible"};
  return name_in(names, 3, (size_t)stop);
}

const char *hetab_fit_end_name(hetab_fit_end end) {
  static const char *const names[] = {"inside", "lower bound", "upper bound", "constraint",
                                      "fixed"};
  return name_in(names, 5, (size_t)end);
}

/* ---- checks ---------------------------------------------------------------------------------- */

static hetab_status check_parameter(hetab_context *ctx, const rule *r, hetab_fit_parameter *p) {
  if (p->free && p->low == 0 && p->high == 0) {
    p->low = r->low;
    p->high = r->high;
  }
  if (p->free && !(p->low >= r->least && p->low < p->high && p->high <= r->most))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "%s: bounds %g to %g: give an interval, the lower bound first, within %g to "
                      "%g",
                      r->name, p->low, p->high, r->least, r->most);
  if (p->value != 0 && !(p->value >= r->least && p->value <= r->most))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s = %g: give a value from %g to %g", r->name,
                      p->value, r->least, r->most);
  return HETAB_OK;
}

static hetab_status check_roughness(hetab_context *ctx, const hetab_fit_parameter *p) {
  int known = 0;
  for (int q = HETAB_FIT_SLOPE; q <= HETAB_FIT_TAU; q++)
    known += p[q].free || p[q].value > 0;
  if (known == 2)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "%s of slope, sigma0 and tau %s free or given: it takes two, the third follows "
                    "(a free slope needs tau, for example)",
                    known == 0   ? "none"
                    : known == 1 ? "one"
                                 : "all three",
                    known == 1 ? "is" : "are");
}

static hetab_status check_index(hetab_context *ctx, hetab_fit_options *o) {
  hetab_fit_parameter *n = &o->parameters[HETAB_FIT_N];
  if (!o->index)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "no refractive index: give one");
  if (!n->free && n->value > 0)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "n is given by the index: set it there");
  if (n->free && o->index->origin != HETAB_INDEX_CONSTANT)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "n cannot be free with the index of %s, which varies with the wavelength: "
                      "give a constant one",
                      hetab_index_source(o->index));
  if (n->free && n->value == 0)
    n->value = o->index->n.values[0];
  return HETAB_OK;
}

static hetab_status check_counts(hetab_context *ctx, hetab_fit_options *o) {
  if (o->starts > MOST_STARTS)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%zu starts: give at most %d", o->starts,
                      MOST_STARTS);
  if (o->bootstrap > MOST_BOOTSTRAP)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%zu resamplings: give at most %d", o->bootstrap,
                      MOST_BOOTSTRAP);
  if (!(o->exclude_mirror >= 0.0 && o->exclude_mirror <= M_PI))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "exclude_mirror = %g degrees: give an angle from 0 to 180",
                      hetab_degrees(o->exclude_mirror));
  if (!(o->asked_diffuse >= 0 && o->asked_diffuse <= 10))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "asked_diffuse = %g: give a reflectance",
                      o->asked_diffuse);
  if (!o->starts)
    o->starts = STARTS;
  if (!o->max_evaluations)
    o->max_evaluations = MOST_EVALUATIONS;
  return HETAB_OK;
}

hetab_status hetab_fit_options_check(hetab_context *ctx, hetab_fit_options *o) {
  int any = 0;
  for (int q = 0; q < HETAB_FIT_QUANTITIES; q++) {
    HETAB_TRY(check_parameter(ctx, &rules[q], &o->parameters[q]));
    any |= o->parameters[q].free;
  }
  if (!any)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "nothing is free: there is nothing to fit");
  HETAB_TRY(check_roughness(ctx, o->parameters));
  HETAB_TRY(check_index(ctx, o));
  return check_counts(ctx, o);
}

/* The corner of the bounds that is the roughest. */
hetab_status hetab_fit_bounds_check(hetab_context *ctx, const hetab_fit_options *o,
                                    double least_lambda_um) {
  const hetab_fit_parameter *p = o->parameters;
  const hetab_fit_parameter *slope = &p[HETAB_FIT_SLOPE], *sigma0 = &p[HETAB_FIT_SIGMA0],
                            *tau = &p[HETAB_FIT_TAU];
  double steepest = slope->free ? slope->high : slope->value;
  double longest = tau->free ? tau->high : tau->value;
  double roughest = sigma0->free        ? sigma0->high
                    : sigma0->value > 0 ? sigma0->value
                                        : steepest * longest;
  if (roughest <= MOST_ROUGH * least_lambda_um)
    return HETAB_OK;
  return hetab_fail(
      ctx, HETAB_ERR_RANGE,
      "the bounds allow sigma0 = %g um at %g nm, more than %g wavelengths: lower them", roughest,
      1e3 * least_lambda_um, MOST_ROUGH);
}
