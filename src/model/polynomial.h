/* Polynomials on [-1, 1] through Chebyshev nodes. */
#pragma once

enum { HETAB_MOST_DEGREE = 32 /* coefficients at most */ };

/* Polynomials of `count` coefficients: what every fit of that many needs. */
typedef struct hetab_fitter {
  int count;
  double node[HETAB_MOST_DEGREE];                         /* cos(pi (k + 1/2) / count) */
  double chebyshev[HETAB_MOST_DEGREE][HETAB_MOST_DEGREE]; /* [j][k]: of value k in T_j */
  double powers[HETAB_MOST_DEGREE][HETAB_MOST_DEGREE];    /* [j][i]: of t^i in T_j */
} hetab_fitter;

void hetab_fitter_make(int count, hetab_fitter *fitter);
/* Coefficients of T_0 .. T_(count-1) from the values at the nodes. */
void hetab_chebyshev(const hetab_fitter *fitter, const double *values, double *coefficients);
/* The same polynomial in powers of t, in place. */
void hetab_to_powers(const hetab_fitter *fitter, double *coefficients);
