/* Unpolarised Fresnel reflectance |F|^2 of a half-space n + ik. */
#ifndef HETAB_FRESNEL_H
#define HETAB_FRESNEL_H

#include "hetab_lang.h"
#include "tables.h"

/* Source: Eq. 25 with the reflection coefficients written for real arithmetic. With a + ib =
 *         sqrt((n + ik)^2 - sin^2), m = a^2 + b^2 and t = 2 a cos,
 *           F_s = (cos^2 + m - t) / (cos^2 + m + t)
 *           F_p / F_s = (m cos^2 + sin^4 - t sin^2) / (m cos^2 + sin^4 + t sin^2)
 *         and the mean of F_s and F_p has one division.
 * In    : cos2 = cos^2(theta_d) in [0, 1], the square because it is what the kernels know exactly
 * Out   : (F_s + F_p) / 2 in [0, 1]; 1 at grazing */
static inline vreal hetab_fresnel_mean(vreal cos2, vreal t, vreal m, vreal minus_s) {
  vreal sin2 = RC(1.0) - cos2;
  vreal u = m * cos2 + sin2 * sin2;
  return minus_s * u / ((cos2 + m + t) * (u + t * sin2));
}

/* In: e1 = n^2 - k^2 - 1 and nk = n k, which the host forms in double: near n = 1 a float n has no
 *     digits left for them. Any n > 0, k >= 0.
 * The smaller of a and b comes from a b = n k, and a - cos from a^2 - cos^2 = e1 + b^2: the plain
 * differences cancel for good metals and for thin dielectrics.
 * Error: relative <= 2e-6 float, <= 1e-12 double (tests/test_kernels.c); around the critical angle
 * of n < 1, k = 0, where a is the root of what is left of a cancellation, up to 6e-3 float. */
static inline vreal hetab_fresnel(vreal cos2, vreal e1, vreal nk) {
  vreal c = sqrt(cos2);
  vreal re = e1 + cos2;
  vreal m = sqrt(re * re + RC(4.0) * nk * nk);
  vreal large = sqrt(RC(0.5) * (m + fabs(re)));
  vreal small = nk / fmax(large, (vreal)RC(1e-18));
  vreal a = re > (vreal)RC(0.0) ? large : small;
  vreal b = re > (vreal)RC(0.0) ? small : large;
  vreal a_c = (e1 + b * b) / fmax(a + c, (vreal)RC(1e-18));
  /* 1e-30: at n = 1 and grazing the quotient is 0/0 */
  vreal mean = hetab_fresnel_mean(cos2, RC(2.0) * a * c, m + RC(1e-30), a_c * a_c + b * b);
  return fmin(mean, (vreal)RC(1.0));
}

#ifdef HETAB_CL
/* For indices far from 1, as of metals: a and m hardly depend on the angle, and the host has made
 * polynomials of both in 2 cos^2 - 1 (src/model/fresnel_fit.c says when they are good enough).
 * Two square roots and a division less, in the hottest loop there is. */
static inline vreal hetab_fresnel_fitted(vreal cos2, __global const real *fit, int count) {
  vreal v = RC(2.0) * cos2 - RC(1.0);
  vreal a = RC(0.0), m = RC(0.0);
  if (count > HETAB_FRESNEL_SHORT)
#pragma unroll
    for (int i = HETAB_FRESNEL_FIT - 1; i >= HETAB_FRESNEL_SHORT; i--) {
      a = fma(a, v, (vreal)fit[i]);
      m = fma(m, v, (vreal)fit[HETAB_FRESNEL_FIT + i]);
    }
#pragma unroll
  for (int i = HETAB_FRESNEL_SHORT - 1; i >= 0; i--) {
    a = fma(a, v, (vreal)fit[i]);
    m = fma(m, v, (vreal)fit[HETAB_FRESNEL_FIT + i]);
  }
  vreal t = RC(2.0) * a * sqrt(cos2);
  return hetab_fresnel_mean(cos2, t, m, cos2 + m - t);
}
#endif

#endif
