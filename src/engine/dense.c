#include "engine/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels/tables.h"
#include "model/fresnel_fit.h"
#include "model/limits.h"

enum { PAD = 16 /* the widest vector */ };
static const size_t SLAB_BYTES = 32u << 20, SLAB_ROWS = 1u << 19, ROW_BYTES = 128u << 20;
/* The atlas reaches down to this fraction of the smallest g of normal directions: only rows within
 * a degree of grazing on both sides are below, and take the series. */
static const double G_RANGE = 1e-4;
/* Of the tolerance, what the fit of Fresnel's equations may take. */
static const double FRESNEL_SHARE = 0.02;
/* Entries below this may be stored as 0, 1/sr: half of the absolute error that is allowed there. */
static const double ZERO_BELOW = 5e-15;

static hetab_direction *directions(hetab_context *ctx, const hetab_surface *surface,
                                   const hetab_grid *grid, hetab_axis axis) {
  size_t count = hetab_grid_count(grid, axis);
  const double *deg = hetab_grid_deg(grid, axis);
  hetab_direction *d = hetab_alloc(ctx, count, sizeof *d);
  for (size_t i = 0; d && i < count; i++)
    d[i] = hetab_direction_at(hetab_radians(deg[i]), hetab_tau_2sigma(surface));
  return d;
}

static double *padded_one_plus_cos(hetab_context *ctx, const hetab_grid *grid, size_t padded) {
  size_t count = hetab_grid_count(grid, HETAB_PHI);
  const double *deg = hetab_grid_deg(grid, HETAB_PHI);
  double *values = hetab_alloc(ctx, padded, sizeof *values);
  for (size_t i = 0; values && i < padded; i++)
    values[i] = hetab_one_plus_cos(hetab_radians(deg[i < count ? i : count - 1]));
  return values;
}

void hetab_two_reals(const hetab_engine *engine, double value, double two[2]) {
  two[0] = engine->precision == HETAB_FLOAT ? (double)(float)value : value;
  two[1] = value - two[0];
}

void hetab_wave_row(const hetab_engine *engine, const hetab_wave *wave, double *row) {
  hetab_two_reals(engine, wave->g, row + HETAB_WAVE_G);
  hetab_two_reals(engine, wave->x, row + HETAB_WAVE_X);
  row[HETAB_WAVE_AMPLITUDE] = wave->amplitude;
  row[HETAB_WAVE_E1] = wave->e1;
  row[HETAB_WAVE_NK] = wave->nk;
  row[HETAB_WAVE_DIFFUSE] = wave->diffuse_brdf;
}

void hetab_band_row(const hetab_engine *engine, const hetab_surface *surface,
                    const hetab_band *band, double *row) {
  hetab_wave wave =
      hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), band);
  hetab_wave_row(engine, &wave, row);
  row[HETAB_WAVE_FITTED] =
      hetab_fresnel_fit(band->n, band->k, FRESNEL_SHARE * engine->tolerance, row + HETAB_WAVE_FIT);
}

static void pair_row(const hetab_engine *engine, const hetab_pair *pair, double *row) {
  hetab_two_reals(engine, pair->mu2 * pair->ratio2, row + HETAB_PAIR_G);
  hetab_two_reals(engine, pair->d2, row + HETAB_PAIR_D2);
  row[HETAB_PAIR_P] = pair->p;
  row[HETAB_PAIR_MU2] = pair->mu2;
  row[HETAB_PAIR_SHADOW] = pair->shadow;
}

static double *wave_rows(hetab_context *ctx, const hetab_engine *engine,
                         const hetab_surface *surface) {
  size_t count = hetab_surface_band_count(surface);
  double *rows = hetab_alloc(ctx, count, HETAB_WAVE_REALS * sizeof *rows);
  for (size_t w = 0; rows && w < count; w++)
    hetab_band_row(engine, surface, &hetab_surface_bands(surface)[w], rows + w * HETAB_WAVE_REALS);
  return rows;
}

