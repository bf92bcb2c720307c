/* Roughness: signals with known answers, the filter, random surfaces against the process's own
 * statistics, whether the intervals cover, and readers of text and SDF. */
#include "golden_support.h"
#include "profile_support.h"
#include "text_fixture.h"

#include <hetab/roughness.h>
#include <stdbool.h>
#include "core/student.h"

static const profile_scale report_surfaces[5] = {
    {0.72, 5.6}, {0.54, 6.5}, {0.86, 5.6}, {0.61, 4.7}, {0.13, 5.4}};
static const char *const report_names[5] = {"BBQAL1", "BBQAL2", "GGAL120", "GGAL240", "NGGAL"};

static hetab_heights *new_scans(hetab_context *ctx, const double *z_um, size_t count, size_t rows,
                                double spacing_um) {
  hetab_heights *heights;
  assert_ok(ctx, hetab_heights_create(ctx, "scans", HETAB_HEIGHTS_SCANS, z_um, count, rows,
                                      spacing_um, 0, &heights));
  return heights;
}

/* Of heights that are then gone. */
static hetab_roughness *measured(hetab_context *ctx, hetab_heights *heights,
                                 const hetab_roughness_options *options) {
  const hetab_heights *list = heights;
  hetab_roughness *r;
  assert_ok(ctx, hetab_roughness_measure(ctx, &list, 1, options, &r));
  hetab_heights_free(heights);
  return r;
}

static int has_note(const hetab_roughness *r, const char *words) {
  for (size_t i = 0; i < r->note_count; i++)
    if (strstr(r->notes[i], words))
      return 1;
  return 0;
}

static double *gaussian_scans(profile_scale a, profile_scale b, size_t count, size_t rows,
                              uint64_t *state) {
  double *z_um = calloc(count * rows, sizeof *z_um);
  for (size_t row = 0; row < rows; row++) {
    add_gaussian_profile(z_um + row * count, count, 0.1, a, state);
    if (b.sigma_um > 0)
      add_gaussian_profile(z_um + row * count, count, 0.1, b, state);
  }
  return z_um;
}

/* ---- the filter ---------------------------------------------------------------------------- */

enum { SINE_POINTS = 6000 };

/* How much of a sine's amplitude the small-scale part keeps, where no weights are missing. */
static double kept_amplitude(hetab_context *ctx, double wavelength_um, double cutoff_um) {
  double z[SINE_POINTS], line[SINE_POINTS], product = 0, square = 0;
  unsigned char evaluated[SINE_POINTS];
  for (int i = 0; i < SINE_POINTS; i++)
    z[i] = sin(2 * M_PI * i * 0.1 / wavelength_um + 0.7);
  assert_ok(ctx, hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, SINE_POINTS, 0.1, cutoff_um, line,
                                 evaluated));
  int end = (int)(cutoff_um / 0.1);
  for (int i = end; i < SINE_POINTS - end; i++) {
    product += z[i] * (z[i] - line[i]);
    square += z[i] * z[i];
  }
  return product / square;
}

static void test_transmission(void **state) {
  assert_below("50 % at the cut-off", fabs(kept_amplitude(*state, 30, 30) - 0.5), TOL_TRANSMISSION);
  for (double wavelength = 10; wavelength <= 120; wavelength += 11) {
    double kept = kept_amplitude(*state, wavelength, 40), ratio = 40 / wavelength;
    assert_true(fabs(kept - (1 - pow(0.5, ratio * ratio))) < TOL_TRANSMISSION);
  }
}

/* Half a cut-off at each end, and at a gap longer than a tenth of it. */
static void test_end_zones(void **state) {
  hetab_context *ctx = *state;
  double z[1000], line[1000];
  unsigned char evaluated[1000];
  for (int i = 0; i < 1000; i++)
    z[i] = 2 + 0.001 * i;
  z[300] = z[301] = NAN; /* short */
  for (int i = 500; i < 520; i++)
    z[i] = NAN; /* long */
  assert_ok(ctx, hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, 1000, 0.5, 50, line, evaluated));
  for (int i = 0; i < 1000; i++) {
    int inside = (i >= 50 && i < 450) || (i >= 570 && i < 950);
    assert_int_equal(evaluated[i], inside && i != 300 && i != 301);
  }
  /* What the filter says of a straight line where it is evaluated: the line. */
  for (int i = 100; i < 200; i++)
    assert_true(fabs(line[i] - z[i]) < 1e-6);
  assert_int_equal(hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, 1000, 0.5, 4.9, line, evaluated),
                   HETAB_ERR_ARGUMENT);
  assert_int_equal(hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, 1000, 0.5, 501, line, evaluated),
                   HETAB_ERR_ARGUMENT);
}

/* The printed convolution, weight by weight, where nothing is missing. */
static void test_convolution(void **state) {
  hetab_context *ctx = *state;
  uint64_t random = 3;
  double z[800], line[800], alpha = sqrt(M_LN2 / M_PI), cutoff = 20;
  unsigned char evaluated[800];
  for (int i = 0; i < 800; i++)
    z[i] = random_normal(&random);
  assert_ok(ctx,
            hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, 800, 0.25, cutoff, line, evaluated));
  for (int i = 100; i < 700; i += 7) {
    double sum = 0;
    for (int j = 0; j < 800; j++) {
      double x = (i - j) * 0.25 / (alpha * cutoff);
      sum += 0.25 / (alpha * cutoff) * exp(-M_PI * x * x) * z[j];
    }
    assert_true(fabs(sum - line[i]) < 1e-6);
  }
}

/* The moving average sum by sum; the Fourier filter between two waves, one of them longer than the
 * cut-off; the robust one over pits that drag the Gaussian line down. */
static void test_other_filters(void **state) {
  enum { POINTS = 800 };
  hetab_context *ctx = *state;
  uint64_t random = 5;
  double z[POINTS], line[POINTS], dragged[POINTS];
  unsigned char evaluated[POINTS];
  for (int i = 0; i < POINTS; i++)
    z[i] = random_normal(&random);
  assert_ok(ctx,
            hetab_mean_line(ctx, HETAB_FILTER_AVERAGE, z, POINTS, 0.2, 41 * 0.2, line, evaluated));
  for (int i = 50; i < POINTS - 50; i++) {
    double sum = 0;
    for (int j = -20; j <= 20; j++)
      sum += z[i + j] / 41;
    assert_true(!evaluated[i] || fabs(sum - line[i]) < 1e-12);
  }
  for (int i = 0; i < POINTS; i++)
    z[i] = sin(2 * M_PI * i / 160) + sin(2 * M_PI * i / 25);
  assert_ok(ctx, hetab_mean_line(ctx, HETAB_FILTER_FOURIER, z, POINTS, 0.2, 12, line, evaluated));
  for (int i = 200; i < POINTS - 200; i++)
    assert_true(fabs(line[i] - sin(2 * M_PI * i / 160)) < 0.03);
  for (int i = 0; i < POINTS; i++)
    z[i] = 0.001 * i + 0.01 * random_normal(&random) - (i % 100 < 20 ? 1 : 0);
  assert_ok(ctx, hetab_mean_line(ctx, HETAB_FILTER_ROBUST, z, POINTS, 0.2, 20, line, evaluated));
  assert_ok(ctx,
            hetab_mean_line(ctx, HETAB_FILTER_GAUSSIAN, z, POINTS, 0.2, 20, dragged, evaluated));
  double worst = 0, most = 0;
  for (int i = 100; i < POINTS - 100; i++) {
    worst = fmax(worst, fabs(line[i] - 0.001 * i));
    most = fmax(most, fabs(dragged[i] - 0.001 * i));
  }
  print_message("  pits: robust line off by %.4f, Gaussian by %.3f\n", worst, most);
  assert_true(worst < 0.02 && most > 0.1);
  for (int i = 300; i < 500; i++)
    z[i] -= 5; /* wider than the cut-off */
  assert_ok(ctx, hetab_mean_line(ctx, HETAB_FILTER_ROBUST, z, POINTS, 0.2, 20, line, evaluated));
  for (int i = 0; i < POINTS; i++)
    assert_true(isfinite(line[i]));
}

