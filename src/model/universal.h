/* One table of the series for every surface. h(g, x) holds no material, so that ln h is tabulated
 * once, as cubic B-splines of 64 and 64 x 64 coefficients:
 *
 *   v = x / (1 + g), t = v / (v + 10) in [0, 12/13], s = (g / (g + 15))^(3/16) in [0, 1]
 *   ln h(g, x) = A(s) - v (1 + r(s, t)) - 2 ln(1 + g)
 *
 * 1 + r is 1 at g = 0, where h = e^-x, and at infinity, h = e^(-x/g) / g^2; the root resolves the
 * kink at small g, where the terms 1 and 2 cross.
 *
 * Relative error of h for g from 0 to 1e7: 2e-5 where h > 1e-6 h(g, 0), 2e-4 to 1e-9 h(g, 0),
 * 2e-2 to 1e-14 (tests/test_universal.c, against the series and 40-digit values). Beyond v = 120
 * h is below 1e-17, and r is that of 120. */
#pragma once

#include "model/spline.h"

#define HETAB_UNIVERSAL_SOFT_G 15.0
#define HETAB_UNIVERSAL_ROOT 0.1875
#define HETAB_UNIVERSAL_SOFT_V 10.0
#define HETAB_UNIVERSAL_MOST_T (120.0 / (120.0 + HETAB_UNIVERSAL_SOFT_V))

/* Places along s are s HETAB_SPLINE_CELLS, along t they are t / HETAB_UNIVERSAL_MOST_T
 * HETAB_SPLINE_CELLS; model/spline.h says how places become weights. */
typedef struct hetab_universal {
  double a[HETAB_SPLINE_COUNT];                     /* of A over s */
  double r[HETAB_SPLINE_COUNT][HETAB_SPLINE_COUNT]; /* [s][t], of r */
} hetab_universal;

/* Made from the series at the first call; any thread may ask. */
const hetab_universal *hetab_universal_table(void);

/* s of g, and g of s: infinite at 1. */
double hetab_universal_s(double g);
double hetab_universal_g(double s);

/* v of t; t / HETAB_UNIVERSAL_MOST_T of v, at most 1. */
double hetab_universal_v(double t);
double hetab_universal_part(double v);

/* ln h(g, x) of the table; g, x >= 0, finite. */
double hetab_universal_ln_h(double g, double x);
/* The same of a copy, which may have been rounded. */
double hetab_universal_ln_h_of(const hetab_universal *table, double g, double x);