/* Two slabs per device are in memory, each at least one row of theta_i. */
static hetab_status check_row_size(hetab_context *ctx, const hetab_engine *engine,
                                   const hetab_dense *dense) {
  double bytes = (double)dense->count[HETAB_THETA_R] * (double)dense->count[HETAB_PHI] *
                 (double)hetab_real_size(engine);
  if (bytes <= (double)ROW_BYTES)
    return HETAB_OK;
  return hetab_fail(
      ctx, HETAB_ERR_RANGE,
      "%zu theta_r x %zu phi are %.0f MiB for each theta_i, over the %zu MiB that are "
      "held in memory at a time; use a coarser grid, or several tables",
      dense->count[HETAB_THETA_R], dense->count[HETAB_PHI], bytes / (1 << 20), ROW_BYTES >> 20);
}

/* theta_i rows per slab: as many as fit, at least one. */
static size_t slab_rows(const hetab_engine *engine, const hetab_dense *dense) {
  size_t row_bytes =
      dense->count[HETAB_THETA_R] * dense->count[HETAB_PHI] * hetab_real_size(engine);
  size_t by_bytes = SLAB_BYTES / row_bytes, by_rows = SLAB_ROWS / dense->count[HETAB_THETA_R];
  size_t rows = by_bytes < by_rows ? by_bytes : by_rows;
  rows = rows < dense->count[HETAB_THETA_I] ? rows : dense->count[HETAB_THETA_I];
  return rows ? rows : 1;
}

void hetab_engine_atlas_degrees(const hetab_engine *engine, hetab_atlas *atlas) {
  int width = 1;
  for (int i = 0; i < engine->lane_count; i++)
    width = width > engine->lanes[i].vector_width ? width : engine->lanes[i].vector_width;
  hetab_atlas_degrees(HETAB_ATLAS_SHARE * engine->tolerance, width, atlas);
}

hetab_status hetab_engine_atlas(hetab_context *ctx, const hetab_engine *engine, const double *waves,
                                size_t wave_count, double tau_2sigma, hetab_atlas *atlas) {
  double g_max = 0.0, g_min = HUGE_VAL, amplitude = 0.0;
  for (size_t w = 0; w < wave_count; w++) {
    const double *wave = waves + w * HETAB_WAVE_REALS;
    g_max = fmax(g_max, 4.0 * wave[HETAB_WAVE_G]);
    g_min = fmin(g_min, 4.0 * wave[HETAB_WAVE_G]);
    amplitude = fmax(amplitude, wave[HETAB_WAVE_AMPLITUDE]);
  }
  /* S / mu is at most sqrt(pi) tau_2sigma, at grazing, or of order 1 on steep surfaces */
  double largest = amplitude * 2.0 * fmax(1.0, M_PI * tau_2sigma * tau_2sigma);
  if (!atlas->degree_x) /* else set before the threads that read them */
    hetab_engine_atlas_degrees(engine, atlas);
  atlas->ln_h_end = fmin(log(ZERO_BELOW / largest), -1.0);
  return hetab_atlas_build(ctx, G_RANGE * g_min, g_max, HETAB_ATLAS_SHARE * engine->tolerance,
                           atlas);
}

hetab_status hetab_dense_create(hetab_context *ctx, const hetab_engine *engine,
                                const hetab_surface *surface, const hetab_grid *grid,
                                hetab_dense *dense) {
  HETAB_TRY(hetab_check_surface(ctx, surface));
  *dense = (hetab_dense){.surface = surface, .grid = grid, .g_least = HUGE_VAL};
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    dense->count[axis] = hetab_grid_count(grid, (hetab_axis)axis);
  dense->wavelength_count = hetab_surface_band_count(surface);
  dense->phi_padded = (dense->count[HETAB_PHI] + PAD - 1) / PAD * PAD;
  dense->theta_i = directions(ctx, surface, grid, HETAB_THETA_I);
  dense->theta_r = directions(ctx, surface, grid, HETAB_THETA_R);
  dense->one_plus_cos = padded_one_plus_cos(ctx, grid, dense->phi_padded);
  dense->waves = wave_rows(ctx, engine, surface);
  hetab_status status = HETAB_OK;
  if (!dense->theta_i || !dense->theta_r || !dense->one_plus_cos || !dense->waves)
    status = HETAB_ERR_MEMORY;
  dense->rows_i = slab_rows(engine, dense);
  if (status == HETAB_OK)
    status = check_row_size(ctx, engine, dense);
  dense->is_reciprocal =
      dense->count[HETAB_THETA_I] == dense->count[HETAB_THETA_R] &&
      memcmp(hetab_grid_deg(grid, HETAB_THETA_I), hetab_grid_deg(grid, HETAB_THETA_R),
             dense->count[HETAB_THETA_I] * sizeof(double)) == 0;
  hetab_engine_atlas_degrees(engine, &dense->atlas);
  if (status != HETAB_OK)
    hetab_dense_clear(dense);
  return status;
}

