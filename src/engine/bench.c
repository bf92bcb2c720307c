/* Speed against error: every method over the same grid, the literal loop and a store-only kernel
 * measured beside them in the same run. */
#include <hetab/bench.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cl/device.h"
#include "core/number.h"
#include "core/option_size.h"
#include "core/clock.h"
#include "core/random.h"
#include "engine/dense.h"
#include "kernels/tables.h"

HETAB_HANDLE(hetab_engine)
HETAB_HANDLE(hetab_grid)

enum { DEFAULT_SAMPLES = 20000, DEFAULT_REPEATS = 5, MOST_REPEATS = 64, LITERAL_ENTRIES = 20000 };
/* Short runs are repeated for this long: a machine's slow moments last longer than a few of them.
 */
static const double ENOUGH_SECONDS = 0.6;

typedef struct bench {
  hetab_context *ctx;
  const hetab_surface *surface;
  const hetab_bench_options *options;
  hetab_grid *grid;
  double literal, store; /* entries per second */
  double peak;           /* multiply-adds per second */
  hetab_bench_fn fn;
  void *user;
} bench;

static double median(double *values, size_t count) {
  hetab_sort(values, count);
  return values[count / 2];
}

/* Runs of one thing. */
typedef struct timing {
  double rates[MOST_REPEATS];
  size_t count;
  double seconds;
} timing;

static int wants_more(const bench *b, const timing *t) {
  size_t asked = b->options->repeats;
  if (t->count == MOST_REPEATS)
    return 0;
  return asked ? t->count < asked : t->count < DEFAULT_REPEATS || t->seconds < ENOUGH_SECONDS;
}

/* One run more, of so many things, which started at `start`. */
static hetab_status add_run(const bench *b, timing *t, double things, double start) {
  double seconds = hetab_seconds() - start;
  t->rates[t->count++] = things / seconds;
  t->seconds += seconds;
  return hetab_progress(b->ctx, (double)t->count, MOST_REPEATS);
}

static void emit(const bench *b, hetab_bench_row row) {
  row.ratio_to_literal = row.entries_per_second / b->literal;
  row.ratio_to_store = b->store > 0.0 ? row.entries_per_second / b->store : 0.0;
  row.ratio_to_peak =
      b->peak > 0.0 ? row.entries_per_second * row.operations_per_entry / b->peak : 0.0;
  b->fn(b->user, hetab_surface_name(b->surface), &row);
}

/* The printed equations in double on one core, at random entries of the table. */
static hetab_status time_literal(bench *b) {
  hetab_engine_options options = {.method = HETAB_METHOD_LITERAL};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  hetab_dense dense = {0};
  timing timing = {0};
  double sum = 0.0;
  HETAB_TRY(hetab_engine_create(b->ctx, &options, &engine));
  hetab_status status = hetab_dense_create(b->ctx, engine, b->surface, b->grid, &dense);
  while (status == HETAB_OK && wants_more(b, &timing)) {
    uint64_t state = timing.count;
    double start = hetab_seconds();
    for (int i = 0; i < LITERAL_ENTRIES; i++)
      sum += hetab_dense_literal(&dense, hetab_random(&state) % dense.wavelength_count,
                                 hetab_random(&state) % dense.count[HETAB_THETA_I],
                                 hetab_random(&state) % dense.count[HETAB_THETA_R],
                                 hetab_random(&state) % dense.count[HETAB_PHI]);
    status = add_run(b, &timing, LITERAL_ENTRIES, start);
  }
  hetab_dense_clear(&dense);
  if (status == HETAB_OK) {
    b->literal = median(timing.rates, timing.count);
    /* the sum keeps the loop from being optimised away */
    emit(b, (hetab_bench_row){.method = "literal",
                              .precision = "double",
                              .entries_per_second = sum >= 0.0 ? b->literal : 0.0});
  }
  return status;
}

/* A slab of every wavelength, one after the other into the same place. */
static hetab_status run_spectrum(hetab_context *ctx, const hetab_engine *engine,
                                 const hetab_dense *dense, hetab_dense_lane *lane, cl_mem out) {
  for (size_t w = 0; w < dense->wavelength_count; w++)
    HETAB_TRY(hetab_dense_run(ctx, engine, dense, lane, w, 0, dense->rows_i, out, NULL));
  return hetab_lane_finish(ctx, lane->lane);
}

