/* Conversions of tables: against closed forms, of clean and of measured-like tables, and refused.
 */
#include "golden_support.h"

#include "lookup_support.h"

#include "rgl/rgl_build.h"

#include <sys/stat.h>
#include <unistd.h>

#include "convert/mend.h"

/* ---- a folder ------------------------------------------------------------------------------- */

static char folder[] = "/tmp/hetab_convert_XXXXXX";

static const char *in_folder(const char *name) {
  static char paths[8][128];
  static int next;
  char *path = paths[next++ % 8];
  snprintf(path, sizeof *paths, "%s/%s", folder, name);
  return path;
}

static int make_folder(void **state) {
  return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state) {
  char command[160];
  snprintf(command, sizeof command, "rm -r '%s'", folder);
  return system(command);
}

/* ---- a surface in closed form --------------------------------------------------------------- */

static const double albedo[3] = {0.2, 0.1, 0.05}, gloss[3] = {0.9, 0.8, 0.6}, alpha = 0.2;

/* Cook and Torrance, 1982: Beckmann's distribution and the V groove, F = 1; a Lambertian part. */
static void cook_torrance(double cos_h, double cos_d, double mu_i, double mu_r, double rgb[3]) {
  double tan2 = 1 / (cos_h * cos_h) - 1;
  double d = exp(-tan2 / (alpha * alpha)) / (M_PI * alpha * alpha * pow(cos_h, 4));
  double g = fmin(1, 2 * cos_h * fmin(mu_i, mu_r) / cos_d);
  for (int c = 0; c < 3; c++)
    rgb[c] = albedo[c] / M_PI + gloss[c] * d * g / (4 * mu_i * mu_r);
}

static void truth(const double wi[3], const double wo[3], double rgb[3]) {
  double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
  double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  cook_torrance(h[2] / length, 0.5 * length, wi[2], wo[2], rgb);
}

static hetab_merl *new_merl(hetab_context *ctx) {
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    double rgb[3];
    hetab_half_diff middle = hetab_merl_middle(cell);
    hetab_merl_pair pair;
    if (!hetab_merl_pair_of(middle, &pair))
      continue;
    cook_torrance(cos(middle.theta_h), cos(middle.theta_d), pair.mu_i, pair.mu_r, rgb);
    for (int c = 0; c < 3; c++)
      hetab_merl_channel(merl, c)[cell] = rgb[c];
  }
  return merl;
}

static hetab_convert_report convert(hetab_context *ctx, const char *in, const char *out,
                                    hetab_convert_options options) {
  hetab_convert_report report;
  options.overwrite = 1;
  assert_ok(ctx, hetab_convert(ctx, in, out, &options, &report));
  print_message(
      "  %-12s -> %-12s L1 %.2e (interpolated %.2e), bias %+.1e, filled %zu, clamped %zu\n",
      strrchr(in, '/') + 1, strrchr(out, '/') + 1, report.error_l1, report.error_l1_interpolated,
      report.bias, report.filled, report.clamped);
  return report;
}

/* ---- what a table is ------------------------------------------------------------------------ */

typedef struct judged {
  double l1, bias;
  size_t bad; /* NaN, infinite or negative */
} judged;

/* Against the closed form, by a rule of its own: nodes even in theta_i, and in the viewer's
 * (theta_h, phi_h) about the lobe and over the hemisphere; the mean of what the two rules say would
 * be no integral, so they are weighed by each other's density (balance heuristic). */