hetab_status hetab_dense_make_atlas(hetab_context *ctx, const hetab_engine *engine,
                                    hetab_dense *dense) {
  if (engine->method != HETAB_METHOD_ROWS)
    return HETAB_OK;
  HETAB_TRY(hetab_engine_atlas(ctx, engine, dense->waves, dense->wavelength_count,
                               hetab_tau_2sigma(dense->surface), &dense->atlas));
  dense->g_least = dense->atlas.panels[HETAB_PANEL_START];
  dense->wave_g_least = HUGE_VAL;
  for (size_t w = 0; w < dense->wavelength_count; w++)
    dense->wave_g_least =
        fmin(dense->wave_g_least, dense->waves[w * HETAB_WAVE_REALS + HETAB_WAVE_G]);
  return HETAB_OK;
}

void hetab_dense_clear(hetab_dense *dense) {
  free(dense->theta_i);
  free(dense->theta_r);
  free(dense->one_plus_cos);
  free(dense->waves);
  hetab_atlas_clear(&dense->atlas);
  *dense = (hetab_dense){0};
}

hetab_status hetab_dense_lane_create(hetab_context *ctx, const hetab_engine *engine,
                                     const hetab_lane *lane, const hetab_dense *dense,
                                     hetab_dense_kernel which, hetab_dense_lane *out) {
  static const char *const names[] = {"hetab_k_dense_rows", "hetab_k_dense_series",
                                      "hetab_k_dense_store"};
  hetab_build build = {.program = "dense",
                       .kernel = names[which],
                       .atlas = which == HETAB_DENSE_ROWS ? &dense->atlas : NULL,
                       .row_items = lane->shape->row_items};
  *out = (hetab_dense_lane){.lane = lane, .which = which};
  HETAB_TRY(hetab_lane_kernel(ctx, engine, lane, &build, &out->kernel));
  build.kernel = names[HETAB_DENSE_SERIES];
  return which != HETAB_DENSE_ROWS ? HETAB_OK
                                   : hetab_lane_kernel(ctx, engine, lane, &build, &out->series);
}

hetab_status hetab_dense_lane_load(hetab_context *ctx, const hetab_engine *engine,
                                   const hetab_dense *dense, hetab_dense_lane *l) {
  HETAB_TRY(hetab_lane_upload(ctx, engine, l->lane, dense->waves,
                              dense->wavelength_count * HETAB_WAVE_REALS, &l->waves));
  HETAB_TRY(hetab_lane_upload(ctx, engine, l->lane, dense->one_plus_cos, dense->phi_padded,
                              &l->one_plus_cos));
  const hetab_atlas *a = &dense->atlas;
  return l->which != HETAB_DENSE_ROWS
             ? HETAB_OK
             : hetab_lane_upload_atlas(ctx, engine, l->lane, a, a->coefficients,
                                       (size_t)a->degree_g * (size_t)a->pad_x, &l->atlas);
}

void hetab_dense_lane_clear(hetab_dense_lane *l) {
  cl_mem *const buffers[] = {&l->waves, &l->one_plus_cos, &l->pairs, &l->rows, &l->low_rows};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
    hetab_release(*buffers[i]);
  hetab_atlas_release(&l->atlas);
  if (l->kernel)
    clReleaseKernel(l->kernel);
  if (l->series)
    clReleaseKernel(l->series);
  *l = (hetab_dense_lane){0};
}