/* Median over the repeats of the time that all wavelengths take in the kernel alone. */
static hetab_status time_kernel(bench *b, const hetab_engine *engine, hetab_dense_kernel which,
                                double *entries_per_second) {
  HETAB_ENDS(hetab_dense_clear) hetab_dense dense = {0};
  HETAB_ENDS(hetab_dense_lane_clear) hetab_dense_lane lane = {0};
  HETAB_ENDS(hetab_output_free) hetab_output out = {0};
  timing timing = {0};
  HETAB_TRY(hetab_dense_create(b->ctx, engine, b->surface, b->grid, &dense));
  HETAB_TRY(hetab_dense_make_atlas(b->ctx, engine, &dense));
  size_t rows = dense.rows_i;
  double entries = (double)rows * (double)dense.count[HETAB_THETA_R] *
                   (double)dense.count[HETAB_PHI] * (double)dense.wavelength_count;
  HETAB_TRY(hetab_dense_lane_create(b->ctx, engine, &engine->lanes[0], &dense, which, &lane));
  HETAB_TRY(hetab_dense_lane_load(b->ctx, engine, &dense, &lane));
  HETAB_TRY(hetab_output_create(b->ctx, engine, lane.lane,
                                rows * dense.count[HETAB_THETA_R] * dense.count[HETAB_PHI], &out));
  HETAB_TRY(run_spectrum(b->ctx, engine, &dense, &lane, out.buffer)); /* warm-up */
  while (wants_more(b, &timing)) {
    double start = hetab_seconds();
    HETAB_TRY(run_spectrum(b->ctx, engine, &dense, &lane, out.buffer));
    HETAB_TRY(add_run(b, &timing, entries, start));
  }
  *entries_per_second = median(timing.rates, timing.count);
  return HETAB_OK;
}

/* Vector operations of one entry of the rows method, counted in kernels/dense.cl and what it calls:
 * 47 (x, Fresnel fitted, exp, the product) and the atlas's polynomial; a mirror image is free. */
static double rows_operations(const hetab_engine *engine) {
  hetab_atlas atlas;
  hetab_atlas_degrees(HETAB_ATLAS_SHARE * engine->tolerance, 1, &atlas);
  return 0.5 * (47.0 + atlas.degree_x);
}

static hetab_status bench_method(bench *b, hetab_precision precision, hetab_method method,
                                 double tolerance) {
  hetab_engine_options options = {.devices = b->options->devices,
                                  .precision = precision,
                                  .method = method,
                                  .tolerance = tolerance};
  hetab_tabulate_options sampling = {.samples = b->options->samples ? b->options->samples
                                                                    : DEFAULT_SAMPLES};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  hetab_report report = {0};
  double rate = 0.0;
  HETAB_TRY(hetab_engine_create(b->ctx, &options, &engine));
  HETAB_TRY(time_kernel(
      b, engine, method == HETAB_METHOD_ROWS ? HETAB_DENSE_ROWS : HETAB_DENSE_SERIES, &rate));
  HETAB_TRY(hetab_tabulate(b->ctx, engine, b->surface, b->grid, &sampling, NULL, NULL, &report));
  emit(b, (hetab_bench_row){.method = hetab_method_name(method),
                            .precision = hetab_precision_name(precision),
                            .tolerance = tolerance,
                            .entries_per_second = rate,
                            .operations_per_entry =
                                method == HETAB_METHOD_ROWS ? rows_operations(engine) : 0.0,
                            .error = report.error});
  return HETAB_OK;
}

/* What arrives in the host's memory: the whole call, over grids refined until it takes a while. */
static hetab_status time_delivered(bench *b, hetab_precision precision, double tolerance) {
  hetab_engine_options options = {.devices = b->options ? b->options->devices : NULL,
                                  .precision = precision,
                                  .tolerance = tolerance};
  hetab_tabulate_options unsampled = {.samples = 0};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  HETAB_ENDS(hetab_grid_end) hetab_grid *grid = NULL;
  hetab_report report = {0};
  HETAB_TRY(hetab_engine_create(b->ctx, &options, &engine));
  HETAB_TRY(hetab_grid_create(b->ctx, &grid));
  for (int count = 90; report.wall_seconds < ENOUGH_SECONDS && count < 24000; count *= 4) {
    char axis[32];
    snprintf(axis, sizeof axis, "0:90:%d", count);
    HETAB_TRY(hetab_grid_set_axis(b->ctx, grid, HETAB_THETA_I, axis));
    HETAB_TRY(hetab_tabulate(b->ctx, engine, b->surface, grid, &unsampled, NULL, NULL, &report));
  }
  emit(b, (hetab_bench_row){.method = "delivered",
                            .precision = hetab_precision_name(precision),
                            .tolerance = tolerance,
                            .entries_per_second = report.entries / report.wall_seconds});
  return HETAB_OK;
}

