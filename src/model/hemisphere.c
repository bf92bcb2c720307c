#include "model/hemisphere.h"

#include <math.h>
#include <stdbool.h>

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

/* Twice over, for integrands that do not vanish where panels or pieces meet at the kink: the error
 * goes with the 16th power of the step, after one map with the 4th. */
static hetab_crowded crowd(const hetab_hemisphere *at, double t) {
  hetab_crowded once = hetab_crowd(t);
  if (at->kink == 0.0)
    return once;
  hetab_crowded low = hetab_crowd(once.w), high = hetab_crowd(once.rest);
  return (hetab_crowded){.w = low.w, .rest = high.w, .slope = low.slope * once.slope};
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
  at.panels = 1;
  at.cut[1] = at.period;
  return at;
}

/* ---- the kink ------------------------------------------------------------------------------ */

double hetab_hemisphere_kink(const hetab_band *band) {
  static const double SHARP = 0.5; /* the branch point's distance from the real axis, 2 n k */
  double cos2 = (1.0 - band->n) * (1.0 + band->n) + band->k * band->k;
  return cos2 > 0.0 && cos2 < 1.0 && 2.0 * band->n * band->k < SHARP ? cos2 : 0.0;
}

/* The inverse of amplitude() up to the whole period, by bisection. */
static double u_of(const hetab_hemisphere *at, double psi) {
  double low = 0.0, high = 0.5 * at->period, nearest = fmin(psi, M_PI - psi);
  for (int i = 0; i < 60; i++) {
    double u = 0.5 * (low + high);
    if (amplitude(u, at->in.mu) < nearest)
      low = u;
    else
      high = u;
  }
  return psi < M_PI_2 ? low : at->period - low;
}

static void add_cut(hetab_hemisphere *at, double psi) {
  double u = u_of(at, psi);
  size_t i = at->panels++;
  for (; at->cut[i - 1] > u; i--)
    at->cut[i] = at->cut[i - 1];
  at->cut[i] = u;
  at->cut[at->panels] = at->period;
}

/* cos^2(theta_d) = c^2 sin^2((alpha + start) / 2) along a ray (see ray_at): it touches the kink
 * where c^2 = kink, and has it at the rim where c (c + s cos(psi)) = 2 kink. */
void hetab_hemisphere_split(hetab_hemisphere *at, double kink) {
  double s2 = at->in.s * at->in.s, touched = (1.0 - kink) / s2;
  double c2 = 4.0 * kink * kink / (4.0 * kink - at->in.mu * at->in.mu), rim = (1.0 - c2) / s2;
  at->kink = kink;
  if (touched < 1.0)
    add_cut(at, asin(sqrt(touched)));
  if (rim > 0.0 && rim < 1.0)
    add_cut(at, c2 < 2.0 * kink ? asin(sqrt(rim)) : M_PI - asin(sqrt(rim)));
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

enum { PIECES = 3 };

typedef struct ray {
  double c;           /* half the chord */
  double start, span; /* alpha at the mirror point, and from there to the ray's end */
  double beyond;      /* alpha from the end to the rim */
  double weight;
} ray;

/* A ray's place, and what du is there. */
static double u_at(const hetab_hemisphere *at, size_t number, size_t rays, double *step) {
  size_t each = rays / at->panels, panel = number < rays ? number / each : at->panels - 1;
  double width = at->cut[panel + 1] - at->cut[panel];
  *step = width / (double)each;
  if (at->panels == 1)
    return *step * (double)number;
  hetab_crowded crowded = crowd(at, (double)(number - panel * each) / (double)each);
  *step *= crowded.slope;
  return at->cut[panel] + width * crowded.w;
}

static ray ray_at(const hetab_hemisphere *at, size_t number, size_t rays) {
  double mu = at->in.mu, s = at->in.s, step, u = u_at(at, number, rays, &step);
  bool middle = at->panels == 1 && 2 * number == rays, outward = u > 0.5 * at->period;
  double psi = amplitude(outward ? at->period - u : u, mu);
  double cos_psi = middle ? 0.0 : outward ? -cos(psi) : cos(psi);
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

/* The ends of a ray's pieces, as angles from the mirror point: 0, where it meets the kink, its end.
 */
static size_t pieces_of(const hetab_hemisphere *at, const ray *r, double ends[PIECES + 1]) {
  size_t count = 0;
  double sine = sqrt(at->kink) / r->c;
  ends[0] = 0.0;
  for (int side = 0; side < 2 && at->kink > 0.0 && sine < 1.0; side++) {
    double half = side ? M_PI - asin(sine) : asin(sine), from = 2.0 * (half - r->start);
    if (from > ends[count] && from < r->span)
      ends[++count] = from;
  }
  ends[++count] = r->span;
  return count;
}

void hetab_hemisphere_ray(const hetab_hemisphere *at, size_t number, size_t rays, size_t nodes,
                          hetab_node *out) {
  ray r = ray_at(at, number, rays);
  double ends[PIECES + 1];
  size_t pieces = pieces_of(at, &r, ends), each = 2 * (nodes / (2 * pieces)), half = nodes / 2;
  hetab_node *next[2] = {out, out + half}; /* of the coarser rule, and of the rest */
  for (size_t j = 0; j < pieces * each; j++) {
    size_t piece = j / each, i = j % each;
    double length = ends[piece + 1] - ends[piece];
    if (i == 0)
      continue;
    hetab_crowded crowded = crowd(at, (double)i / (double)each);
    double from = ends[piece] + length * crowded.w;
    double left = r.beyond + (r.span - ends[piece + 1]) + length * crowded.rest;
    double mu_r = r.c * (left < 0.5 * M_PI ? sin(left) : sin(r.start + from));
    double rho = 2.0 * r.c * sin(0.5 * from) * sin(left + 0.5 * from);
    hetab_node *node = next[i % 2]++;
    *node = node_at(at, rho, mu_r);
    /* dq = rho drho dpsi, drho = mu_r dalpha, dpsi = c du */
    node->weight *= rho * mu_r * r.c * length * crowded.slope * r.weight / (double)each;
  }
  for (int rest = 0; rest < 2; rest++) /* the halves are whole vectors */
    while (next[rest] < out + half * (size_t)(rest + 1))
      *next[rest]++ = (hetab_node){1.0, 0.0, 1.0, 0.0};
}