static judged judge(hetab_context *ctx, const char *path, int truncating) {
  enum { INCIDENCES = 17, SIDE = 60 };
  hetab_lookup *table;
  hetab_merl *merl = NULL;
  judged j = {0};
  double sum = 0;
  assert_ok(ctx, hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &table));
  assert_int_equal(hetab_lookup_channel_count(table), 3);
  if (truncating)
    assert_ok(ctx, hetab_merl_load(ctx, path, &merl));
  for (int i = 0; i < INCIDENCES; i++)
    for (int n = 0; n < 2 * SIDE * SIDE; n++) {
      double theta_i = (i + 0.5) * 80 / INCIDENCES * M_PI / 180;
      double u = (n / 2 / SIDE + 0.5) / SIDE, v = (n / 2 % SIDE + 0.5) / SIDE;
      double wi[3] = {sin(theta_i), 0, cos(theta_i)}, wo[3];
      if (n % 2) { /* by the cosine */
        wo[0] = sqrt(u) * cos(2 * M_PI * v);
        wo[1] = sqrt(u) * sin(2 * M_PI * v);
        wo[2] = sqrt(1 - u);
      } else { /* by D cos(theta_h) */
        double tan_h = alpha * sqrt(-log(1 - u)), cos_h = 1 / sqrt(1 + tan_h * tan_h);
        double h[3] = {tan_h * cos_h * cos(2 * M_PI * v), tan_h * cos_h * sin(2 * M_PI * v), cos_h};
        double twice = 2 * (wi[0] * h[0] + wi[2] * h[2]);
        for (int k = 0; k < 3; k++)
          wo[k] = twice * h[k] - wi[k];
        if (twice <= 0 || wo[2] <= 0)
          continue;
      }
      double half[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
      double length = sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
      double cos_h = half[2] / length, tan2 = 1 / (cos_h * cos_h) - 1;
      double lobe = exp(-tan2 / (alpha * alpha)) / (M_PI * alpha * alpha * pow(cos_h, 3)) /
                    (2 * length); /* 4 wi.h */
      double weight = wo[2] / (lobe + wo[2] / M_PI);
      float wif[3] = {(float)wi[0], 0, (float)wi[2]}, value[3];
      float wof[3] = {(float)wo[0], (float)wo[1], (float)wo[2]};
      double expected[3], rgb[3];
      truth(wi, wo, expected);
      hetab_lookup_eval(table, NULL, 1, wif, wof, value, NULL);
      if (merl)
        hetab_merl_lookup(merl, (hetab_directions){theta_i, acos(wo[2]), atan2(wo[1], wo[0])}, rgb);
      for (int c = 0; c < 3; c++) {
        double got = merl ? fmax(rgb[c], 0) : (double)value[c];
        j.bad += !(got >= 0 && isfinite(got));
        j.l1 += weight * fabs(got - expected[c]);
        j.bias += weight * (got - expected[c]);
        sum += weight * expected[c];
      }
    }
  j.l1 /= sum;
  j.bias /= sum;
  hetab_lookup_free(table);
  hetab_merl_free(merl);
  print_message("  %-30s against the closed form: L1 %.2e, bias %+.1e, %zu bad\n",
                strrchr(path, '/') + 1, j.l1, j.bias, j.bad);
  assert_int_equal(j.bad, 0);
  return j;
}

/* ---- conversions ---------------------------------------------------------------------------- */

/* From a clean MERL table to both others, and back. */
static void test_clean(void **state) {
  hetab_context *ctx = *state;
  hetab_merl *merl = new_merl(ctx);
  const char *start = in_folder("clean.binary"), *h5 = in_folder("clean.h5");
  const char *bsdf = in_folder("clean.bsdf"), *back = in_folder("back.binary");
  hetab_convert_options none = {0};
  assert_int_equal(hetab_merl_holes(merl), 0);
  assert_ok(ctx, hetab_merl_save(ctx, merl, start, 1));
  hetab_merl_free(merl);
  judged before = judge(ctx, start, 0), truncated = judge(ctx, start, 1);
  hetab_convert_report r = convert(ctx, start, bsdf, none);
  assert_true(r.from == HETAB_FORMAT_MERL && r.to == HETAB_FORMAT_RGL && r.filled == 0);
  assert_true(r.srgb_in && r.srgb_out && r.channels_out == 3);
  assert_below("MERL to RGL", r.error_l1, 0.01);
  assert_below("its error against the closed form", judge(ctx, bsdf, 0).l1,
               before.l1 + 1.5 * r.error_l1);
  r = convert(ctx, start, h5, none);
  assert_true(r.to == HETAB_FORMAT_H5 && r.srgb_out);
  assert_below("MERL to HDF5", r.error_l1, 0.01);
  assert_below("its error against the closed form", judge(ctx, h5, 0).l1,
               before.l1 + 1.5 * r.error_l1);
  r = convert(ctx, h5, back, none);
  assert_below("back, interpolated", r.error_l1_interpolated, 0.01);
  /* what the report says of truncating readers is what the test finds */
  double found = judge(ctx, back, 1).l1;
  assert_below("truncating, stated / found", fabs(log(r.error_l1 / found)), log(1.25));
  assert_below("truncating, against the first one's", found, 1.1 * truncated.l1);
  r = convert(ctx, bsdf, h5, none);
  assert_below("RGL to HDF5", r.error_l1, 0.01);
  r = convert(ctx, h5, bsdf, none);
  assert_below("HDF5 to RGL", r.error_l1, 0.01);
}