static hetab_status upload_pairs(hetab_context *ctx, const hetab_engine *engine,
                                 const hetab_dense *dense, hetab_dense_lane *l) {
  size_t per_row = dense->count[HETAB_THETA_R];
  HETAB_FREED double *reals =
      hetab_alloc(ctx, l->count * per_row, HETAB_PAIR_REALS * sizeof *reals);
  HETAB_NEED(reals);
  for (size_t i = 0; i < l->count; i++)
    for (size_t r = 0; r < per_row; r++) {
      hetab_pair pair = hetab_pair_of(&dense->theta_i[l->first + i], &dense->theta_r[r]);
      pair_row(engine, &pair, reals + (i * per_row + r) * HETAB_PAIR_REALS);
    }
  return hetab_lane_upload(ctx, engine, l->lane, reals, l->count * per_row * HETAB_PAIR_REALS,
                           &l->pairs);
}

/* A row (i, r) of the slab: its number and its mirror image's, or -1; 0 if that one comes first. */
static int row_numbers(const hetab_dense *dense, const hetab_dense_lane *l, size_t i, size_t r,
                       cl_int numbers[2]) {
  size_t per_row = dense->count[HETAB_THETA_R];
  int in_slab = dense->is_reciprocal && r >= l->first && r < l->first + l->count;
  numbers[0] = (cl_int)(i * per_row + r);
  numbers[1] = in_slab ? (cl_int)((r - l->first) * per_row + l->first + i) : -1;
  return !in_slab || r >= l->first + i;
}

/* Whether g lies below the atlas at some wavelength; the kernels say at which. */
static int is_low(const hetab_dense *dense, const hetab_dense_lane *l, size_t i, size_t r) {
  hetab_pair pair = hetab_pair_of(&dense->theta_i[l->first + i], &dense->theta_r[r]);
  return pair.mu2 * pair.ratio2 * dense->wave_g_least < (1.0 + 1e-6) * dense->g_least;
}

/* The rows to compute, and those of them that the series takes. */
static hetab_status upload_rows(hetab_context *ctx, const hetab_dense *dense, hetab_dense_lane *l) {
  size_t per_row = dense->count[HETAB_THETA_R];
  HETAB_FREED cl_int(*rows)[2] = hetab_alloc(ctx, l->count * per_row, sizeof *rows);
  HETAB_FREED cl_int(*low)[2] = hetab_alloc(ctx, l->count * per_row, sizeof *low);
  HETAB_NEED(rows && low);
  l->row_count = l->low_count = 0;
  for (size_t i = 0; i < l->count; i++)
    for (size_t r = 0; r < per_row; r++) {
      if (!row_numbers(dense, l, i, r, rows[l->row_count]))
        continue;
      if (l->series && is_low(dense, l, i, r))
        memcpy(low[l->low_count++], rows[l->row_count], sizeof *low);
      l->row_count++;
    }
  HETAB_TRY(hetab_lane_upload_bytes(ctx, l->lane, rows, l->row_count * sizeof *rows, &l->rows));
  if (!l->low_count)
    return HETAB_OK;
  return hetab_lane_upload_bytes(ctx, l->lane, low, l->low_count * sizeof *low, &l->low_rows);
}

/* What some theta_i rows need; kept while the same rows are asked for again, as they are for every
 * wavelength. */
static hetab_status load_rows(hetab_context *ctx, const hetab_engine *engine,
                              const hetab_dense *dense, hetab_dense_lane *l, size_t first,
                              size_t count) {
  if (l->rows && l->first == first && l->count == count)
    return HETAB_OK;
  hetab_release(l->pairs);
  hetab_release(l->rows);
  hetab_release(l->low_rows);
  l->pairs = l->rows = l->low_rows = NULL;
  l->first = first;
  l->count = count;
  HETAB_TRY(upload_pairs(ctx, engine, dense, l));
  return upload_rows(ctx, dense, l);
}

