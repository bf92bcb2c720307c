#include "model/spline.h"

enum { COUNT = HETAB_SPLINE_COUNT, CELLS = HETAB_SPLINE_CELLS };

int hetab_spline_weights(double p, double w[4]) {
  int cell = p < CELLS ? (int)p : CELLS - 1;
  double f = p - cell, e = 1.0 - f;
  w[0] = e * e * e / 6.0;
  w[1] = (4.0 - 3.0 * f * f * (1.0 + e)) / 6.0;
  w[2] = (4.0 - 3.0 * e * e * (1.0 + f)) / 6.0;
  w[3] = f * f * f / 6.0;
  return cell;
}

double hetab_spline_place(int i) {
  if (i == 0 || i == COUNT - 1)
    return i ? CELLS : 0.0;
  return i == 1 ? 0.5 : i == COUNT - 2 ? CELLS - 0.5 : i - 1;
}

/* Gaussian elimination within the band of five; it needs no pivots. */
void hetab_spline_fit(double *values, int stride, int lines) {
  double band[COUNT][COUNT] = {{0.0}};
  for (int i = 0; i < COUNT; i++) {
    double w[4];
    int cell = hetab_spline_weights(hetab_spline_place(i), w);
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
