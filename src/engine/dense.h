/* What dense tables are computed from, shared by the tabulation and the benchmark. */
#pragma once

#include <hetab/tabulate.h>

#include "engine/engine_internal.h"
#include "model/model.h"

typedef enum hetab_dense_kernel {
  HETAB_DENSE_ROWS,
  HETAB_DENSE_SERIES,
  HETAB_DENSE_STORE
} hetab_dense_kernel;

/* A job's host side: directions and waves in double, the series' polynomials. */
typedef struct hetab_dense {
  const hetab_surface *surface;
  const hetab_grid *grid;
  size_t count[HETAB_AXIS_COUNT], wavelength_count;
  hetab_direction *theta_i, *theta_r;
  double *one_plus_cos; /* [phi_padded] */
  size_t phi_padded;
  double *waves; /* [wavelength][HETAB_WAVE_REALS] */
  hetab_atlas atlas;
  double g_least;      /* where the atlas begins; infinite without one */
  double wave_g_least; /* of the wavelengths; with an atlas */
  size_t rows_i;       /* theta_i rows per slab */
  int is_reciprocal; /* theta_i and theta_r are the same axis: half of the rows are mirror images */
} hetab_dense;

/* One device's side: its buffers and kernel. */
typedef struct hetab_dense_lane {
  const hetab_lane *lane;
  hetab_dense_kernel which;
  cl_kernel kernel, series; /* series: of rows below the atlas */
  cl_mem waves, one_plus_cos;
  hetab_atlas_buffers atlas;
  cl_mem pairs, rows, low_rows; /* of the theta_i rows first .. first + count */
  size_t first, count, row_count, low_count;
} hetab_dense_lane;

/* All but the numbers of the atlas, whose degrees are there: kernels can be compiled meanwhile. */
hetab_status hetab_dense_create(hetab_context *ctx, const hetab_engine *engine,
                                const hetab_surface *surface, const hetab_grid *grid,
                                hetab_dense *dense);
/* The atlas, if the engine's method has one. */
hetab_status hetab_dense_make_atlas(hetab_context *ctx, const hetab_engine *engine,
                                    hetab_dense *dense);
void hetab_dense_clear(hetab_dense *dense);

/* The kernel; and what it reads, once the atlas is made. Clear the lane whatever the outcome. */
hetab_status hetab_dense_lane_create(hetab_context *ctx, const hetab_engine *engine,
                                     const hetab_lane *lane, const hetab_dense *dense,
                                     hetab_dense_kernel which, hetab_dense_lane *out);
hetab_status hetab_dense_lane_load(hetab_context *ctx, const hetab_engine *engine,
                                   const hetab_dense *dense, hetab_dense_lane *lane);
void hetab_dense_lane_clear(hetab_dense_lane *lane);

/* Start computing theta_i rows [first, first + count) of a wavelength into out. done (or NULL): the
 * kernels that do it, for hetab_lane_seconds. */
hetab_status hetab_dense_run(hetab_context *ctx, const hetab_engine *engine,
                             const hetab_dense *dense, hetab_dense_lane *lane, size_t wavelength,
                             size_t first, size_t count, cl_mem out, cl_event done[2]);

/* The literal reference at one entry: dd + ud, 1/sr. */
double hetab_dense_literal(const hetab_dense *dense, size_t wavelength, size_t i, size_t r,
                           size_t p);

/* Of the tolerance, what the atlas may take; the rest is for the arithmetic. */
#define HETAB_ATLAS_SHARE 0.2

/* How many coefficients the atlas has at the engine's tolerance, for the widest of its devices. */
void hetab_engine_atlas_degrees(const hetab_engine *engine, hetab_atlas *atlas);
/* The atlas for these waves at the engine's tolerance; it ends where no entry reaches 5e-15 / sr.
 */
hetab_status hetab_engine_atlas(hetab_context *ctx, const hetab_engine *engine, const double *waves,
                                size_t wave_count, double tau_2sigma, hetab_atlas *atlas);

/* A value as the engine's nearest real and the rest. */
void hetab_two_reals(const hetab_engine *engine, double value, double two[2]);
/* The kernels' row of one wavelength, kernels/tables.h, as far as the wave makes it; and with the
 * fit of Fresnel's equations. Its weights are left as they are. */
void hetab_wave_row(const hetab_engine *engine, const hetab_wave *wave, double *row);
void hetab_band_row(const hetab_engine *engine, const hetab_surface *surface,
                    const hetab_band *band, double *row);
