#include "model/polynomial.h"

#include <math.h>
#include <string.h>

double hetab_node(int k, int count) {
  return cos(M_PI * (k + 0.5) / count);
}

void hetab_chebyshev(const double *values, int count, double *coefficients) {
  memset(coefficients, 0, (size_t)count * sizeof *coefficients);
  for (int k = 0; k < count; k++) {
    double x = hetab_node(k, count), t = 2.0 * values[k] / count, before = x * t;
    for (int j = 0; j < count; j++) { /* t is T_j(x), times 2 values[k] / count */
      double after = 2.0 * x * t - before;
      coefficients[j] += t;
      before = t;
      t = after;
    }
  }
  coefficients[0] *= 0.5;
}

void hetab_to_powers(double *c, int count) {
  double previous[HETAB_MOST_DEGREE] = {1}, current[HETAB_MOST_DEGREE] = {0, 1},
         next[HETAB_MOST_DEGREE];
  double powers[HETAB_MOST_DEGREE] = {0};
  powers[0] = c[0];
  for (int j = 1; j < count; j++) {
    for (int i = 0; i <= j; i++)
      powers[i] += c[j] * current[i];
    for (int i = 0; i < count; i++)
      next[i] = (i ? 2.0 * current[i - 1] : 0.0) - previous[i];
    memcpy(previous, current, sizeof previous);
    memcpy(current, next, sizeof(double) * (size_t)count);
  }
  memcpy(c, powers, sizeof(double) * (size_t)count);
}
