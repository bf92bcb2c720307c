/* Dense tables: every entry finite and not negative, the error against the literal reference, odd
 * grids, several devices, cancellation, sinks. */
#include "golden_support.h"

#include <time.h>

/* --- a sink that checks ---------------------------------------------------------------------- */

enum { SAMPLES = 100000, MIRROR_SAMPLES = 5000 };

typedef struct checker {
  const hetab_surface *surface;
  const hetab_grid *grid;
  hetab_precision precision;
  size_t samples;      /* random entries to compare over the whole table */
  unsigned char *seen; /* [wavelength][theta_i], times delivered */
  double *all;         /* the whole table, if wanted: [wavelength][theta_i][theta_r][phi] */
  size_t bad, slabs;
  double total;
  uint64_t random;
  worst error, mirror; /* random entries; entries about the mirror direction */
  hetab_point worst_point;
} checker;

static size_t count_of(const checker *c, hetab_axis axis) {
  return hetab_grid_count(c->grid, axis);
}

static checker new_checker(const hetab_surface *surface, const hetab_grid *grid,
                           hetab_precision precision, size_t samples) {
  checker c = {
      .surface = surface, .grid = grid, .precision = precision, .samples = samples, .random = 97};
  size_t rows = hetab_surface_band_count(surface) * count_of(&c, HETAB_THETA_I);
  c.seen = calloc(rows, 1);
  c.total = (double)rows * (double)count_of(&c, HETAB_THETA_R) * (double)count_of(&c, HETAB_PHI);
  return c;
}

static double slab_value(const checker *c, const hetab_slab *slab, size_t at) {
  return c->precision == HETAB_DOUBLE ? ((const double *)slab->values)[at]
                                      : (double)((const float *)slab->values)[at];
}

static hetab_point point_at(const checker *c, size_t wavelength, size_t i, size_t r, size_t p) {
  const hetab_band *band = &hetab_surface_bands(c->surface)[wavelength];
  return (hetab_point){.lambda_um = band->lambda_um,
                       .n = band->n,
                       .k = band->k,
                       .diffuse_brdf = band->diffuse_brdf,
                       .sigma0_um = hetab_surface_sigma0_um(c->surface),
                       .tau_um = hetab_surface_tau_um(c->surface),
                       .theta_i = hetab_grid_deg(c->grid, HETAB_THETA_I)[i] / 180 * M_PI,
                       .theta_r = hetab_grid_deg(c->grid, HETAB_THETA_R)[r] / 180 * M_PI,
                       .phi = hetab_grid_deg(c->grid, HETAB_PHI)[p] / 180 * M_PI};
}

static void compare(hetab_context *ctx, checker *c, const hetab_slab *slab, size_t at, worst *w) {
  size_t phis = count_of(c, HETAB_PHI), rs = count_of(c, HETAB_THETA_R);
  hetab_point point = point_at(c, slab->wavelength, slab->theta_i_first + at / phis / rs,
                               at / phis % rs, at % phis);
  hetab_value value;
  double before = w->relative;
  assert_ok(ctx, hetab_evaluate_literal(ctx, &point, 1, &value));
  worst_add(w, at, slab_value(c, slab, at), value.total);
  if (w->relative > before && w == &c->error)
    c->worst_point = point;
}

