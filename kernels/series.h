/* The series of the model, at a cost that does not grow with the roughness.
 *
 *   h(g, x) = e^-g sum_{m>=1} g^(m-1) / (m! m) e^(-x/m)
 *
 * (the sum of Eq. 18 over g). Positive, decreasing in x, free of material parameters.
 *
 * The summand is a bump in m about m*, m*^2 ln(m* / g) = x, of width s = (1/m* + 2x/m*^3)^(-1/2).
 *   g <  HETAB_SERIES_G: the integers themselves, up to m* plus some widths;
 *   g >= HETAB_SERIES_G: the sum over integers equals the integral over real m (Gamma for m!), and
 *     the integral equals the trapezoidal rule with HETAB_SERIES_NODES nodes a stride apart, in
 *     the variable m^(2/3) in which a Poisson bump is symmetric.
 * Error of h: relative <= 5e-6 float, where it is above 1e-25, <= 1e-13 double
 * (tests/test_kernels.c). */
#ifndef HETAB_SERIES_H
#define HETAB_SERIES_H

#include "hetab_lang.h"
#include "lambert_w.h"
#include "vexp.h"

#if HETAB_REAL_BITS == 64
#define HETAB_SERIES_G RC(40.0)
#define HETAB_SERIES_NODES 24
#define HETAB_SERIES_STRIDE RC(0.7236)
#define HETAB_SERIES_WIDTHS RC(8.5)
#define HETAB_DEVIANCE_SERIES RC(0.25)
#else
#define HETAB_SERIES_G RC(20.0)
#define HETAB_SERIES_NODES 10
#define HETAB_SERIES_STRIDE RC(1.087)
#define HETAB_SERIES_WIDTHS RC(6.0)
#define HETAB_DEVIANCE_SERIES RC(0.5)
#endif

/* ln(m* / g): the largest term sits at m* = g e^(this). */
static inline vreal hetab_series_ln_peak(vreal g, vreal x) {
  vreal ln_kappa = log(fmax(RC(2.0) * x, (vreal)RC(1e-30))) - RC(2.0) * log(g);
  return RC(0.5) * hetab_lambert_w(ln_kappa);
}

/* (1 + r) ln(1 + r) - r, the deviance of a Poisson variable at g (1 + r), over g. With
 * v = r / (2 + r) it is r v + 2 (1 + r) (atanh(v) - v): no cancellation for small r (Loader 2000).
 */
static inline vreal hetab_deviance(vreal r) {
  vreal v = r / (RC(2.0) + r);
  vreal v2 = v * v;
  vreal p = (vreal)(RC(1.0) / RC(21.0));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(19.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(17.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(15.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(13.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(11.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(9.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(7.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(5.0)));
  p = fma(p, v2, (vreal)(RC(1.0) / RC(3.0)));
  vreal near = v * (r + RC(2.0) * (RC(1.0) + r) * v2 * p);
  vreal far = (RC(1.0) + r) * log(fmax(RC(1.0) + r, (vreal)RC(1e-30))) - r;
  return fabs(v) < (vreal)HETAB_DEVIANCE_SERIES ? near : far;
}

/* ln(m!) - Stirling: ln(sqrt(2 pi m) (m/e)^m) + this. m > 1 where it matters. */
static inline vreal hetab_stirling_rest(vreal m) {
  vreal i = RC(1.0) / m;
  vreal i2 = i * i;
  return i * (RC(1.0) / RC(12.0) - i2 * (RC(1.0) / RC(360.0) - i2 * (RC(1.0) / RC(1260.0) -
                                                                     i2 * (RC(1.0) / RC(1680.0)))));
}

/* g >= HETAB_SERIES_G. Offsets from g are carried as r = m/g - 1: at g = 10^6 a float m has no
 * digits left for the width of the bump. */
static inline vreal hetab_series_integral(vreal g, vreal x) {
  vreal ln_peak = hetab_series_ln_peak(g, x);
  vreal peak_1 = expm1(ln_peak); /* m* / g - 1 */
  vreal m_peak = g * (RC(1.0) + peak_1);
  vreal x_m2 = RC(2.0) * x / (m_peak * m_peak);
  vreal width = rsqrt(m_peak * (RC(1.0) + x_m2)); /* s / m* = (m* + 2x/m*)^(-1/2) */
  vreal step = RC(0.66666666666666667) * HETAB_SERIES_STRIDE * width;
  vreal sum = RC(0.0);
  for (int j = 0; j < HETAB_SERIES_NODES; j++) {
    /* m = m* (1 + z)^(3/2); m/m* - 1 without cancellation */
    vreal z = fmax(step * ((real)j - RC(0.5) * (HETAB_SERIES_NODES - 1)), (vreal)RC(-0.98));
    vreal root = sqrt(RC(1.0) + z);
    vreal q_1 = z * (RC(3.0) + z * (RC(3.0) + z)) / (RC(1.0) + root * (RC(1.0) + z));
    vreal r = peak_1 + (RC(1.0) + peak_1) * q_1;
    vreal m = g * (RC(1.0) + r);
    vreal exponent = g * hetab_deviance(r) + x / m + hetab_stirling_rest(m);
    sum += root * rsqrt(m) / m * hetab_exp(-exponent);
  }
  /* dm = stride s sqrt(1 + z) dj, and 1/sqrt(2 pi) of Stirling's formula */
  return sum * HETAB_SERIES_STRIDE * width * m_peak * RC(0.39894228040143268) / g;
}

/* g < HETAB_SERIES_G, down to 0. Lanes whose every term is below e^-120 / g are 0. */
static inline vreal hetab_series_sum(vreal g, vreal x) {
  vreal g1 = fmax(g, (vreal)RC(1e-18));
  vreal ln_peak = hetab_series_ln_peak(g1, x);
  vreal m_peak = g1 * exp(ln_peak);
  vreal exponent = RC(2.0) * m_peak * ln_peak - m_peak + g1 + log(g1);
  /* s <= sqrt(m*) */
  vreal last = m_peak + HETAB_SERIES_WIDTHS * sqrt(m_peak) + RC(14.0);
  last = exponent > (vreal)RC(120.0) ? (vreal)RC(0.0) : last;
  vreal weight = hetab_exp(-g); /* e^-g g^(m-1) / m! */
  vreal sum = RC(0.0);
  for (real m = RC(1.0); V_ANY(last >= (vreal)m); m += RC(1.0)) {
    real inverse = RC(1.0) / m;
    sum += weight * inverse * hetab_exp(-x * inverse);
    weight *= g * (RC(1.0) / (m + RC(1.0)));
  }
  return sum;
}

/* h(g, x) for g >= 0, x >= 0; 0 where it is below about 1e-30 (float). */
static inline vreal hetab_h(vreal g, vreal x) {
  vreal h = RC(0.0);
  if (V_ANY(g < (vreal)HETAB_SERIES_G))
    h = hetab_series_sum(fmin(g, (vreal)HETAB_SERIES_G), x);
  if (V_ANY(g >= (vreal)HETAB_SERIES_G)) {
    vreal large = hetab_series_integral(fmax(g, (vreal)HETAB_SERIES_G), x);
    h = g >= (vreal)HETAB_SERIES_G ? large : h;
  }
  return h;
}

#endif
