/* The principal branch of Lambert's W for positive arguments: w e^w = kappa.
 *
 * It solves both implicit equations of the model: the effective roughness (Eqs. 20-21,
 * shadowing.h) and the place of the largest term of the series (series.h). The argument is
 * ln(kappa), so that neither overflows. */
#ifndef HETAB_LAMBERT_W_H
#define HETAB_LAMBERT_W_H

#include "hetab_lang.h"

/* In: ln kappa, any (below -80 counts as -80: W = 2e-35). Out: W > 0.
 * Newton's iteration on the concave w + ln w = ln kappa: the first step lands left of the root,
 * the others climb to it. Error: relative <= 1e-6 float, <= 1e-14 double (tests/test_kernels.c). */
static inline vreal hetab_lambert_w(vreal ln_kappa) {
  vreal l = fmax(ln_kappa, (vreal)RC(-80.0));
  vreal w = l > (vreal)RC(20.0) ? l : log1p(exp(fmin(l, (vreal)RC(20.0))));
  for (int i = 0; i < (HETAB_REAL_BITS == 64 ? 6 : 5); i++)
    w = w * (RC(1.0) + l - log(w)) / (RC(1.0) + w);
  return w;
}

#endif
