#include "table/merl_frame.h"

#include <math.h>

enum { CHANNELS = HETAB_MERL_CHANNELS };
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

void hetab_merl_lookup(const hetab_merl *merl, hetab_directions at, double rgb[3]) {
  size_t cell = hetab_merl_cell(at);
  for (int c = 0; c < CHANNELS; c++)
    rgb[c] = hetab_merl_channel_const(merl, c)[cell];
}

/* ---- two ways to read ---------------------------------------------------------------------- */

/* phi_d and phi_d + pi are one (reciprocity). */
static int wrapped(int p) {
  p %= HETAB_MERL_PHI_D;
  return p < 0 ? p + HETAB_MERL_PHI_D : p;
}

static int clamped(int i, int count) {
  return i < 0 ? 0 : i < count ? i : count - 1;
}

static size_t cell_at(int h, int d, int p) {
  h = clamped(h, HETAB_MERL_THETA_H);
  d = clamped(d, HETAB_MERL_THETA_D);
  return ((size_t)h * HETAB_MERL_THETA_D + (size_t)d) * HETAB_MERL_PHI_D + (size_t)wrapped(p);
}

static int is_valid(double value) {
  return value >= 0 && isfinite(value);
}

void hetab_merl_read_truncated(const hetab_merl *merl, hetab_merl_place at, double rgb[CHANNELS]) {
  size_t cell = cell_at((int)at.h, (int)at.d, (int)floor(at.p));
  int below = 0;
  for (int c = 0; c < CHANNELS; c++) {
    double value = hetab_merl_channel_const(merl, c)[cell];
    below |= value < 0; /* one negative channel, and the reader takes the cell for invalid */
    rgb[c] = is_valid(value) ? value : 0;
  }
  for (int c = 0; c < CHANNELS && below; c++)
    rgb[c] = 0;
}

int hetab_merl_read_interpolated(const hetab_merl *merl, hetab_merl_place at,
                                 double rgb[CHANNELS]) {
  double h = floor(at.h - 0.5), d = floor(at.d - 0.5), p = floor(at.p - 0.5);
  double fraction[CHANNELS] = {at.h - 0.5 - h, at.d - 0.5 - d, at.p - 0.5 - p};
  double sum[CHANNELS] = {0}, weights[CHANNELS] = {0};
  for (int corner = 0; corner < 8; corner++) {
    int up[CHANNELS] = {corner & 1, corner >> 1 & 1, corner >> 2};
    size_t cell = cell_at((int)h + up[0], (int)d + up[1], (int)p + up[2]);
    double weight = 1;
    for (int axis = 0; axis < CHANNELS; axis++)
      weight *= up[axis] ? fraction[axis] : 1 - fraction[axis];
    for (int c = 0; c < CHANNELS; c++) {
      double value = hetab_merl_channel_const(merl, c)[cell];
      sum[c] += is_valid(value) ? weight * value : 0;
      weights[c] += is_valid(value) ? weight : 0;
    }
  }
  for (int c = 0; c < CHANNELS; c++)
    rgb[c] = weights[c] > 0 ? sum[c] / weights[c] : 0;
  return weights[0] > 0 && weights[1] > 0 && weights[2] > 0;
}