static hetab_status check_slab(hetab_context *ctx, void *user, const hetab_slab *slab) {
  checker *c = user;
  size_t phis = count_of(c, HETAB_PHI), rs = count_of(c, HETAB_THETA_R), r_mirror = 0;
  size_t entries = slab->theta_i_count * rs * phis;
  for (size_t i = 0; i < slab->theta_i_count; i++)
    c->seen[slab->wavelength * count_of(c, HETAB_THETA_I) + slab->theta_i_first + i]++;
  for (size_t at = 0; at < entries; at++) {
    double value = slab_value(c, slab, at);
    c->bad += !(value >= 0 && value < 1e300);
  }
  double share = (double)entries / c->total;
  for (double s = uniform(&c->random, 0, 1); s < share * (double)c->samples; s++)
    compare(ctx, c, slab, (size_t)uniform(&c->random, 0, (double)entries), &c->error);
  for (double s = uniform(&c->random, 0, 1); c->samples && s < share * MIRROR_SAMPLES; s++) {
    size_t i = (size_t)uniform(&c->random, 0, (double)slab->theta_i_count);
    size_t off = (size_t)uniform(&c->random, 0, 5), back = (size_t)uniform(&c->random, 0, 12);
    r_mirror = slab->theta_i_first + i + off;
    r_mirror = r_mirror < 2 ? 0 : r_mirror - 2;
    if (r_mirror < rs && back < phis)
      compare(ctx, c, slab, (i * rs + r_mirror) * phis + phis - 1 - back, &c->mirror);
  }
  for (size_t at = 0; c->all && at < entries; at++)
    c->all[(slab->wavelength * count_of(c, HETAB_THETA_I) + slab->theta_i_first) * rs * phis + at] =
        slab_value(c, slab, at);
  c->slabs++;
  return HETAB_OK;
}

/* Every slab came once and every entry is a number; frees. */
static void finish(checker *c) {
  for (size_t i = 0; i < hetab_surface_band_count(c->surface) * count_of(c, HETAB_THETA_I); i++)
    assert_int_equal(c->seen[i], 1);
  assert_int_equal(c->bad, 0);
  free(c->seen);
  c->seen = NULL;
}

/* --- surfaces -------------------------------------------------------------------------------- */

static hetab_surface *metal_surface(hetab_context *ctx, double sigma0_um, double tau_um) {
  hetab_surface *surface;
  char path[] = "/tmp/hetab-test-XXXXXX.yml";
  FILE *file = fdopen(mkstemps(path, 4), "w");
  fprintf(file, "sigma0_um: %g\ntau_um: %g\nindex: Al\n", sigma0_um, tau_um);
  fclose(file);
  assert_ok(ctx, hetab_surface_load(ctx, path, &surface));
  remove(path);
  return surface;
}

static hetab_surface *few_bands(hetab_context *ctx, const char *preset) {
  static const double lambda_um[] = {0.4, 0.55, 0.7};
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_preset(ctx, preset, &surface));
  assert_ok(ctx, hetab_surface_set_wavelengths(ctx, surface, lambda_um, 3));
  return surface;
}

/* --- the default grid ------------------------------------------------------------------------ */

/* A whole table, measured twice: by the library and by the sink. */
static void check_table(hetab_context *ctx, const hetab_surface *surface, hetab_precision precision,
                        hetab_method method, double tolerance, double bound, size_t samples) {
  hetab_grid *grid;
  hetab_report report;
  hetab_engine *engine = new_engine(ctx, precision, method, tolerance);
  hetab_tabulate_options options = {.samples = samples, .seed = 7};
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  checker c = new_checker(surface, grid, precision, samples);
  assert_ok(ctx, hetab_tabulate(ctx, engine, surface, grid, &options, check_slab, &c, &report));
  finish(&c);
  assert_true(report.entries == c.total);
  assert_true(report.kernel_seconds > 0 && report.wall_seconds > 0);
  const hetab_error_stats *e = &report.error;
  print_message("  %s %s: max %.2e p99 %.1e rms %.1e of %zu, below %.1e; %.2f s\n",
                hetab_precision_name(precision), hetab_method_name(method), e->max_rel, e->p99_rel,
                e->rms_rel, e->compared, e->max_abs_below, report.wall_seconds);
  assert_int_equal(e->bad, 0);
  assert_int_equal(e->samples, samples);
  assert_true(e->rms_rel <= e->max_rel && e->p99_rel <= e->max_rel);
  if (c.error.relative > bound) {
    const hetab_point *p = &c.worst_point;
    print_message("  worst at lambda %.17g theta_i %.17g theta_r %.17g phi %.17g\n", p->lambda_um,
                  p->theta_i, p->theta_r, p->phi);
  }
  /* who asks for a looser relative error gets it below the floor, too */
  double below = fmax(TOL_BELOW_FLOOR, bound * TOL_FLOOR);
  assert_worst("own sample", &c.error, bound, below);
  assert_worst("about the mirror", &c.mirror, bound, below);
  assert_true(e->max_rel <= bound && e->max_abs_below <= below);
  /* the two samples are of one population */
  assert_true(fabs((double)e->compared - (double)c.error.compared) < 0.02 * (double)samples);
  hetab_engine_free(engine);
  hetab_grid_free(grid);
}

