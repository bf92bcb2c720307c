#include "audit/separability.h"

#include <math.h>
#include <stdlib.h>

/* The power method; table lobes drift slowly with theta_i, and two digits are enough. */
enum { ITERATIONS = 24 };

typedef struct matrix {
  const double *values; /* [rows][columns] */
  size_t rows, columns;
} matrix;

static double entry(const matrix *m, size_t row, size_t column) {
  double value = m->values[row * m->columns + column];
  return isfinite(value) ? value : 0;
}

/* u <- A v, v <- A' u / |u|: the square of v's length settles at the first singular value's. */
static double step(const matrix *m, double *u, double *v) {
  double length2 = 0, sigma2 = 0;
  for (size_t r = 0; r < m->rows; r++) {
    u[r] = 0;
    for (size_t c = 0; c < m->columns; c++)
      u[r] += entry(m, r, c) * v[c];
    length2 += u[r] * u[r];
  }
  for (size_t c = 0; c < m->columns; c++)
    v[c] = 0;
  for (size_t r = 0; r < m->rows && length2 > 0; r++)
    for (size_t c = 0; c < m->columns; c++)
      v[c] += entry(m, r, c) * u[r] / sqrt(length2);
  for (size_t c = 0; c < m->columns; c++)
    sigma2 += v[c] * v[c];
  return sigma2;
}

hetab_status hetab_separability(hetab_context *ctx, const hetab_dense_table *t, double *share) {
  matrix m = {t->values, t->count[HETAB_THETA_I], t->count[HETAB_THETA_R] * t->count[HETAB_PHI]};
  HETAB_FREED double *u = hetab_alloc(ctx, m.rows, sizeof *u),
                     *v = hetab_alloc(ctx, m.columns, sizeof *v);
  HETAB_NEED(u && v);
  double sigma2 = 0, total = 0;
  for (size_t c = 0; c < m.columns; c++)
    v[c] = 1;
  for (int i = 0; i < ITERATIONS; i++)
    sigma2 = step(&m, u, v);
  for (size_t r = 0; r < m.rows; r++)
    for (size_t c = 0; c < m.columns; c++)
      total += entry(&m, r, c) * entry(&m, r, c);
  *share = total > 0 ? fmin(1, sigma2 / total) : 1;
  return HETAB_OK;
}