static double gaussian(uint64_t *seed) {
  return sqrt(-2 * log(1 - uniform(seed, 0, 1))) * cos(2 * M_PI * uniform(seed, 0, 1));
}

/* As gonioreflectometers and cameras leave them: noise, dead cells, NaN, slightly negative ones,
 * and nothing at grazing or near retro-reflection. */
static size_t spoil(hetab_merl *merl, uint64_t seed) {
  size_t holes = 0;
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    double factor = 1 + 0.05 * gaussian(&seed), kind = uniform(&seed, 0, 1);
    hetab_merl_pair pair;
    if (!hetab_merl_pair_of(hetab_merl_middle(cell), &pair))
      continue;
    int missing = fmin(pair.mu_i, pair.mu_r) < cos(84 * M_PI / 180) || cell / 180 % 90 < 2;
    double *r = hetab_merl_channel(merl, 0) + cell, *g = hetab_merl_channel(merl, 1) + cell;
    double *b = hetab_merl_channel(merl, 2) + cell;
    if (missing || kind < 0.02)
      *r = *g = *b = -1;
    else if (kind < 0.025)
      *g = (double)NAN;
    else if (kind < 0.03)
      *b = -1e-4;
    else if (kind < 0.031)
      *r = (double)INFINITY;
    holes += missing || kind < 0.031;
    *r *= *r > 0 ? factor : 1;
    *g *= *g > 0 ? factor : 1;
    *b *= *b > 0 ? factor : 1;
  }
  return holes;
}

/* Byte by byte: hetab_merl_save() takes no such table. */
static void save_spoilt(const hetab_merl *merl, const char *path) {
  static const int32_t dims[3] = {90, 90, 180};
  static const double scale[3] = {1 / 1500.0, 1.15 / 1500, 1.66 / 1500};
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fwrite(dims, sizeof dims, 1, file);
  for (int c = 0; c < 3; c++)
    for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
      double value = hetab_merl_channel_const(merl, c)[cell];
      value /= value == -1 ? 1 : scale[c];
      fwrite(&value, sizeof value, 1, file);
    }
  assert_int_equal(fclose(file), 0);
}

static void test_measured(void **state) {
  hetab_context *ctx = *state;
  hetab_merl *merl = new_merl(ctx), *again;
  size_t holes = spoil(merl, 9);
  const char *start = in_folder("measured.binary"), *bsdf = in_folder("measured.bsdf");
  const char *h5 = in_folder("measured.h5"), *mended = in_folder("mended.binary");
  hetab_convert_options none = {0};
  save_spoilt(merl, start);
  hetab_merl_free(merl);
  assert_ok(ctx, hetab_merl_load_raw(ctx, start, &again));
  assert_int_equal(hetab_merl_holes(again), holes);
  hetab_merl_free(again);
  static const char *const outputs[] = {"bsdf", "h5", "binary"};
  const char *paths[] = {bsdf, h5, mended};
  for (int i = 0; i < 3; i++) {
    hetab_convert_report r = convert(ctx, start, paths[i], none);
    assert_int_equal(r.filled, holes);
    print_message("  to %s\n", outputs[i]);
    judged j = judge(ctx, paths[i], 0);
    assert_below("against the closed form without noise", j.l1, TOL_CONVERT_MEASURED);
    assert_below("bias", fabs(j.bias), TOL_CONVERT_MEASURED_BIAS);
    struct stat about;
    assert_int_equal(stat(paths[i], &about), 0);
    print_message("  %.1f MB\n", (double)about.st_size / 1e6);
  }
  assert_ok(ctx, hetab_merl_load_raw(ctx, mended, &again));
  assert_int_equal(hetab_merl_holes(again), 0);
  hetab_merl_free(again);
}

