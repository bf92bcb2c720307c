/* RGL tables: the container's bytes, our reader against Mitsuba's values, samplers against their
 * densities, tables against the literal equations, and hostile files. */
#include "golden_support.h"

#include <unistd.h>

#include "rgl/rgl_build.h"
#include "rgl/rgl_model.h"

/* ---- a file, byte by byte ------------------------------------------------------------------- */

enum { U8 = 1, F32 = 10, MOST_BYTES = 1 << 16 };

typedef struct field {
  const char *name;
  unsigned type;
  unsigned ndim;
  uint64_t shape[5];
  const void *data;
} field;

typedef struct bytes {
  unsigned char data[MOST_BYTES];
  size_t size;
} bytes;

static void put(bytes *b, const void *data, size_t size) {
  assert_true(b->size + size <= MOST_BYTES);
  memcpy(b->data + b->size, data, size);
  b->size += size;
}

static size_t field_size(const field *f) {
  size_t size = f->type == U8 ? 1 : 4;
  for (unsigned d = 0; d < f->ndim; d++)
    size *= f->shape[d];
  return size;
}

/* Where the offset of field i is in the header, and where its data are. */
typedef struct places {
  size_t name[16], ndim[16], type[16], offset[16], shape[16], data[16];
} places;

static places assemble(const field *fields, uint32_t count, bytes *b) {
  places at;
  b->size = 0;
  put(b, "tensor_file", 12);
  put(b, (unsigned char[]){1, 0}, 2);
  put(b, &count, 4);
  for (uint32_t i = 0; i < count; i++) {
    uint16_t length = (uint16_t)strlen(fields[i].name), ndim = (uint16_t)fields[i].ndim;
    uint64_t unknown = 0;
    put(b, &length, 2);
    at.name[i] = b->size;
    put(b, fields[i].name, length);
    at.ndim[i] = b->size;
    put(b, &ndim, 2);
    at.type[i] = b->size;
    put(b, &(unsigned char){(unsigned char)fields[i].type}, 1);
    at.offset[i] = b->size;
    put(b, &unknown, 8);
    at.shape[i] = b->size;
    put(b, fields[i].shape, 8 * fields[i].ndim);
  }
  for (uint32_t i = 0; i < count; i++) {
    while (b->size % 8)
      put(b, "", 1);
    uint64_t offset = at.data[i] = b->size;
    memcpy(b->data + at.offset[i], &offset, 8);
    put(b, fields[i].data, field_size(&fields[i]));
  }
  return at;
}

static void save_bytes(const bytes *b, size_t size, const char *path) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(b->data, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
}

/* ---- the table whose values Mitsuba has computed -------------------------------------------- */

enum { T = 4, R = 5, NDF = 9, SIGMA = 7, VX = 8, VY = 6, FIELDS = 9 };
enum { DESCRIPTION, JACOBIAN, PHI_I, THETA_I, NDF_FIELD, SIGMA_FIELD, VNDF, LUMINANCE, RGB };

typedef struct small_table {
  unsigned char jacobian;
  float phi_i[8], theta_i[T], ndf[2 * NDF], sigma[2 * SIGMA];
  float vndf[T * VX * VY], luminance[T * R * R], rgb[T * 3 * R * R];
  field fields[FIELDS];
} small_table;

static void numbers(long salt, size_t count, float *out) {
  for (size_t i = 0; i < count; i++)
    out[i] = (float)(((long)i * 7919 + salt * 104729) % 1009 + 50) / 1000.0f;
}

static void two_rows(long salt, size_t count, float *out) {
  numbers(salt, count, out);
  memcpy(out + count, out, count * sizeof *out);
}

/* The fields point into it: no copies. */
static void small_table_init(small_table *t) {
  *t = (small_table){.jacobian = 1, .theta_i = {0.0f, 0.5f, 1.2f, (float)M_PI_2}};
  two_rows(1, NDF, t->ndf);
  two_rows(2, SIGMA, t->sigma);
  numbers(3, T * VX * VY, t->vndf);
  numbers(4, T * R * R, t->luminance);
  numbers(5, T * 3 * R * R, t->rgb);
  const field fields[FIELDS] = {
      {"description", U8, 1, {17}, "arbitrary numbers"},
      {"jacobian", U8, 1, {1}, &t->jacobian},
      {"phi_i", F32, 1, {1}, t->phi_i},
      {"theta_i", F32, 1, {T}, t->theta_i},
      {"ndf", F32, 2, {2, NDF}, t->ndf},
      {"sigma", F32, 2, {2, SIGMA}, t->sigma},
      {"vndf", F32, 4, {1, T, VY, VX}, t->vndf},
      {"luminance", F32, 4, {1, T, R, R}, t->luminance},
      {"rgb", F32, 5, {1, T, 3, R, R}, t->rgb},
  };
  memcpy(t->fields, fields, sizeof fields);
}

static char *temporary(char *path) {
  int fd = mkstemp(strcpy(path, "/tmp/hetab-test-XXXXXX"));
  assert_true(fd >= 0);
  close(fd);
  return path;
}

static hetab_rgl *load_small(hetab_context *ctx, const small_table *t) {
  static bytes b;
  char path[64];
  hetab_rgl *rgl;
  assemble(t->fields, FIELDS, &b);
  save_bytes(&b, b.size, temporary(path));
  assert_ok(ctx, hetab_rgl_load(ctx, path, &rgl));
  unlink(path);
  return rgl;
}

enum { GOLDEN_COLUMNS = 16 };

/* The rows of tests/golden/rgl_mitsuba.csv; free() them. */
static double (*golden_rows(size_t *count))[GOLDEN_COLUMNS] {
  FILE *file = fopen("tests/golden/rgl_mitsuba.csv", "r");
  char line[1024];
  double(*rows)[GOLDEN_COLUMNS] = calloc(1000, sizeof *rows);
  assert_non_null(file);
  *count = 0;
  while (fgets(line, sizeof line, file)) {
    char *rest = line;
    if (line[0] == '#' || line[0] == 'w')
      continue;
    for (size_t c = 0; c < GOLDEN_COLUMNS; c++)
      rows[*count][c] = strtod(strsep(&rest, ","), NULL);
    ++*count;
  }
  fclose(file);
  return rows;
}