/* ---- signals with known answers ------------------------------------------------------------- */

/* 100 whole waves: sigma = A / sqrt 2; the autocorrelation is (1 - r / L) cos. */
static void test_sine(void **state) {
  double z[4000];
  for (int i = 0; i < 4000; i++)
    z[i] = 0.3 * sin(2 * M_PI * i / 40);
  hetab_roughness_options options = {.level = HETAB_LEVEL_NONE};
  hetab_roughness *r = measured(*state, new_scans(*state, z, 4000, 1, 0.1), &options);
  const hetab_scan_statistics *s = &r->raw.scans[0];
  double tau = 4 * acos(exp(-1)) / (2 * M_PI);
  assert_true(relative_error(s->sigma_um.value, 0.3 / sqrt(2)) < 1e-12);
  assert_true(relative_error(s->tau_um.value, tau) < 2e-3); /* linear between 40 lags a wave */
  assert_true(relative_error(s->slope.value, s->sigma_um.value / s->tau_um.value) < 1e-14);
  double step = 2 * 0.3 * sin(M_PI / 40) / sqrt(2) / 0.1; /* rms of first differences */
  assert_true(relative_error(s->rms_slope.value, step) < 1e-3);
  assert_true(fabs(s->skewness.value) < 1e-10 && fabs(s->kurtosis.value - 1.5) < 1e-10);
  assert_true(has_note(r, "not Gaussian"));
  hetab_roughness_free(r);
}

static void test_white_noise(void **state) {
  enum { COUNT = 100000 };
  double *z = calloc(COUNT, sizeof *z);
  uint64_t random = 11;
  for (int i = 0; i < COUNT; i++)
    z[i] = 0.2 * random_normal(&random);
  hetab_roughness *r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  const hetab_scan_statistics *s = &r->raw.scans[0];
  assert_true(fabs(s->sigma_um.value - 0.2) < 3 * s->sigma_um.error);
  assert_true(relative_error(s->sigma_um.error, 0.2 / sqrt(2.0 * COUNT)) < 0.02);
  assert_true(relative_error(s->tau_um.value, 0.1 * (1 - exp(-1))) < 0.02);
  assert_true(relative_error(s->rms_slope.value, sqrt(2) * 0.2 / 0.1) < 0.02);
  assert_true(fabs(s->skewness.value) < 3 * s->skewness.error);
  assert_true(fabs(s->kurtosis.value - 3) < 3 * s->kurtosis.error);
  assert_true(relative_error(s->skewness.error, sqrt(6.0 / COUNT)) < 0.02);
  assert_true(relative_error(s->kurtosis.error, sqrt(24.0 / COUNT)) < 0.02);
  assert_true(relative_error(s->independent, COUNT) < 0.02);
  assert_true(s->normal_distance < 2 / sqrt(COUNT));
  assert_int_equal(r->scans[0].outliers, 0);
  assert_true(has_note(r, "too far apart"));
  hetab_roughness_free(r);
  free(z);
}

/* A long scan of one Gaussian scale: every number of the process. */
static void test_long_scan(void **state) {
  enum { COUNT = 400000 };
  profile_scale scale = {0.5, 5}, none = {0, 0};
  uint64_t random = 5;
  double *z = gaussian_scans(scale, none, COUNT, 1, &random);
  hetab_roughness *r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  const hetab_scan_statistics *s = &r->raw.scans[0];
  assert_below("sigma", relative_error(s->sigma_um.value, 0.5), 0.02);
  assert_below("tau", relative_error(s->tau_um.value, 5), 0.02);
  assert_below("rms slope / (sqrt 2 sigma / tau)",
               relative_error(s->rms_slope.value, M_SQRT2 * s->slope.value), 0.02);
  /* integral of exp(-2 (r/tau)^2): sqrt(pi/2) tau */
  assert_below("independent", relative_error(s->independent, 40000 / (sqrt(M_PI / 2) * 5)), 0.1);
  assert_true(s->misfit_gaussian < 0.02 && s->misfit_exponential > 0.1);
  assert_int_equal(r->note_count, 0);
  assert_true(relative_error(r->curvature_um, 25 / (sqrt(12) * 0.5)) < 0.05);
  hetab_roughness_free(r);
  free(z);
}

/* ---- levelling, gaps, outliers -------------------------------------------------------------- */

static void test_levelling(void **state) {
  profile_scale scale = {0.3, 2}, none = {0, 0};
  uint64_t random = 17;
  double *z = gaussian_scans(scale, none, 2000, 1, &random);
  hetab_roughness *flat = measured(*state, new_scans(*state, z, 2000, 1, 0.1), NULL);
  for (int i = 0; i < 2000; i++)
    z[i] += 400 - 0.05 * i;
  hetab_roughness *tilted = measured(*state, new_scans(*state, z, 2000, 1, 0.1), NULL);
  assert_true(relative_error(tilted->raw.sigma_um.mean, flat->raw.sigma_um.mean) < 1e-10);
  assert_true(relative_error(tilted->raw.tau_um.mean, flat->raw.tau_um.mean) < 1e-10);
  hetab_roughness_options as_is = {.level = HETAB_LEVEL_NONE};
  hetab_roughness *raw = measured(*state, new_scans(*state, z, 2000, 1, 0.1), &as_is);
  assert_true(raw->raw.sigma_um.mean > 20);
  hetab_roughness_free(flat);
  hetab_roughness_free(tilted);
  hetab_roughness_free(raw);
  free(z);
}

/* 2000 scans of 50 tau: what the mean and the line carry away of sigma and tau, in tau / length. */
static void test_levelling_bias(void **state) {
  profile_scale scale = {0.3, 2}, none = {0, 0};
  uint64_t random = 19;
  double *z = gaussian_scans(scale, none, 1000, 2000, &random);
  hetab_roughness *r = measured(*state, new_scans(*state, z, 1000, 2000, 0.1), NULL);
  double sigma = 50 * (1 - r->raw.sigma_um.mean / 0.3), tau = 50 * (1 - r->raw.tau_um.mean / 2);
  print_message("  sigma low by %.2f tau / length, tau by %.2f\n", sigma, tau);
  assert_true(fabs(sigma - 2) < 0.3 && fabs(tau - 2.5) < 0.3);
  hetab_roughness_free(r);
  free(z);
}

