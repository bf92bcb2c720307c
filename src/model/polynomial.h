/* Polynomials on [-1, 1] through Chebyshev nodes. */
#ifndef HETAB_MODEL_POLYNOMIAL_H
#define HETAB_MODEL_POLYNOMIAL_H

enum { HETAB_MOST_DEGREE = 32 /* coefficients at most */ };

/* Node k of count: cos(pi (k + 1/2) / count). */
double hetab_node(int k, int count);
/* Coefficients of T_0 .. T_(count-1) from the values at the nodes. */
void hetab_chebyshev(const double *values, int count, double *coefficients);
/* The same polynomial in powers of t, in place. */
void hetab_to_powers(double *coefficients, int count);

#endif