static void take(const double *from, float to[3]) {
  for (int c = 0; c < 3; c++)
    to[c] = (float)from[c];
}

/* Eval, pdf and sample against Mitsuba 3.9.1 on a table of arbitrary numbers. */
static void test_mitsuba(void **state) {
  hetab_context *ctx = *state;
  small_table t;
  size_t count;
  double(*rows)[GOLDEN_COLUMNS] = golden_rows(&count), value = 0, pdf = 0, sample = 0, density = 0;
  small_table_init(&t);
  hetab_rgl *rgl = load_small(ctx, &t);
  assert_int_equal(hetab_rgl_channel_count(rgl), 3);
  assert_null(hetab_rgl_wavelengths_um(rgl));
  assert_int_equal(count, 60);
  for (size_t i = 0; i < count; i++) {
    float wi[3], wo[3], f[3], drawn[3], u[2] = {(float)rows[i][10], (float)rows[i][11]};
    take(rows[i], wi);
    take(rows[i] + 3, wo);
    hetab_rgl_eval(rgl, wi, wo, f);
    for (int c = 0; c < 3; c++)
      value = fmax(value, relative_error((double)(f[c] * wo[2]), rows[i][6 + c]));
    pdf = fmax(pdf, relative_error((double)hetab_rgl_pdf(rgl, wi, wo), rows[i][9]));
    float drawn_density = hetab_rgl_sample(rgl, wi, u, drawn);
    if (drawn_density == 0.0f) {
      assert_true(rows[i][14] <= 0);
      continue;
    }
    density = fmax(density, relative_error((double)drawn_density, rows[i][15]));
    for (int c = 0; c < 3; c++)
      sample = fmax(sample, fabs((double)drawn[c] - rows[i][12 + c]));
  }
  assert_below("f cos against Mitsuba", value, TOL_RGL_MITSUBA);
  assert_below("pdf against Mitsuba", pdf, TOL_RGL_MITSUBA);
  assert_below("sample against Mitsuba", sample, TOL_RGL_MITSUBA_SAMPLE);
  assert_below("its pdf", density, TOL_RGL_MITSUBA_PDF);
  hetab_rgl_free(rgl);
  free(rows);
}

/* jacobian 0: spectra are f cos(theta_o). A constant table shows it. */
static void test_no_jacobian(void **state) {
  hetab_context *ctx = *state;
  small_table t;
  small_table_init(&t);
  t.jacobian = 0;
  for (size_t i = 0; i < T * 3 * R * R; i++)
    t.rgb[i] = 0.25f;
  hetab_rgl *rgl = load_small(ctx, &t);
  float wi[3] = {0.6f, 0.0f, 0.8f}, wo[3] = {0.0f, 0.6f, 0.8f}, down[3] = {0.6f, 0.0f, -0.8f};
  float f[3];
  hetab_rgl_eval(rgl, wi, wo, f);
  for (int c = 0; c < 3; c++)
    assert_true(relative_error((double)f[c], 0.25 / 0.8) < 1e-6);
  hetab_rgl_eval(rgl, wi, down, f);
  assert_true(f[0] == 0 && f[1] == 0 && f[2] == 0 && hetab_rgl_pdf(rgl, wi, down) == 0);
  hetab_rgl_free(rgl);
}

/* ---- samplers ------------------------------------------------------------------------------- */

static void set_direction(double theta, double phi, float w[3]) {
  w[0] = (float)(sin(theta) * cos(phi));
  w[1] = (float)(sin(theta) * sin(phi));
  w[2] = (float)cos(theta);
}

static double radians(double deg) {
  return deg * M_PI / 180;
}

enum { BINS = 12, DRAWS = 100000, FINE = 40 };

/* Bins in cos^2(theta_o) and the azimuth. */
static void expected_counts(const hetab_rgl *rgl, const float wi[3], double *out) {
  for (size_t b = 0; b < BINS * BINS; b++) {
    out[b] = 0;
    for (size_t k = 0; k < FINE * FINE; k++) {
      double c2 = ((double)(b / BINS) + ((double)(k / FINE) + 0.5) / FINE) / BINS;
      double phi = 2 * M_PI * ((double)(b % BINS) + ((double)(k % FINE) + 0.5) / FINE) / BINS;
      float wo[3];
      set_direction(acos(sqrt(c2)), phi, wo);
      out[b] += (double)hetab_rgl_pdf(rgl, wi, wo) * M_PI / sqrt(c2);
    }
    out[b] *= (double)DRAWS / (BINS * BINS * FINE * FINE);
  }
}

/* The statistic of Pearson's test; bins where fewer than 10 are expected are pooled. */
static double chi_square(const hetab_rgl *rgl, const float wi[3], uint64_t *random,
                         size_t *freedom) {
  static double expected[BINS * BINS], counted[BINS * BINS];
  double statistic = 0, rest_expected = DRAWS, rest_counted = DRAWS;
  memset(counted, 0, sizeof counted);
  expected_counts(rgl, wi, expected);
  for (size_t i = 0; i < DRAWS; i++) {
    float u[2] = {(float)uniform(random, 0, 1), (float)uniform(random, 0, 1)}, wo[3];
    if (!(hetab_rgl_sample(rgl, wi, u, wo) > 0))
      continue;
    double turn = atan2((double)wo[1], (double)wo[0]) / (2 * M_PI);
    size_t y = (size_t)((double)(wo[2] * wo[2]) * BINS), x = (size_t)((turn - floor(turn)) * BINS);
    counted[(y < BINS ? y : BINS - 1) * BINS + (x < BINS ? x : BINS - 1)]++;
  }
  *freedom = 0;
  for (size_t b = 0; b < BINS * BINS; b++)
    if (expected[b] >= 10) {
      statistic += (counted[b] - expected[b]) * (counted[b] - expected[b]) / expected[b];
      rest_expected -= expected[b];
      rest_counted -= counted[b];
      ++*freedom;
    }
  if (rest_expected >= 10)
    statistic += (rest_counted - rest_expected) * (rest_counted - rest_expected) / rest_expected;
  return statistic;
}