static void check_float(hetab_context *ctx, hetab_surface *surface) {
  check_table(ctx, surface, HETAB_FLOAT, HETAB_METHOD_ROWS, 0, TOL_TABLE_FLOAT, SAMPLES);
  hetab_surface_free(surface);
}

static void test_presets(void **state) {
  for (size_t i = 0; i < 5; i++) {
    hetab_surface *surface;
    print_message("%s\n", hetab_preset_name(i));
    assert_ok(*state, hetab_surface_preset(*state, hetab_preset_name(i), &surface));
    check_float(*state, surface);
  }
}

static void test_needle(void **state) {
  check_float(*state, metal_surface(*state, 0.05, 60));
}

static void test_smooth(void **state) {
  check_float(*state, metal_surface(*state, 0.02, 3));
}

static void test_very_rough(void **state) {
  check_float(*state, metal_surface(*state, 5, 50));
}

static void test_slope_one(void **state) {
  check_float(*state, metal_surface(*state, 1, 1));
}

static void test_dielectric(void **state) {
  double lambda_um[31];
  hetab_surface *surface;
  for (int w = 0; w < 31; w++)
    lambda_um[w] = 0.4 + 0.01 * w;
  assert_ok(*state, hetab_surface_create(*state, 0.3, 4, 1.5, 0, lambda_um, 31, &surface));
  check_float(*state, surface);
}

static void test_series_float(void **state) {
  hetab_surface *surface = few_bands(*state, "NGGAL");
  check_table(*state, surface, HETAB_FLOAT, HETAB_METHOD_SERIES, 0, TOL_TABLE_FLOAT, 20000);
  hetab_surface_free(surface);
}

static void test_series_double(void **state) {
  hetab_surface *surface = few_bands(*state, "BBQAL2");
  check_table(*state, surface, HETAB_DOUBLE, HETAB_METHOD_SERIES, 0, TOL_TABLE_DOUBLE, 20000);
  hetab_surface_free(surface);
}

static void test_rows_double(void **state) {
  static const char *const presets[] = {"BBQAL1", "NGGAL"};
  for (size_t i = 0; i < 2; i++) {
    hetab_surface *surface = few_bands(*state, presets[i]);
    check_table(*state, surface, HETAB_DOUBLE, HETAB_METHOD_ROWS, 0, TOL_TABLE_DOUBLE, 20000);
    hetab_surface_free(surface);
  }
}

/* Tables are accurate to the tolerance that the engine was asked for. */
static void test_tolerances(void **state) {
  static const struct {
    hetab_precision precision;
    double tolerance;
  } cases[] = {{HETAB_FLOAT, 1e-2},  {HETAB_FLOAT, 1e-3},  {HETAB_FLOAT, 1e-4},
               {HETAB_DOUBLE, 1e-4}, {HETAB_DOUBLE, 1e-7}, {HETAB_DOUBLE, 1e-8},
               {HETAB_DOUBLE, 1e-9}, {HETAB_DOUBLE, 1e-10}};
  hetab_surface *surfaces[] = {few_bands(*state, "NGGAL"), few_bands(*state, "BBQAL2")};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    for (size_t s = 0; s < 2; s++)
      check_table(*state, surfaces[s], cases[i].precision, HETAB_METHOD_ROWS, cases[i].tolerance,
                  cases[i].tolerance, 10000);
  for (size_t s = 0; s < 2; s++)
    hetab_surface_free(surfaces[s]);
}