/* What the file's sampler draws is usable too. */
static void test_measured_samples(void **state) {
  enum { COUNT = 100000 };
  hetab_context *ctx = *state;
  hetab_lookup *table;
  uint64_t seed = 4;
  double sum = 0, sum2 = 0;
  assert_ok(ctx,
            hetab_lookup_open(ctx, in_folder("measured.bsdf"), HETAB_LOOKUP_INTERPOLATE, &table));
  for (int i = 0; i < COUNT; i++) {
    double theta = uniform(&seed, 0, M_PI_2 - 1e-3);
    float wi[3] = {(float)sin(theta), 0, (float)cos(theta)}, wo[3], weight[3];
    float u[2] = {(float)uniform(&seed, 0, 0.9999999), (float)uniform(&seed, 0, 0.9999999)};
    float density = sample_at(table, wi, u[1], u, wo, weight);
    assert_true(isfinite(density) && density >= 0);
    if (density > 0)
      for (int c = 0; c < 3; c++)
        assert_true(isfinite(weight[c]) && weight[c] >= 0);
    sum += density > 0 ? (double)weight[0] : 0;
    sum2 += density > 0 ? (double)weight[0] * (double)weight[0] : 0;
  }
  print_message("  mean weight %.3f, effective %.2f\n", sum / COUNT, sum * sum / sum2 / COUNT);
  assert_true(sum / COUNT > 0.2 && sum / COUNT < 1.5);
  hetab_lookup_free(table);
}

/* ---- spectra -------------------------------------------------------------------------------- */

#define AXES                                                                                       \
  { "0:90:31", "0:90:31", "0:180:31" }

static hetab_grid *new_grid(hetab_context *ctx) {
  static const char *const axes[] = AXES;
  hetab_grid *grid;
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    assert_ok(ctx, hetab_grid_set_axis(ctx, grid, (hetab_axis)axis, axes[axis]));
  return grid;
}

/* A small table of a smooth surface, with a specular part. */
static void save_spectral(hetab_context *ctx, const char *path, const hetab_surface *surface,
                          hetab_engine *engine) {
  hetab_grid *grid = new_grid(ctx);
  hetab_table_writer *writer;
  const hetab_h5_options options = {.overwrite = 1};
  double rho[31 * 31];
  assert_ok(ctx, hetab_h5_create(ctx, path, surface, grid, &options, &writer));
  assert_ok(ctx,
            hetab_tabulate(ctx, engine, surface, grid, NULL, hetab_table_write_slab, writer, NULL));
  assert_ok(ctx, hetab_specular_reflectance(ctx, surface, hetab_grid_radians(grid, HETAB_THETA_I),
                                            31, rho));
  assert_ok(ctx, hetab_table_write_specular(ctx, writer, rho));
  assert_ok(ctx, hetab_table_commit(ctx, writer));
  hetab_grid_free(grid);
}

/* The largest difference of rho_s between two tables, up to 85 degrees. */
static double specular_difference(hetab_context *ctx, const char *a, const char *b) {
  hetab_lookup *tables[2];
  double worst = 0;
  assert_ok(ctx, hetab_lookup_open(ctx, a, HETAB_LOOKUP_NEAREST, &tables[0]));
  assert_ok(ctx, hetab_lookup_open(ctx, b, HETAB_LOOKUP_NEAREST, &tables[1]));
  size_t channels = hetab_lookup_channel_count(tables[0]);
  assert_int_equal(channels, hetab_lookup_channel_count(tables[1]));
  for (int deg = 0; deg <= 85; deg++) {
    float wi[3] = {(float)sin(deg * M_PI / 180), 0, (float)cos(deg * M_PI / 180)}, rho[2][31];
    for (int t = 0; t < 2; t++)
      hetab_lookup_albedo(tables[t], NULL, 1, wi, NULL, rho[t]);
    for (size_t c = 0; c < channels; c++)
      worst = fmax(worst, fabs((double)rho[0][c] - (double)rho[1][c]));
  }
  hetab_lookup_free(tables[0]);
  hetab_lookup_free(tables[1]);
  return worst;
}