/* A preset at one wavelength, or at its own 31 as linear sRGB. */
static hetab_surface *open_surface(hetab_context *ctx, const char *name, double lambda_um) {
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_open(ctx, name, &surface));
  if (lambda_um > 0)
    assert_ok(ctx, hetab_surface_set_wavelengths(ctx, surface, &lambda_um, 1));
  return surface;
}

static hetab_rgl *tabulate(hetab_context *ctx, const char *name, double lambda_um,
                           double table_error, hetab_rgl_report *report) {
  hetab_surface *surface = open_surface(ctx, name, lambda_um);
  hetab_rgl_options options = {.bands = lambda_um > 0 ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB,
                               .table_error = table_error};
  hetab_rgl *rgl;
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, report));
  hetab_surface_free(surface);
  return rgl;
}

/* Directions come with the density that pdf gives. */
static void test_samples(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl_report report;
  uint64_t random = 1;
  hetab_rgl *rgl = tabulate(ctx, "BBQAL2", 0.55, 0.03, &report);
  for (int k = 0; k < 4; k++) {
    float wi[3];
    size_t freedom;
    set_direction(radians(5 + 25 * k), 1 + k, wi);
    double statistic = chi_square(rgl, wi, &random, &freedom);
    print_message("  %d degrees: chi-square %.1f with %zu degrees of freedom\n", 5 + 25 * k,
                  statistic, freedom);
    assert_true(freedom > 20);
    assert_below("standard deviations from the mean",
                 (statistic - (double)freedom) / sqrt(2.0 * (double)freedom), TOL_RGL_CHI_SQUARE);
  }
  hetab_rgl_free(rgl);
}

/* ---- against the literal equations ---------------------------------------------------------- */

enum { INCIDENCES = 9, DIRECTIONS = 500, MOST_BANDS = 31 };

/* Linear sRGB of a preset's bands, by the printed equations. */
static void literal_rgb(hetab_context *ctx, const hetab_surface *surface, const float wi[3],
                        const float wo[3], double rgb[3]) {
  const hetab_band *bands = hetab_surface_bands(surface);
  hetab_point points[MOST_BANDS];
  hetab_value values[MOST_BANDS];
  hetab_reflectance spectrum[MOST_BANDS] = {0};
  hetab_reflectance_colour colour;
  size_t count = hetab_surface_band_count(surface);
  double along = atan2((double)wo[1], (double)wo[0]) - atan2((double)wi[1], (double)wi[0]);
  for (size_t b = 0; b < count; b++)
    points[b] = (hetab_point){.lambda_um = bands[b].lambda_um,
                              .n = bands[b].n,
                              .k = bands[b].k,
                              .sigma0_um = hetab_surface_sigma0_um(surface),
                              .tau_um = hetab_surface_tau_um(surface),
                              .theta_i = acos((double)wi[2]),
                              .theta_r = acos((double)wo[2]),
                              .phi = along};
  assert_ok(ctx, hetab_evaluate_literal(ctx, points, count, values));
  for (size_t b = 0; b < count; b++)
    spectrum[b].dh = values[b].total;
  assert_ok(ctx, hetab_reflectance_rgb(ctx, surface, spectrum, 1, &colour, NULL));
  memcpy(rgb, colour.rgb, 3 * sizeof *rgb);
}

/* L1 and bias of one incidence; directions half evenly, half by the table's sampler. */
static void incidence_error(hetab_context *ctx, const hetab_surface *surface, const hetab_rgl *rgl,
                            const float wi[3], uint64_t *random, double errors[2]) {
  double sums[3] = {0};
  for (int i = 0; i < DIRECTIONS; i++) {
    float u[2] = {(float)uniform(random, 0, 1), (float)uniform(random, 0, 1)}, wo[3], value[3];
    double reference[3];
    if (i % 2)
      hetab_rgl_sample(rgl, wi, u, wo);
    else
      set_direction(acos((double)u[0]), 2 * M_PI * (double)u[1], wo);
    if (!(wo[2] > 1e-4f))
      continue;
    double cosine = (double)wo[2];
    double density = 0.5 * (double)hetab_rgl_pdf(rgl, wi, wo) + 0.25 / M_PI;
    hetab_rgl_eval(rgl, wi, wo, value);
    literal_rgb(ctx, surface, wi, wo, reference);
    for (int c = 0; c < 3; c++) {
      double difference = (double)value[c] - reference[c];
      sums[0] += fabs(difference) * cosine / density;
      sums[1] += difference * cosine / density;
      sums[2] += reference[c] * cosine / density;
    }
  }
  errors[0] = sums[0] / sums[2];
  errors[1] = fabs(sums[1] / sums[2]);
}

static void check_surface(hetab_context *ctx, const char *name) {
  hetab_rgl_report report;
  uint64_t random = 7;
  double worst_l1 = 0, worst_bias = 0;
  hetab_surface *surface = open_surface(ctx, name, 0);
  hetab_rgl *rgl = tabulate(ctx, name, 0, 0, &report);
  for (int k = 0; k < INCIDENCES; k++) {
    float wi[3];
    double errors[2], jitter = k > 0 && k + 1 < INCIDENCES ? uniform(&random, -4, 4) : 0;
    set_direction(radians(10.0 * k + jitter), uniform(&random, -3, 3), wi);
    incidence_error(ctx, surface, rgl, wi, &random, errors);
    worst_l1 = fmax(worst_l1, errors[0]);
    worst_bias = fmax(worst_bias, errors[1]);
  }
  print_message(
      "  %s: %zu incidences, %zu x %zu nodes, %.2f MB; reported %.4f, bias %.4f, %zu clamped\n",
      name, report.theta_i_count, report.resolution, report.resolution, 1e-6 * (double)report.bytes,
      report.error_l1, report.bias, report.clamped);
  assert_true(report.error_l1 <= 0.01 && fabs(report.bias) <= 0.003 && report.target == 0.01);
  assert_true(report.bytes <= 700000);
  assert_below("relative L1, worst incidence", worst_l1, TOL_RGL_L1);
  assert_below("bias", worst_bias, TOL_RGL_BIAS);
  hetab_rgl_free(rgl);
  hetab_surface_free(surface);
}