/* --- odd grids ------------------------------------------------------------------------------- */

static hetab_grid *grid_of(hetab_context *ctx, const char *i, const char *r, const char *phi) {
  hetab_grid *grid;
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_I, i));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_R, r));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_PHI, phi));
  return grid;
}

static double *whole_table(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                           const hetab_grid *grid, size_t *count) {
  hetab_tabulate_options options = {0};
  checker c = new_checker(surface, grid, hetab_engine_precision(engine), 0);
  *count = (size_t)c.total;
  c.all = calloc(*count, sizeof *c.all);
  assert_ok(ctx, hetab_tabulate(ctx, engine, surface, grid, &options, check_slab, &c, NULL));
  finish(&c);
  return c.all;
}

/* Every entry of a small table, against the points of the double build. */
static void check_small(hetab_context *ctx, const hetab_surface *surface, const hetab_grid *grid,
                        hetab_precision precision, hetab_method method) {
  size_t count, at = 0;
  hetab_engine *engine = new_engine(ctx, precision, method, 0);
  double *table = whole_table(ctx, engine, surface, grid, &count);
  hetab_point *points = calloc(count, sizeof *points);
  checker c = {.surface = surface, .grid = grid};
  worst error = {0};
  for (size_t w = 0; w < hetab_surface_band_count(surface); w++)
    for (size_t i = 0; i < count_of(&c, HETAB_THETA_I); i++)
      for (size_t r = 0; r < count_of(&c, HETAB_THETA_R); r++)
        for (size_t p = 0; p < count_of(&c, HETAB_PHI); p++)
          points[at++] = point_at(&c, w, i, r, p);
  assert_int_equal(at, count);
  hetab_value *values = device_values(ctx, HETAB_DOUBLE, points, count);
  for (at = 0; at < count; at++)
    worst_add(&error, at, table[at], values[at].total);
  assert_worst(hetab_method_name(method), &error,
               precision == HETAB_DOUBLE ? TOL_TABLE_DOUBLE : TOL_TABLE_FLOAT, TOL_BELOW_FLOOR);
  free(values);
  free(points);
  free(table);
  hetab_engine_free(engine);
}

static const char *const odd_grids[][3] = {
    {"30", "30", "180"},
    {"0", "0", "0"},
    {"90", "90", "180"},
    {"10,45,80", "0:90:7", "0,180"},
    {"0:90:4", "20", "cells:15"},
    {"0:89.9999:3", "60:75:31", "cells:16"},
    {"75", "74.99,75,75.01,89.9999,90", "0:180:17"},
    {"cells:9", "cells:5", "0:180:33"},
    {"0,1e-6,0.001,89.99", "0,1e-6,0.001,89.99", "0,1e-6,90,179,179.999,179.999999,180"},
    {"5", "0:90:2", "1,2,3,5,8,13,21,34,55,89,144,170,171,172,173,174,175,176,177,178"},
};

static void test_odd_grids(void **state) {
  hetab_surface *surfaces[] = {few_bands(*state, "NGGAL"), metal_surface(*state, 0.05, 60),
                               metal_surface(*state, 2, 4)};
  for (size_t g = 0; g < sizeof odd_grids / sizeof *odd_grids; g++)
    for (size_t s = 0; s < 3; s++) {
      hetab_grid *grid = grid_of(*state, odd_grids[g][0], odd_grids[g][1], odd_grids[g][2]);
      for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
        check_small(*state, surfaces[s], grid, (hetab_precision)precision, HETAB_METHOD_ROWS);
        check_small(*state, surfaces[s], grid, (hetab_precision)precision, HETAB_METHOD_SERIES);
      }
      hetab_grid_free(grid);
    }
  for (size_t s = 0; s < 3; s++)
    hetab_surface_free(surfaces[s]);
}