static void check_wavelengths(hetab_context *ctx, const char *path, const double *expected) {
  hetab_lookup *table;
  assert_ok(ctx, hetab_lookup_open(ctx, path, HETAB_LOOKUP_NEAREST, &table));
  assert_int_equal(hetab_lookup_channel_count(table), 31);
  for (int b = 0; b < 31; b++)
    assert_true(fabs(hetab_lookup_wavelengths_um(table)[b] - expected[b]) < 1e-6);
  hetab_lookup_free(table);
}

static void test_spectral(void **state) {
  hetab_context *ctx = *state;
  double lambda_um[31];
  for (int b = 0; b < 31; b++)
    lambda_um[b] = 0.4 + 0.01 * b;
  hetab_surface *surface;
  hetab_merl *merl;
  hetab_engine *engine = new_engine(ctx, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  assert_ok(ctx, hetab_surface_create(ctx, 0.06, 0.7, 1.2, 3, lambda_um, 31, &surface));
  const char *h5 = in_folder("spectral.h5"), *bsdf = in_folder("spectral.bsdf");
  const char *back = in_folder("spectral-back.h5"), *binary = in_folder("spectral.binary");
  const char *direct = in_folder("direct.binary");
  const hetab_convert_options coarse = {.table_error = 0.03, .pairs = 20000};
  save_spectral(ctx, h5, surface, engine);
  hetab_convert_report r = convert(ctx, h5, bsdf, coarse);
  assert_true(!r.srgb_out && r.channels_out == 31 && r.specular_max > 0.1);
  assert_below("spectral HDF5 to RGL", r.error_l1, 0.03);
  check_wavelengths(ctx, bsdf, lambda_um);
  assert_below("rho_s", specular_difference(ctx, h5, bsdf), 2e-3);
  r = convert(ctx, bsdf, back,
              (hetab_convert_options){.axes = AXES, .pairs = 20000, .compression = 1});
  /* colour has no wavelengths, but a delta */
  const char *colour = in_folder("colour.h5"), *kept = in_folder("kept.binary");
  convert(ctx, h5, colour, (hetab_convert_options){.axes = AXES, .srgb = 1, .pairs = 1000});
  r.specular_max = convert(ctx, colour, kept, (hetab_convert_options){.pairs = 1000}).specular_max;
  assert_true(r.specular_max > 0.1);
  assert_below("rho_s of colour", specular_difference(ctx, colour, kept), 1e-3);
  assert_true(!r.srgb_out && r.channels_out == 31);
  check_wavelengths(ctx, back, lambda_um);
  assert_below("rho_s", specular_difference(ctx, h5, back), 2e-3);
  /* colours are those of a table made directly */
  convert(ctx, h5, binary, coarse);
  assert_ok(ctx, hetab_tabulate_merl(ctx, engine, surface, &(hetab_merl_options){0}, &merl, NULL));
  assert_ok(ctx, hetab_merl_save(ctx, merl, direct, 1));
  hetab_merl_free(merl);
  hetab_lookup *tables[2];
  assert_ok(ctx, hetab_lookup_open(ctx, binary, HETAB_LOOKUP_INTERPOLATE, &tables[0]));
  assert_ok(ctx, hetab_lookup_open(ctx, direct, HETAB_LOOKUP_INTERPOLATE, &tables[1]));
  double sum = 0, difference = 0;
  uint64_t seed = 2;
  for (int i = 0; i < 20000; i++) {
    double ti = uniform(&seed, 0, 1.4), tr = uniform(&seed, 0, 1.4), phi = uniform(&seed, 0, M_PI);
    float wi[3] = {(float)sin(ti), 0, (float)cos(ti)}, a[3], b[3];
    float wo[3] = {(float)(sin(tr) * cos(phi)), (float)(sin(tr) * sin(phi)), (float)cos(tr)};
    hetab_lookup_eval(tables[0], NULL, 1, wi, wo, a, NULL);
    hetab_lookup_eval(tables[1], NULL, 1, wi, wo, b, NULL);
    for (int c = 0; c < 3; c++) {
      sum += (double)b[c];
      difference += fabs((double)a[c] - (double)b[c]);
    }
  }
  assert_below("colour of the converted against the direct", difference / sum, 0.01);
  hetab_lookup_free(tables[0]);
  hetab_lookup_free(tables[1]);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
}

/* ---- HDF5 of linear sRGB -------------------------------------------------------------------- */

static void test_srgb_h5(void **state) {
  const char *const channels[] = {"linear sRGB", "hetab convert", NULL};
  hetab_context *ctx = *state;
  hetab_h5_table *table = (void *)ctx;
  const char *path = in_folder("clean.h5");
  assert_fails(ctx, hetab_h5_open(ctx, path, &table), HETAB_ERR_UNSUPPORTED, channels);
  assert_null(table);
  assert_ok(ctx, hetab_h5_open_any(ctx, path, &table));
  assert_int_equal(hetab_h5_wavelength_count(table), 3);
  assert_null(hetab_h5_wavelengths_um(table));
  hetab_h5_free(table);
}

/* ---- refusals ------------------------------------------------------------------------------- */

static void refused(hetab_context *ctx, const char *in, const char *out, int overwrite,
                    hetab_status status, const char *const *words) {
  hetab_convert_options options = {.overwrite = overwrite, .pairs = 10};
  hetab_convert_report report;
  assert_fails(ctx, hetab_convert(ctx, in, out, &options, &report), status, words);
}

static void test_refused(void **state) {
  hetab_context *ctx = *state;
  const char *clean = in_folder("clean.binary"), *none = in_folder("none.h5");
  const char *text = in_folder("text.binary"), *dead = in_folder("dead.binary");
  refused(ctx, in_folder("missing.h5"), none, 0, HETAB_ERR_IO,
          (const char *const[]){"missing.h5", NULL});
  refused(ctx, clean, in_folder("x.exr"), 0, HETAB_ERR_UNSUPPORTED,
          (const char *const[]){"x.exr", ".bsdf", NULL});
  refused(ctx, clean, clean, 1, HETAB_ERR_ARGUMENT, (const char *const[]){"one file", NULL});
  refused(ctx, clean, in_folder("clean.h5"), 0, HETAB_ERR_EXISTS,
          (const char *const[]){"clean.h5", NULL});
  refused(ctx, clean, in_folder("nowhere/x.h5"), 0, HETAB_ERR_IO,
          (const char *const[]){"nowhere", NULL});
  FILE *file = fopen(text, "w");
  fputs("no table at all\n", file);
  fclose(file);
  refused(ctx, text, none, 0, HETAB_ERR_PARSE, (const char *const[]){"text.binary", NULL});
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl)); /* every cell is marked */
  assert_ok(ctx, hetab_merl_save(ctx, merl, dead, 1));
  hetab_merl_free(merl);
  refused(ctx, dead, none, 0, HETAB_ERR_PARSE, (const char *const[]){"no valid cell", NULL});
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  for (int c = 0; c < 3; c++)
    memset(hetab_merl_channel(merl, c), 0, HETAB_MERL_CELLS * sizeof(double));
  assert_ok(ctx, hetab_merl_save(ctx, merl, in_folder("black.binary"), 1));
  hetab_merl_free(merl);
  refused(ctx, in_folder("black.binary"), in_folder("black.bsdf"), 0, HETAB_ERR_RANGE,
          (const char *const[]){"black.binary", "black at every", NULL});
  assert_int_equal(truncate(dead, 1000), 0);
  refused(ctx, dead, none, 0, HETAB_ERR_PARSE, (const char *const[]){"dead.binary", NULL});
  /* colour needs the visible wavelengths */
  double lambda_um[2] = {0.5, 0.6};
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_create(ctx, 0.1, 2, 1.5, 0, lambda_um, 2, &surface));
  hetab_engine *engine = new_engine(ctx, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  save_spectral(ctx, in_folder("two.h5"), surface, engine);
  refused(ctx, in_folder("two.h5"), in_folder("two.binary"), 0, HETAB_ERR_RANGE,
          (const char *const[]){"400", NULL});
  assert_int_equal(access(none, F_OK), -1);
  assert_int_equal(access(in_folder("two.binary"), F_OK), -1);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
}

