/* MERL tables as their readers read them. */
#include "table/merl_frame.h"

#include <math.h>

enum { CHANNELS = HETAB_MERL_CHANNELS };

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