static void set_inputs(hetab_args *args, const hetab_dense *dense, const hetab_dense_lane *l,
                       cl_mem rows, size_t row_count, size_t wavelength, cl_mem out) {
  hetab_arg_mem(args, rows);
  hetab_arg_int(args, row_count);
  hetab_arg_mem(args, l->waves);
  hetab_arg_int(args, wavelength);
  hetab_arg_mem(args, l->pairs);
  hetab_arg_mem(args, l->one_plus_cos);
  hetab_arg_int(args, dense->count[HETAB_PHI]);
  hetab_arg_mem(args, out);
}

/* Rows whose g is below the atlas; all of them where there is none. */
static hetab_status run_series(hetab_args *args, const hetab_dense *dense,
                               const hetab_dense_lane *l, cl_mem rows, size_t row_count,
                               size_t wavelength, cl_mem out, cl_event *done) {
  set_inputs(args, dense, l, rows, row_count, wavelength, out);
  hetab_arg_real(args, dense->g_least);
  return hetab_lane_run_rows(args, row_count, l->lane->shape->row_items, done);
}

static hetab_status run_atlas(hetab_args *args, const hetab_dense *dense, const hetab_dense_lane *l,
                              size_t wavelength, cl_mem out, cl_event *done) {
  set_inputs(args, dense, l, l->rows, l->row_count, wavelength, out);
  hetab_arg_mem(args, l->atlas.panels);
  hetab_arg_mem(args, l->atlas.segments);
  hetab_arg_mem(args, l->atlas.coefficients);
  hetab_arg_int(args, dense->atlas.panel_count);
  hetab_arg_int(args, (size_t)dense->atlas.first_panel);
  return hetab_lane_run_rows(args, l->row_count, l->lane->shape->row_items, done);
}

static hetab_status run_store(hetab_args *args, const hetab_dense *dense, const hetab_lane *lane,
                              size_t count, cl_mem out, cl_event *done) {
  size_t rows = count * dense->count[HETAB_THETA_R];
  hetab_arg_int(args, rows);
  hetab_arg_int(args, dense->count[HETAB_PHI]);
  hetab_arg_mem(args, out);
  return hetab_lane_run_rows(args, rows, lane->shape->row_items, done);
}

hetab_status hetab_dense_run(hetab_context *ctx, const hetab_engine *engine,
                             const hetab_dense *dense, hetab_dense_lane *l, size_t wavelength,
                             size_t first, size_t count, cl_mem out, cl_event done[2]) {
  hetab_args args = {ctx, engine, l->lane, l->kernel, 0, HETAB_OK};
  hetab_args series = {ctx, engine, l->lane, l->series, 0, HETAB_OK};
  cl_event *second = done ? &done[1] : NULL;
  if (l->which == HETAB_DENSE_STORE)
    return run_store(&args, dense, l->lane, count, out, done);
  HETAB_TRY(load_rows(ctx, engine, dense, l, first, count));
  if (l->which == HETAB_DENSE_SERIES)
    return run_series(&args, dense, l, l->rows, l->row_count, wavelength, out, done);
  HETAB_TRY(run_atlas(&args, dense, l, wavelength, out, done));
  return l->low_count
             ? run_series(&series, dense, l, l->low_rows, l->low_count, wavelength, out, second)
             : HETAB_OK;
}

double hetab_dense_literal(const hetab_dense *dense, size_t wavelength, size_t i, size_t r,
                           size_t p) {
  const hetab_band *band = &hetab_surface_bands(dense->surface)[wavelength];
  hetab_point point = {.lambda_um = band->lambda_um,
                       .theta_i = dense->theta_i[i].theta,
                       .theta_r = dense->theta_r[r].theta,
                       .phi = hetab_radians(hetab_grid_deg(dense->grid, HETAB_PHI)[p]),
                       .sigma0_um = hetab_surface_sigma0_um(dense->surface),
                       .tau_um = hetab_surface_tau_um(dense->surface),
                       .n = band->n,
                       .k = band->k,
                       .diffuse_brdf = band->diffuse_brdf};
  return hetab_literal(&point).total;
}
