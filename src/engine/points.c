/* Points: angles become the kernels' columns in double, so that nothing cancels in float. */
#include "engine/points.h"

#include <hetab/evaluate.h>

#include <stdlib.h>
#include <string.h>

#include "engine/dense.h"
#include "engine/engine_internal.h"
#include "kernels/tables.h"
#include "model/limits.h"
#include "model/model.h"

enum { BATCH = 1 << 16 /* of values that cross the bus */, PAD = 16 /* the widest vector */ };

/* Columns [...][stride] of up to `stride` points, in and out of a kernel. */
typedef struct columns {
  double *in;
  size_t count, stride;
} columns;

static columns columns_of(double *in, size_t count) {
  return (columns){in, count, (count + PAD - 1) / PAD * PAD};
}

static void set_column(const columns *c, size_t slot, size_t i, double value) {
  c->in[slot * c->stride + i] = value;
}

/* The padding repeats the last point. */
static void pad(const columns *c, size_t slots) {
  for (size_t slot = 0; slot < slots; slot++)
    for (size_t i = c->count; i < c->stride; i++)
      set_column(c, slot, i, c->in[slot * c->stride + c->count - 1]);
}

static void set_place(const columns *c, size_t i, const hetab_direction *in,
                      const hetab_direction *out, double phi) {
  hetab_pair pair = hetab_pair_of(in, out);
  set_column(c, HETAB_PLACE_MU2, i, pair.mu2);
  set_column(c, HETAB_PLACE_LATERAL2, i, pair.d2 + pair.p * hetab_one_plus_cos(phi));
  set_column(c, HETAB_PLACE_SHADOW, i, pair.shadow);
  set_column(c, HETAB_PLACE_RATIO2, i, pair.ratio2);
}

/* Takes what the kernel has left in its output. */
typedef void (*take_fn)(void *user, const hetab_engine *engine, const void *results);

/* The kernel's arguments so far, the columns, their stride, the output; over the points in vectors
 * and `planes`. */
static hetab_status run(hetab_args *args, const columns *c, size_t slots, size_t results,
                        size_t planes, take_fn take, void *user) {
  const hetab_engine *engine = args->engine;
  const hetab_lane *lane = args->lane;
  cl_mem in = NULL;
  hetab_output out = {0};
  hetab_status status;
  pad(c, slots);
  HETAB_GOTO(hetab_lane_upload(args->ctx, engine, lane, c->in, c->stride * slots, &in));
  HETAB_GOTO(hetab_output_create(args->ctx, engine, lane, c->stride * results, &out));
  hetab_arg_mem(args, in);
  hetab_arg_int(args, c->stride);
  hetab_arg_mem(args, out.buffer);
  HETAB_GOTO(hetab_lane_run(args, c->stride / (size_t)lane->vector_width, planes, NULL));
  HETAB_GOTO(hetab_output_fetch(args->ctx, engine, c->stride * results, &out));
  HETAB_GOTO(hetab_output_wait(args->ctx, &out));
  take(user, engine, out.values);
done:
  hetab_release(in);
  hetab_output_free(&out);
  return status;
}

/* ---- points of waves of their own ---------------------------------------------------------- */

static void set_point(const columns *c, size_t i, const hetab_point *p) {
  double tau_2sigma = p->tau_um / (2.0 * p->sigma0_um);
  hetab_direction in = hetab_direction_at(p->theta_i, tau_2sigma);
  hetab_direction out = hetab_direction_at(p->theta_r, tau_2sigma);
  hetab_band band = {p->lambda_um, p->n, p->k, p->diffuse_brdf};
  hetab_wave wave = hetab_wave_of(p->sigma0_um, p->tau_um, &band);
  double s = in.shadow_over_cos * in.mu;
  set_place(c, i, &in, &out, p->phi);
  set_column(c, HETAB_POINT_WAVE_G, i, wave.g);
  set_column(c, HETAB_POINT_WAVE_X, i, wave.x);
  set_column(c, HETAB_POINT_AMPLITUDE, i, wave.amplitude);
  set_column(c, HETAB_POINT_E1, i, wave.e1);
  set_column(c, HETAB_POINT_NK, i, wave.nk);
  set_column(c, HETAB_POINT_MU_I, i, in.mu);
  set_column(c, HETAB_POINT_SPECULAR_SHADOW2, i, s * s);
  set_column(c, HETAB_POINT_SPECULAR_RATIO2, i, hetab_pair_of(&in, &in).ratio2);
}

/* Some points and where their values go. */
typedef struct batch {
  columns columns;
  const hetab_point *points;
  hetab_value *values;
} batch;

static void take_points(void *user, const hetab_engine *engine, const void *results) {
  const batch *b = user;
  size_t stride = b->columns.stride;
  for (size_t i = 0; i < b->columns.count; i++) {
    hetab_value *value = &b->values[i];
    *value = (hetab_value){.dd = hetab_real_at(engine, results, HETAB_RESULT_DD * stride + i),
                           .specular =
                               hetab_real_at(engine, results, HETAB_RESULT_SPECULAR * stride + i),
                           .ud = b->points[i].diffuse_brdf,
                           .g = hetab_real_at(engine, results, HETAB_RESULT_G * stride + i),
                           .x = hetab_real_at(engine, results, HETAB_RESULT_X * stride + i)};
    value->total = value->dd + value->ud;
  }
}