static hetab_status run_peak(hetab_context *ctx, const hetab_engine *engine, cl_kernel kernel,
                             cl_mem out, size_t items, size_t rounds, double *seconds) {
  const hetab_lane *lane = &engine->lanes[0];
  hetab_args args = {ctx, engine, lane, kernel, 0, HETAB_OK};
  hetab_arg_int(&args, rounds);
  hetab_arg_real(&args, 0.5);
  hetab_arg_mem(&args, out);
  double start = hetab_seconds();
  HETAB_TRY(hetab_lane_run(&args, items, 1, NULL));
  HETAB_TRY(hetab_lane_finish(ctx, lane));
  *seconds = hetab_seconds() - start;
  return HETAB_OK;
}

/* The device's multiply-add rate: the best of the repeats, for it is a ceiling. */
static hetab_status time_peak(bench *b, const hetab_engine *engine) {
  enum { ITEMS = 2048 /* a compute unit */, ROUNDS = 4096 };
  const hetab_lane *lane = &engine->lanes[0];
  timing timing = {0};
  cl_kernel kernel = NULL;
  hetab_output out = {0};
  hetab_status status;
  double best = 0.0, seconds, width = lane->vector_width;
  size_t items = ITEMS * hetab_cl_device_uint(lane->device, CL_DEVICE_MAX_COMPUTE_UNITS);
  HETAB_GOTO(hetab_lane_kernel(
      b->ctx, engine, lane, &(hetab_build){.program = "peak", .kernel = "hetab_k_peak"}, &kernel));
  HETAB_GOTO(hetab_output_create(b->ctx, engine, lane, items * (size_t)lane->vector_width, &out));
  HETAB_GOTO(run_peak(b->ctx, engine, kernel, out.buffer, items, ROUNDS, &seconds)); /* warm-up */
  while (wants_more(b, &timing)) {
    double operations = width * (double)items * ROUNDS * HETAB_PEAK_CHAINS;
    double start = hetab_seconds();
    HETAB_GOTO(run_peak(b->ctx, engine, kernel, out.buffer, items, ROUNDS, &seconds));
    HETAB_GOTO(add_run(b, &timing, operations, start));
    best = fmax(best, operations / seconds);
  }
  b->peak = best;
done:
  if (kernel)
    clReleaseKernel(kernel);
  hetab_output_free(&out);
  return status;
}

static hetab_status time_baselines(bench *b, hetab_precision precision) {
  hetab_engine_options options = {
      .devices = b->options->devices, .precision = precision, .method = HETAB_METHOD_SERIES};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  HETAB_TRY(hetab_engine_create(b->ctx, &options, &engine));
  HETAB_TRY(time_peak(b, engine));
  HETAB_TRY(time_kernel(b, engine, HETAB_DENSE_STORE, &b->store));
  emit(b, (hetab_bench_row){.method = "peak",
                            .precision = hetab_precision_name(precision),
                            .entries_per_second = b->peak,
                            .operations_per_entry = 1.0});
  emit(b, (hetab_bench_row){.method = "store",
                            .precision = hetab_precision_name(precision),
                            .entries_per_second = b->store});
  return HETAB_OK;
}

static hetab_status bench_precision(bench *b, hetab_precision precision) {
  static const double float_tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5};
  static const double double_tolerances[] = {1e-6, 1e-8, 1e-9, 1e-10};
  const double *tolerances = precision == HETAB_FLOAT ? float_tolerances : double_tolerances;
  HETAB_TRY(time_baselines(b, precision));
  for (int t = 0; t < 4; t++)
    HETAB_TRY(bench_method(b, precision, HETAB_METHOD_ROWS, tolerances[t]));
  if (precision == HETAB_FLOAT)
    HETAB_TRY(time_delivered(b, precision, tolerances[3]));
  return bench_method(b, precision, HETAB_METHOD_SERIES, 0.0);
}

hetab_status hetab_bench(hetab_context *ctx, const hetab_surface *surface,
                         const hetab_bench_options *options, hetab_bench_fn fn, void *user) {
  HETAB_OPTIONS(ctx, hetab_bench_options, o, options);
  bench b = {.ctx = ctx, .surface = surface, .options = &o, .fn = fn, .user = user};
  HETAB_TRY(hetab_grid_create(ctx, &b.grid));
  hetab_status status = time_literal(&b);
  if (status == HETAB_OK)
    status = bench_precision(&b, HETAB_FLOAT);
  if (status == HETAB_OK)
    status = bench_precision(&b, HETAB_DOUBLE);
  if (status == HETAB_ERR_UNSUPPORTED) /* a device without fp64: the float rows stand */
    status = HETAB_OK;
  hetab_grid_free(b.grid);
  return status;
}
