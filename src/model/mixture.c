#include "model/mixture.h"

#include <math.h>
#include <stdlib.h>

#define HETAB_HOST
#include "kernels/fresnel.h"
#include "model/hemisphere.h"

/* Rows of weights: theta = pi/2 (1 - (1 - v)^2), v from 0 to 1. */
static double angle_of(size_t row) {
  double rest = 1.0 - (double)row / (HETAB_MIXTURE_ANGLES - 1);
  return M_PI_2 * (1.0 - fmax(rest * rest, 1e-4)); /* at 90 degrees f is 0 */
}

void hetab_mixture_at(const hetab_mixture *mixture, double theta_i, double *weights) {
  double at = (1.0 - sqrt(fmax(1.0 - theta_i / M_PI_2, 0.0))) * (HETAB_MIXTURE_ANGLES - 1);
  size_t row = at < HETAB_MIXTURE_ANGLES - 2 ? (size_t)at : HETAB_MIXTURE_ANGLES - 2;
  double share = fmin(at - (double)row, 1.0);
  const double *a = mixture->weights[row], *b = mixture->weights[row + 1];
  for (size_t i = 0; i < mixture->count; i++)
    weights[i] = a[i] + share * (b[i] - a[i]);
}

/* ---- lobes --------------------------------------------------------------------------------- */

/* Series lobes from the g of the disc's centre at normal incidence down to where the first term is
 * all; above LARGEST_G the slopes do as well. Slopes as wide as the surface's, and narrower: at
 * grazing only the tops are seen. */
static const double SMALLEST_G = 0.03, LARGEST_G = 2000.0;
enum { SERIES_LOBES = 16 };
static const double STEP_G = 2.5;

static void add_lobes(hetab_mixture *mixture, const hetab_wave *wave, double tau_2sigma) {
  static const double narrower[] = {1.08, 0.8, 0.55};
  hetab_lobe *next = mixture->lobes;
  double g = fmin(4.0 * wave->g, LARGEST_G);
  for (int i = 0; i < SERIES_LOBES && (i == 0 || g > SMALLEST_G); i++, g /= STEP_G)
    hetab_lobe_series(next++, fmax(g, 1e-12), wave->x);
  for (size_t i = 0; i < sizeof narrower / sizeof *narrower; i++)
    hetab_lobe_slopes(next++, narrower[i] / tau_2sigma);
  hetab_lobe_cosine(next++);
  mixture->count = (size_t)(next - mixture->lobes);
}

/* ---- weights ------------------------------------------------------------------------------- */

enum { RAYS = 8, RAY_NODES = 64, POINTS = (RAYS + 1) * (RAY_NODES - 1), ROUNDS = 60 };

typedef struct points {
  size_t count;
  double f2[POINTS]; /* f^2 dq */
  double density[POINTS][HETAB_MIXTURE_LOBES];
} points;

static void add_point(const hetab_mixture *mixture, const hetab_hemisphere *at,
                      const hetab_wave *wave, const hetab_node *node, points *p) {
  double c = sqrt(fmax(4.0 * node->cos2_d - node->lateral2, 0.0));
  hetab_lobe_pair pair = {at->in.mu, at->in.s, c - at->in.mu, node->lateral2};
  if (!(pair.mu_r > 1e-9) || !(node->weight > 0.0))
    return;
  hetab_direction r = hetab_direction_at(acos(fmin(pair.mu_r, 1.0)), at->tau_2sigma);
  double shadow = hetab_pair_of(&at->in, &r).shadow;
  double h = exp(hetab_ln_h(wave->g * node->g, wave->x * node->lateral2));
  double fresnel = hetab_fresnel(node->cos2_d, wave->e1, wave->nk);
  double f =
      wave->amplitude * fresnel * node->cos2_d * node->cos2_d * shadow * h + wave->diffuse_brdf;
  p->f2[p->count] = f * f * node->weight / shadow;
  for (size_t i = 0; i < mixture->count; i++)
    p->density[p->count][i] = hetab_lobe_density(&mixture->lobes[i], &pair) / pair.mu_r;
  p->count++;
}

static void add_points(const hetab_mixture *mixture, const hetab_wave *wave, double theta_i,
                       double tau_2sigma, points *p) {
  hetab_node nodes[RAY_NODES];
  hetab_hemisphere at = hetab_hemisphere_at(theta_i, tau_2sigma);
  p->count = 0;
  if (wave->diffuse_brdf == 0.0)
    at.reach = hetab_hemisphere_reach(&at, wave, 1e-9);
  for (size_t ray = 0; ray <= RAYS; ray++) {
    hetab_hemisphere_ray(&at, ray, RAYS, RAY_NODES, nodes);
    for (size_t i = 0; i < RAY_NODES; i++)
      if (i != RAY_NODES / 2 - 1) /* the rule has a node less */
        add_point(mixture, &at, wave, &nodes[i], p);
  }
}

/* One step towards the least second moment of f / p, the integral of f^2 / p over the plane: the
 * multiplicative rule of optimal design; at the optimum its derivatives by all weights in use are
 * the same. */
static void improve(const points *p, size_t count, double *weights) {
  double slope[HETAB_MIXTURE_LOBES] = {0}, sum = 0.0;
  for (size_t k = 0; k < p->count; k++) {
    double density = 0.0;
    for (size_t i = 0; i < count; i++)
      density += weights[i] * p->density[k][i];
    double share = density > 0.0 ? p->f2[k] / (density * density) : 0.0;
    for (size_t i = 0; i < count; i++)
      slope[i] += share * p->density[k][i];
  }
  for (size_t i = 0; i < count; i++)
    sum += weights[i] *= sqrt(slope[i]);
  for (size_t i = 0; i < count; i++)
    weights[i] /= sum;
}

/* Lobes that hardly help cost as much time as others. */
static void drop_small(size_t count, double *weights) {
  double sum = 0.0;
  for (size_t i = 0; i < count; i++)
    sum += weights[i] = weights[i] < 2e-3 ? 0.0 : weights[i];
  for (size_t i = 0; i < count; i++)
    weights[i] /= sum;
}

hetab_status hetab_mixture_build(hetab_context *ctx, const hetab_wave *wave, double tau_2sigma,
                                 hetab_mixture *mixture) {
  HETAB_FREED points *p = hetab_alloc(ctx, 1, sizeof *p);
  HETAB_NEED(p);
  add_lobes(mixture, wave, tau_2sigma);
  for (size_t row = 0; row < HETAB_MIXTURE_ANGLES; row++) {
    double *weights = mixture->weights[row];
    for (size_t i = 0; i < mixture->count; i++)
      weights[i] = 1.0 / (double)mixture->count;
    add_points(mixture, wave, angle_of(row), tau_2sigma, p);
    for (int round = 0; round < ROUNDS; round++)
      improve(p, mixture->count, weights);
    drop_small(mixture->count, weights);
  }
  return HETAB_OK;
}
