/* Small symmetric positive matrices, dense, row by row. */
#pragma once

#include <stddef.h>

/* The inverse of a[n][n]; scratch[n][n]. Unknowns whose pivot, with the diagonal scaled to 1, is
 * below 1e-10 are taken out (their rows and columns of the inverse become 0) and marked. */
void hetab_matrix_invert(size_t n, const double *a, double *scratch, double *inverse,
                         unsigned char *singular);
/* out = a b a, for symmetric a and b. */
void hetab_matrix_sandwich(size_t n, const double *a, const double *b, double *scratch,
                           double *out);
/* Takes the direction g out of an inverse: m - m g (m g)' / (g' m g). scratch[n]. */
void hetab_matrix_project(size_t n, double *m, const double *g, double *scratch);
