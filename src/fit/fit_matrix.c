#include "fit/fit_matrix.h"

#include <math.h>
#include <string.h>

static const double LEAST_PIVOT = 1e-10;

/* Cholesky factor of the matrix with its diagonal scaled to 1; rows of singular unknowns are those
 * of the unit matrix. */
static void factor(size_t n, const double *a, double *l, unsigned char *singular) {
  for (size_t i = 0; i < n; i++) {
    double scale_i = sqrt(a[i * n + i]);
    singular[i] = !(scale_i > 0);
    for (size_t j = 0; j <= i; j++) {
      double sum = singular[i] || singular[j] ? (double)(i == j)
                                              : a[i * n + j] / (scale_i * sqrt(a[j * n + j]));
      for (size_t k = 0; k < j; k++)
        sum -= l[i * n + k] * l[j * n + k];
      if (i == j && sum < LEAST_PIVOT) {
        singular[i] = 1;
        memset(&l[i * n], 0, i * sizeof *l);
        sum = 1;
      }
      l[i * n + j] = i == j ? sqrt(sum) : sum / l[j * n + j];
    }
  }
}

/* One column of the inverse of l l'. */
static void solve_unit(size_t n, const double *l, size_t column, double *x) {
  for (size_t i = 0; i < n; i++) {
    double sum = i == column;
    for (size_t k = 0; k < i; k++)
      sum -= l[i * n + k] * x[k];
    x[i] = sum / l[i * n + i];
  }
  for (size_t i = n; i-- > 0;) {
    double sum = x[i];
    for (size_t k = i + 1; k < n; k++)
      sum -= l[k * n + i] * x[k];
    x[i] = sum / l[i * n + i];
  }
}

void hetab_matrix_invert(size_t n, const double *a, double *scratch, double *inverse,
                         unsigned char *singular) {
  factor(n, a, scratch, singular);
  for (size_t i = 0; i < n; i++) {
    solve_unit(n, scratch, i, &inverse[i * n]);
    for (size_t j = 0; j < n; j++) {
      double scale = sqrt(a[i * n + i] * a[j * n + j]);
      inverse[i * n + j] = singular[i] || singular[j] ? 0 : inverse[i * n + j] / scale;
    }
  }
}

static void multiply(size_t n, const double *a, const double *b, double *out) {
  memset(out, 0, n * n * sizeof *out);
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < n; k++)
      for (size_t j = 0; j < n; j++)
        out[i * n + j] += a[i * n + k] * b[k * n + j];
}

void hetab_matrix_sandwich(size_t n, const double *a, const double *b, double *scratch,
                           double *out) {
  multiply(n, a, b, scratch);
  multiply(n, scratch, a, out);
}

void hetab_matrix_project(size_t n, double *m, const double *g, double *scratch) {
  double along = 0;
  for (size_t i = 0; i < n; i++) {
    scratch[i] = 0;
    for (size_t j = 0; j < n; j++)
      scratch[i] += m[i * n + j] * g[j];
    along += g[i] * scratch[i];
  }
  for (size_t i = 0; along > 0 && i < n; i++)
    for (size_t j = 0; j < n; j++)
      m[i * n + j] -= scratch[i] * scratch[j] / along;
}

/* Expansion about the normal's; exact enough (2 %) from 3 degrees of freedom on. */
double hetab_student_95(double freedom) {
  const double z = 1.959963984540054;
  double v = fmax(freedom, 1);
  return z + (z * z * z + z) / (4 * v) + (5 * pow(z, 5) + 16 * pow(z, 3) + 3 * z) / (96 * v * v) +
         (3 * pow(z, 7) + 19 * pow(z, 5) + 17 * pow(z, 3) - 15 * z) / (384 * v * v * v);
}
