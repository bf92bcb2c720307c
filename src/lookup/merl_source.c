#include "lookup/merl_source.h"

#include <math.h>
#include <stdlib.h>

enum { CHANNELS = HETAB_MERL_CHANNELS, HALF = HETAB_MERL_HALF, D = HETAB_MERL_THETA_D };

static size_t row_of(int h, int d) {
  return (size_t)h * D + (size_t)d;
}

/* The mean of cell p and its mirror image; 0 if both are below the horizon. */
static int mean_cell(const hetab_merl *merl, size_t row, int p, float *log2_values, float *high) {
  size_t first = row * HETAB_MERL_PHI_D, a = first + (size_t)p;
  size_t b = first + (size_t)(HETAB_MERL_PHI_D - 1 - p);
  for (int c = 0; c < CHANNELS; c++) {
    const double *values = hetab_merl_channel_const(merl, c);
    int valid = (values[a] >= 0) + (values[b] >= 0);
    if (!valid)
      return 0;
    log2_values[c] = hetab_log2_or_zero((fmax(values[a], 0) + fmax(values[b], 0)) / valid);
    *high = fmaxf(*high, log2_values[c]);
  }
  return 1;
}

/* phi_d = 90 is always above the horizon: from there down, a row is valid up to some cell, and goes
 * on beyond it as it began to change. */
static void continue_row(float (*row)[CHANNELS], int first_valid) {
  for (int p = first_valid - 1; p >= 0; p--)
    for (int c = 0; c < CHANNELS; c++) {
      float last = row[p + 1][c], before = p + 2 < HALF ? row[p + 2][c] : last;
      float slope = first_valid - p <= 3 ? last - before : 0;
      row[p][c] = last + fminf(fmaxf(slope, -1), 1);
    }
}

static void fill_row(const hetab_merl *merl, int h, int d, hetab_merl_source *source,
                     unsigned char *first_valid) {
  float(*row)[CHANNELS] = source->logs + row_of(h, d) * HALF;
  int p = HALF;
  while (p > 0 && mean_cell(merl, row_of(h, d), p - 1, row[p - 1], &source->high))
    p--;
  *first_valid = (unsigned char)p;
}

/* A row without any valid cell takes the one before it. */
static void finish_row(hetab_merl_source *source, size_t row, int first_valid) {
  float(*to)[CHANNELS] = source->logs + row * HALF;
  for (int p = first_valid; p < HALF; p++)
    for (int c = 0; c < CHANNELS; c++)
      to[p][c] = fmaxf(to[p][c], source->low);
  if (first_valid < HALF)
    continue_row(to, first_valid);
  else
    for (int p = 0; p < HALF; p++)
      for (int c = 0; c < CHANNELS; c++)
        to[p][c] = row % D ? to[p - HALF][c] : source->low;
}

hetab_status hetab_merl_prepare(hetab_context *ctx, const hetab_merl *merl,
                                hetab_merl_source *source) {
  enum { ROWS = HETAB_MERL_THETA_H * D };
  unsigned char first_valid[ROWS];
  *source = (hetab_merl_source){.high = HETAB_LATTICE_ZERO};
  source->logs = hetab_alloc(ctx, (size_t)ROWS * HALF, sizeof *source->logs);
  HETAB_NEED(source->logs);
  for (int h = 0; h < HETAB_MERL_THETA_H; h++) {
    double s = sin(hetab_merl_angles((hetab_merl_place){h + 0.5, 0.0, 0.0}).theta_h);
    source->sin2_h[h] = s * s;
    for (int d = 0; d < D; d++)
      fill_row(merl, h, d, source, &first_valid[row_of(h, d)]);
  }
  for (int d = 0; d < D; d++)
    source->theta_d[d] = hetab_merl_angles((hetab_merl_place){0.0, d + 0.5, 0.0}).theta_d;
  source->low = source->high - 50;
  for (size_t row = 0; row < ROWS; row++)
    finish_row(source, row, first_valid[row]);
  HETAB_TRY(hetab_stencil_axis_create(ctx, source->sin2_h, HETAB_MERL_THETA_H, &source->h));
  return hetab_stencil_axis_create(ctx, source->theta_d, D, &source->d);
}

void hetab_merl_source_clear(hetab_merl_source *source) {
  free(source->logs);
  hetab_stencil_axis_clear(&source->h);
  hetab_stencil_axis_clear(&source->d);
  source->logs = NULL;
}

/* Cubic along phi_d, in cells, mirrored at both ends. */
static void add_row(const hetab_merl_source *source, size_t row, double weight, double cells,
                    float *sum) {
  double base = floor(cells - 0.5), t = cells - 0.5 - base;
  double w[4] = {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2,
                 -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6};
  for (int k = 0; k < 4; k++) {
    int p = (int)base - 1 + k;
    p = p < 0 ? -1 - p : p >= HALF ? 2 * HALF - 1 - p : p;
    const float *cell = source->logs[row * HALF + (size_t)p];
    for (int c = 0; c < CHANNELS; c++)
      sum[c] += (float)(weight * w[k]) * cell[c];
  }
}

void hetab_merl_at(const void *user, const hetab_lattice_place *place, float *log2_values) {
  const hetab_merl_source *source = user;
  double side = sqrt(place->sin2_h * (1 - place->cos_d * place->cos_d));
  double cos_p = side > 0 ? fmin(0.5 * (place->mu_high - place->mu_low) / side, 1) : 0;
  double cells = acos(cos_p) / M_PI_2 * HALF;
  hetab_stencil h = hetab_stencil_at(&source->h, place->sin2_h);
  hetab_stencil d = hetab_stencil_at(&source->d, acos(place->cos_d));
  float sum[CHANNELS] = {0};
  for (int a = 0; a < h.count; a++)
    for (int b = 0; b < d.count; b++)
      add_row(source, row_of((int)h.first + a, (int)d.first + b), h.weight[a] * d.weight[b], cells,
              sum);
  for (int c = 0; c < CHANNELS; c++)
    log2_values[c] = sum[c] > source->low ? fminf(sum[c], source->high + 1) : HETAB_LATTICE_ZERO;
}

void hetab_merl_nearest(const hetab_merl *merl, const float wi[3], const float wo[3],
                        float *value) {
  double theta_i = atan2(hypot((double)wi[0], (double)wi[1]), (double)wi[2]);
  double theta_r = atan2(hypot((double)wo[0], (double)wo[1]), (double)wo[2]), rgb[CHANNELS];
  double phi = atan2((double)wo[1], (double)wo[0]) - atan2((double)wi[1], (double)wi[0]);
  hetab_merl_lookup(merl, (hetab_directions){theta_i, theta_r, phi}, rgb);
  for (int c = 0; c < CHANNELS; c++)
    value[c] = (float)fmin(fmax(rgb[c], 0), 1e30);
}