static hetab_status white(hetab_context *ctx, void *user, const hetab_directions *pairs,
                          size_t count, double *values) {
  for (size_t i = 0; i < 3 * count; i++)
    values[i] = 1 / M_PI;
  return HETAB_OK;
}

static void white_albedo(hetab_context *ctx, const char *path, double deg, double bound) {
  hetab_lookup *table;
  float wi[3] = {(float)sin(deg * M_PI / 180), 0, (float)cos(deg * M_PI / 180)}, albedo[3];
  assert_ok(ctx, hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &table));
  hetab_lookup_albedo(table, NULL, 1, wi, albedo, NULL);
  hetab_lookup_free(table);
  print_message("  at %g degrees\n", deg);
  assert_below("albedo", fabs((double)albedo[1] - 1), bound);
}

/* Of an HDF5 table's row, by trapezoids. */
static double dense_albedo(hetab_context *ctx, const char *path, size_t theta_i) {
  hetab_h5_table *table;
  assert_ok(ctx, hetab_h5_open_any(ctx, path, &table));
  const hetab_grid *grid = hetab_h5_grid(table);
  const double *r = hetab_grid_radians(grid, HETAB_THETA_R),
               *p = hetab_grid_radians(grid, HETAB_PHI);
  size_t rows = hetab_grid_count(grid, HETAB_THETA_R), columns = hetab_grid_count(grid, HETAB_PHI);
  double *values = calloc(hetab_grid_count(grid, HETAB_THETA_I) * rows * columns, sizeof *values);
  assert_ok(ctx, hetab_h5_read(ctx, table, 0, values));
  double sum = 0;
  for (size_t i = 0; i < rows; i++)
    for (size_t k = 1; k < columns; k++) {
      const double *v = values + (theta_i * rows + i) * columns + k;
      sum += (p[k] - p[k - 1]) * (v[-1] + v[0]) * sin(r[i]) * cos(r[i]) * (r[1] - r[0]);
    }
  free(values);
  hetab_h5_free(table);
  return sum;
}