/* At the default setting: 1 % at every incidence, bias 0.3 %, 0.7 MB. */
static void test_presets(void **state) {
  for (size_t i = 0; i < 5; i++)
    check_surface(*state, hetab_preset_name(i));
}

/* A lobe of half a degree, hardly rough, and one as wide as the hemisphere, at one wavelength. */
static void test_needle(void **state) {
  hetab_context *ctx = *state;
  double lambda_um = 0.55;
  hetab_rgl_options options = {.bands = HETAB_RGL_SPECTRAL};
  hetab_rgl_report report;
  hetab_surface *surface;
  hetab_rgl *rgl;
  assert_ok(ctx, hetab_surface_create(ctx, 0.02, 0.2, 0.96, 6.7, &lambda_um, 1, &surface));
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report));
  assert_below("below the wavelength, L1", report.error_l1, 0.01);
  hetab_rgl_free(rgl);
  hetab_surface_free(surface);
  assert_ok(ctx, hetab_surface_create(ctx, 0.05, 60, 0.96, 6.7, &lambda_um, 1, &surface));
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report));
  print_message("  %zu incidences, %zu x %zu nodes: %.4f, bias %.4f\n", report.theta_i_count,
                report.resolution, report.resolution, report.error_l1, report.bias);
  assert_true(report.error_l1 <= 0.01 && hetab_rgl_channel_count(rgl) == 1);
  assert_true(hetab_rgl_wavelengths_um(rgl)[0] == 0.55);
  hetab_rgl_free(rgl);
  options.table_error = 1e-5; /* no table of any shape keeps that */
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report));
  assert_true(report.error_l1 > 1e-5 && report.error_l1 < 0.01 && report.target == 1e-5);
  hetab_rgl_free(rgl);
  options.table_error = -1;
  assert_fails(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report), HETAB_ERR_ARGUMENT,
               (const char *const[]){"table_error", NULL});
  hetab_surface_free(surface);
}

/* Asking for less never gives a larger file. */
static void test_monotone(void **state) {
  static const double errors[] = {0.005, 0.009, 0.01, 0.013, 0.02, 0.03, 0.05, 0.1};
  size_t before = SIZE_MAX;
  for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
    hetab_rgl_report report;
    hetab_rgl_free(tabulate(*state, "NGGAL", 0.55, errors[i], &report));
    print_message("  %g: %zu bytes, %.4f, bias %.4f, beyond 80 degrees %.4f\n", errors[i],
                  report.bytes, report.error_l1, report.bias, report.error_grazing);
    assert_true(report.bytes <= before && report.error_l1 <= errors[i]);
    assert_true(fabs(report.bias) <= errors[i] / 3.0 && report.error_grazing <= 0.1);
    before = report.bytes;
  }
}

/* The albedo of a table, by its own samples. */
static double albedo_of(const hetab_rgl *rgl, double theta_i) {
  enum { COUNT = 40000 };
  double sum = 0;
  float wi[3], wo[3], f;
  set_direction(theta_i, 0, wi);
  for (int i = 0; i < COUNT; i++) {
    double x = 0.5 + 0.7548776662466927 * i, y = 0.5 + 0.5698402909980532 * i;
    float u[2] = {fminf((float)(x - floor(x)), 0x1.fffffep-1f),
                  fminf((float)(y - floor(y)), 0x1.fffffep-1f)};
    float density = hetab_rgl_sample(rgl, wi, u, wo);
    if (!(density > 0))
      continue;
    hetab_rgl_eval(rgl, wi, wo, &f);
    assert_true(f > 0); /* or a chi-square test would leave it out */
    sum += (double)(f * wo[2] / density) / COUNT;
  }
  return sum;
}

/* A near mirror with its delta folded in: the energy is that of the model at every incidence. */
static void test_folded(void **state) {
  static const double theta_deg[] = {0,    7.3, 21, 33.3, 45, 52.8, 60,
                                     66.6, 71,  75, 80,   82, 83.5, 85};
  enum { COUNT = sizeof theta_deg / sizeof *theta_deg };
  hetab_context *ctx = *state;
  double lambda_um = 0.55, worst = 0;
  hetab_rgl_options options = {.bands = HETAB_RGL_SPECTRAL, .specular_cone = radians(2)};
  hetab_surface *surface;
  hetab_reflectance expected[COUNT];
  double theta_i[COUNT];
  for (size_t i = 0; i < COUNT; i++)
    theta_i[i] = radians(theta_deg[i]);
  hetab_rgl *rgl;
  assert_ok(ctx, hetab_surface_create(ctx, 0.03, 3, 2.9, 3.1, &lambda_um, 1, &surface));
  hetab_engine *engine = new_engine(ctx, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, COUNT, 0, expected));
  hetab_rgl_report report;
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report));
  assert_true(fabs(hetab_rgl_specular_cone(rgl) - radians(2)) < 1e-7);
  assert_true(report.error_l1 <= 0.01 && fabs(report.bias) <= 0.01 / 3 && report.bytes < 8000000);
  for (size_t i = 0; i < COUNT; i++) {
    double albedo = albedo_of(rgl, theta_i[i]);
    print_message("  %g degrees: %.5f of %.5f\n", theta_deg[i], albedo, expected[i].dh);
    worst = fmax(worst, relative_error(albedo, expected[i].dh));
  }
  assert_below("albedo of folded steel", worst, TOL_RGL_FOLDED);
  hetab_rgl_free(rgl);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
}