static void test_plane(void **state) {
  enum { SIDE = 120 };
  double *z = calloc(SIDE * SIDE, sizeof *z);
  uint64_t random = 23;
  for (int i = 0; i < SIDE * SIDE; i++)
    z[i] = 0.1 * random_normal(&random) + 3 * (i % SIDE) - 7 * (double)(i / SIDE);
  hetab_heights *map;
  assert_ok(*state,
            hetab_heights_create(*state, "map", HETAB_HEIGHTS_MAP, z, SIDE, SIDE, 0.5, 0.5, &map));
  hetab_roughness *r = measured(*state, map, NULL);
  assert_int_equal(r->raw.count, 2 * SIDE);
  assert_true(relative_error(r->raw.sigma_um.mean, 0.1) < 0.02);
  assert_string_equal(r->scans[SIDE].name, "map column 1");
  hetab_roughness_free(r);
  free(z);
}

static void test_gaps_and_outliers(void **state) {
  profile_scale scale = {0.3, 4}, none = {0, 0};
  uint64_t random = 29;
  double *z = gaussian_scans(scale, none, 8000, 1, &random);
  hetab_roughness_options options = {.cutoff_um = 40};
  hetab_roughness *whole = measured(*state, new_scans(*state, z, 8000, 1, 0.1), &options);
  for (int i = 100; i < 8000; i += 397)
    z[i] += i % 2 ? 1e4 : -8; /* 21 spikes, the larger ones tilting the first fit */
  for (int i = 50; i < 8000; i += 97)
    z[i] = NAN;
  for (int i = 3000; i < 3100; i++)
    z[i] = INFINITY;
  hetab_roughness *holed = measured(*state, new_scans(*state, z, 8000, 1, 0.1), &options);
  const hetab_scan_source *s = &holed->scans[0];
  size_t missing = 0;
  for (int i = 0; i < 8000; i++)
    missing += isfinite(z[i]) ? 0 : 1;
  assert_int_equal(s->missing, missing);
  assert_true(s->outliers >= 19 && s->outliers <= 21); /* some fall on what is missing */
  assert_below("sigma", relative_error(holed->small.sigma_um.mean, whole->small.sigma_um.mean),
               0.03);
  assert_below("tau", relative_error(holed->small.tau_um.mean, whole->small.tau_um.mean), 0.03);
  hetab_roughness_free(holed);
  hetab_roughness_options keep = {.outlier = -1};
  holed = measured(*state, new_scans(*state, z, 8000, 1, 0.1), &keep);
  assert_int_equal(holed->scans[0].outliers, 0);
  assert_true(holed->raw.sigma_um.mean > 100);
  hetab_roughness_free(holed);
  hetab_roughness_free(whole);
  free(z);
}

static void test_nothing_to_measure(void **state) {
  hetab_context *ctx = *state;
  double z[500] = {0};
  hetab_roughness *r;
  for (int kind = 0; kind < 4; kind++) {
    for (int i = 0; i < 500; i++)
      z[i] = kind == 0 ? 1.25 : kind == 2 ? 1e5 + 0.125 * i : (double)NAN;
    for (int i = 0; kind == 3 && i < 20; i++)
      z[i] = i % 3;
    hetab_heights *heights = new_scans(ctx, z, 500, 1, 0.1);
    const hetab_heights *list = heights;
    assert_int_equal(hetab_roughness_measure(ctx, &list, 1, NULL, &r), HETAB_ERR_RANGE);
    assert_null(r);
    assert_non_null(strstr(hetab_error_message(ctx), "no roughness"));
    hetab_heights_free(heights);
  }
}

static void test_bad_arguments(void **state) {
  hetab_context *ctx = *state;
  double z[100];
  hetab_heights *heights;
  hetab_roughness *r;
  for (int i = 0; i < 100; i++)
    z[i] = i % 7;
  assert_int_equal(hetab_heights_create(ctx, "a", HETAB_HEIGHTS_SCANS, z, 100, 1, 0, 0, &heights),
                   HETAB_ERR_RANGE);
  assert_null(heights);
  assert_int_equal(hetab_heights_create(ctx, "a", HETAB_HEIGHTS_MAP, z, 10, 10, 1, NAN, &heights),
                   HETAB_ERR_RANGE);
  assert_int_equal(hetab_heights_create(ctx, "a", HETAB_HEIGHTS_SCANS, z, 1, 1, 1, 0, &heights),
                   HETAB_ERR_RANGE);
  assert_int_equal(hetab_roughness_measure(ctx, NULL, 0, NULL, &r), HETAB_ERR_ARGUMENT);
  heights = new_scans(ctx, z, 100, 1, 0.1);
  const hetab_heights *list = heights;
  const double bad[] = {NAN, INFINITY, -2};
  for (int i = 0; i < 3; i++) {
    hetab_roughness_options options = {.cutoff_um = bad[i]};
    assert_int_equal(hetab_roughness_measure(ctx, &list, 1, &options, &r), HETAB_ERR_ARGUMENT);
  }
  hetab_roughness_options long_cutoff = {.cutoff_um = 9.5};
  assert_int_equal(hetab_roughness_measure(ctx, &list, 1, &long_cutoff, &r), HETAB_ERR_RANGE);
  hetab_heights_free(heights);
  hetab_roughness_options automatic = {.cutoff_um = HETAB_CUTOFF_AUTO};
  list = heights = new_scans(ctx, z, 50, 2, 0.1);
  assert_int_equal(hetab_roughness_measure(ctx, &list, 1, &automatic, &r), HETAB_ERR_RANGE);
  hetab_heights_free(heights);
}

/* ---- what speaks against the model ---------------------------------------------------------- */

static void test_notes(void **state) {
  enum { COUNT = 20000 };
  uint64_t random = 31;
  profile_scale none = {0, 0}, steep = {0.5, 1}, coarse = {0.5, 200};
  double *z = calloc(COUNT, sizeof *z);
  add_exponential_profile(z, COUNT, 0.1, (profile_scale){0.5, 10}, &random);
  hetab_roughness *r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  assert_true(has_note(r, "jagged") && has_note(r, "rms slope"));
  assert_true(r->raw.misfit_exponential < 0.5 * r->raw.misfit_gaussian);
  assert_true(!has_note(r, "not Gaussian"));
  hetab_roughness_free(r);
  for (int i = 0; i < COUNT; i++)
    z[i] = exp(2 * z[i]);
  r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  assert_true(has_note(r, "not Gaussian"));
  hetab_roughness_free(r);
  free(z);
  z = gaussian_scans(steep, none, COUNT, 1, &random);
  r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  assert_true(has_note(r, "radius of curvature") && !has_note(r, "jagged"));
  hetab_roughness_free(r);
  free(z);
  z = gaussian_scans((profile_scale){0.3, 5}, coarse, COUNT, 1, &random);
  r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), NULL);
  assert_true(has_note(r, "too short"));
  hetab_roughness_free(r);
  hetab_roughness_options options = {.cutoff_um = 30};
  r = measured(*state, new_scans(*state, z, COUNT, 1, 0.1), &options);
  assert_true(has_note(r, "several scales") && has_note(r, "part of the small scale"));
  assert_true(!has_note(r, "too short"));
  hetab_roughness_free(r);
  free(z);
  z = gaussian_scans((profile_scale){0.3, 5}, none, COUNT, 9, &random);
  options.cutoff_um = HETAB_CUTOFF_AUTO;
  r = measured(*state, new_scans(*state, z, COUNT, 9, 0.1), &options);
  assert_true(has_note(r, "No large scale") && r->cutoff_um == 0 && !r->small.count);
  hetab_roughness_free(r);
  free(z);
}

