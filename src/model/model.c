#include "model/model.h"

#define HETAB_HOST
#include "kernels/he_torrance.h"
#include "kernels/shadowing.h"

double hetab_one_plus_cos(double phi) {
  double c = fabs(phi) == M_PI ? 0.0 : cos(0.5 * phi);
  return 2.0 * c * c;
}

hetab_direction hetab_direction_at(double theta, double tau_2sigma) {
  hetab_direction d = {.theta = theta, .mu = cos(theta), .s = sin(theta)};
  if (theta >= M_PI_2)
    d.mu = 0.0;
  d.shadow_over_cos = hetab_shadow_over_cos(d.mu, d.s, tau_2sigma);
  d.k = d.mu > 0.0 ? hetab_k(d.mu, d.s, tau_2sigma) : HUGE_VAL;
  return d;
}

hetab_pair hetab_pair_of(const hetab_direction *i, const hetab_direction *r) {
  double mu = i->mu + r->mu;
  double difference = 2.0 * cos(0.5 * (i->theta + r->theta)) * sin(0.5 * (i->theta - r->theta));
  hetab_pair pair = {.mu2 = mu * mu, .d2 = difference * difference, .p = 2.0 * i->s * r->s};
  pair.ratio2 = isinf(i->k) || isinf(r->k) ? 0.0 : hetab_roughness_ratio2(i->k + r->k);
  pair.shadow = i->shadow_over_cos * r->shadow_over_cos * pair.ratio2;
  return pair;
}

/* n^2 - k^2 - 1 without cancellation near n = 1. */
static double e1_of(double n, double k) {
  return (n - 1.0) * (n + 1.0) - k * k;
}

hetab_wave hetab_wave_of(double sigma0_um, double tau_um, const hetab_band *band) {
  hetab_wave wave = {.g = hetab_wave_g(sigma0_um, band->lambda_um),
                     .x = hetab_wave_x(tau_um, band->lambda_um),
                     .e1 = e1_of(band->n, band->k),
                     .nk = band->n * band->k,
                     .diffuse_brdf = band->diffuse_brdf};
  wave.amplitude = hetab_wave_amplitude(wave.g, wave.x);
  return wave;
}

double hetab_specular(const hetab_direction *i, const hetab_wave *wave) {
  hetab_pair mirror = hetab_pair_of(i, i);
  double s = i->shadow_over_cos * i->mu;
  return hetab_rho_s(hetab_fresnel(i->mu * i->mu, wave->e1, wave->nk), s * s,
                     wave->g * mirror.mu2 * mirror.ratio2);
}

double hetab_fresnel_at(double cos2, double n, double k) {
  return hetab_fresnel(cos2, e1_of(n, k), n * k);
}

double hetab_ln_h(double g, double x) {
  return log(hetab_h(g, x));
}
