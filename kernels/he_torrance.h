/* The He-Torrance model, put together from its factors in the form that has no 0/0:
 *
 *   f_dd = |F(theta_d)|^2 16 pi^3 sigma0^2 tau^2 / lambda^4 cos^4(theta_d)
 *          [S_i / mu_i] [S_r / mu_r] h(g, x) / (1 + W)
 *   g = (2 pi sigma0 / lambda)^2 (mu_i + mu_r)^2 / (1 + W)
 *   x = (pi tau / lambda)^2 |q_i + q_r|^2          (q: lateral direction cosines)
 *   cos^2(theta_d) = ((mu_i + mu_r)^2 + |q_i + q_r|^2) / 4
 *
 * equal to Eqs. 8, 11-25 as printed (tests/test_literal.c). |q_i + q_r|^2 vanishes at the mirror
 * direction, where the lobe is: whoever calls forms it without cancellation, as
 * (sin_i - sin_r)^2 + 2 sin_i sin_r (1 + cos phi). */
#ifndef HETAB_HE_TORRANCE_H
#define HETAB_HE_TORRANCE_H

#include "hetab_lang.h"
#include "fresnel.h"
#include "series.h"

/* What depends on the surface and the wavelength alone: `wave` in the code. */
static inline real hetab_wave_g(real sigma0_um, real lambda_um) {
  real phase = RC(2.0) * RC_PI * sigma0_um / lambda_um;
  return phase * phase;
}
static inline real hetab_wave_x(real tau_um, real lambda_um) {
  real phase = RC_PI * tau_um / lambda_um;
  return phase * phase;
}
/* 16 pi^3 sigma0^2 tau^2 / lambda^4 */
static inline real hetab_wave_amplitude(real wave_g, real wave_x) {
  return RC(4.0) / RC_PI * wave_g * wave_x;
}

/* f_dd from its factors, 1/sr, >= 0. amplitude: the wave's times S_i S_r / (mu_i mu_r) / (1 + W).
 */
static inline vreal hetab_dd(vreal cos2_d, vreal fresnel, vreal amplitude, vreal h) {
  return fresnel * (cos2_d * cos2_d) * amplitude * h;
}

/* rho_s of Eq. 10, of the mirror direction's g; shadow2: S_i^2. */
static inline vreal hetab_rho_s(vreal fresnel, vreal shadow2, vreal g) {
  return fresnel * shadow2 * exp(-g);
}

#endif
