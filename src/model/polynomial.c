#include "model/polynomial.h"

#include <math.h>
#include <string.h>

double hetab_node(int k, int count) {
  return cos(M_PI * (k + 0.5) / count);
}

void hetab_chebyshev(const double *values, int count, double *coefficients) {
  for (int j = 0; j < count; j++) {
    double sum = 0;
    for (int k = 0; k < count; k++)
      sum += values[k] * cos(M_PI * j * (k + 0.5) / count);
    coefficients[j] = sum * (j ? 2.0 : 1.0) / count;
  }
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
