#include "model/universal.h"

#include <math.h>
#include <pthread.h>

#include "model/model.h"

enum { COUNT = HETAB_UNIVERSAL_COUNT, CELLS = HETAB_UNIVERSAL_CELLS };

/* ---- splines ------------------------------------------------------------------------------- */

/* The cell of place p; its four weights. */
static int spline_weights(double p, double w[4]) {
  int cell = p < CELLS ? (int)p : CELLS - 1;
  double f = p - cell, e = 1.0 - f;
  w[0] = e * e * e / 6.0;
  w[1] = (4.0 - 3.0 * f * f * (1.0 + e)) / 6.0;
  w[2] = (4.0 - 3.0 * e * e * (1.0 + f)) / 6.0;
  w[3] = f * f * f / 6.0;
  return cell;
}

/* The places where splines are exact: the knots, and the middles of the outer cells. */
static double place_of(int i) {
  if (i == 0 || i == COUNT - 1)
    return i ? CELLS : 0.0;
  return i == 1 ? 0.5 : i == COUNT - 2 ? CELLS - 0.5 : i - 1;
}

/* Values at the places to coefficients, in place, `stride` apart; `lines` systems at once, one
 * apart. Gaussian elimination within the band of five needs no pivots. */
static void solve(double *values, int stride, int lines) {
  double band[COUNT][COUNT] = {{0.0}};
  for (int i = 0; i < COUNT; i++) {
    double w[4];
    int cell = spline_weights(place_of(i), w);
    for (int k = 0; k < 4; k++)
      band[i][cell + k] = w[k];
  }
  for (int i = 0; i < COUNT; i++)
    for (int j = i + 1; j < COUNT && j <= i + 3; j++) {
      double factor = band[j][i] / band[i][i];
      for (int k = i; k < COUNT && k <= i + 4; k++)
        band[j][k] -= factor * band[i][k];
      for (int l = 0; l < lines; l++)
        values[j * stride + l] -= factor * values[i * stride + l];
    }
  for (int i = COUNT - 1; i >= 0; i--)
    for (int l = 0; l < lines; l++) {
      for (int k = i + 1; k < COUNT && k <= i + 4; k++)
        values[i * stride + l] -= band[i][k] * values[k * stride + l];
      values[i * stride + l] /= band[i][i];
    }
}

/* ---- the table ----------------------------------------------------------------------------- */

/* g at s = 1 is infinite: there r and A are 0. */
static double g_of(double s) {
  double part = pow(s, 1.0 / HETAB_UNIVERSAL_ROOT);
  return HETAB_UNIVERSAL_SOFT_G * part / (1.0 - part);
}

static double slope(double g, double ln_h0, double v) {
  return (ln_h0 - hetab_ln_h(g, v * (1.0 + g))) / v - 1.0;
}

/* r(g, v); its limit at v = 0 by extrapolation. */
static double r_of(double g, double ln_h0, double v) {
  if (v > 0.0)
    return slope(g, ln_h0, v);
  return (8.0 * slope(g, ln_h0, 0.01) - 6.0 * slope(g, ln_h0, 0.02) + slope(g, ln_h0, 0.04)) / 3.0;
}

static void fill_row(hetab_universal *table, int i) {
  double g = g_of(place_of(i) / CELLS), ln_h0 = hetab_ln_h(g, 0.0);
  table->a[i] = ln_h0 + 2.0 * log1p(g);
  for (int j = 0; j < COUNT; j++) {
    double t = place_of(j) / CELLS * HETAB_UNIVERSAL_MOST_T;
    table->r[i][j] = r_of(g, ln_h0, HETAB_UNIVERSAL_SOFT_V * t / (1.0 - t));
  }
}

static hetab_universal universal;

static void transpose(void) {
  for (int i = 0; i < COUNT; i++)
    for (int j = 0; j < i; j++) {
      double other = universal.r[i][j];
      universal.r[i][j] = universal.r[j][i];
      universal.r[j][i] = other;
    }
}

static void make(void) {
  for (int i = 0; i < COUNT - 1; i++)
    fill_row(&universal, i);
  solve(universal.a, 1, 1);
  solve(universal.r[0], COUNT, COUNT);
  transpose();
  solve(universal.r[0], COUNT, COUNT);
  transpose();
}

const hetab_universal *hetab_universal_table(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, make);
  return &universal;
}

double hetab_universal_ln_h(double g, double x) {
  return hetab_universal_ln_h_of(hetab_universal_table(), g, x);
}

double hetab_universal_ln_h_of(const hetab_universal *table, double g, double x) {
  double s = pow(g / (g + HETAB_UNIVERSAL_SOFT_G), HETAB_UNIVERSAL_ROOT), v = x / (1.0 + g);
  double t = fmin(v / (v + HETAB_UNIVERSAL_SOFT_V) / HETAB_UNIVERSAL_MOST_T, 1.0);
  double ws[4], wt[4], a = 0.0, r = 0.0;
  int i = spline_weights(s * CELLS, ws), j = spline_weights(t * CELLS, wt);
  for (int k = 0; k < 4; k++) {
    const double *row = &table->r[i + k][j];
    a += ws[k] * table->a[i + k];
    r += ws[k] * (wt[0] * row[0] + wt[1] * row[1] + wt[2] * row[2] + wt[3] * row[3]);
  }
  return a - v * (1.0 + r) - 2.0 * log1p(g);
}
