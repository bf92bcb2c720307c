/* exp(x) for x <= 88, lane by lane.
 *
 * Float: x = n ln 2 + r, ln 2 in two parts, and the near-minimax polynomial of degree 6 on
 * |r| <= ln(2)/2 (2.5e-9 itself); relative error <= 1.2e-7 for x in [-87, 88], e^-87 below
 * (tests/test_kernels.c). n is rounded, and put into the exponent, by adding 1.5 2^23: rint and
 * conversions cost as much as all the rest where they are not one instruction. Double and the host
 * use the library's exp. */
#ifndef HETAB_VEXP_H
#define HETAB_VEXP_H

#include "hetab_lang.h"

#if HETAB_REAL_BITS == 32
static inline vreal hetab_exp(vreal x) {
  vreal xc = fmax(x, (vreal)RC(-87.0));
  vreal shifted = fma(xc, (vreal)RC(1.44269504088896341), (vreal)RC(12582912.0));
  vreal n = shifted - RC(12582912.0);
  vreal r = fma(n, (vreal)RC(-0.693145751953125), xc);
  r = fma(n, (vreal)RC(-1.42860682030941723e-6), r);
  vreal p = (vreal)RC(1.3941108434e-3);
  p = fma(p, r, (vreal)RC(8.37512639815e-3));
  p = fma(p, r, (vreal)RC(0.0416663528968));
  p = fma(p, r, (vreal)RC(0.166664155147));
  p = fma(p, r, (vreal)RC(0.500000004712));
  p = fma(p, r, (vreal)RC(1.00000003772));
  p = fma(p, r, (vreal)RC(1.0));
  return p * V_FROM_BITS((V_BITS(shifted) << 23) + 0x3f800000);
}
#else
static inline vreal hetab_exp(vreal x) {
  return exp(x);
}
#endif

#endif