/* ---- the report's surfaces ------------------------------------------------------------------ */

enum { SCANS = 9, SCAN_POINTS = 4000, TRIALS = 200, AUTO_TRIALS = 6 };
static const profile_scale large_scale = {1, 150};

/* HETAB_TRIALS changes how many; sanitizers are slow. */
static int trial_count(int usual) {
  const char *text = getenv("HETAB_TRIALS");
#ifdef __SANITIZE_ADDRESS__
  usual = usual / 5 + 1;
#endif
  return text ? atoi(text) : usual;
}

typedef struct tally {
  const char *name;
  double sum, squares;
  int covered, count;
} tally;

static void count_trial(tally *t, const hetab_average *a, double truth) {
  double error = a->mean / truth - 1;
  t->sum += error;
  t->squares += error * error;
  t->covered += a->low <= truth && truth <= a->high;
  t->count++;
}

static void check_tally(const tally *t, const char *surface) {
  double bias = t->sum / t->count, spread = sqrt(t->squares / t->count - bias * bias);
  double cover = (double)t->covered / t->count;
  print_message("  %-8s %-9s bias %+5.2f %%, spread %4.2f %%, covered %.3f\n", surface, t->name,
                100 * bias, 100 * spread, cover);
  double few = sqrt(fmax(1.0, (double)TRIALS / t->count)); /* their own noise */
  assert_true(fabs(bias) <= few * TOL_SCAN_BIAS);
  assert_true(spread <= few * TOL_SCAN_SPREAD);
  assert_true(1 - cover <= few * (1 - TOL_SCAN_COVER));
}

static hetab_roughness *one_trial(hetab_context *ctx, profile_scale small, double cutoff_um,
                                  uint64_t *random) {
  hetab_roughness_options options = {.cutoff_um = cutoff_um};
  double *z = gaussian_scans(small, large_scale, SCAN_POINTS, SCANS, random);
  hetab_roughness *r = measured(ctx, new_scans(ctx, z, SCAN_POINTS, SCANS, 0.1), &options);
  free(z);
  return r;
}

static void test_report_surfaces(void **state) {
  uint64_t random = 41;
  for (int s = 0; s < 5; s++) {
    const profile_scale scales[2] = {report_surfaces[s], large_scale};
    profile_truth truth = filtered_truth(scales, 0.1, 30);
    tally sigma = {.name = "sigma"}, tau = {.name = "tau"}, slope = {.name = "slope"},
          rms = {.name = "rms slope"};
    for (int i = 0; i < trial_count(TRIALS); i++) {
      hetab_roughness *r = one_trial(*state, scales[0], 30, &random);
      count_trial(&sigma, &r->small.sigma_um, truth.sigma_um);
      count_trial(&tau, &r->small.tau_um, truth.tau_um);
      count_trial(&slope, &r->small.slope, truth.slope);
      count_trial(&rms, &r->small.rms_slope, truth.rms_slope);
      hetab_roughness_free(r);
    }
    check_tally(&sigma, report_names[s]);
    check_tally(&tau, report_names[s]);
    check_tally(&slope, report_names[s]);
    check_tally(&rms, report_names[s]);
  }
}

static void test_auto_cutoff(void **state) {
  uint64_t random = 43;
  int alone = 0; /* levelling has left nothing of the large scale, by chance */
  for (int s = 0; s < 5; s++) {
    const profile_scale scales[2] = {report_surfaces[s], large_scale};
    double best = largest_slope_cutoff(scales, 20, 130), worst = 0;
    for (int i = 0; i < trial_count(AUTO_TRIALS); i++) {
      hetab_roughness *r = one_trial(*state, scales[0], HETAB_CUTOFF_AUTO, &random);
      assert_true(r->cutoff_scan.count > 20 && r->cutoff_scan.from_fit);
      if (r->cutoff_um > 0)
        worst = fmax(worst, fabs(r->cutoff_um / best - 1));
      else
        alone++;
      hetab_roughness_free(r);
    }
    print_message("  %-8s largest slope at %.1f um\n", report_names[s], best);
    assert_below("cut-off", worst, TOL_CUTOFF);
  }
  print_message("  no cut-off: %d\n", alone);
  assert_true(100 * alone <= 5 * trial_count(AUTO_TRIALS));
}

/* A 30 um cut-off and tau 5.6 um, as the header says. */
static void test_what_the_filter_takes(void **state) {
  (void)state;
  const profile_scale scales[2] = {{1, 5.6}, {0, 100}};
  profile_truth raw = filtered_truth(scales, 0.1, 0), kept = filtered_truth(scales, 0.1, 30);
  assert_true(relative_error(raw.sigma_um, 1) < 1e-9 && relative_error(raw.tau_um, 5.6) < 1e-6);
  assert_true(kept.sigma_um * kept.sigma_um < 1.0 / 3);
  assert_true(fabs(kept.tau_um - 3.2) < 0.05);
  assert_true(fabs(kept.slope / raw.slope - 0.96) < 0.005);
  double best = largest_slope_cutoff(scales, 20, 200);
  assert_true(fabs(best / 5.6 - 13) < 0.5);
  assert_true(fabs(filtered_truth(scales, 0.1, best).slope / raw.slope - 1.08) < 0.005);
}

/* The interval from one scan's own errors, and the one of a map, whose rows are no independent
 * scans. */
static void test_single_scans_cover(void **state) {
  enum { SINGLE = 200 };
  uint64_t random = 47;
  profile_scale scale = {0.4, 5}, none = {0, 0};
  const profile_scale scales[2] = {scale, {0, 100}};
  profile_truth truth = filtered_truth(scales, 0.1, 60);
  tally sigma = {.name = "sigma"}, tau = {.name = "tau"}, slope = {.name = "slope"};
  hetab_roughness_options options = {.cutoff_um = 60};
  for (int i = 0; i < SINGLE; i++) {
    double *z = gaussian_scans(scale, none, 8000, 1, &random);
    hetab_roughness *r = measured(*state, new_scans(*state, z, 8000, 1, 0.1), &options);
    count_trial(&sigma, &r->small.sigma_um, truth.sigma_um);
    count_trial(&tau, &r->small.tau_um, truth.tau_um);
    count_trial(&slope, &r->small.slope, truth.slope);
    hetab_roughness_free(r);
    free(z);
  }
  const tally *const all[3] = {&sigma, &tau, &slope};
  for (int i = 0; i < 3; i++) {
    double cover = (double)all[i]->covered / SINGLE;
    print_message("  one scan, %s: covered %.3f\n", all[i]->name, cover);
    assert_true(cover >= TOL_SCAN_COVER_ONE && cover < 0.995);
  }
}

/* A map of Gaussian bumps: z(x, y) with exp(-(r / tau)^2), tau = 4 spacings. */
static void fill_map(double *z, int side, uint64_t *random) {
  enum { REACH = 12 };
  double bump[2 * REACH + 1], *rows = calloc((size_t)(side * side), sizeof *rows), squares = 0;
  for (int i = -REACH; i <= REACH; i++) {
    bump[i + REACH] = exp(-2 * i * i / 16.0);
    squares += bump[i + REACH] * bump[i + REACH];
  }
  for (int pass = 0; pass < 2; pass++)
    for (int y = 0; y < side; y++) {
      double noise[512];
      for (int i = 0; i < side + 2 * REACH; i++)
        noise[i] = random_normal(random);
      for (int x = 0; x < side; x++) {
        double sum = 0;
        for (int i = 0; i <= 2 * REACH; i++)
          sum += bump[i] * (pass ? rows[y * side + (x + i) % side] : noise[x + i]);
        (pass ? z : rows)[pass ? y * side + x : x * side + y] = sum / sqrt(squares);
      }
    }
  free(rows);
}