/* The literal method, which needs no device, is the literal reference. */
static void test_literal_method(void **state) {
  hetab_surface *surface = few_bands(*state, "BBQAL2");
  hetab_grid *grid = grid_of(*state, "0:90:10", "0:90:7", "0:180:5");
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_LITERAL, 0);
  hetab_tabulate_options options = {.samples = 500};
  hetab_report report;
  assert_int_equal(hetab_engine_precision(engine), HETAB_DOUBLE);
  checker c = new_checker(surface, grid, HETAB_DOUBLE, 500);
  assert_ok(*state,
            hetab_tabulate(*state, engine, surface, grid, &options, check_slab, &c, &report));
  finish(&c);
  assert_true(report.error.max_rel == 0 && report.error.max_abs_below == 0);
  assert_true(c.error.relative < 1e-12);
  hetab_engine_free(engine);
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

/* --- the diffuse term ------------------------------------------------------------------------ */

/* One diffuse part per wavelength: each slab is that of the bare surface plus its own. */
static void test_diffuse(void **state) {
  static const double diffuse[] = {0.0, 0.125, 0.03};
  hetab_surface *bare = few_bands(*state, "NGGAL"), *surface;
  hetab_grid *grid = grid_of(*state, "0:90:10", "0:90:7", "0:180:5");
  char path[] = "/tmp/hetab-test-XXXXXX.yml";
  FILE *file = fdopen(mkstemps(path, 4), "w");
  fprintf(file,
          "sigma0_um: %.17g\ntau_um: %.17g\nindex: Al\nwavelengths_nm: [400, 550, 700]\n"
          "diffuse_brdf: [%g, %g, %g]\n",
          hetab_surface_sigma0_um(bare), hetab_surface_tau_um(bare), diffuse[0], diffuse[1],
          diffuse[2]);
  fclose(file);
  assert_ok(*state, hetab_surface_load(*state, path, &surface));
  remove(path);
  for (int method = HETAB_METHOD_ROWS; method <= HETAB_METHOD_LITERAL; method++) {
    size_t count;
    hetab_engine *engine = new_engine(*state, HETAB_DOUBLE, (hetab_method)method, 0);
    double *without = whole_table(*state, engine, bare, grid, &count);
    double *with = whole_table(*state, engine, surface, grid, &count);
    for (size_t i = 0; i < count; i++) {
      double expected = without[i] + diffuse[i / (count / 3)];
      assert_true(fabs(with[i] - expected) <= 1e-15 * expected);
    }
    free(with);
    free(without);
    hetab_engine_free(engine);
  }
  hetab_grid_free(grid);
  hetab_surface_free(bare);
  hetab_surface_free(surface);
}

/* --- stopping -------------------------------------------------------------------------------- */

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct stopper {
  int calls, stop_at;
  double last;
} stopper;

static int stop_progress(void *user, double done, double total) {
  stopper *s = user;
  assert_true(total > 0 && done >= s->last && done <= total);
  s->last = done;
  return ++s->calls >= s->stop_at;
}

static hetab_status failing_sink(hetab_context *ctx, void *user, const hetab_slab *slab) {
  int *left = user;
  return --*left < 0 ? HETAB_ERR_IO : HETAB_OK;
}

