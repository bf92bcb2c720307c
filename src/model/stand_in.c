#include <hetab/stand_in.h>

#include <math.h>

#include "core/context.h"
#include "model/hemisphere.h"
#include "model/universal.h"

double hetab_stand_in_alpha(const hetab_surface *surface) {
  return 2.0 * hetab_surface_sigma0_um(surface) / hetab_surface_tau_um(surface);
}

/* Density of facets, tan^2 of their tilt. */
static double facets(hetab_microfacets distribution, double alpha, double tan2) {
  double t = tan2 / (alpha * alpha), cos4 = 1.0 / ((1.0 + tan2) * (1.0 + tan2));
  double falls = distribution == HETAB_BECKMANN ? exp(-t) : 1.0 / ((1.0 + t) * (1.0 + t));
  return falls / (M_PI * alpha * alpha * cos4);
}

/* Smith's masking of one direction. */
static double unmasked(hetab_microfacets distribution, double alpha, double mu) {
  double tan2 = (1.0 - mu * mu) / (mu * mu);
  if (distribution == HETAB_GGX)
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * tan2));
  double a = 1.0 / (alpha * sqrt(fmax(tan2, 1e-30)));
  return 1.0 / (0.5 * (1.0 + erf(a)) + exp(-a * a) / (2.0 * a * sqrt(M_PI)));
}

enum { RAYS = 16, NODES = 128 };

/* At one node of the hemisphere's rule: f_dd and the stand-in times the node's part of the disc. */
static void add_node(const hetab_hemisphere *at, const hetab_wave *wave, const hetab_band *band,
                     hetab_microfacets distribution, const hetab_node *node, double sums[3]) {
  double alpha = 1.0 / at->tau_2sigma, mu = at->in.mu;
  double mu2 = fmax(4.0 * node->cos2_d - node->lateral2, 0.0), mu_r = sqrt(mu2) - mu;
  if (!(mu_r > 1e-9) || !(node->weight > 0.0))
    return;
  hetab_direction r = hetab_direction_at(acos(fmin(mu_r, 1.0)), at->tau_2sigma);
  double shadow = hetab_pair_of(&at->in, &r).shadow;
  double fresnel = hetab_fresnel_at(node->cos2_d, band->n, band->k);
  double dd = wave->amplitude * fresnel * node->cos2_d * node->cos2_d * shadow *
              exp(hetab_universal_ln_h(wave->g * node->g, wave->x * node->lateral2));
  double f = fresnel * facets(distribution, alpha, node->lateral2 / mu2) *
             unmasked(distribution, alpha, mu) * unmasked(distribution, alpha, mu_r) /
             (4.0 * mu * mu_r);
  double part = node->weight / shadow;
  sums[0] += dd * part;
  sums[1] += f * part;
  sums[2] += fabs(f - dd) * part;
}

static hetab_stand_in compare(const hetab_wave *wave, const hetab_band *band, double tau_2sigma,
                              hetab_microfacets distribution, double theta_i) {
  hetab_hemisphere at = hetab_hemisphere_at(theta_i, tau_2sigma);
  hetab_node nodes[NODES];
  double sums[3] = {0.0};
  for (size_t ray = 0; ray <= RAYS; ray++) {
    hetab_hemisphere_ray(&at, ray, RAYS, NODES, nodes);
    for (size_t i = 0; i < NODES; i++)
      if (i != NODES / 2 - 1) /* the rule has a node less */
        add_node(&at, wave, band, distribution, &nodes[i], sums);
  }
  double rho_s = hetab_specular(&at.in, wave), whole = sums[0] + rho_s;
  return (hetab_stand_in){
      .specular_share = rho_s / whole, .error = sums[2] / sums[0], .energy = sums[1] / whole};
}

hetab_status hetab_stand_in_compare(hetab_context *ctx, const hetab_surface *surface,
                                    hetab_microfacets distribution, double lambda_um,
                                    const double *theta_i, size_t count, hetab_stand_in *out) {
  hetab_band band;
  HETAB_TRY(hetab_surface_at(ctx, surface, lambda_um, &band));
  hetab_wave wave =
      hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), &band);
  for (size_t i = 0; i < count; i++) {
    if (!(theta_i[i] >= 0.0 && theta_i[i] < M_PI_2))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "theta_i[%zu] = %g: give incidences from 0 to below pi/2", i, theta_i[i]);
    out[i] = compare(&wave, &band, hetab_tau_2sigma(surface), distribution, theta_i[i]);
  }
  return HETAB_OK;
}
