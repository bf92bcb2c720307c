#include "model/lobe.h"

#include <math.h>
#include <string.h>

#define HETAB_HOST
#include "kernels/series.h"

/* ---- the series ---------------------------------------------------------------------------- */

/* Below LARGEST_SUM the terms are g^m / (m! (e^g - 1)), m >= 1: a Poisson variable that is not 0.
 * From there on the sum over integers is the integral over m, which is the trapezoidal rule a
 * stride of 0.7236 widths apart, both to 2e-12 (kernels/series.h): its nodes are as good a set of
 * m, and few whatever g is. */
static const double LARGEST_SUM = 40.0;
enum { NODES = 37, NODES_BELOW = 11 }; /* from 8 widths below g to 18 above: x moves the bump up */

static void poisson_terms(hetab_lobe *lobe) {
  double g = lobe->g, weight = 1.0;
  size_t last = (size_t)(g + 9.0 * sqrt(g) + 14.0);
  lobe->terms = last < HETAB_LOBE_TERMS ? last : HETAB_LOBE_TERMS;
  for (size_t i = 0; i < lobe->terms; i++) {
    lobe->m[i] = (double)(i + 1);
    lobe->cumulative[i] = weight; /* over the first one, g / (e^g - 1) */
    weight *= g / (double)(i + 2);
  }
}

/* In z = (m / g)^(2/3) - 1 the bump is symmetric. */
static void integral_terms(hetab_lobe *lobe) {
  double g = lobe->g, step = 2.0 / 3.0 * 0.7236 / sqrt(g);
  lobe->terms = NODES;
  for (size_t i = 0; i < NODES; i++) {
    double z = step * ((double)i - NODES_BELOW), root = sqrt(1.0 + z);
    double r = z * (3.0 + z * (3.0 + z)) / (1.0 + root * (1.0 + z)); /* m / g - 1 */
    double m = g * (1.0 + r);
    lobe->m[i] = m;
    lobe->cumulative[i] = root / sqrt(m) * exp(-g * hetab_deviance(r) - hetab_stirling_rest(m));
  }
}

static void accumulate(double *weights, size_t count) {
  for (size_t i = 1; i < count; i++)
    weights[i] += weights[i - 1];
  for (size_t i = 0; i < count; i++)
    weights[i] /= weights[count - 1];
}

/* ln h at sqrt(x); h itself is 0 below e^-120. */
static double ln_h_at(double g, double root_x) {
  return log(hetab_h(g, root_x * root_x));
}

static const double LN_H_RANGE = 100.0;

/* sqrt(x) where h has fallen by LN_H_RANGE, or the disc's far end. */
static double end_of_root_x(double g, double wave_x) {
  double low = 0.0, high = 2.0 * sqrt(wave_x), top = ln_h_at(g, 0.0);
  if (ln_h_at(g, high) > top - LN_H_RANGE)
    return high;
  for (int i = 0; i < 60; i++) {
    double middle = 0.5 * (low + high);
    if (ln_h_at(g, middle) > top - LN_H_RANGE)
      low = middle;
    else
      high = middle;
  }
  return low;
}

void hetab_lobe_series(hetab_lobe *lobe, double g, double wave_x) {
  memset(lobe, 0, sizeof *lobe);
  lobe->kind = HETAB_LOBE_SERIES;
  lobe->g = g;
  lobe->wave_x = wave_x;
  lobe->norm = wave_x / M_PI * g / -expm1(-g);
  if (g < LARGEST_SUM)
    poisson_terms(lobe);
  else
    integral_terms(lobe);
  accumulate(lobe->cumulative, lobe->terms);

  lobe->end = end_of_root_x(g, wave_x);
  double step = lobe->end / (HETAB_LOBE_KNOTS - 2), nudge = 0.01 * step;
  lobe->knots_per_unit = 1.0 / step;
  for (int k = 0; k < HETAB_LOBE_KNOTS; k++) {
    double root = step * k;
    lobe->ln_h[k][0] = ln_h_at(g, root);
    lobe->ln_h[k][1] = (ln_h_at(g, root + nudge) - ln_h_at(g, root - nudge)) / (2.0 * 0.01);
  }
}

/* cos^2(theta_r) at distance d from the mirror point: 1 - |q_r|^2 without cancellation at grazing.
 * Samples outside the disc, half of all at grazing, are turned about the mirror point: d becomes
 * (-d_x, d_y). If that is inside, it is where both come from. */
static double mu2_at(const hetab_lobe_pair *pair, double dx, double lateral2) {
  return pair->mu * pair->mu + 2.0 * pair->s * dx - lateral2;
}

static int image_is_outside(const hetab_lobe_pair *pair) {
  return 2.0 * (pair->mu * pair->mu - pair->lateral2) <= pair->mu_r * pair->mu_r;
}

/* ln h by cubic polynomials between the knots; it is smooth in sqrt(x). */
static double interpolated_h(const hetab_lobe *lobe, double lateral2) {
  double at = sqrt(lobe->wave_x * lateral2);
  if (!(at <= lobe->end))
    return 0.0;
  at *= lobe->knots_per_unit;
  int k = (int)at;
  double t = at - k;
  const double *a = lobe->ln_h[k], *b = lobe->ln_h[k + 1];
  double rise = b[0] - a[0];
  double c2 = 3.0 * rise - 2.0 * a[1] - b[1], c3 = a[1] + b[1] - 2.0 * rise;
  return exp(a[0] + t * (a[1] + t * (c2 + t * c3)));
}