/* The source against the literal equations. */
static void test_model_source(void **state) {
  hetab_context *ctx = *state;
  uint64_t random = 3;
  enum { PAIRS = 300 };
  static hetab_directions pairs[PAIRS];
  static double values[PAIRS * MOST_BANDS];
  static const char *const names[] = {"BBQAL2", "NGGAL", "GGAL120"};
  for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
    hetab_surface *surface = open_surface(ctx, names[k], 0);
    hetab_rgl_model *model;
    double worst_value = 0, difference = 0, sum = 0;
    assert_ok(ctx, hetab_rgl_model_create(
                       ctx, surface, &(hetab_rgl_options){.bands = HETAB_RGL_SPECTRAL}, &model));
    const hetab_rgl_source *source = hetab_rgl_model_source(model);
    assert_int_equal(source->channels, MOST_BANDS);
    for (size_t i = 0; i < PAIRS; i++) {
      double theta = uniform(&random, 0, 1.5);
      pairs[i] = (hetab_directions){theta, fmin(fabs(theta + uniform(&random, -0.3, 0.3)), 1.55),
                                    uniform(&random, 2.5, 3.5)};
    }
    assert_ok(ctx, source->values(ctx, source->user, pairs, PAIRS, values));
    for (size_t i = 0; i < PAIRS * MOST_BANDS; i++) {
      const hetab_directions *pair = &pairs[i / MOST_BANDS];
      const hetab_band *band = &hetab_surface_bands(surface)[i % MOST_BANDS];
      hetab_point point = {band->lambda_um,
                           pair->theta_i,
                           pair->theta_r,
                           pair->phi,
                           hetab_surface_sigma0_um(surface),
                           hetab_surface_tau_um(surface),
                           band->n,
                           band->k,
                           band->diffuse_brdf};
      hetab_value literal;
      assert_ok(ctx, hetab_evaluate_literal(ctx, &point, 1, &literal));
      difference += fabs(values[i] - literal.total);
      sum += literal.total;
      if (literal.total >= 1e-3)
        worst_value = fmax(worst_value, relative_error(values[i], literal.total));
    }
    print_message("  %s\n", names[k]);
    assert_below("L1", difference / sum, TOL_RGL_SOURCE_L1);
    assert_below("worst", worst_value, TOL_RGL_SOURCE);
    hetab_rgl_model_free(model);
    hetab_surface_free(surface);
  }
}

/* ---- other sources -------------------------------------------------------------------------- */

/* Lambert's, of reflectances 0.1, 0.5 and 0.9. */
static hetab_status lambertian(hetab_context *ctx, void *user, const hetab_directions *pairs,
                               size_t count, double *values) {
  for (size_t i = 0; i < count; i++)
    for (int c = 0; c < 3; c++)
      values[3 * i + (size_t)c] = (0.1 + 0.4 * c) / M_PI;
  return HETAB_OK;
}

/* A source that is not ours, with closed forms: f = rho / pi. */
static void test_lambertian(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl_source source = {.channels = 3, .values = lambertian};
  hetab_rgl_options options = {.table_error = 0.02};
  hetab_rgl_report report, again = {0};
  uint64_t random = 5;
  hetab_rgl *rgl;
  assert_ok(ctx, hetab_rgl_build(ctx, &source, &options, &rgl, &report));
  print_message("  %zu incidences, %zu x %zu nodes: %.4f, bias %.4f\n", report.theta_i_count,
                report.resolution, report.resolution, report.error_l1, report.bias);
  assert_true(report.error_l1 <= 0.02);
  assert_ok(ctx, hetab_rgl_measure(ctx, &source, rgl, &again));
  assert_true(again.error_l1 <= 0.022 && again.error_l1 > 0.2 * report.error_l1);
  double sum[3] = {0};
  enum { COUNT = 20000 };
  for (int i = 0; i < COUNT; i++) { /* the albedo, by the table's own samples */
    float wi[3] = {0.6f, 0.0f, 0.8f}, wo[3], f[3];
    float u[2] = {(float)uniform(&random, 0, 1), (float)uniform(&random, 0, 1)};
    float density = hetab_rgl_sample(rgl, wi, u, wo);
    if (!(density > 0))
      continue;
    hetab_rgl_eval(rgl, wi, wo, f);
    for (int c = 0; c < 3; c++)
      sum[c] += (double)(f[c] * wo[2] / density) / COUNT;
  }
  for (int c = 0; c < 3; c++)
    assert_below("albedo", relative_error(sum[c], 0.1 + 0.4 * c), 0.02);
  hetab_rgl_free(rgl);
}

/* Nothing but at grazing incidence. */
static hetab_status grazing_only(hetab_context *ctx, void *user, const hetab_directions *pairs,
                                 size_t count, double *values) {
  const double least = radians(86);
  for (size_t i = 0; i < count; i++)
    for (int c = 0; c < 3; c++)
      values[3 * i + (size_t)c] = pairs[i].theta_i > least && pairs[i].theta_r > least ? 1.0 : 0.0;
  return HETAB_OK;
}

/* A source that gives no reason to place incidences anywhere: the file is a table all the same. */
static void test_dark(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl_source source = {.channels = 3, .values = grazing_only};
  hetab_rgl_options options = {.table_error = 0.02};
  hetab_rgl_report report;
  hetab_rgl *rgl, *again;
  char path[64];
  assert_ok(ctx, hetab_rgl_build(ctx, &source, &options, &rgl, &report));
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, temporary(path), 1));
  assert_ok(ctx, hetab_rgl_load(ctx, path, &again));
  unlink(path);
  hetab_rgl_free(rgl);
  hetab_rgl_free(again);
}

/* ---- files ---------------------------------------------------------------------------------- */

static unsigned char *read_whole(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  unsigned char *data = malloc(1 << 24);
  *size = fread(data, 1, 1 << 24, file);
  fclose(file);
  return data;
}

/* What is saved is what is loaded, to the bit of the second saving. */
static void test_round_trip(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl_report report;
  uint64_t random = 9;
  char first[64], second[64];
  size_t sizes[2];
  hetab_rgl *rgl = tabulate(ctx, "BBQAL2", 0.55, 0.05, &report), *loaded, *again;
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, temporary(first), 1));
  assert_fails(ctx, hetab_rgl_save(ctx, rgl, first, 0), HETAB_ERR_EXISTS,
               (const char *const[]){first, NULL});
  assert_ok(ctx, hetab_rgl_load(ctx, first, &loaded));
  assert_ok(ctx, hetab_rgl_save(ctx, loaded, temporary(second), 1));
  assert_ok(ctx, hetab_rgl_load(ctx, second, &again));
  unsigned char *data[2] = {read_whole(first, &sizes[0]), read_whole(second, &sizes[1])};
  assert_true(sizes[0] == sizes[1] && sizes[0] == report.bytes);
  double worst = 0;
  for (int i = 0; i < 2000; i++) {
    float wi[3], wo[3], a, b;
    set_direction(uniform(&random, 0, 1.55), uniform(&random, -3, 3), wi);
    set_direction(uniform(&random, 0, 1.55), uniform(&random, -3, 3), wo);
    hetab_rgl_eval(rgl, wi, wo, &a);
    hetab_rgl_eval(loaded, wi, wo, &b);
    if ((double)a >= 1e-3)
      worst = fmax(worst, relative_error((double)b, (double)a));
  }
  assert_below("loaded against built", worst, TOL_RGL_FILE);
  assert_true(hetab_rgl_wavelengths_um(loaded)[0] > 0.5499999 &&
              hetab_rgl_wavelengths_um(loaded)[0] < 0.5500001);
  unlink(first);
  unlink(second);
  free(data[0]);
  free(data[1]);
  hetab_rgl_free(rgl);
  hetab_rgl_free(loaded);
  hetab_rgl_free(again);
}

