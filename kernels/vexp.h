/* exp(x) for x <= 88, lane by lane.
 *
 * Float: reduction by multiples of ln 2 in two parts and the Taylor polynomial of degree 7 on
 * |r| <= ln(2)/2; relative error <= 1.2e-7 for x in [-87, 88], 0 below (tests/test_kernels.c). The
 * library's own exp handles every argument and, on CPUs, is not always vectorised: this one is
 * worth a factor 2 in the tables. Double and the host use the library's. */
#ifndef HETAB_VEXP_H
#define HETAB_VEXP_H

#include "hetab_lang.h"

#if HETAB_REAL_BITS == 32
static inline vreal hetab_exp(vreal x) {
  vreal xc = fmax(x, (vreal)RC(-87.0));
  vreal n = rint(xc * RC(1.44269504088896341));
  vreal r = fma(n, (vreal)RC(-0.693145751953125), xc);
  r = fma(n, (vreal)RC(-1.42860682030941723e-6), r);
  vreal p = (vreal)RC(1.9841269841e-4);
  p = fma(p, r, (vreal)RC(1.3888888889e-3));
  p = fma(p, r, (vreal)RC(8.3333333333e-3));
  p = fma(p, r, (vreal)RC(4.1666666667e-2));
  p = fma(p, r, (vreal)RC(1.6666666667e-1));
  p = fma(p, r, (vreal)RC(0.5));
  p = fma(p, r, (vreal)RC(1.0));
  p = fma(p, r, (vreal)RC(1.0));
  vreal scaled = p * V_FROM_BITS((V_INT(n) + 127) << 23);
  return x < (vreal)RC(-87.0) ? (vreal)RC(0.0) : scaled;
}
#else
static inline vreal hetab_exp(vreal x) {
  return exp(x);
}
#endif

#endif