/* Scans of a few tau: what cannot be negative has no interval that is. */
static void test_short_scans(void **state) {
  hetab_context *ctx = *state;
  size_t beyond = 0;
  for (uint64_t seed = 1; seed <= 50; seed++) {
    double z[40] = {0};
    uint64_t random = seed;
    for (int i = 1; i < 40; i++)
      z[i] = 0.95 * z[i - 1] + random_normal(&random);
    hetab_heights *h;
    hetab_roughness *r;
    assert_ok(ctx, hetab_heights_create(ctx, "short", HETAB_HEIGHTS_SCANS, z, 40, 1, 1, 0, &h));
    assert_ok(ctx, hetab_roughness_measure(ctx, (const hetab_heights *[]){h}, 1, NULL, &r));
    const hetab_average *tau = &r->raw.tau_um;
    assert_true(0 < tau->low && tau->low < tau->mean && tau->mean < tau->high);
    assert_true(r->raw.sigma_um.low > 0 && r->raw.slope.low > 0);
    beyond += tau->mean < 1.96 * tau->error;
    hetab_roughness_free(r);
    hetab_heights_free(h);
  }
  assert_true(beyond > 0); /* where an even interval would have reached below 0 */
}

static void test_maps_cover(void **state) {
  enum { SIDE = 200, MAPS = 60 };
  uint64_t random = 53;
  const profile_scale scales[2] = {{1, 1}, {0, 100}};
  profile_truth truth = filtered_truth(scales, 0.25, 12);
  hetab_roughness_options options = {.cutoff_um = 12};
  double *z = calloc(SIDE * SIDE, sizeof *z);
  tally sigma = {.name = "sigma"};
  for (int i = 0; i < MAPS; i++) {
    hetab_heights *map;
    fill_map(z, SIDE, &random);
    assert_ok(*state, hetab_heights_create(*state, "map", HETAB_HEIGHTS_MAP, z, SIDE, SIDE, 0.25,
                                           0.25, &map));
    hetab_roughness *r = measured(*state, map, &options);
    count_trial(&sigma, &r->small.sigma_um, truth.sigma_um);
    hetab_roughness_free(r);
  }
  double bias = sigma.sum / MAPS, spread = sqrt(sigma.squares / MAPS - bias * bias);
  print_message("  maps: sigma bias %+.2f %%, spread %.2f %%, covered %.3f\n", 100 * bias,
                100 * spread, sigma.covered / (double)MAPS);
  assert_true(sigma.covered >= 0.9 * MAPS);
  free(z);
}

/* ---- published rows and readers ------------------------------------------------------------- */

static hetab_heights *load(text_fixture *f, const char *text,
                           const hetab_heights_options *options) {
  hetab_heights *heights;
  const char *path = write_text_file(f, "scan.txt", text);
  if (hetab_heights_load(f->ctx, path, options, &heights) != HETAB_OK)
    fail_msg("%s\n%s", text, hetab_error_message(f->ctx));
  return heights;
}

static void assert_scan(hetab_heights *h, size_t columns, size_t rows, double spacing_um,
                        const double *z_um) {
  assert_int_equal(hetab_heights_column_count(h), columns);
  assert_int_equal(hetab_heights_row_count(h), rows);
  assert_true(relative_error(hetab_heights_spacing_um(h), spacing_um) < 1e-12);
  for (size_t i = 0; i < columns * rows; i++) {
    double found = hetab_heights_z_um(h)[i];
    assert_true(isnan(z_um[i]) ? isnan(found) : fabs(found - z_um[i]) <= 1e-12 * fabs(z_um[i]));
  }
  hetab_heights_free(h);
}

static void test_text(void **state) {
  text_fixture *f = *state;
  const double z[4] = {1, 2, NAN, 4};
  const hetab_heights_options nm = {.unit = "nm", .spacing_um = 0.5};
  assert_scan(load(f, "x_um,z_um\n0,1\n0.5,2\n1,\n1.5,4\n", NULL), 4, 1, 0.5, z);
  assert_scan(load(f, "x_um,z_um\n0,1\n0.5,2\n1.5,4\n", NULL), 4, 1, 0.5, z); /* a gap in x */
  assert_scan(load(f,
                   "\xEF\xBB\xBF# made\r\nX [mm]; Height (nm);\r\n0;1000;\r\n0.0005;2e3;\r\n"
                   "0.001;NaN;\r\n0.0015;4000;\r\n",
                   NULL),
              4, 1, 0.5, z);
  assert_scan(load(f, "x/mm\tz/\u00b5m\n0\t1\n0.0005\t2\n0.001\tBAD\n0.0015\t4\n", NULL), 4, 1, 0.5,
              z);
  assert_scan(load(f, "1000\n2000\nnan\n4000\n", &nm), 4, 1, 0.5, z);
  assert_scan(load(f, "0 1000\n 500  2000\n1000 -\n1500 4000", &nm), 4, 1, 0.5, z);
  assert_scan(load(f, "z_um\n1\n2\nnan\n4\n", &nm), 4, 1, 0.5, z);
  const double even[5] = {0, 1, 2, NAN, 8};
  const hetab_heights_options resampled = {.resample_um = 0.5};
  assert_scan(load(f, "x_um,z_um\n0,0\n0.2,0.4\n0.55,1.1\n1.1,2.2\n1.9,7.6\n2,8\n", &resampled), 5,
              1, 0.5, (const double[]){0, 1, 2, 4.9, 8});
  assert_scan(load(f, "x_um,z_um\n0,0\n0.1,0.2\n0.4,0.8\n0.6,1.2\n0.9,1.8\n1.1,2.2\n1.9,7.6\n2,8\n",
                   &resampled),
              5, 1, 0.5, even);
  const double two[8] = {1, 2, NAN, 4, 9, 8, 7, 6};
  assert_scan(load(f, "n,z1_um,z2_nm\n1,1,9000\n2,2,8000\n3,,7000\n4,4,6000\n", &nm), 4, 2, 0.5,
              two);
  const double map[6] = {1, 2, 3, 4, NAN, 6};
  hetab_heights *h = load(f,
                          "# Channel: Z\n# Width: 1.5 \u00b5m\n# Height: 0.5 um\n"
                          "# Value units: nm\n1000\t2000\t3000\n4000\t\t6000\n",
                          NULL);
  assert_int_equal(hetab_heights_kind_of(h), HETAB_HEIGHTS_MAP);
  assert_true(hetab_heights_spacing_y_um(h) == 0.25);
  assert_scan(h, 3, 2, 0.5, map);
  assert_scan(load(f, "1000 2000 3000\n4000 nan 6000\n", &nm), 3, 2, 0.5, map);
}

/* Text as instruments and their programs export it, each with the source of its layout; the numbers
 * are made here. All say 1, 2, missing, 4 um every 0.5 um, or a map of it and of -1, 5, 6, 7. */
