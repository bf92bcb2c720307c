#include <hetab/sampler.h>

#include <math.h>
#include <stdlib.h>

#define HETAB_HOST
#include "kernels/he_torrance.h"
#include "kernels/shadowing.h"
#include "model/limits.h"
#include "model/mixture.h"

struct hetab_model_sampler {
  double tau_2sigma;
  size_t band_count;
  hetab_wave *waves;
  hetab_mixture mixture;
};

hetab_status hetab_model_sampler_create(hetab_context *ctx, const hetab_surface *surface,
                                        size_t hero, hetab_model_sampler **out) {
  size_t count = hetab_surface_band_count(surface);
  double sigma0_um = hetab_surface_sigma0_um(surface), tau_um = hetab_surface_tau_um(surface);
  hetab_status status;
  *out = NULL;
  HETAB_TRY(hetab_check_surface(ctx, surface));
  if (hero >= count)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "surface '%s' has no band %zu to sample: give one from 0 to %zu",
                      hetab_surface_name(surface), hero, count - 1);
  hetab_model_sampler *sampler = hetab_alloc(ctx, 1, sizeof *sampler);
  HETAB_NEED(sampler);
  sampler->tau_2sigma = tau_um / (2.0 * sigma0_um);
  sampler->band_count = count;
  sampler->waves = hetab_alloc(ctx, count, sizeof *sampler->waves);
  if (!sampler->waves)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  for (size_t b = 0; b < count; b++)
    sampler->waves[b] = hetab_wave_of(sigma0_um, tau_um, &hetab_surface_bands(surface)[b]);
  HETAB_GOTO(
      hetab_mixture_build(ctx, &sampler->waves[hero], sampler->tau_2sigma, &sampler->mixture));
  *out = sampler;
done:
  if (status != HETAB_OK)
    hetab_model_sampler_free(sampler);
  return status;
}

void hetab_model_sampler_free(hetab_model_sampler *sampler) {
  if (!sampler)
    return;
  free(sampler->waves);
  free(sampler);
}

size_t hetab_model_sampler_band_count(const hetab_model_sampler *sampler) {
  return sampler->band_count;
}

/* ---- the model ----------------------------------------------------------------------------- */

/* As hetab_direction_at(), from cosine and sine. */
static hetab_direction direction_of(double mu, double s, double tau_2sigma) {
  return (hetab_direction){.mu = mu,
                           .s = s,
                           .shadow_over_cos = hetab_shadow_over_cos(mu, s, tau_2sigma),
                           .k = hetab_k(mu, s, tau_2sigma)};
}

static void values_of(const hetab_model_sampler *sampler, const hetab_lobe_pair *pair,
                      double factor, double *value) {
  double s_r = sqrt(fmax((1.0 - pair->mu_r) * (1.0 + pair->mu_r), 0.0));
  hetab_direction i = direction_of(pair->mu, pair->s, sampler->tau_2sigma);
  hetab_direction r = direction_of(pair->mu_r, s_r, sampler->tau_2sigma);
  double ratio2 = hetab_roughness_ratio2(i.k + r.k);
  double shadow = i.shadow_over_cos * r.shadow_over_cos * ratio2;
  double c = pair->mu + pair->mu_r, g = c * c * ratio2;
  double cos2_d = fmin(0.25 * (c * c + pair->lateral2), 1.0);
  for (size_t b = 0; b < sampler->band_count; b++) {
    const hetab_wave *wave = &sampler->waves[b];
    double dd = hetab_dd(cos2_d, hetab_fresnel(cos2_d, wave->e1, wave->nk),
                         wave->amplitude * shadow, hetab_h(wave->g * g, wave->x * pair->lateral2));
    value[b] = factor * (dd + wave->diffuse_brdf);
  }
}

/* 0 unless both directions are above the horizon. */
static int pair_of(const double wi[3], const double wo[3], hetab_lobe_pair *pair) {
  double dx = wi[0] + wo[0], dy = wi[1] + wo[1];
  *pair = (hetab_lobe_pair){wi[2], hypot(wi[0], wi[1]), wo[2], dx * dx + dy * dy};
  return pair->mu > 0.0 && pair->mu_r > 0.0;
}

