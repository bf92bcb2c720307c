/* Lobes: densities over the directions of reflection that can be sampled in closed form.
 *
 * All live in the plane of incidence's frame: the light at (s, 0, mu), q_r the viewer's lateral
 * direction cosines, d = q_i + q_r the distance from the mirror point. */
#pragma once

#include <stddef.h>

/* One light direction with one viewer: what densities depend on. */
typedef struct hetab_lobe_pair {
  double mu, s;    /* cosine and sine of theta_i */
  double mu_r;     /* cosine of theta_r, > 0 */
  double lateral2; /* |d|^2 */
} hetab_lobe_pair;

typedef enum hetab_lobe_kind {
  HETAB_LOBE_SERIES, /* the model's series with g held: Gaussians about the mirror point */
  HETAB_LOBE_SLOPES, /* Gaussian slopes as seen by the light, g -> infinity */
  HETAB_LOBE_COSINE
} hetab_lobe_kind;

enum { HETAB_LOBE_TERMS = 128, HETAB_LOBE_KNOTS = 640 };

typedef struct hetab_lobe {
  hetab_lobe_kind kind;
  double alpha; /* SLOPES: density of slopes ~ e^(-t^2 / alpha^2) */
  /* SERIES: p(q) = norm h(g, x), x = wave_x |d|^2 */
  double g, wave_x, norm;
  size_t terms;
  double m[HETAB_LOBE_TERMS];          /* the sum's m, or the nodes of the integral */
  double cumulative[HETAB_LOBE_TERMS]; /* probability of m or less */
  double knots_per_unit, end;          /* of sqrt(x) */
  double ln_h[HETAB_LOBE_KNOTS][2];    /* and its derivative by the knot's number */
} hetab_lobe;

void hetab_lobe_series(hetab_lobe *lobe, double g, double wave_x);
void hetab_lobe_slopes(hetab_lobe *lobe, double alpha);
void hetab_lobe_cosine(hetab_lobe *lobe);

/* 1/sr */
double hetab_lobe_density(const hetab_lobe *lobe, const hetab_lobe_pair *pair);

/* d from u[3] in [0, 1), and pair->mu_r and lateral2 to pair->mu and s; 0 if the sample is below
 * the horizon. */
int hetab_lobe_sample(const hetab_lobe *lobe, const double u[3], hetab_lobe_pair *pair,
                      double d[2]);