#define MAP "1\t2\tnan\t4\n-1\t5\t6\t7\n"
static const struct {
  const char *who, *text, *columns, *unit;
  bool map;
} exports[] = {
    {"Gwyddion, text export (ContactEngineering/SurfaceTopography, gwyddion-export-english.txt)",
     "# Channel: Topo\n# Width: 2.0 \u00b5m\n# Height: 0.5 \u00b5m\n# Value units: um\n" MAP,
     .map = true},
    {"Gwyddion in German (SurfaceTopography, gwyddion-export-german.txt)",
     "# Kanal: Topo\n# Breite: 2,0 \u00b5m\n# H\u00f6he: 500 nm\n# Werteinheit: um\n"
     "1,0\t2,0\tnan\t4\n-1\t5\t6\t7\n",
     .map = true},
    {"Gwyddion in French (labels of its fr.po, as in SurfaceTopography/IO/Text.py)",
     "# Canal : Topo\n# Largeur : 0,002 mm\n# Hauteur : 500 nm\n# Unit\u00e9s : m\n"
     "1e-06\t2e-06\tnan\t4e-06\n-1e-06\t5e-06\t6e-06\t7,0e-06\n",
     .map = true},
    {"Bruker Dektak, CSV (SurfaceTopography, dektak-1.csv)",
     "Scan Parameters\r\nScan Type,Standard Scan\r\nID,0\r\nStylus,Radius: 2.5 \xB5m\r\n"
     "Length,1.5 um\r\nProfile,Hills&Valleys\r\n\r\nAnalytical Results\r\nFunction,R.Cur "
     "Pos,Result\r\n"
     "Ra,468.0 um,0.00525 um\r\n\r\nScan Data\r\nLateral um,Raw Micrometer,\r\n"
     "0.0,1,,\r\n0.5,2,,\r\n1.0,,,\r\n1.5,4,,\r\n",
     .map = false},
    {"a profiler's CSV (SurfaceTopography, csv-1.csv)",
     "X_(microns),y1\n0,1\n0.5,2\n1,nan\n1.5,4\n", .map = false},
    {"a profiler's CSV with an index (SurfaceTopography, csv-2.csv)",
     "index,x in \u00b5m,y in \u00b5m\r\n0,0,1\r\n1,0.5,2\r\n2,1.0,nan\r\n3,1.5,4\r\n",
     .map = false},
    {"Dektak in Angstrom (SurfaceTopography, dektak-1.csv, heights in the unit of older ones)",
     "Lateral(um),Profile(\u00c5)\n0,10000\n0.5,20000\n1,BAD\n1.5,40000\n", .map = false},
    {"STIL confocal sensor with encoders (jonathan-bender/scaling-octo-telegram, README)",
     "Counter\tAltitude (\u00b5m)\tEncoder1 (\u00b5m)\tEncoder2 (\u00b5m)\tRow number\n"
     "37\t1\t0.0\t0\t1\n38\t2\t0.5\t0\t1\n39\tnan\t1.0\t0\t1\n40\t4\t1.5\t0\t1\n",
     .map = false},
    {"KLA Tencor P-7, APEX text (adpleach/ProfilometryData)",
     "0.0000\t1\n0.0005\t2\n0.0010\tnan\n0.0015\t4\n", .unit = "mm,um"},
    {"SPIP, ASCII (SurfaceTopography/IO/Text.py, flavour spip)",
     "# File Format = ASCII\n# x-pixels = 4\n# y-pixels = 2\n# x-length = 2000\n# y-length = 500\n"
     "# Bit2nm = 1000\n" MAP,
     .map = true},
    {"Attocube, .asc (gwyddion modules/file/attocube.c)",
     "# Daisy frame view snapshot\n# x-pixels: 4\n# y-pixels: 2\n# x-length: 2.0\n# y-length: 0.5\n"
     "# x-unit: um\n# y-unit: um\n# z-unit: um\n# Start of Data:\n" MAP,
     .map = true},
    {"NT-MDT Nova, ASCII (SurfaceTopography/IO/Text.py, 'Nova ASCII export')",
     "File Format = ASCII\nNX = 4\nNY = 2\nScale X = 0.5\nScale Y = 0.25\nUnit X = um\n"
     "Unit Data = um\nStart of Data :\n" MAP,
     .map = true},
    {"Lyncee digital holographic microscope (SurfaceTopography, matrix-2.txt)",
     "h=2 w=4\npixel size=5.0e-007 m\ndata unit=rad\nheight conversion factor (-> m)=2e-006\n"
     "0.5 1.0 nan 2.0\n-0.5 2.5 3.0 3.5\n",
     .map = true},
    {"Wyko Vision, ASCII in waves (SurfaceTopography, test of wyko_real_units)",
     "Wyko ASCII Data File Format 0\t0\t1\nX Size\t2\nY Size\t4\nBlock Name\tType\tLength\tValue\n"
     "Pixel_size\t7\t4\t0.0005\nWavelength\t7\t4\t500\nMult\t7\t4\t0.5\nRAW_DATA\t3\t32\t\n"
     "1\t2\tBad\t4\n-1\t5\t6\t7\n",
     .map = true},
    {"Wyko Vision, ASCII in nm (the same)",
     "Wyko ASCII Data File Format 0\t1\t1\nX Size\t2\nY Size\t4\nPixel_size\t7\t4\t0.0005\n"
     "RAW_DATA\t3\t32\t\n1000\t2000\tBad\t4000\n-1000\t5000\t6000\t7000\n",
     .map = true},
    {"Keyence VK-X and VR, ImageDataCsv (as users' programs write it for its MultiFileAnalyzer)",
     "\"Measured date\",\"2024-11-05 10:20:30\"\r\n\"Model\",\"VK-X3000 Series\"\r\n"
     "\"Data type\",\"ImageDataCsv\"\r\n\"Objective Lens Power\",\"50\"\r\n"
     "\"XY Calibration\",\"500\",\"nm\"\r\n\"Output image data\",\"Height\"\r\n"
     "\"Horizontal\",\"4\"\r\n\"Vertical\",\"2\"\r\n\"Minimum value\",\"-1\"\r\n"
     "\"Unit\",\"um\"\r\n\"Reference data name\",\"\"\r\n\r\n\"Height\"\r\n"
     "\"1\",\"2\",\"\",\"4\"\r\n\"-1\",\"5\",\"6\",\"7\"\r\n",
     .map = true},
    {"WSxM, ASCII XYZ (Probe-Particle/ppafm, io.py, saveWSxM_2D)",
     "WSxM file copyright UAM\nWSxM ASCII XYZ file\nX[nm]\t\tY[nm]\t\tZ[nm]\n\n0\t0\t1000\n"
     "500\t0\t2000\n1000\t0\tnan\n1500\t0\t4000\n0\t250\t-1000\n500\t250\t5000\n"
     "1000\t250\t6000\n1500\t250\t7000\n",
     .map = true},
    {"a list of points, y fastest, without a header (SurfaceTopography, xyz-1.txt)",
     "0.0 0.00 1\n0.0 0.25 -1\n0.5 0.00 2\n0.5 0.25 5\n1.0 0.25 6\n1.5 0.00 4\n1.5 0.25 7\n",
     .unit = "um", .map = true},
    {"any columns, chosen by name or number",
     "time,place,gauge,temp\n1,0,1,20\n2,5e-4,2,20\n3,1e-3,nan,20\n4,1.5e-3,4,20\n", "place,3",
     "mm,um", false},
    {"numbers without a header, chosen", "9 1 0\n9 2 0.5\n9 nan 1\n9 4 1.5\n", "3,2", "um", false},
};