void hetab_model_sampler_eval(const hetab_model_sampler *sampler, const double wi[3],
                              const double wo[3], double *value) {
  hetab_lobe_pair pair;
  if (pair_of(wi, wo, &pair))
    values_of(sampler, &pair, 1.0, value);
  else
    for (size_t b = 0; b < sampler->band_count; b++)
      value[b] = 0.0;
}

void hetab_model_sampler_specular(const hetab_model_sampler *sampler, const double wi[3],
                                  double *value) {
  hetab_direction i = hetab_direction_at(atan2(hypot(wi[0], wi[1]), wi[2]), sampler->tau_2sigma);
  for (size_t b = 0; b < sampler->band_count; b++)
    value[b] = i.mu > 0.0 ? hetab_specular(&i, &sampler->waves[b]) : 0.0;
}

/* ---- sampling ------------------------------------------------------------------------------ */

static double density_of(const hetab_mixture *mixture, const double *weights,
                         const hetab_lobe_pair *pair) {
  double density = 0.0;
  for (size_t i = 0; i < mixture->count; i++)
    if (weights[i] > 0.0)
      density += weights[i] * hetab_lobe_density(&mixture->lobes[i], pair);
  return density;
}

double hetab_model_sampler_pdf(const hetab_model_sampler *sampler, const double wi[3],
                               const double wo[3]) {
  double weights[HETAB_MIXTURE_LOBES];
  hetab_lobe_pair pair;
  if (!pair_of(wi, wo, &pair))
    return 0.0;
  hetab_mixture_at(&sampler->mixture, atan2(pair.s, pair.mu), weights);
  return density_of(&sampler->mixture, weights, &pair);
}

/* The lobe that u falls to; *rest: where in its share, in [0, 1). */
static const hetab_lobe *choose(const hetab_mixture *mixture, const double *weights, double u,
                                double *rest) {
  size_t chosen = 0;
  double start = 0.0, sum = 0.0;
  for (size_t i = 0; i < mixture->count && sum <= u; i++)
    if (weights[i] > 0.0) {
      chosen = i;
      start = sum;
      sum += weights[i];
    }
  *rest = fmin((u - start) / weights[chosen], 1.0 - 0x1p-53);
  return &mixture->lobes[chosen];
}

/* wi's azimuth is the frame's x axis. */
static void turn(const double wi[3], const hetab_lobe_pair *pair, const double d[2], double wo[3]) {
  double x = pair->s > 0.0 ? wi[0] / pair->s : 1.0, y = pair->s > 0.0 ? wi[1] / pair->s : 0.0;
  double qx = d[0] - pair->s;
  wo[0] = qx * x - d[1] * y;
  wo[1] = qx * y + d[1] * x;
  wo[2] = pair->mu_r;
}

static double no_sample(const hetab_model_sampler *sampler, const double wi[3], double wo[3],
                        double *weight) {
  wo[0] = -wi[0];
  wo[1] = -wi[1];
  wo[2] = wi[2];
  for (size_t b = 0; weight && b < sampler->band_count; b++)
    weight[b] = 0.0;
  return 0.0;
}

double hetab_model_sampler_sample(const hetab_model_sampler *sampler, const double wi[3],
                                  const double u[3], double wo[3], double *weight) {
  const hetab_mixture *mixture = &sampler->mixture;
  double weights[HETAB_MIXTURE_LOBES], d[2], v[3] = {0.0, u[1], u[2]};
  hetab_lobe_pair pair = {.mu = wi[2], .s = hypot(wi[0], wi[1])};
  if (!(pair.mu > 0.0))
    return no_sample(sampler, wi, wo, weight);
  hetab_mixture_at(mixture, atan2(pair.s, pair.mu), weights);
  const hetab_lobe *lobe = choose(mixture, weights, u[0], &v[0]);
  if (!hetab_lobe_sample(lobe, v, &pair, d))
    return no_sample(sampler, wi, wo, weight);
  double density = density_of(mixture, weights, &pair);
  if (!(density > 0.0))
    return no_sample(sampler, wi, wo, weight);
  turn(wi, &pair, d, wo);
  if (weight)
    values_of(sampler, &pair, pair.mu_r / density, weight);
  return density;
}