/* RGL tables store f cos: what is made of it at the horizon, where readers divide by the cosine. */
static void test_white_horizon(void **state) {
  hetab_context *ctx = *state;
  const hetab_rgl_source source = {.channels = 3, .values = white};
  const hetab_rgl_options options = {.table_error = 0.01};
  hetab_rgl_report report;
  hetab_rgl *rgl;
  hetab_merl *merl;
  const char *in = in_folder("white.bsdf"), *out = in_folder("white.binary");
  assert_ok(ctx, hetab_rgl_build(ctx, &source, &options, &rgl, &report));
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, in, 1));
  convert(ctx, in, out, (hetab_convert_options){0});
  assert_ok(ctx, hetab_merl_load(ctx, out, &merl));
  double largest = 0, least = 1;
  size_t valid = 0, wrong = 0;
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    double value = hetab_merl_channel_const(merl, 1)[cell];
    if (value < 0)
      continue;
    valid++;
    wrong += fabs(value * M_PI - 1) > 0.05;
    largest = fmax(largest, value);
    least = fmin(least, value);
  }
  print_message("  cells from %.3f to %.3f\n", least, largest);
  assert_below("cells off by 5 %", (double)wrong / (double)valid, 0.035);
  assert_true(least > 0.13 && largest < 0.47);
  hetab_merl_free(merl);
  white_albedo(ctx, out, 80, 0.001);
  white_albedo(ctx, out, 89, 0.01);
  convert(ctx, in, in_folder("white.h5"), (hetab_convert_options){.pairs = 1000});
  white_albedo(ctx, in_folder("white.h5"), 89, 0.01);
  assert_below("albedo of the nodes at 89 degrees, linear",
               fabs(dense_albedo(ctx, in_folder("white.h5"), 88) - 1), 0.01);
  hetab_rgl_free(rgl);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_white_horizon),    TEST(test_clean),    TEST(test_measured),
      TEST(test_measured_samples), TEST(test_spectral), TEST(test_srgb_h5),
      TEST(test_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
