/* The reflectance under a uniform sky: the directional ones, integrated over incidence in mu, with
 * the crowding rule, since rho behaves as mu / log(mu) at grazing. Each level's nodes lie between
 * those of the one before. */
#include <hetab/reflectance.h>

#include <math.h>
#include <stdlib.h>

#include "engine/engine_internal.h"
#include "model/hemisphere.h"

enum { FIRST_INTERVALS = 16, MOST_INTERVALS = 2048 };

typedef struct sky {
  hetab_context *ctx;
  hetab_engine *engine;
  const hetab_surface *surface;
  double tolerance;
  size_t band_count;
  size_t intervals;          /* of the rule */
  hetab_reflectance *sums;   /* [band], over all nodes so far, without the step */
  hetab_reflectance *before; /* [band], the values of the rule with half the intervals */
} sky;

static double theta_at(const hetab_crowded *mu) {
  return mu->w < 0.5 ? M_PI_2 - asin(mu->w) : 2.0 * asin(sqrt(0.5 * mu->rest));
}

/* The parts times a factor; the error and the evaluations too. */
static void add_scaled(const hetab_reflectance *r, double factor, hetab_reflectance *sum) {
  sum->dd.value += factor * r->dd.value;
  sum->dd.error += factor * r->dd.error;
  sum->dd.evaluations += r->dd.evaluations;
  sum->dd.stop = r->dd.stop > sum->dd.stop ? r->dd.stop : sum->dd.stop;
  sum->specular += factor * r->specular;
  sum->fresnel += factor * r->fresnel;
}

/* Evaluates the nodes j = first, first + step, ... below `intervals` and adds them to the sums. */
static hetab_status add_nodes(sky *s, size_t first, size_t step) {
  size_t count = (s->intervals - 1 - first) / step + 1;
  HETAB_FREED double *theta = hetab_alloc(s->ctx, count, sizeof *theta);
  HETAB_FREED hetab_reflectance *values =
      hetab_alloc(s->ctx, count * s->band_count, sizeof *values);
  HETAB_NEED(theta && values);
  for (size_t i = 0; i < count; i++) {
    hetab_crowded mu = hetab_crowd((double)(first + i * step) / (double)s->intervals);
    theta[i] = theta_at(&mu);
  }
  HETAB_TRY(hetab_reflectance_dh(s->ctx, s->engine, s->surface, theta, count, 0.5 * s->tolerance,
                                 values));
  for (size_t i = 0; i < count; i++) {
    hetab_crowded mu = hetab_crowd((double)(first + i * step) / (double)s->intervals);
    for (size_t b = 0; b < s->band_count; b++)
      add_scaled(&values[b * count + i], 2.0 * mu.w * mu.slope, &s->sums[b]);
  }
  return HETAB_OK;
}

static hetab_reflectance value_of(const sky *s, size_t band) {
  hetab_reflectance value = {.dd.stop = HETAB_STOP_TOLERANCE};
  add_scaled(&s->sums[band], 1.0 / (double)s->intervals, &value);
  value.ud = M_PI * hetab_surface_bands(s->surface)[band].diffuse_brdf;
  value.dh = value.dd.value + value.specular + value.ud;
  return value;
}

/* What is below this is none, with rounding for its digits. */
static const double NOTHING = 1e-15;

static double relative(double a, double b) {
  return fabs(a - b) / fmax(fabs(b), NOTHING);
}

/* The rule's own relative error, dd and specular together, the polished one's beside. */
static double rule_error(const sky *s, size_t band) {
  hetab_reflectance value = value_of(s, band);
  const hetab_reflectance *before = &s->before[band];
  double part = relative(before->dd.value + before->specular, value.dd.value + value.specular);
  return hetab_rule_error(fmax(part, relative(before->fresnel, value.fresnel)));
}

/* A rule better than the reflectances that it adds up would be wasted. */
static int converged(const sky *s, size_t band) {
  hetab_reflectance value = value_of(s, band);
  double sum = value.dd.value + value.specular;
  return rule_error(s, band) * sum <= fmax(0.5 * s->tolerance * sum, value.dd.error);
}

static int all_converged(const sky *s) {
  size_t band = 0;
  while (band < s->band_count && converged(s, band))
    band++;
  return band == s->band_count;
}

static hetab_status refine(sky *s) {
  HETAB_TRY(add_nodes(s, 1, 1));
  do {
    for (size_t b = 0; b < s->band_count; b++)
      s->before[b] = value_of(s, b);
    s->intervals *= 2;
    HETAB_TRY(add_nodes(s, 1, 2));
  } while (!all_converged(s) && s->intervals < MOST_INTERVALS);
  return HETAB_OK;
}

static void store(const sky *s, size_t band, hetab_reflectance *out) {
  *out = value_of(s, band);
  double sum = out->dd.value + out->specular;
  out->dd.error += rule_error(s, band) * sum;
  if (out->dd.error <= s->tolerance * sum)
    out->dd.stop = HETAB_STOP_TOLERANCE;
  else if (!converged(s, band))
    out->dd.stop = HETAB_STOP_BUDGET;
  else if (out->dd.stop == HETAB_STOP_TOLERANCE)
    out->dd.stop = HETAB_STOP_ROUNDOFF;
}

hetab_status hetab_reflectance_hh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, double tolerance,
                                  hetab_reflectance *out) {
  int is_double = hetab_engine_precision(engine) == HETAB_DOUBLE;
  sky s = {.ctx = ctx,
           .engine = engine,
           .surface = surface,
           .tolerance = tolerance > 0.0 ? tolerance
                        : is_double     ? 1e-9
                                        : 1e-5,
           .band_count = hetab_surface_band_count(surface),
           .intervals = FIRST_INTERVALS};
  HETAB_TRY(hetab_check_tolerance(ctx, tolerance));
  s.sums = hetab_alloc(ctx, s.band_count, sizeof *s.sums);
  s.before = hetab_alloc(ctx, s.band_count, sizeof *s.before);
  hetab_status status = s.sums && s.before ? refine(&s) : HETAB_ERR_MEMORY;
  for (size_t b = 0; status == HETAB_OK && b < s.band_count; b++)
    store(&s, b, &out[b]);
  free(s.sums);
  free(s.before);
  return status;
}