static void refuse(hetab_context *ctx, const bytes *b, hetab_status expected, const char *word) {
  char path[64];
  hetab_rgl *rgl;
  save_bytes(b, b->size, temporary(path));
  assert_fails(ctx, hetab_rgl_load(ctx, path, &rgl), expected,
               (const char *const[]){path, word, NULL});
  assert_null(rgl);
  unlink(path);
}

/* A small table with `size` bytes replaced. */
static void refuse_patch(hetab_context *ctx, size_t at, const void *patch, size_t size,
                         const char *word) {
  static bytes b;
  small_table t;
  small_table_init(&t);
  assemble(t.fields, FIELDS, &b);
  memcpy(b.data + at, patch, size);
  refuse(ctx, &b, HETAB_ERR_PARSE, word);
}

static void test_hostile_header(void **state) {
  static bytes b;
  small_table t;
  small_table_init(&t);
  places at = assemble(t.fields, FIELDS, &b);
  uint64_t far = UINT64_MAX - 3, huge = 1ull << 62, near = at.data[VNDF], zero = 0;
  uint32_t many = 0xffffffff;
  uint16_t dims = 9;
  refuse_patch(*state, 0, "T", 1, "tensor_file");
  refuse_patch(*state, 12, "\2", 1, "version");
  refuse_patch(*state, 14, &many, 4, "fields");
  refuse_patch(*state, at.name[0] - 2, &many, 2, "name");
  refuse_patch(*state, at.name[0] - 2, &zero, 2, "name");
  refuse_patch(*state, at.ndim[VNDF], &dims, 2, "dimensions");
  refuse_patch(*state, at.type[VNDF], "\0", 1, "vndf: there is no type 0");
  refuse_patch(*state, at.type[VNDF], "\377", 1, "vndf: there is no type 255");
  refuse_patch(*state, at.type[VNDF], "\5", 1, "vndf holds uint32 in place of float32");
  refuse_patch(*state, at.offset[VNDF], &far, 8, "vndf");
  refuse_patch(*state, at.offset[LUMINANCE], &near, 8, "overlap");
  refuse_patch(*state, at.offset[VNDF], &zero, 8, "header");
  refuse_patch(*state, at.shape[VNDF] + 8, &huge, 8, "vndf");
  refuse_patch(*state, at.shape[VNDF], &zero, 8, "vndf is empty");
  refuse_patch(*state, at.shape[VNDF], &far, 8, "vndf");
}

static void test_hostile_numbers(void **state) {
  static bytes b;
  small_table t;
  float nan = NAN, infinite = INFINITY, negative = -1, large = 3e38f, nought = 0,
        zeros[VX * VY] = {0};
  small_table_init(&t);
  places at = assemble(t.fields, FIELDS, &b);
  refuse_patch(*state, at.data[VNDF] + 40, &nan, 4, "vndf: number 10 is nan");
  refuse_patch(*state, at.data[RGB], &infinite, 4, "rgb: number 0 is inf");
  refuse_patch(*state, at.data[LUMINANCE], &negative, 4, "luminance: number 0 is -1");
  refuse_patch(*state, at.data[SIGMA_FIELD] + 8, &nought, 4, "sigma: number 2 is 0");
  refuse_patch(*state, at.data[RGB] + 4, &negative, 4, "rgb: number 1 is -1");
  refuse_patch(*state, at.data[RGB], &large, 4, "rgb: 3e+38 overflows");
  refuse_patch(*state, at.data[THETA_I] + 8, &nought, 4, "theta_i: number 2");
  refuse_patch(*state, at.data[THETA_I] + 12, &infinite, 4, "theta_i");
  refuse_patch(*state, at.data[VNDF] + sizeof zeros, zeros, sizeof zeros, "vndf: slice 1");
  refuse_patch(*state, at.name[VNDF], "vodf", 4, "no field vndf");
  refuse_patch(*state, at.name[NDF_FIELD], "rgb", 3, "two fields rgb");
}

/* Noise about 0 is taken for 0 and counted. */
static void test_negative_noise(void **state) {
  hetab_context *ctx = *state;
  static bytes b;
  small_table t;
  char path[64];
  hetab_rgl *rgl;
  float largest = 0;
  small_table_init(&t);
  places at = assemble(t.fields, FIELDS, &b);
  for (size_t i = 0; i < sizeof t.rgb / sizeof *t.rgb; i++)
    largest = fmaxf(largest, t.rgb[i]);
  float noise = -0.9e-3f * largest, damage = -1.1e-3f * largest;
  refuse_patch(ctx, at.data[RGB] + 4, &damage, 4, "rgb: number 1");
  memcpy(b.data + at.data[RGB] + 4, &noise, 4);
  save_bytes(&b, b.size, temporary(path));
  assert_ok(ctx, hetab_rgl_load(ctx, path, &rgl));
  assert_int_equal(hetab_rgl_negative(rgl), 1);
  hetab_rgl_free(rgl);
  unlink(path);
}

