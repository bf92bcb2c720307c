/* What the tests and the benchmark of look-ups share: tables of surfaces in files, the literal
 * model in a table's channels, and the error of a table against it. */
#ifndef HETAB_TESTS_LOOKUP_SUPPORT_H
#define HETAB_TESTS_LOOKUP_SUPPORT_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <hetab/hetab.h>

#include "model/colour.h"

enum { MOST_BANDS = 31 };

static inline double lookup_random(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-53;
}

static inline void direction_at(double theta, double phi, float w[3]) {
  w[0] = (float)(sin(theta) * cos(phi));
  w[1] = (float)(sin(theta) * sin(phi));
  w[2] = (float)cos(theta);
}

/* --- tables ---------------------------------------------------------------------------------- */

/* Without its delta. */
static inline hetab_status save_merl(hetab_context *ctx, hetab_engine *engine,
                                     const hetab_surface *surface,
                                     const hetab_merl_options *options, const char *path) {
  hetab_merl *merl;
  hetab_status status = hetab_tabulate_merl(ctx, engine, surface, options, &merl, NULL);
  if (status == HETAB_OK) {
    status = hetab_merl_save(ctx, merl, path, 1);
    hetab_merl_free(merl);
  }
  return status;
}

/* grid = NULL: the default. */
static inline hetab_status save_h5(hetab_context *ctx, hetab_engine *engine,
                                   const hetab_surface *surface, const hetab_grid *grid,
                                   const char *path) {
  const hetab_tabulate_options no_samples = {.samples = HETAB_NO_SAMPLES};
  const hetab_tabulate_to_options options = {.grid = grid, .sample = &no_samples, .overwrite = 1};
  return hetab_tabulate_to(ctx, engine, surface, &path, 1, &options, NULL);
}

/* --- the model ------------------------------------------------------------------------------- */

typedef struct lookup_model {
  hetab_context *ctx;
  const hetab_surface *surface;
  int srgb; /* 0: a channel a band */
  double weight[MOST_BANDS][3];
} lookup_model;

static inline lookup_model model_of(hetab_context *ctx, const hetab_surface *surface, int srgb) {
  lookup_model m = {ctx, surface, srgb, {{0}}};
  double lambda_um[MOST_BANDS], xyz[MOST_BANDS][3];
  size_t count = hetab_surface_band_count(surface);
  for (size_t b = 0; b < count; b++)
    lambda_um[b] = hetab_surface_bands(surface)[b].lambda_um;
  if (srgb && hetab_xyz_weights(ctx, lambda_um, count, xyz) == HETAB_OK)
    for (size_t b = 0; b < count; b++)
      hetab_xyz_to_srgb(xyz[b], m.weight[b]);
  return m;
}

/* Values of the literal equations; negative colours are 0, as in tables. */
static inline void model_at(const lookup_model *m, double theta_i, double theta_r, double phi,
                            double *value) {
  size_t count = hetab_surface_band_count(m->surface);
  hetab_point points[MOST_BANDS];
  hetab_value values[MOST_BANDS];
  for (size_t b = 0; b < count; b++) {
    const hetab_band *band = &hetab_surface_bands(m->surface)[b];
    points[b] = (hetab_point){.lambda_um = band->lambda_um,
                              .theta_i = theta_i,
                              .theta_r = theta_r,
                              .phi = phi,
                              .sigma0_um = hetab_surface_sigma0_um(m->surface),
                              .tau_um = hetab_surface_tau_um(m->surface),
                              .n = band->n,
                              .k = band->k,
                              .diffuse_brdf = band->diffuse_brdf};
  }
  if (hetab_evaluate_literal(m->ctx, points, count, values) != HETAB_OK)
    abort();
  for (size_t c = 0; m->srgb && c < 3; c++) {
    value[c] = 0;
    for (size_t b = 0; b < count; b++)
      value[c] += m->weight[b][c] * values[b].total;
    value[c] = fmax(value[c], 0);
  }
  for (size_t b = 0; !m->srgb && b < count; b++)
    value[b] = values[b].total;
}

/* Standard deviation of the lobe in direction cosines, at the middle band. */
static inline double lobe_width(const hetab_surface *surface, double theta_i) {
  size_t middle = hetab_surface_band_count(surface) / 2;
  double lambda_um = hetab_surface_bands(surface)[middle].lambda_um;
  double phase = 4 * M_PI / lambda_um * hetab_surface_sigma0_um(surface) * cos(theta_i);
  return sqrt(2 * fmax(phase * phase, 1)) * lambda_um / (2 * M_PI * hetab_surface_tau_um(surface));
}

/* --- error ----------------------------------------------------------------------------------- */

typedef struct lookup_error {
  double l1, bias; /* relative: sums over pairs, weighed with cos(theta_r), and all channels */
} lookup_error;

/* What looks up: value[channels] for a pair of directions. */
typedef void (*lookup_fn)(const void *user, const float wi[3], const float wo[3], float *value);

/* Half of the pairs uniform in the disc of direction cosines, half about the lobe. */
static inline lookup_error error_at(lookup_fn look_up, const void *user, const lookup_model *m,
                                    double theta_i, size_t pairs, uint64_t *random) {
  size_t channels = m->srgb ? 3 : hetab_surface_band_count(m->surface);
  double width = fmin(4 * lobe_width(m->surface, theta_i), 1), si = sin(theta_i);
  double absolute = 0, bias = 0, sum = 0;
  for (size_t n = 0; n < pairs; n++) {
    double x = 2 * lookup_random(random) - 1, y = 2 * lookup_random(random) - 1;
    double reference[MOST_BANDS];
    float wi[3], wo[3], value[MOST_BANDS];
    if (n & 1) {
      x = width * x - si;
      y *= width;
    }
    if (x * x + y * y >= 1)
      continue;
    int near = fabs(x + si) < width && fabs(y) < width;
    double weight = 1 / (0.25 + (near ? 0.25 / (width * width) : 0));
    double theta_r = asin(hypot(x, y)), phi = atan2(y, x);
    direction_at(theta_i, 0, wi);
    direction_at(theta_r, phi, wo);
    look_up(user, wi, wo, value);
    model_at(m, theta_i, theta_r, phi, reference);
    for (size_t c = 0; c < channels; c++) {
      absolute += weight * fabs((double)value[c] - reference[c]);
      bias += weight * ((double)value[c] - reference[c]);
      sum += weight * reference[c];
    }
  }
  return (lookup_error){absolute / sum, bias / sum};
}

/* The density of a table's sampler, its delta aside. */
static inline float density_at(const hetab_lookup *table, const float wi[3], const float wo[3]) {
  const hetab_lookup_query query = {.without_delta = 1};
  float pdf;
  hetab_lookup_eval(table, &query, 1, wi, wo, NULL, &pdf);
  return pdf;
}

/* A sample that is not the delta's; its density. */
static inline float sample_at(const hetab_lookup *table, const float wi[3], float uc,
                              const float u[2], float wo[3], float *weight) {
  const hetab_lookup_query query = {.without_delta = 1};
  hetab_lookup_drawn drawn;
  hetab_lookup_sample(table, &query, 1, wi, &uc, u, &drawn, weight);
  memcpy(wo, drawn.wo, sizeof drawn.wo);
  return drawn.pdf;
}

static inline void look_up_table(const void *user, const float wi[3], const float wo[3],
                                 float *value) {
  hetab_lookup_eval(user, NULL, 1, wi, wo, value, NULL);
}

#endif
