#include "audit/merl_read.h"

#include <math.h>

#include "table/half_diff.h"

enum { CHANNELS = 3 };

hetab_merl_place hetab_merl_place_of(double theta_i, double theta_r, double phi) {
  hetab_half_diff angles = hetab_half_diff_of(theta_i, theta_r, phi);
  return (hetab_merl_place){HETAB_MERL_THETA_H * sqrt(angles.theta_h / M_PI_2),
                            HETAB_MERL_THETA_D * angles.theta_d / M_PI_2,
                            HETAB_MERL_PHI_D * angles.phi_d / M_PI};
}

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

static void truncate_at(const hetab_merl *merl, hetab_merl_place at, double rgb[CHANNELS]) {
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

static void interpolate_at(const hetab_merl *merl, hetab_merl_place at, double rgb[CHANNELS]) {
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
}

void hetab_merl_read(const hetab_merl *merl, hetab_reading lookup, hetab_merl_place place,
                     double rgb[3]) {
  if (lookup == HETAB_READ_INTERPOLATE)
    interpolate_at(merl, place, rgb);
  else
    truncate_at(merl, place, rgb);
}