static hetab_status run_batches(hetab_context *ctx, const hetab_engine *engine, cl_kernel kernel,
                                const hetab_point *points, size_t count, hetab_value *values) {
  HETAB_FREED double *in = hetab_alloc(ctx, (size_t)BATCH * HETAB_POINT_REALS, sizeof *in);
  HETAB_NEED(in);
  for (size_t first = 0; first < count; first += BATCH) {
    batch b = {columns_of(in, count - first < BATCH ? count - first : BATCH), points + first,
               values + first};
    hetab_args args = {ctx, engine, &engine->lanes[0], kernel, 0, HETAB_OK};
    for (size_t i = 0; i < b.columns.count; i++)
      set_point(&b.columns, i, &b.points[i]);
    HETAB_TRY(run(&args, &b.columns, HETAB_POINT_REALS, HETAB_RESULT_REALS, 1, take_points, &b));
    HETAB_TRY(hetab_progress(ctx, (double)(first + b.columns.count), (double)count));
  }
  return HETAB_OK;
}

hetab_status hetab_evaluate(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, hetab_value *values) {
  cl_kernel kernel;
  HETAB_TRY(hetab_check_points(ctx, points, count));
  if (engine->method == HETAB_METHOD_LITERAL)
    return hetab_evaluate_literal(ctx, points, count, values);
  HETAB_TRY(hetab_lane_kernel(ctx, engine, &engine->lanes[0],
                              &(hetab_build){.program = "points", .kernel = "hetab_k_points"},
                              &kernel));
  hetab_status status = run_batches(ctx, engine, kernel, points, count, values);
  clReleaseKernel(kernel);
  return status;
}

/* ---- one surface's waves at many places ---------------------------------------------------- */

struct hetab_places {
  const hetab_engine *engine;
  cl_kernel kernel;
  double *in; /* columns of a batch */
};

hetab_status hetab_places_create(hetab_context *ctx, const hetab_engine *engine,
                                 hetab_places **out) {
  *out = NULL;
  if (engine->method == HETAB_METHOD_LITERAL)
    return hetab_fail(
        ctx, HETAB_ERR_UNSUPPORTED,
        "fits and tables of points run on a device: create the engine with the series "
        "method");
  hetab_places *places = hetab_alloc(ctx, 1, sizeof *places);
  HETAB_NEED(places);
  places->engine = engine;
  places->in = hetab_alloc(ctx, (size_t)BATCH * HETAB_PLACE_REALS, sizeof *places->in);
  hetab_build build = {.program = "points", .kernel = "hetab_k_places"};
  *out = places;
  HETAB_MADE(hetab_places, out,
             places->in ? hetab_lane_kernel(ctx, engine, &engine->lanes[0], &build, &places->kernel)
                        : HETAB_ERR_MEMORY);
}

void hetab_places_free(hetab_places *places) {
  if (!places)
    return;
  if (places->kernel)
    clReleaseKernel(places->kernel);
  free(places->in);
  free(places);
}

/* From the kernel's [plane][stride] to the caller's [point][plane]. */
typedef struct planes {
  size_t count, stride, points;
  double *values;
} planes;

static void take_planes(void *user, const hetab_engine *engine, const void *results) {
  const planes *p = user;
  for (size_t i = 0; i < p->points; i++)
    for (size_t n = 0; n < p->count; n++)
      p->values[i * p->count + n] = hetab_real_at(engine, results, n * p->stride + i);
}

static hetab_status upload_waves(hetab_context *ctx, const hetab_engine *engine, double sigma0_um,
                                 double tau_um, const hetab_band *bands, size_t count,
                                 const double (*weights)[3], cl_mem *out) {
  HETAB_FREED double *rows = hetab_alloc(ctx, count, HETAB_WAVE_REALS * sizeof *rows);
  HETAB_NEED(rows);
  for (size_t b = 0; b < count; b++) {
    double *row = rows + b * HETAB_WAVE_REALS;
    hetab_wave wave = hetab_wave_of(sigma0_um, tau_um, &bands[b]);
    hetab_wave_row(engine, &wave, row);
    if (weights)
      memcpy(row + HETAB_WAVE_WEIGHTS, weights[b], sizeof weights[b]);
  }
  return hetab_lane_upload(ctx, engine, &engine->lanes[0], rows, count * HETAB_WAVE_REALS, out);
}

hetab_status hetab_places_evaluate(hetab_context *ctx, hetab_places *places, double sigma0_um,
                                   double tau_um, const hetab_band *bands, size_t band_count,
                                   const double (*weights)[3], const hetab_directions *at,
                                   size_t count, double *values) {
  const hetab_engine *engine = places->engine;
  double tau_2sigma = tau_um / (2.0 * sigma0_um);
  size_t results = weights ? HETAB_CHANNELS : band_count;
  size_t most = results < BATCH ? BATCH / results : 1;
  cl_mem waves = NULL;
  hetab_status status;
  HETAB_GOTO(upload_waves(ctx, engine, sigma0_um, tau_um, bands, band_count, weights, &waves));
  for (size_t first = 0; first < count; first += most) {
    columns c = columns_of(places->in, count - first < most ? count - first : most);
    for (size_t i = 0; i < c.count; i++) {
      const hetab_directions *d = &at[first + i];
      hetab_direction in = hetab_direction_at(d->theta_i, tau_2sigma);
      hetab_direction out = hetab_direction_at(d->theta_r, tau_2sigma);
      set_place(&c, i, &in, &out, d->phi);
    }
    hetab_args args = {ctx, engine, &engine->lanes[0], places->kernel, 0, HETAB_OK};
    hetab_arg_mem(&args, waves);
    hetab_arg_int(&args, band_count);
    hetab_arg_int(&args, weights != NULL);
    planes p = {results, c.stride, c.count, values + first * results};
    HETAB_GOTO(
        run(&args, &c, HETAB_PLACE_REALS, results, weights ? 1 : band_count, take_planes, &p));
  }
done:
  hetab_release(waves);
  return status;
}