/* Fields that are well formed, but do not fit each other. */
static void test_hostile_shapes(void **state) {
  static const struct {
    size_t field, dimension;
    uint64_t extent;
    const char *word;
  } cases[] = {{THETA_I, 0, 3, "vndf: dimension 1 is 4 in place of 3"},
               {NDF_FIELD, 0, 1, "ndf: dimension 0 is 1"},
               {VNDF, 3, 1, "vndf: dimension 3 is 1"},
               {LUMINANCE, 1, 3, "luminance: dimension 1 is 3"},
               {LUMINANCE, 2, 4, "luminance has 4 x 5 nodes"},
               {RGB, 2, 2, "rgb: dimension 2 is 2 in place of 3"},
               {RGB, 4, 4, "rgb: dimension 4 is 4 in place of 5"}};
  static bytes b;
  small_table t;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    small_table_init(&t);
    t.fields[cases[i].field].shape[cases[i].dimension] = cases[i].extent;
    assemble(t.fields, FIELDS, &b);
    refuse(*state, &b, HETAB_ERR_PARSE, cases[i].word);
  }
  small_table_init(&t);
  for (size_t i = 0; i < 8; i++)
    t.phi_i[i] = (float)i;
  t.fields[PHI_I].shape[0] = 8;
  assemble(t.fields, FIELDS, &b);
  refuse(*state, &b, HETAB_ERR_UNSUPPORTED, "anisotropic");
  static float many[4097];
  field more[FIELDS + 1];
  small_table_init(&t);
  memcpy(more, t.fields, sizeof t.fields);
  more[FIELDS] = (field){"wavelengths", F32, 1, {4097}, many};
  assemble(more, FIELDS + 1, &b);
  refuse(*state, &b, HETAB_ERR_PARSE, "4097 of them");
}

/* Every truncation of the header and many of the data; every byte of the header changed. */
static void test_corrupted(void **state) {
  hetab_context *ctx = *state;
  static bytes b, changed;
  small_table t;
  char path[64];
  size_t loaded = 0;
  small_table_init(&t);
  places at = assemble(t.fields, FIELDS, &b);
  temporary(path);
  for (size_t size = 0; size < b.size; size += size < at.data[0] ? 1 : 97) {
    hetab_rgl *rgl;
    save_bytes(&b, size, path);
    assert_fails(ctx, hetab_rgl_load(ctx, path, &rgl), HETAB_ERR_PARSE,
                 (const char *const[]){path, NULL});
  }
  for (size_t i = 0; i < 2 * at.data[0]; i++) {
    hetab_rgl *rgl;
    float wi[3] = {0.6f, 0.0f, 0.8f}, u[2] = {0.3f, 0.6f}, wo[3], f[64];
    changed = b;
    changed.data[i / 2] = (unsigned char)(i % 2 ? changed.data[i / 2] + 1 : 0xff);
    save_bytes(&changed, changed.size, path);
    if (hetab_rgl_load(ctx, path, &rgl) != HETAB_OK)
      continue;
    loaded++; /* what can be read can be used */
    assert_true(hetab_rgl_channel_count(rgl) <= 64);
    hetab_rgl_sample(rgl, wi, u, wo);
    hetab_rgl_eval(rgl, wi, wo, f);
    hetab_rgl_free(rgl);
  }
  unlink(path);
  print_message("  %zu of %zu changes leave a table\n", loaded, 2 * at.data[0]);
  assert_true(loaded < at.data[0]);
}

static void test_no_file(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl *rgl;
  assert_fails(ctx, hetab_rgl_load(ctx, "/nowhere/x.bsdf", &rgl), HETAB_ERR_IO,
               (const char *const[]){"/nowhere/x.bsdf", NULL});
  assert_fails(ctx, hetab_rgl_load(ctx, "/tmp", &rgl), HETAB_ERR_IO,
               (const char *const[]){"/tmp", NULL});
  hetab_rgl_free(NULL);
}

/* Tables of others: spectra; two azimuths; a luminance of zeros, which samples evenly. */
static void test_foreign(void **state) {
  hetab_context *ctx = *state;
  small_table t, dark;
  float nm[] = {400, 550, 700}, wi[3] = {0.6f, 0.0f, 0.8f}, wo[3] = {-0.48f, 0.36f, 0.8f};
  float a[3], b[3];
  small_table_init(&t);
  small_table_init(&dark);
  t.fields[DESCRIPTION] = (field){"wavelengths", F32, 1, {3}, nm};
  t.fields[RGB].name = "spectra";
  memset(dark.luminance, 0, sizeof dark.luminance);
  hetab_rgl *spectral = load_small(ctx, &t), *rgb = load_small(ctx, &dark);
  assert_true(fabs(hetab_rgl_wavelengths_um(spectral)[1] - 0.55) < 1e-9);
  hetab_rgl_eval(spectral, wi, wo, a);
  hetab_rgl_eval(rgb, wi, wo, b);
  assert_memory_equal(a, b, sizeof a);
  float pdf = hetab_rgl_pdf(rgb, wi, wo);
  assert_true(isfinite(pdf) && pdf > 0);
  static float vndf[2 * T * VX * VY], luminance[2 * T * R * R], values[2 * T * 3 * R * R];
  for (size_t half = 0; half < 2; half++) { /* the same at both azimuths */
    numbers(3, T * VX * VY, vndf + half * T * VX * VY);
    numbers(4, T * R * R, luminance + half * T * R * R);
    numbers(5, T * 3 * R * R, values + half * T * 3 * R * R);
  }
  small_table_init(&t);
  t.phi_i[0] = -1;
  t.phi_i[1] = 2;
  t.fields[PHI_I].shape[0] = t.fields[VNDF].shape[0] = 2;
  t.fields[LUMINANCE].shape[0] = t.fields[RGB].shape[0] = 2;
  t.fields[VNDF].data = vndf;
  t.fields[LUMINANCE].data = luminance;
  t.fields[RGB].data = values;
  hetab_rgl *two = load_small(ctx, &t);
  hetab_rgl_eval(two, wi, wo, a);
  for (int c = 0; c < 3; c++)
    assert_true(relative_error((double)a[c], (double)b[c]) < 1e-5);
  hetab_rgl_free(spectral);
  hetab_rgl_free(rgb);
  hetab_rgl_free(two);
  nm[2] = 550;
  small_table_init(&t);
  t.fields[DESCRIPTION] = (field){"wavelengths", F32, 1, {3}, nm};
  t.fields[RGB].name = "spectra";
  static bytes file;
  assemble(t.fields, FIELDS, &file);
  refuse(ctx, &file, HETAB_ERR_PARSE, "wavelengths: number 2");
}

