/* The model on the host, in double, from the physics that the kernels share (kernels/ *.h):
 * what depends on angles alone is computed here once, where float would cancel. */
#pragma once

#include <stddef.h>

#include <hetab/types.h>

#include "core/angle.h"
#include <hetab/surface.h>

/* One direction's polar angle. */
typedef struct hetab_direction {
  double theta;
  double mu, s;           /* cosine and sine; mu is exactly 0 at pi/2 */
  double shadow_over_cos; /* S / mu, Eqs. 15-17 */
  double k;               /* Eq. 22; infinite at pi/2 */
} hetab_direction;

/* tau / (2 sigma0). Inline: what links the model alone needs no surfaces. */
static inline double hetab_tau_2sigma(const hetab_surface *surface) {
  return hetab_surface_tau_um(surface) / (2.0 * hetab_surface_sigma0_um(surface));
}

/* theta in radians, [0, pi/2]. */
hetab_direction hetab_direction_at(double theta, double tau_2sigma);

/* 1 + cos(phi) without cancellation at phi = pi, exact 0 there. */
double hetab_one_plus_cos(double phi);

/* What one (theta_i, theta_r) pair contributes to every phi and wavelength. The squared lateral
 * sum |q_i + q_r|^2 is d2 + p (1 + cos phi). */
typedef struct hetab_pair {
  double mu2;    /* (mu_i + mu_r)^2 */
  double d2;     /* (sin_i - sin_r)^2, from a product, not a difference */
  double p;      /* 2 sin_i sin_r */
  double shadow; /* S_i S_r / (mu_i mu_r) / (1 + W) */
  double ratio2; /* sigma^2 / sigma0^2 = 1 / (1 + W); 0 at grazing */
} hetab_pair;

hetab_pair hetab_pair_of(const hetab_direction *i, const hetab_direction *r);

/* What one wavelength contributes everywhere. */
typedef struct hetab_wave {
  double g;            /* (2 pi sigma0 / lambda)^2 */
  double x;            /* (pi tau / lambda)^2 */
  double amplitude;    /* 16 pi^3 sigma0^2 tau^2 / lambda^4, 1/sr */
  double e1, nk;       /* n^2 - k^2 - 1 and n k */
  double diffuse_brdf; /* 1/sr */
} hetab_wave;

hetab_wave hetab_wave_of(double sigma0_um, double tau_um, const hetab_band *band);

/* rho_s of Eq. 10: |F|^2 e^-g S^2 at the mirror direction. */
double hetab_specular(const hetab_direction *i, const hetab_wave *wave);

/* Fresnel reflectance |F(theta)|^2 and ln h(g, x) of the shared source. */
double hetab_fresnel_at(double cos2, double n, double k);
double hetab_ln_h(double g, double x);

/* The printed equations (src/model/literal.c). */
hetab_value hetab_literal(const hetab_point *point);