static void test_exports(void **state) {
  text_fixture *f = *state;
  const double scan[4] = {1, 2, NAN, 4}, map[8] = {1, 2, NAN, 4, -1, 5, 6, 7};
  for (size_t i = 0; i < sizeof exports / sizeof *exports; i++) {
    hetab_heights_options options = {.columns = exports[i].columns, .unit = exports[i].unit};
    hetab_heights *h = load(f, exports[i].text, &options);
    bool map_read = hetab_heights_kind_of(h) == HETAB_HEIGHTS_MAP;
    if (map_read != exports[i].map || hetab_heights_column_count(h) != 4)
      fail_msg("%s: %zu columns", exports[i].who, hetab_heights_column_count(h));
    if (relative_error(hetab_heights_spacing_um(h), 0.5) > 1e-12)
      fail_msg("%s: spacing %.17g", exports[i].who, hetab_heights_spacing_um(h));
    if (map_read && !strstr(exports[i].who, "Wyko") && !strstr(exports[i].who, "Lyncee") &&
        !strstr(exports[i].who, "Keyence"))
      assert_true(relative_error(hetab_heights_spacing_y_um(h), 0.25) < 1e-12);
    assert_scan(h, 4, map_read ? 2 : 1, 0.5, map_read ? map : scan);
  }
}

/* 1, 2, 3 ... um every 0.15625 um; x with one decimal, and a few of its steps are all but gaps. */
static void test_rounded_places(void **state) {
  text_fixture *f = *state;
  static char text[20000];
  for (int points = 40; points <= 800; points *= 20) {
    double *z = calloc((size_t)points, sizeof *z);
    size_t used = (size_t)sprintf(text, "x_um,z_um\n");
    for (int i = 0; i < points; i++)
      used += (size_t)sprintf(text + used, "%.1f,%g\n", 0.15625 * i, z[i] = i % 7);
    hetab_heights *h = load(f, text, NULL);
    assert_int_equal(hetab_heights_column_count(h), points);
    assert_true(relative_error(hetab_heights_spacing_um(h), 0.15625) < 2.0 / points / points);
    assert_memory_equal(hetab_heights_z_um(h), z, (size_t)points * sizeof *z);
    hetab_heights_free(h);
    free(z);
  }
  size_t used = (size_t)sprintf(text, "x_um,z_um\n");
  for (int i = 0; i < 60; i++)
    used += (size_t)sprintf(text + used, "%.1f,%d\n", 0.1 * (i + (i > 20) + (i > 30)), i);
  hetab_heights *h = load(f, text, NULL); /* two gaps, of which rounding is no explanation */
  assert_int_equal(hetab_heights_column_count(h), 62);
  assert_true(isnan(hetab_heights_z_um(h)[21]));
  hetab_heights_free(h);
}

static void test_units_in_doubt(void **state) {
  text_fixture *f = *state;
  char text[4000] = "x_um,height\n";
  for (int i = 0; i < 200; i++)
    sprintf(text + strlen(text), "%d,%d\n", i, i * 37 % 11);
  const hetab_heights *h = load(f, text, NULL);
  hetab_roughness *r;
  assert_ok(f->ctx, hetab_roughness_measure(f->ctx, &h, 1, NULL, &r));
  assert_non_null(strstr(r->notes[0], "'height' names no unit"));
  assert_non_null(strstr(r->notes[1], "--unit mm,um"));
  assert_true(r->raw.tau_um.low >= 0);
  hetab_roughness_free(r);
  hetab_heights_free((hetab_heights *)h);
}

static void test_sdf(void **state) {
  text_fixture *f = *state;
  const double z[6] = {1, 2, NAN, 4, 5, 6};
  hetab_heights *h = load(f,
                          "aISO-1.0\r\nManufacID = x\r\nNumPoints = 3\r\nNumProfiles = 2\r\n"
                          "Xscale = 5e-07\r\nYscale = 1e-6\r\nZscale = 1e-9\r\nZresolution = -1\r\n"
                          "Compression = 0\r\nDataType = 6\r\nCheckType = 0\r\n*\r\n"
                          "1000 2000 BAD\r\n4000\r\n5000 6000\r\n*\r\nsomething\r\n*\r\n",
                          NULL);
  assert_int_equal(hetab_heights_kind_of(h), HETAB_HEIGHTS_MAP);
  assert_true(relative_error(hetab_heights_spacing_y_um(h), 1) < 1e-12);
  assert_scan(h, 3, 2, 0.5, z);
}

#define SDF(points, profiles, x, values)                                                           \
  "aISO-1.0\nNumPoints=" points "\nNumProfiles=" profiles "\nXscale=" x                            \
  "\nYscale=1e-6\nZscale=1e-6\n*\n" values
static const struct {
  const char *text, *words[3];
} malformed[] = {
    {"", {"no heights"}},
    {"# only\n", {"no heights"}},
    {"x_um,z_um\n", {"no heights"}},
    {"x_um,z_um\n0,1\n", {"one point"}},
    {"x,z\n0,1\n1,2\n", {":1:", "--unit"}},
    {"x_um,z_furlong\n0,1\n1,2\n", {":1:", "--unit"}},
    {"z_um\n1\n2\n3\n", {"--spacing"}},
    {"1 2\n2 3\n", {"--unit"}},
    {"a,b\n1,2\n2,3\n", {"no column of heights"}},
    {"x_um,z_um\n0,1\n1,two\n", {":3:", "'two'"}},
    {"x_um,z_um\n0,1\n1,2,3\n", {":3:", "3 fields"}},
    {"x_um,z_um\n0,1\n1\n", {":3:", "1 field "}},
    {"x_um;z_um\n0.0;1\n1;2,5\n", {":3:", "'2,5'"}},
    {"x_um,z_um\n0,1\n,2\n", {"no x"}},
    {"x_um,x_um,z_um\n0,1,1\n1,1,2\n", {"two x"}},
    {"x_um,y_um,z_um\n0,0,1\n1,2,2\n5,1,7\n3.3,9,1\n", {"lies on no grid", "--columns"}},
    {"x_um,z_um\n0,1\n1,2\n1,3\n2,4\n", {"not always increase"}},
    {"x_um,z_um\n0,1\n-1,2\n-2,3\n", {"not always increase"}},
    {"x_um,z_um\n0,1\n1,2\n2.4,3\n3.4,1\n", {"unequally", "resample"}},
    {"x_um,z_um\n0,1\n1,2\n2,3\n1e12,3\n", {"2^27"}},
    {"x_m,z_m\n0,1\n1e-6,2\n", {"are the units right"}},
    {"x_um,z_um\n0,1e300\n1,2\n", {"are the units right"}},
    {"x_m,z_um\n0,1\n10,2\n", {"spacing", "units"}},
    {"aISO-1.0\nNumPoints=3\n", {"no '*'"}},
    {SDF("three", "1", "1e-6", "1 2 3\n*\n"), {":2:", "NumPoints"}},
    {SDF("3", "0", "1e-6", "1 2 3\n*\n"), {"NumProfiles 0"}},
    {SDF("-3", "1", "1e-6", "1 2 3\n*\n"), {"NumPoints -3"}},
    {SDF("3", "1", "0", "1 2 3\n*\n"), {"Xscale"}},
    {SDF("3", "1", "1e-6", "1 2\n*\n"), {"2 heights", "cut off"}},
    {SDF("3", "1", "1e-6", "1 2"), {"2 heights", "cut off"}},
    {SDF("3", "1", "1e-6", "1 2 3 4\n*\n"), {"more heights"}},
    {SDF("3", "1", "1e-6", "1 x 3\n*\n"), {"height 2", "'x'"}},
    {SDF("99999999", "99999999", "1e-6", "1 2 3\n*\n"), {"do not fit"}},
    {SDF("1e18", "1", "1e-6", "1 2 3\n*\n"), {"NumPoints"}},
    {SDF("3", "1", "1", "1 2 3\n*\n"), {"spacing", "units"}},
    {"bISO-1.0 123", {"no room for the header"}},
    {"PK\3\4 no archive", {"cut off"}},
};
#undef SDF