static void test_cancel(void **state) {
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_tabulate_options options = {0};
  assert_ok(*state, hetab_surface_preset(*state, "NGGAL", &surface));
  assert_ok(*state, hetab_grid_create(*state, &grid));
  for (int method = HETAB_METHOD_ROWS; method <= HETAB_METHOD_LITERAL; method++) {
    hetab_engine *engine = new_engine(*state, HETAB_FLOAT, (hetab_method)method, 0);
    for (int stop_at = 1; stop_at <= 3; stop_at++) {
      stopper stop = {.stop_at = stop_at};
      hetab_set_progress(*state, stop_progress, &stop);
      double start = seconds();
      assert_int_equal(hetab_tabulate(*state, engine, surface, grid, &options, NULL, NULL, NULL),
                       HETAB_ERR_CANCELLED);
      assert_int_equal(stop.calls, stop_at);
      assert_below("seconds to stop", seconds() - start, TOL_CANCEL_SECONDS);
    }
    hetab_set_progress(*state, NULL, NULL);
    hetab_engine_free(engine);
  }
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

static void test_failing_sink(void **state) {
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  assert_ok(*state, hetab_surface_preset(*state, "NGGAL", &surface));
  assert_ok(*state, hetab_grid_create(*state, &grid));
  for (int good = 0; good < 5; good += 2) {
    int left = good;
    hetab_report report = {.entries = -1};
    assert_int_equal(
        hetab_tabulate(*state, engine, surface, grid, NULL, failing_sink, &left, &report),
        HETAB_ERR_IO);
    assert_int_equal(left, -1);
    assert_true(report.entries == -1);
  }
  hetab_engine_free(engine);
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

/* Progress ends at the total, and asking for nothing but the report works. */
static void test_progress(void **state) {
  hetab_surface *surface = few_bands(*state, "NGGAL");
  hetab_grid *grid = grid_of(*state, "0:90:10", "0:90:7", "0:180:5");
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  stopper never = {.stop_at = 1 << 30};
  hetab_report report;
  hetab_set_progress(*state, stop_progress, &never);
  assert_ok(*state, hetab_tabulate(*state, engine, surface, grid, NULL, NULL, NULL, &report));
  assert_true(never.last == 3 * 10 * 7 * 5 && report.entries == never.last);
  assert_int_equal(report.error.samples, 2000);
  hetab_engine_free(engine);
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

/* --- several devices ------------------------------------------------------------------------- */

/* In a child: all devices give what the first one gives. */
static void test_devices_share(void **state) {
  hetab_surface *surface;
  hetab_grid *grid = grid_of(*state, "0:90:90", "0:90:40", "0:180:37");
  hetab_device_info *list;
  size_t count, same;
  double *tables[2];
  assert_ok(*state, hetab_device_list(*state, &list, &count));
  free(list);
  assert_int_equal(count, 2);
  assert_ok(*state, hetab_surface_preset(*state, "BBQAL2", &surface));
  for (int i = 0; i < 2; i++) {
    hetab_engine *engine;
    hetab_engine_options options = {.devices = i ? "all" : "1"};
    assert_ok(*state, hetab_engine_create(*state, &options, &engine));
    print_message("  %s\n", hetab_engine_device(engine));
    tables[i] = whole_table(*state, engine, surface, grid, &same);
    hetab_engine_free(engine);
  }
  assert_memory_equal(tables[0], tables[1], same * sizeof(double));
  free(tables[0]);
  free(tables[1]);
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

static void test_two_devices(void **state) {
  assert_int_equal(
      run_again("devices", (const char *const[]){"POCL_DEVICES=pthread pthread", NULL}), 0);
}

int main(int argc, char **argv) {
  if (argc > 1) {
    const struct CMUnitTest tests[] = {TEST(test_devices_share)};
    return cmocka_run_group_tests(tests, NULL, NULL);
  }
  const struct CMUnitTest tests[] = {
      TEST(test_presets),      TEST(test_needle),        TEST(test_smooth),
      TEST(test_very_rough),   TEST(test_slope_one),     TEST(test_dielectric),
      TEST(test_series_float), TEST(test_series_double), TEST(test_rows_double),
      TEST(test_tolerances),   TEST(test_odd_grids),     TEST(test_literal_method),
      TEST(test_diffuse),      TEST(test_cancel),        TEST(test_failing_sink),
      TEST(test_progress),     TEST(test_two_devices),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