/* One field as another parser, by the format's description alone, finds it at *at. */
static field parse_field(const unsigned char *data, size_t *at) {
  static char names[16][32];
  static size_t next;
  char *name = names[next++ % 16];
  uint16_t length, ndim;
  uint64_t offset;
  memcpy(&length, data + *at, 2);
  assert_true(length > 0 && length < sizeof names[0]);
  memcpy(name, data + *at + 2, length);
  name[length] = '\0';
  *at += 2u + length;
  memcpy(&ndim, data + *at, 2);
  memcpy(&offset, data + *at + 3, 8);
  field f = {.name = name, .type = data[*at + 2], .ndim = ndim, .data = data + offset};
  assert_true(ndim <= 5 && offset % 8 == 0 && (f.type == U8 || f.type == F32));
  memcpy(f.shape, data + *at + 11, 8u * ndim);
  *at += 11 + 8u * ndim;
  return f;
}

static void assert_field(const field *f, const char *name, unsigned ndim, const uint64_t *shape) {
  assert_string_equal(f->name, name);
  assert_int_equal(f->ndim, ndim);
  for (unsigned d = 0; d < ndim; d++)
    assert_int_equal(f->shape[d], shape[d]);
}

/* A file of ours: names, types, shapes, and data that follow each other up to the end. */
static void test_container(void **state) {
  hetab_context *ctx = *state;
  hetab_rgl_report report;
  char path[64];
  size_t size, at = 18;
  hetab_rgl *rgl = tabulate(ctx, "NGGAL", 0.55, 0.1, &report);
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, temporary(path), 1));
  unsigned char *data = read_whole(path, &size), *end = data;
  uint32_t count;
  memcpy(&count, data + 14, 4);
  assert_memory_equal(data, "tensor_file\0\1\0", 14);
  assert_int_equal(count, 10);
  const uint64_t t = report.theta_i_count, n = report.ndf_count, r = report.resolution;
  field f[10];
  for (uint32_t i = 0; i < count; i++) {
    f[i] = parse_field(data, &at);
    assert_int_equal(f[i].type, i < 2 ? U8 : F32);
    assert_true((const unsigned char *)f[i].data >= end);
    end = data + ((const unsigned char *)f[i].data - data) + field_size(&f[i]);
  }
  assert_true(end == data + size);
  assert_field(&f[0], "description", 1, f[0].shape);
  assert_field(&f[1], "jacobian", 1, (uint64_t[]){1});
  assert_field(&f[2], "phi_i", 1, (uint64_t[]){1});
  assert_field(&f[3], "theta_i", 1, (uint64_t[]){t});
  assert_field(&f[4], "ndf", 2, (uint64_t[]){2, n});
  assert_field(&f[5], "sigma", 2, (uint64_t[]){2, n});
  assert_field(&f[6], "vndf", 4, (uint64_t[]){1, t, 16, report.vndf_count});
  assert_field(&f[7], "luminance", 4, (uint64_t[]){1, t, r, r});
  assert_field(&f[8], "wavelengths", 1, (uint64_t[]){1});
  assert_field(&f[9], "spectra", 5, (uint64_t[]){1, t, 1, r, r});
  const float *theta = f[3].data;
  assert_true(theta[0] == 0.0f && theta[t - 1] == (float)M_PI_2);
  assert_true(*(const unsigned char *)f[1].data == 1 && *(const float *)f[8].data == 550.0f);
  free(data);
  unlink(path);
  hetab_rgl_free(rgl);
}

/* Normal and grazing incidence, mirror and retro-reflection, the ends of u: nothing but numbers. */
static void test_edges(void **state) {
  static const float z[] = {1.0f, 0.99999994f, 0.9999f, 0.5f, 1e-3f, 1e-6f, 1e-30f};
  enum { COUNT = sizeof z / sizeof *z };
  hetab_rgl_report report;
  hetab_rgl *rgl = tabulate(*state, "NGGAL", 0.55, 0.1, &report);
  for (size_t k = 0; k < COUNT * COUNT * 4; k++) {
    float phi = (float)(M_PI_2 * (double)(k % 4)), f, pdf, u[2] = {z[k / 4 % COUNT], 0.0f},
          drawn[3];
    float zi = z[k / 4 % COUNT], zo = z[k / 4 / COUNT];
    float wi[3] = {sqrtf(1 - zi * zi), 0.0f, zi};
    float wo[3] = {sqrtf(1 - zo * zo) * cosf(phi), sqrtf(1 - zo * zo) * sinf(phi), zo};
    u[0] = fminf(u[0], 0x1.fffffep-1f);
    hetab_rgl_eval(rgl, wi, wo, &f);
    pdf = hetab_rgl_pdf(rgl, wi, wo);
    assert_true(f >= 0 && pdf >= 0 && isfinite(pdf) && (isfinite(f) || zo < 1e-6f));
    pdf = hetab_rgl_sample(rgl, wi, u, drawn);
    assert_true(pdf >= 0 && isfinite(pdf));
    if (pdf > 0)
      assert_true(fabsf(drawn[0] * drawn[0] + drawn[1] * drawn[1] + drawn[2] * drawn[2] - 1) <
                  1e-5f);
  }
  hetab_rgl_free(rgl);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(test_mitsuba),         TEST(test_no_jacobian),
                                     TEST(test_container),       TEST(test_round_trip),
                                     TEST(test_samples),         TEST(test_model_source),
                                     TEST(test_presets),         TEST(test_needle),
                                     TEST(test_monotone),        TEST(test_folded),
                                     TEST(test_lambertian),      TEST(test_hostile_header),
                                     TEST(test_hostile_numbers), TEST(test_hostile_shapes),
                                     TEST(test_corrupted),       TEST(test_no_file),
                                     TEST(test_edges),           TEST(test_foreign),
                                     TEST(test_negative_noise),  TEST(test_dark)};
  return cmocka_run_group_tests_name("RGL tables", tests, NULL, NULL);
}
