/* The principal branch of Lambert's W for positive arguments: w e^w = kappa.
 *
 * It solves both implicit equations of the model: the effective roughness (Eqs. 20-21,
 * shadowing.h) and the place of the largest term of the series (series.h). The argument is
 * ln(kappa), so that neither overflows. */
#ifndef HETAB_LAMBERT_W_H
#define HETAB_LAMBERT_W_H

#include "hetab_lang.h"

/* In: ln kappa, any (below -80 counts as -80: W = 2e-35). Out: W > 0.
 * Fritsch, Shafer & Crowley's iteration on w + ln w = ln kappa, of fourth order (Comm. ACM 16,
 * 1973): two steps from within a third of the root. Error: relative <= 1e-6 float, <= 1e-14 double
 * (tests/test_kernels.c). */
static inline vreal hetab_lambert_w(vreal ln_kappa) {
  vreal l = fmax(ln_kappa, (vreal)RC(-80.0));
  vreal w = l > (vreal)RC(20.0) ? l : log1p(exp(fmin(l, (vreal)RC(20.0))));
  for (int i = 0; i < 2; i++) {
    vreal z = l - w - log(w),
          q = RC(2.0) * (RC(1.0) + w) * (RC(1.0) + w + z * RC(0.6666666666666667));
    w += w * z / (RC(1.0) + w) * (q - z) / (q - RC(2.0) * z);
  }
  return w;
}

#endif
