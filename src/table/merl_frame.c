#include "table/merl_frame.h"

#include <math.h>

enum { H = HETAB_MERL_THETA_H, D = HETAB_MERL_THETA_D, P = HETAB_MERL_PHI_D };

/* Where an azimuth is undefined or the three directions lie in one plane, all that rounding leaves
 * of a component is its noise, and the noise would choose the cell. */
static double without_noise(double component) {
  return fabs(component) < 1e-15 ? 0.0 : component;
}

hetab_half_diff hetab_half_diff_of(double theta_i, double theta_r, double phi) {
  double lx = sin(theta_i), lz = cos(theta_i); /* the light, at azimuth 0 */
  double hx = without_noise(lx + sin(theta_r) * cos(phi));
  double hy = without_noise(sin(theta_r) * sin(phi));
  double hz = without_noise(lz + cos(theta_r));
  double hxy = hypot(hx, hy), length = hypot(hxy, hz);
  double cos_h = length > 0.0 ? hz / length : 1.0, sin_h = length > 0.0 ? hxy / length : 0.0;
  double cos_p = hxy > 0.0 ? hx / hxy : 1.0, sin_p = hxy > 0.0 ? hy / hxy : 0.0;
  double turned = lx * cos_p; /* x of the light when the half vector has azimuth 0 */
  double dx = without_noise(turned * cos_h - lz * sin_h);
  double dy = without_noise(-lx * sin_p);
  double dz = turned * sin_h + lz * cos_h;
  return (hetab_half_diff){atan2(hxy, hz), atan2(hypot(dx, dy), dz), atan2(dy, dx)};
}

int hetab_merl_pair_of(hetab_half_diff a, hetab_merl_pair *pair) {
  double even = cos(a.theta_h) * cos(a.theta_d), up = cos(a.theta_d) * sin(a.theta_h);
  double forward = sin(a.theta_d) * cos(a.phi_d), lateral = sin(a.theta_d) * sin(a.phi_d);
  double odd = sin(a.theta_h) * forward, xi = up + forward * cos(a.theta_h);
  double xr = up - forward * cos(a.theta_h);
  pair->mu_i = even - odd;
  pair->mu_r = even + odd;
  pair->at = (hetab_directions){atan2(hypot(xi, lateral), pair->mu_i),
                                atan2(hypot(xr, lateral), pair->mu_r),
                                atan2(-lateral, xr) - atan2(lateral, xi)};
  return pair->mu_i > 0.0 && pair->mu_r > 0.0;
}

hetab_half_diff hetab_merl_angles(hetab_merl_place place) {
  double u = place.h / H;
  return (hetab_half_diff){u * u * M_PI_2, place.d / D * M_PI_2, place.p / P * M_PI};
}

hetab_merl_place hetab_merl_place_of(hetab_half_diff angles) {
  return (hetab_merl_place){H * sqrt(angles.theta_h / M_PI_2), D * angles.theta_d / M_PI_2,
                            P * angles.phi_d / M_PI};
}

hetab_half_diff hetab_merl_middle(size_t cell) {
  return hetab_merl_angles((hetab_merl_place){
      (double)(cell / (D * P)) + 0.5, (double)(cell / P % D) + 0.5, (double)(cell % P) + 0.5});
}

/* ---- cells --------------------------------------------------------------------------------- */

/* Truncated to an index, as the reference reader does; NaN to the first one. */
static size_t truncated(double position, size_t count) {
  if (!(position > 0.0))
    return 0;
  return position < (double)count ? (size_t)position : count - 1;
}

size_t hetab_merl_cell(hetab_directions at) {
  hetab_half_diff angles = hetab_half_diff_of(at.theta_i, at.theta_r, at.phi);
  /* f(i, r) = f(r, i): phi_d and phi_d + pi share a cell. */
  double phi_d = angles.phi_d < 0.0 ? angles.phi_d + M_PI : angles.phi_d;
  double theta_h_deg = angles.theta_h / M_PI_2 * 90.0;
  size_t h = truncated(sqrt(theta_h_deg * HETAB_MERL_THETA_H), HETAB_MERL_THETA_H);
  size_t d = truncated(angles.theta_d / M_PI_2 * HETAB_MERL_THETA_D, HETAB_MERL_THETA_D);
  size_t p = truncated(phi_d / M_PI * HETAB_MERL_PHI_D, HETAB_MERL_PHI_D);
  return (h * HETAB_MERL_THETA_D + d) * HETAB_MERL_PHI_D + p;
}
