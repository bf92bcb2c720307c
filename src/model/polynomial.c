#include "model/polynomial.h"

#include <math.h>
#include <string.h>

void hetab_fitter_make(int count, hetab_fitter *f) {
  memset(f, 0, sizeof *f);
  f->count = count;
  for (int k = 0; k < count; k++)
    f->node[k] = cos(M_PI * (k + 0.5) / count);
  for (int j = 0; j < count; j++)
    for (int k = 0; k < count; k++)
      f->chebyshev[j][k] = cos(M_PI * j * (k + 0.5) / count) * (j ? 2.0 : 1.0) / count;
  f->powers[0][0] = f->powers[1][1] = 1.0;
  for (int j = 2; j < count; j++)
    for (int i = 0; i <= j; i++)
      f->powers[j][i] = (i ? 2.0 * f->powers[j - 1][i - 1] : 0.0) - f->powers[j - 2][i];
}

void hetab_chebyshev(const hetab_fitter *f, const double *values, double *coefficients) {
  for (int j = 0; j < f->count; j++) {
    double sum = 0.0;
    for (int k = 0; k < f->count; k++)
      sum += f->chebyshev[j][k] * values[k];
    coefficients[j] = sum;
  }
}

void hetab_to_powers(const hetab_fitter *f, double *c) {
  double powers[HETAB_MOST_DEGREE] = {0};
  for (int j = 0; j < f->count; j++)
    for (int i = 0; i <= j; i++)
      powers[i] += c[j] * f->powers[j][i];
  memcpy(c, powers, (size_t)f->count * sizeof *c);
}
