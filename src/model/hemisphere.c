#include "model/hemisphere.h"

#include <math.h>

#define HETAB_HOST
#include "kernels/he_torrance.h"
#include "kernels/shadowing.h"

/* ---- the map ------------------------------------------------------------------------------- */

/* The primitive of sin^3(pi t), normalised (Sidi's transformation): integrands that vanish at an
 * end as w^a do so as t^(4 a + 3) after it, and the trapezoidal rule sees a smooth periodic
 * function. */
hetab_crowded hetab_crowd(double t) {
  double s = sin(0.5 * M_PI * t), c = cos(0.5 * M_PI * t), s2 = s * s, c2 = c * c;
  return (hetab_crowded){.w = s2 * s2 * (1.0 + 2.0 * c2),
                         .rest = c2 * c2 * (1.0 + 2.0 * s2),
                         .slope = 6.0 * M_PI * s2 * s * c2 * c};
}

double hetab_rule_error(double difference) {
  return fmin(2.0 * difference, pow(200.0 * difference, 1.5));
}

/* ---- one incidence ------------------------------------------------------------------------- */

enum { AGM_STEPS = 8 };

/* Half the period of the amplitude in psi, 2 K(s), by the arithmetic-geometric mean. */
static double period(double mu) {
  double a = 1.0, b = mu;
  for (int i = 0; i < AGM_STEPS; i++) {
    double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  return M_PI / a;
}

/* psi = am(u), u in [0, K], by descending Landen transformations. */
static double amplitude(double u, double mu) {
  double a[AGM_STEPS + 1] = {1.0}, c[AGM_STEPS + 1], b = mu;
  for (int i = 0; i < AGM_STEPS; i++) {
    a[i + 1] = 0.5 * (a[i] + b);
    c[i + 1] = 0.5 * (a[i] - b);
    b = sqrt(a[i] * b);
  }
  double psi = ldexp(a[AGM_STEPS] * u, AGM_STEPS);
  for (int i = AGM_STEPS; i > 0; i--)
    psi = 0.5 * (psi + asin(fmin(c[i] / a[i] * sin(psi), 1.0)));
  return psi;
}

hetab_hemisphere hetab_hemisphere_at(double theta_i, double tau_2sigma) {
  hetab_hemisphere at = {
      .in = hetab_direction_at(theta_i, tau_2sigma), .tau_2sigma = tau_2sigma, .reach = 2.0};
  at.period = period(at.in.mu);
  return at;
}

/* x where the largest term of the series, e^-(2 m ln(m/g) - m + g), has fallen to e^-fall. */
static double far_x(double g, double fall) {
  double low = 0.0, high = 60.0; /* of ln(m / g) */
  for (int i = 0; i < 50; i++) {
    double ln = 0.5 * (low + high), m = g * exp(ln);
    if (2.0 * m * ln - m + g < fall)
      low = ln;
    else
      high = ln;
  }
  double m = g * exp(high);
  return fmax(m * m * high, fall); /* the sum starts at m = 1 */
}

double hetab_hemisphere_reach(const hetab_hemisphere *at, const hetab_wave *wave,
                              double negligible) {
  double mu = at->in.mu, s = at->in.s, reach = 1.0 + s;
  /* cos^4(theta_d) is mu^4 at the mirror point; 5 is for the terms beyond the largest one, and for
   * all that is farther out */
  double fall = 5.0 - log(negligible) - 4.0 * log(mu);
  for (int i = 0; i < 4; i++) { /* g is bounded by mu_r^2 <= mu^2 + 2 s rho within the reach */
    double mu_r = fmin(1.0, sqrt(mu * mu + 2.0 * s * reach));
    double g = wave->g * (mu + mu_r) * (mu + mu_r);
    reach = fmin(reach, sqrt(far_x(g, fall) / wave->x));
  }
  return reach;
}

/* ---- rays ---------------------------------------------------------------------------------- */

typedef struct ray {
  double c;           /* half the chord */
  double start, span; /* alpha at the mirror point, and from there to the ray's end */
  double beyond;      /* alpha from the end to the rim */
  double weight;
} ray;

static ray ray_at(const hetab_hemisphere *at, size_t number, size_t rays) {
  double mu = at->in.mu, s = at->in.s, step = at->period / (double)rays;
  int outward = 2 * number > rays;
  double psi = amplitude(step * (double)(outward ? rays - number : number), mu);
  double cos_psi = 2 * number == rays ? 0.0 : outward ? -cos(psi) : cos(psi);
  double sin_psi = sin(psi);
  ray r = {.c = sqrt(cos_psi * cos_psi + mu * mu * sin_psi * sin_psi)};
  r.start = atan2(mu, s * cos_psi);
  r.span = atan2(mu, -s * cos_psi);
  /* twice for the other half of the disc; the first and the last ray are their own mirror images */
  r.weight = number == 0 || number == rays ? step : 2.0 * step;
  double cos_end = s * cos_psi / r.c - at->reach / r.c;
  if (cos_end > -1.0) {
    double span = acos(fmax(fmin(cos_end, 1.0), -1.0)) - r.start;
    r.beyond = r.span - span;
    r.span = span;
  }
  return r;
}

/* What does not depend on the wavelength, at rho from the mirror point. */
static hetab_node node_at(const hetab_hemisphere *at, double rho, double mu_r) {
  double mu = at->in.mu + mu_r, s_r = sqrt(fmax(1.0 - mu_r * mu_r, 0.0));
  double k = at->in.k + hetab_k(mu_r, s_r, at->tau_2sigma);
  double ratio2 = hetab_roughness_ratio2(k);
  hetab_node node = {.lateral2 = rho * rho, .g = mu * mu * ratio2};
  node.weight = at->in.shadow_over_cos * hetab_shadow_over_cos(mu_r, s_r, at->tau_2sigma) * ratio2;
  node.cos2_d = fmin(0.25 * (mu * mu + node.lateral2), 1.0);
  return node;
}

void hetab_hemisphere_ray(const hetab_hemisphere *at, size_t number, size_t rays, size_t nodes,
                          hetab_node *out) {
  ray r = ray_at(at, number, rays);
  out[nodes / 2 - 1] = (hetab_node){1.0, 0.0, 1.0, 0.0}; /* the first half has one node less */
  for (size_t j = 1; j < nodes; j++) {
    hetab_crowded crowded = hetab_crowd((double)j / (double)nodes);
    double from = r.span * crowded.w, left = r.beyond + r.span * crowded.rest;
    double mu_r = r.c * (left < 0.5 * M_PI ? sin(left) : sin(r.start + from));
    double rho = 2.0 * r.c * sin(0.5 * from) * sin(left + 0.5 * from);
    hetab_node *node = &out[j % 2 ? nodes / 2 + j / 2 : j / 2 - 1];
    *node = node_at(at, rho, mu_r);
    /* dq = rho drho dpsi, drho = mu_r dalpha, dpsi = c du */
    node->weight *= rho * mu_r * r.c * r.span * crowded.slope * r.weight / (double)nodes;
  }
}