static double term_of(const hetab_lobe *lobe, double u) {
  size_t low = 0, high = lobe->terms - 1;
  while (low < high) {
    size_t middle = (low + high) / 2;
    if (u < lobe->cumulative[middle])
      high = middle;
    else
      low = middle + 1;
  }
  return lobe->m[low];
}

static void sample_series(const hetab_lobe *lobe, const double u[3], const hetab_lobe_pair *pair,
                          double d[2]) {
  double radius = sqrt(-log1p(-u[1]) * term_of(lobe, u[0]) / lobe->wave_x);
  d[0] = radius * cos(2.0 * M_PI * u[2]);
  d[1] = radius * sin(2.0 * M_PI * u[2]);
  if (mu2_at(pair, d[0], radius * radius) <= 0.0)
    d[0] = -d[0];
}

/* ---- slopes -------------------------------------------------------------------------------- */

void hetab_lobe_slopes(hetab_lobe *lobe, double alpha) {
  memset(lobe, 0, sizeof *lobe);
  lobe->kind = HETAB_LOBE_SLOPES;
  lobe->alpha = alpha;
}

static double gauss(double z) {
  return exp(-0.5 * z * z) / sqrt(2.0 * M_PI);
}

/* The Gaussian's integral from z to infinity. */
static double above(double z) {
  return 0.5 * erfc(z * M_SQRT1_2);
}

/* The visible slopes are distributed as gauss(z) (a + b z), where that is positive; a = mu,
 * b = s alpha / sqrt(2), z the slope towards the light over alpha / sqrt(2). */
static double visible(double a, double b, double z0) {
  return a * above(z0) + b * gauss(z0);
}

static const double FARTHEST = 9.0; /* standard deviations */

static double first_visible(double a, double b) {
  return a < FARTHEST * b ? -a / b : -FARTHEST;
}

/* z above which a share u of the visible ones is: Newton's method, kept within a bracket. A step
 * of 1e-5 leaves an error of its square. */
static double visible_slope(double a, double b, double u) {
  double low = first_visible(a, b), high = FARTHEST;
  double target = u * visible(a, b, low), z = fmax(low + 0.5, 0.0), step = 1.0;
  for (int i = 0; i < 60 && fabs(step) > 1e-5; i++) {
    double here = gauss(z), excess = a * above(z) + b * here - target, from = z;
    if (excess > 0.0)
      low = z;
    else
      high = z;
    z += excess / (here * (a + b * z));
    z = z > low && z < high ? z : 0.5 * (low + high);
    step = z - from;
  }
  return z;
}

/* dOmega = c^3 / (2 cos^2(theta_d)) dt, c = mu + mu_r, and mu + s t_x = 2 cos^2(theta_d) / c. */
static double slopes_density(const hetab_lobe *lobe, const hetab_lobe_pair *pair) {
  double b = pair->s * lobe->alpha * M_SQRT1_2, c = pair->mu + pair->mu_r, c2 = c * c;
  double seen = 0.5 * (c2 + pair->lateral2) / c2; /* 2 cos^2(theta_d) / c^2 */
  double alpha2 = lobe->alpha * lobe->alpha;
  return exp(-pair->lateral2 / (c2 * alpha2)) / (M_PI * alpha2) * seen * seen /
         visible(pair->mu, b, first_visible(pair->mu, b));
}

static int sample_slopes(const hetab_lobe *lobe, const double u[3], const hetab_lobe_pair *pair,
                         double d[2]) {
  double sigma = lobe->alpha * M_SQRT1_2;
  double tx = sigma * visible_slope(pair->mu, pair->s * sigma, u[1]);
  double ty = sigma * sqrt(-2.0 * log1p(-u[0])) * cos(2.0 * M_PI * u[2]);
  double c = 2.0 * (pair->mu + pair->s * tx) / (1.0 + tx * tx + ty * ty);
  d[0] = c * tx;
  d[1] = c * ty;
  return c > pair->mu;
}

/* ---- cosine -------------------------------------------------------------------------------- */

void hetab_lobe_cosine(hetab_lobe *lobe) {
  memset(lobe, 0, sizeof *lobe);
  lobe->kind = HETAB_LOBE_COSINE;
}

static void sample_cosine(const double u[3], const hetab_lobe_pair *pair, double d[2]) {
  double radius = sqrt(u[1]);
  d[0] = radius * cos(2.0 * M_PI * u[2]) + pair->s;
  d[1] = radius * sin(2.0 * M_PI * u[2]);
}

/* ---- any ----------------------------------------------------------------------------------- */

double hetab_lobe_density(const hetab_lobe *lobe, const hetab_lobe_pair *pair) {
  if (lobe->kind == HETAB_LOBE_SERIES)
    return lobe->norm * pair->mu_r * interpolated_h(lobe, pair->lateral2) *
           (image_is_outside(pair) ? 2.0 : 1.0);
  if (lobe->kind == HETAB_LOBE_SLOPES)
    return slopes_density(lobe, pair);
  return pair->mu_r / M_PI;
}

int hetab_lobe_sample(const hetab_lobe *lobe, const double u[3], hetab_lobe_pair *pair,
                      double d[2]) {
  if (lobe->kind == HETAB_LOBE_SERIES)
    sample_series(lobe, u, pair, d);
  else if (lobe->kind == HETAB_LOBE_COSINE)
    sample_cosine(u, pair, d);
  else if (!sample_slopes(lobe, u, pair, d))
    return 0;
  pair->lateral2 = d[0] * d[0] + d[1] * d[1];
  double mu2 = mu2_at(pair, d[0], pair->lateral2);
  if (!(mu2 > 0.0))
    return 0;
  pair->mu_r = sqrt(mu2);
  return 1;
}
