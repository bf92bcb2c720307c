/* Unpolarised Fresnel reflectance |F|^2 of a half-space n + ik. */
#ifndef HETAB_FRESNEL_H
#define HETAB_FRESNEL_H

#include "hetab_lang.h"

/* Source: Eq. 25 with the reflection coefficients written for real arithmetic: a + ib =
 *         sqrt((n + ik)^2 - sin^2 theta), and both polarisations over one division.
 * In    : cos2 = cos^2(theta_d) in [0, 1], the square because it is what the kernels know exactly;
 *         n > 0, k >= 0
 * Out   : (F_s + F_p) / 2 in [0, 1]; 1 at grazing
 * The smaller of a and b comes from a b = n k: their squares cancel for good metals and for
 * dielectrics. */
static inline vreal hetab_fresnel(vreal cos2, vreal n, vreal k) {
  vreal sin2 = RC(1.0) - cos2;
  vreal c = sqrt(cos2);
  vreal nk = n * k;
  vreal re = (n - k) * (n + k) - sin2;
  vreal modulus = sqrt(re * re + RC(4.0) * nk * nk);
  vreal large = sqrt(RC(0.5) * (modulus + fabs(re)));
  vreal small = nk / fmax(large, (vreal)RC(1e-18));
  vreal a = re > (vreal)RC(0.0) ? large : small;
  vreal b2 = re > (vreal)RC(0.0) ? small * small : large * large;
  vreal ac = a * c;
  vreal b2c2 = b2 * cos2;
  vreal minus_s = (a - c) * (a - c) + b2;
  vreal plus_s = (a + c) * (a + c) + b2;
  vreal minus_p = (ac - sin2) * (ac - sin2) + b2c2;
  vreal plus_p = (ac + sin2) * (ac + sin2) + b2c2;
  return RC(0.5) * minus_s * (plus_p + minus_p) / (plus_s * plus_p);
}

#endif
