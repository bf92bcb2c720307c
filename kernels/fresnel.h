/* Unpolarised Fresnel reflectance |F|^2 of a half-space n + ik. */
#ifndef HETAB_FRESNEL_H
#define HETAB_FRESNEL_H

#include "hetab_lang.h"
#include "tables.h"

/* Source: Eq. 12 with the reflection coefficients written for real arithmetic. The refracted wave's
 * normal component is a + ib = sqrt((n + ik)^2 - sin^2), in units of the wave number outside: a is
 * how it propagates, b how it decays. With modulus = a^2 + b^2 and twice_ac = 2 a cos,
 *           F_s = (cos^2 + modulus - twice_ac) / (cos^2 + modulus + twice_ac)
 *           F_p / F_s = (both - twice_ac sin^2) / (both + twice_ac sin^2),  both = modulus cos^2 +
 * sin^4 and the mean of F_s and F_p has one division. In    : cos2 = cos^2(theta_d) in [0, 1], the
 * square because it is what the kernels know exactly; numerator_s, that of F_s, >= 0: callers know
 * how to form it without cancellation Out   : (F_s + F_p) / 2 in [0, 1]; 1 at grazing */
static inline vreal hetab_fresnel_mean(vreal cos2, vreal twice_ac, vreal modulus,
                                       vreal numerator_s) {
  vreal sin2 = RC(1.0) - cos2;
  vreal both = modulus * cos2 + sin2 * sin2;
  return numerator_s * both / ((cos2 + modulus + twice_ac) * (both + twice_ac * sin2));
}

/* In: e1 = n^2 - k^2 - 1 and nk = n k, which the host forms in double: near n = 1 a float n has no
 *     digits left for them. Any n > 0, k >= 0.
 * The smaller of a and b comes from a b = n k, and a - cos from a^2 - cos^2 = e1 + b^2: the plain
 * differences cancel for good metals and for thin dielectrics.
 * Error: relative <= 2e-6 float, <= 1e-14 double (tests/test_kernels.c); around the critical angle
 * of n < 1, k = 0, where a is the root of what is left of a cancellation, up to 6e-3 float. */
static inline vreal hetab_fresnel(vreal cos2, vreal e1, vreal nk) {
  vreal c = sqrt(cos2);
  vreal re = e1 + cos2; /* of (a + ib)^2; its imaginary part is 2 nk */
  vreal modulus = sqrt(re * re + RC(4.0) * nk * nk);
  vreal large = sqrt(RC(0.5) * (modulus + fabs(re)));
  vreal small = nk / fmax(large, (vreal)RC(1e-18));
  vreal a = re > (vreal)RC(0.0) ? large : small;
  vreal b = re > (vreal)RC(0.0) ? small : large;
  vreal a_less_c = (e1 + b * b) / fmax(a + c, (vreal)RC(1e-18));
  /* 1e-30: at n = 1 and grazing the quotient is 0/0 */
  vreal mean =
      hetab_fresnel_mean(cos2, RC(2.0) * a * c, modulus + RC(1e-30), a_less_c * a_less_c + b * b);
  return fmin(mean, (vreal)RC(1.0));
}

#ifdef HETAB_CL
/* For indices far from 1, as of metals: a and the modulus hardly depend on the angle, and the host
 * has made polynomials of both in 2 cos^2 - 1 (src/model/fresnel_fit.c says when they are good
 * enough). Two square roots and a division less, in the hottest loop there is. */
static inline vreal hetab_fresnel_fitted(vreal cos2, __global const real *fit, int count) {
  vreal v = RC(2.0) * cos2 - RC(1.0);
  vreal a = RC(0.0), modulus = RC(0.0);
  if (count > HETAB_FRESNEL_SHORT)
#pragma unroll
    for (int i = HETAB_FRESNEL_FIT - 1; i >= HETAB_FRESNEL_SHORT; i--) {
      a = fma(a, v, (vreal)fit[i]);
      modulus = fma(modulus, v, (vreal)fit[HETAB_FRESNEL_FIT + i]);
    }
#pragma unroll
  for (int i = HETAB_FRESNEL_SHORT - 1; i >= 0; i--) {
    a = fma(a, v, (vreal)fit[i]);
    modulus = fma(modulus, v, (vreal)fit[HETAB_FRESNEL_FIT + i]);
  }
  vreal twice_ac = RC(2.0) * a * sqrt(cos2);
  return hetab_fresnel_mean(cos2, twice_ac, modulus, cos2 + modulus - twice_ac);
}
#endif

#endif
