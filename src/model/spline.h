/* Uniform cubic B-splines through values on a fixed set of places. */
#pragma once

enum {
  HETAB_SPLINE_COUNT = 64, /* coefficients */
  HETAB_SPLINE_CELLS =
      HETAB_SPLINE_COUNT - 3, /* intervals between knots; places are in [0, this] */
};

/* The cell i of place p and the weights of coefficients i to i + 3, which sum to 1. */
int hetab_spline_weights(double p, double weights[4]);

/* Place i of HETAB_SPLINE_COUNT where values are given: the knots, and the middles of the outer
 * cells. */
double hetab_spline_place(int i);

/* Values at the places to coefficients, in place. Value i of a line is at values[i * stride], its
 * neighbour line one further: `lines` of them. */
void hetab_spline_fit(double *values, int stride, int lines);
