/* Shadowing and masking, and the effective roughness: the factors that depend on one angle, or on
 * a pair of them, but not on the wavelength.
 *
 * All take mu = cos(theta), s = sin(theta) and tau_2sigma = tau / (2 sigma0). */
#ifndef HETAB_SHADOWING_H
#define HETAB_SHADOWING_H

#include "hetab_lang.h"
#include "lambert_w.h"

/* tau cot(theta) / (2 sigma0), the argument of every erfc of the model. Large at normal incidence
 * (bounded, so that 0 * infinity cannot arise), 0 at grazing. */
static inline vreal hetab_cot_arg(vreal mu, vreal s, real tau_2sigma) {
  return fmin(tau_2sigma * mu / fmax(s, (vreal)RC(1e-18)), (vreal)RC(1e6));
}

/* S(theta) / cos(theta), Eqs. 15-17 over the cosine of Eq. 8.
 * As printed, Lambda has cot(theta) in a denominator and the quotient is 0/0 at grazing; with
 * A = 1 - erfc(u)/2 it is A / (mu A + exp(-u^2) s / (2 sqrt(pi) tau_2sigma)), which is 1 at normal
 * incidence and sqrt(pi) tau_2sigma at grazing. */
static inline vreal hetab_shadow_over_cos(vreal mu, vreal s, real tau_2sigma) {
  vreal u = hetab_cot_arg(mu, s, tau_2sigma);
  vreal a = RC(1.0) - RC(0.5) * erfc(u);
  return a / (mu * a + exp(-u * u) * s / (RC(2.0) * RC_SQRT_PI * tau_2sigma));
}

/* K(theta) = tan(theta) erfc(u), Eq. 22. mu > 0 (at mu = 0 it is infinite). */
static inline vreal hetab_k(vreal mu, vreal s, real tau_2sigma) {
  return s / mu * erfc(hetab_cot_arg(mu, s, tau_2sigma));
}

/* sigma^2 / sigma0^2 = 1 / (1 + W), Eqs. 20-21 in closed form: W e^W = (K_i + K_r)^2 / (8 pi). */
static inline vreal hetab_roughness_ratio2(vreal k_sum) {
  vreal ln_kappa =
      RC(2.0) * log(fmax(k_sum, (vreal)RC(1e-18))) - RC(3.22417142752924); /* ln 8 pi */
  return RC(1.0) / (RC(1.0) + hetab_lambert_w(ln_kappa));
}

#endif