static void test_malformed(void **state) {
  text_fixture *f = *state;
  for (size_t i = 0; i < sizeof malformed / sizeof *malformed; i++) {
    hetab_heights *heights;
    const char *path = write_text_file(f, "bad.txt", malformed[i].text);
    hetab_status status = hetab_heights_load(f->ctx, path, NULL, &heights);
    if (status == HETAB_OK)
      fail_msg("accepted: %s", malformed[i].text);
    assert_null(heights);
    assert_message(f, (const char *const[]){malformed[i].words[0], malformed[i].words[1], NULL});
  }
  hetab_heights *heights;
  hetab_heights_options odd = {.unit = "parsec"};
  assert_int_equal(hetab_heights_load(f->ctx, f->path, &odd, &heights), HETAB_ERR_PARSE);
  const char *path = write_bytes(f, "nul.txt", "1\0002\n", 4);
  assert_int_equal(hetab_heights_load(f->ctx, path, NULL, &heights), HETAB_ERR_PARSE);
  assert_int_equal(hetab_heights_load(f->ctx, "/nowhere/z.csv", NULL, &heights), HETAB_ERR_IO);
}

/* Made-up numbers whose summaries are worked out by hand: 1.2, 1.3, 1.7: mean 1.4, deviation
 * sqrt((0.04 + 0.01 + 0.09) / 2) = 0.26458, over the mean 0.18898. */
static void test_published(void **state) {
  text_fixture *f = *state;
  hetab_published *p;
  const char *path = write_text_file(f, "rows.csv",
                                     "scan,sigma_um,tau_um,slope\n1,1.2,10,0.12\n2,1.3,12,0.11\n"
                                     "3,1.7,14,0.14\naverage,1.40,12,0.12\n"
                                     "deviation,0.26,2.1,\nnon-uniformity,0.19,,\n");
  assert_ok(f->ctx, hetab_published_load(f->ctx, &path, 1, &p));
  const hetab_published_table *t = p->tables;
  assert_int_equal(t->rows, 3);
  assert_int_equal(t->count, 3);
  assert_string_equal(t->columns[0].name, "sigma_um");
  assert_true(relative_error(hetab_published_summary(t, 0, HETAB_AVERAGE), 1.4) < 1e-14);
  assert_true(relative_error(hetab_published_summary(t, 0, HETAB_DEVIATION), sqrt(0.07)) < 1e-14);
  assert_true(relative_error(hetab_published_summary(t, 0, HETAB_NON_UNIFORMITY),
                             sqrt(0.07) / 1.4) < 1e-14);
  assert_true(isnan(t->columns[1].stated[HETAB_NON_UNIFORMITY]) && t->columns[0].decimals == 1);
  assert_int_equal(p->check_count, 6 + 3);
  static const hetab_match expected[] = {
      HETAB_MATCH_EXACT, HETAB_MATCH_EXACT,    HETAB_MATCH_EXACT, /* sigma */
      HETAB_MATCH_EXACT, HETAB_MATCH_ROUNDING, /* 10, 12, 14 deviate by 2, but 9.5, 12, 14.5 by 2.5
                                                */
      HETAB_MATCH_EXACT,                       /* the slopes' average, 0.1233 */
      HETAB_MATCH_EXACT, HETAB_MATCH_EXACT,    /* slopes: 0.12, 0.1083 */
      HETAB_MATCH_NONE                         /* 1.75 / 13.5 is 0.1296, 0.14 is stated */
  };
  for (size_t i = 0; i < p->check_count; i++)
    assert_int_equal(p->checks[i].verdict, expected[i]);
  hetab_published_free(p);
  static const char *const bad[] = {"",
                                    "scan\n1\n2\n",
                                    "scan,a\n1,2\n",
                                    "scan,a\n1,x\n2,3\n",
                                    "scan,a\n1,2,3\n2,3\n",
                                    "scan,a,b\n1,2\n2,3\n"};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    path = write_text_file(f, "rows.csv", bad[i]);
    assert_int_equal(hetab_published_load(f->ctx, &path, 1, &p), HETAB_ERR_PARSE);
    assert_null(p);
  }
}

#define WITH_CONTEXT(test) cmocka_unit_test_setup_teardown(test, context_setup, context_teardown)
#define WITH_FILES(test)                                                                           \
  cmocka_unit_test_setup_teardown(test, text_fixture_setup, text_fixture_teardown)

/* scipy.stats.t.ppf(0.975, freedom), 1.15. */
static void test_student(void **state) {
  static const double known[][2] = {{1, 12.7062047}, {2, 4.3026527},  {3, 3.1824463},
                                    {7, 2.3646243},  {15, 2.1314495}, {16, 2.1199053},
                                    {30, 2.0422725}, {300, 1.9679030}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    assert_true(fabs(hetab_student_95(known[i][0]) / known[i][1] - 1) < 1e-3);
  assert_true(hetab_student_95(1.5) < 12.7 && hetab_student_95(1.5) > 4.4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_student),
      WITH_CONTEXT(test_transmission),
      WITH_CONTEXT(test_end_zones),
      WITH_CONTEXT(test_convolution),
      WITH_CONTEXT(test_other_filters),
      WITH_CONTEXT(test_sine),
      WITH_CONTEXT(test_white_noise),
      WITH_CONTEXT(test_long_scan),
      WITH_CONTEXT(test_levelling),
      WITH_CONTEXT(test_levelling_bias),
      WITH_CONTEXT(test_plane),
      WITH_CONTEXT(test_gaps_and_outliers),
      WITH_CONTEXT(test_nothing_to_measure),
      WITH_CONTEXT(test_bad_arguments),
      WITH_CONTEXT(test_notes),
      WITH_CONTEXT(test_report_surfaces),
      WITH_CONTEXT(test_auto_cutoff),
      cmocka_unit_test(test_what_the_filter_takes),
      WITH_CONTEXT(test_single_scans_cover),
      WITH_CONTEXT(test_maps_cover),
      WITH_CONTEXT(test_short_scans),
      WITH_FILES(test_text),
      WITH_FILES(test_exports),
      WITH_FILES(test_rounded_places),
      WITH_FILES(test_units_in_doubt),
      WITH_FILES(test_sdf),
      WITH_FILES(test_malformed),
      WITH_FILES(test_published),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
