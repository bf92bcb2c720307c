#include "model/universal.h"

#include <math.h>
#include <pthread.h>

#include "model/model.h"

enum { COUNT = HETAB_SPLINE_COUNT, CELLS = HETAB_SPLINE_CELLS };

double hetab_universal_s(double g) {
  return pow(g / (g + HETAB_UNIVERSAL_SOFT_G), HETAB_UNIVERSAL_ROOT);
}

double hetab_universal_g(double s) {
  double part = pow(s, 1.0 / HETAB_UNIVERSAL_ROOT);
  return HETAB_UNIVERSAL_SOFT_G * part / (1.0 - part);
}

double hetab_universal_v(double t) {
  return HETAB_UNIVERSAL_SOFT_V * t / (1.0 - t);
}

double hetab_universal_part(double v) {
  return fmin(v / (v + HETAB_UNIVERSAL_SOFT_V) / HETAB_UNIVERSAL_MOST_T, 1.0);
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

static hetab_universal universal;

static void fill_row(int i) {
  double g = hetab_universal_g(hetab_spline_place(i) / CELLS), ln_h0 = hetab_ln_h(g, 0.0);
  universal.a[i] = ln_h0 + 2.0 * log1p(g);
  for (int j = 0; j < COUNT; j++) {
    double t = hetab_spline_place(j) / CELLS * HETAB_UNIVERSAL_MOST_T;
    universal.r[i][j] = r_of(g, ln_h0, hetab_universal_v(t));
  }
}

/* The last row, at infinite g, is 0. */
static void make(void) {
  for (int i = 0; i < COUNT - 1; i++)
    fill_row(i);
  hetab_spline_fit(universal.a, 1, 1);
  hetab_spline_fit(universal.r[0], COUNT, COUNT);
  for (int i = 0; i < COUNT; i++)
    hetab_spline_fit(universal.r[i], 1, 1);
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
  double v = x / (1.0 + g), ws[4], wt[4], a = 0.0, r = 0.0;
  int i = hetab_spline_weights(hetab_universal_s(g) * CELLS, ws);
  int j = hetab_spline_weights(hetab_universal_part(v) * CELLS, wt);
  for (int k = 0; k < 4; k++) {
    const double *row = &table->r[i + k][j];
    a += ws[k] * table->a[i + k];
    r += ws[k] * (wt[0] * row[0] + wt[1] * row[1] + wt[2] * row[2] + wt[3] * row[3]);
  }
  return a - v * (1.0 + r) - 2.0 * log1p(g);
}
