/* Surfaces: presets, YAML in and out, wavelengths, bad input. */
#include "text_fixture.h"

#include <locale.h>
#include <math.h>

static const double pi = 3.14159265358979323846;

static hetab_surface *load(text_fixture *fixture, const char *text) {
  hetab_surface *surface;
  const char *path = write_text_file(fixture, "surface.yml", text);
  if (hetab_surface_load(fixture->ctx, path, &surface) != HETAB_OK)
    fail_msg("%s", hetab_error_message(fixture->ctx));
  return surface;
}

static void fails(text_fixture *fixture, const char *path, const char *const *words) {
  hetab_surface *surface = (hetab_surface *)fixture;
  assert_int_not_equal(hetab_surface_load(fixture->ctx, path, &surface), HETAB_OK);
  assert_null(surface);
  assert_message(fixture, words);
}

/* Bit for bit: no padding in a band. */
static void assert_same(const hetab_surface *a, const hetab_surface *b) {
  size_t count = hetab_surface_band_count(a);
  assert_string_equal(hetab_surface_name(a), hetab_surface_name(b));
  assert_true(hetab_surface_sigma0_um(a) == hetab_surface_sigma0_um(b));
  assert_true(hetab_surface_tau_um(a) == hetab_surface_tau_um(b));
  assert_int_equal(hetab_surface_band_count(b), count);
  assert_memory_equal(hetab_surface_bands(a), hetab_surface_bands(b), count * sizeof(hetab_band));
  assert_string_equal(hetab_index_source(hetab_surface_index(a)),
                      hetab_index_source(hetab_surface_index(b)));
}

/* load(yaml(s)) is s; the text is handed back for a closer look: free() it. */
static char *assert_round_trip(text_fixture *fixture, const hetab_surface *surface) {
  char *text;
  assert_int_equal(hetab_surface_yaml(fixture->ctx, surface, &text), HETAB_OK);
  hetab_surface *again = load(fixture, text);
  assert_same(surface, again);
  hetab_surface_free(again);
  return text;
}

/* ---- presets ---- */

static void test_presets(void **state) {
  static const struct {
    const char *name;
    double sigma0_um, tau_um, non_uniformity, fitted_slope, a; /* the last two of Table 2 */
  } table1[] = {{"BBQAL1", 0.72, 5.6, 0.039, 0.144, 0.70},
                {"BBQAL2", 0.54, 6.5, 0.068, 0.080, 0.37},
                {"GGAL120", 0.86, 5.6, 0.045, 0.166, 0.44},
                {"GGAL240", 0.61, 4.7, 0.041, 0.158, 0.44},
                {"NGGAL", 0.13, 5.4, 0.053, 0.02, 0.0}};
  text_fixture *fixture = *state;
  assert_int_equal(hetab_preset_count(), 10);
  for (size_t i = 0; i < 5; i++) {
    hetab_surface *surface;
    assert_string_equal(hetab_preset_name(i), table1[i].name);
    assert_non_null(strstr(hetab_preset_description(i), "Table 1"));
    assert_int_equal(hetab_surface_open(fixture->ctx, table1[i].name, &surface), HETAB_OK);
    assert_true(hetab_surface_sigma0_um(surface) == table1[i].sigma0_um);
    assert_true(hetab_surface_tau_um(surface) == table1[i].tau_um);
    assert_int_equal(hetab_surface_band_count(surface), 31);
    const hetab_band *bands = hetab_surface_bands(surface);
    assert_true(bands[0].lambda_um == 0.4 && bands[15].lambda_um == 0.55);
    assert_true(bands[30].lambda_um == 0.7);
    assert_true(fabs(bands[30].n - 1.92139) < 1e-5 && fabs(bands[30].k - 8.14197) < 1e-5);
    assert_true(bands[7].diffuse_brdf == 0);
    char *text = assert_round_trip(fixture, surface);
    assert_non_null(strstr(text, "wavelengths_nm: 400:700:10\n"));
    assert_non_null(strstr(text, "index: Al "));
    free(text);
    double bounds[2], tau_bounds[2];
    hetab_surface_bounds(surface, bounds, tau_bounds);
    for (int end = 0; end < 2; end++)
      assert_true(fabs(bounds[end] / table1[i].sigma0_um - 1 +
                       (end ? -1 : 1) * table1[i].non_uniformity) < 1e-6);
    hetab_surface_free(surface);
    assert_string_equal(hetab_preset_name(i + 5),
                        strcat(strcpy((char[16]){0}, table1[i].name), "-fit"));
    assert_non_null(strstr(hetab_preset_description(i + 5), "diffuse_brdf"));
    assert_int_equal(hetab_surface_open(fixture->ctx, hetab_preset_name(i + 5), &surface),
                     HETAB_OK);
    assert_true(fabs(hetab_surface_sigma0_um(surface) / table1[i].tau_um - table1[i].fitted_slope) <
                1e-12);
    assert_true(fabs(hetab_surface_bands(surface)->diffuse_brdf * M_PI - table1[i].a) < 1e-12);
    hetab_surface_free(surface);
  }
}

static void test_preset_names(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface;
  assert_int_equal(hetab_surface_preset(fixture->ctx, "bbqal2", &surface), HETAB_OK);
  assert_string_equal(hetab_surface_name(surface), "BBQAL2");
  hetab_surface_free(surface);
  assert_int_equal(hetab_surface_open(fixture->ctx, "BBQAL3", &surface), HETAB_ERR_ARGUMENT);
  assert_null(surface);
  assert_message(fixture, (const char *const[]){"BBQAL3", "BBQAL1, BBQAL2, GGAL120, GGAL240, NGGAL",
                                                ".yml", NULL});
  assert_int_equal(hetab_surface_open(fixture->ctx, "missing.YAML", &surface), HETAB_ERR_IO);
  assert_message(fixture, (const char *const[]){"missing.YAML", "No such file", NULL});
  assert_int_equal(hetab_surface_open(fixture->ctx, "./BBQAL1", &surface), HETAB_ERR_IO);
}

/* ---- loading ---- */

static void test_full_file(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface = load(fixture, "\xEF\xBB\xBF# mine\r\nname: Plate 7\r\n\r\n"
                                         "sigma0_um: 0.54  \r\ntau_um: 6.5\r\n"
                                         "index: {n: 0.958, k: 6.69}\r\n"
                                         "diffuse_reflectance: [0.1, 0.2]\r\n"
                                         "wavelengths_nm: [500, 600]\r\n");
  const hetab_band *bands = hetab_surface_bands(surface);
  assert_string_equal(hetab_surface_name(surface), "Plate 7");
  assert_int_equal(hetab_surface_band_count(surface), 2);
  assert_true(bands[1].lambda_um == 0.6 && bands[1].n == 0.958 && bands[1].k == 6.69);
  assert_true(bands[0].diffuse_brdf == 0.1 / pi && bands[1].diffuse_brdf == 0.2 / pi);
  free(assert_round_trip(fixture, surface));
  hetab_surface_free(surface);
}

static void test_defaults(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface = load(fixture, "sigma0_um: 1\ntau_um: 2\nindex: {n: 1.5}\n");
  assert_string_equal(hetab_surface_name(surface), "surface");
  assert_int_equal(hetab_surface_band_count(surface), 31);
  assert_true(hetab_surface_bands(surface)[0].k == 0);
  hetab_surface_free(surface);
}

static void test_slope(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface =
      load(fixture, "slope: 0.1\ntau_um: 6.5\nindex: Al\ndiffuse_brdf: 0.02\n");
  assert_true(hetab_surface_sigma0_um(surface) == 0.1 * 6.5);
  assert_true(hetab_surface_bands(surface)[30].diffuse_brdf == 0.02);
  free(assert_round_trip(fixture, surface));
  hetab_surface_free(surface);
}

/* An index file's path starts at the surface file's folder, wherever the program runs. */
static void test_index_file(void **state) {
  text_fixture *fixture = *state;
  char folder[160], text[512];
  snprintf(folder, sizeof folder, "%s/data", fixture->folder);
  assert_int_equal(mkdir(folder, 0700), 0);
  write_text_file(fixture, "data/a.csv", "wl_nm,n,k\n500,1.1,2.1\n600,1.3,2.3\n");
  hetab_surface *surface = load(fixture, "sigma0_um: 1\ntau_um: 2\nindex: {file: data/a.csv}\n"
                                         "wavelengths_nm: 500:600:25\n");
  assert_true(hetab_surface_bands(surface)[4].n == 1.3);
  char *yaml = assert_round_trip(fixture, surface);
  char *absolute = realpath(folder, NULL);
  snprintf(text, sizeof text, "%s/a.csv", absolute);
  assert_string_equal(hetab_index_source(hetab_surface_index(surface)), text);
  assert_non_null(strstr(yaml, text));
  free(absolute);
  free(yaml);
  hetab_surface_free(surface);
}

static void test_extrapolation(void **state) {
  text_fixture *fixture = *state;
#define INFRARED "sigma0_um: 1\ntau_um: 2\nindex: Au\nwavelengths_nm: [700, 3000]\n"
  fails(fixture, write_text_file(fixture, "s.yml", INFRARED),
        (const char *const[]){"s.yml:4", "key wavelengths_nm", "3000 nm", "187.9 to 1937 nm",
                              "extrapolate_index: true", NULL});
  hetab_surface *surface = load(fixture, INFRARED "extrapolate_index: true\n");
  assert_true(hetab_surface_bands(surface)[1].n == 0.92);
  char *text = assert_round_trip(fixture, surface);
  assert_non_null(strstr(text, "extrapolate_index: true"));
  free(text);
  hetab_surface_free(surface);
}

/* ---- writing ---- */

/* Values that few digits do not carry, wavelengths that no double in nm divides to, odd names. */
static void test_exact_round_trip(void **state) {
  text_fixture *fixture = *state;
  double lambda_um[999];
  for (int i = 0; i < 999; i++)
    lambda_um[i] = 0.3 + i / 997.0;
  hetab_surface *surface;
  assert_int_equal(hetab_surface_create(fixture->ctx, 0.1 + 0.2, 20 / 3.0, 4 / 3.0, 1e-7 / 3,
                                        lambda_um, 999, &surface),
                   HETAB_OK);
  char *text = assert_round_trip(fixture, surface);
  assert_non_null(strstr(text, "wavelengths_um: ["));
  free(text);
  assert_int_equal(hetab_surface_set_wavelengths(fixture->ctx, surface, lambda_um, 1), HETAB_OK);
  free(assert_round_trip(fixture, surface));
  hetab_surface_free(surface);
}

static void test_fine_steps_round_trip(void **state) {
  static const char *const axes[] = {"400:401:0.1", "380:780:5", "400.3:500.3:12.5", "633",
                                     "[450, 532.1, 632.8]"};
  text_fixture *fixture = *state;
  for (size_t i = 0; i < sizeof axes / sizeof *axes; i++) {
    char text[160], line[64];
    snprintf(line, sizeof line, "wavelengths_nm: %s\n", axes[i]);
    snprintf(text, sizeof text, "sigma0_um: 1\ntau_um: 2\nindex: {n: 2}\n%s", line);
    hetab_surface *surface = load(fixture, text);
    char *written = assert_round_trip(fixture, surface);
    if (strcmp(axes[i], "633") != 0)
      assert_non_null(strstr(written, line));
    free(written);
    hetab_surface_free(surface);
  }
}

static void test_names_round_trip(void **state) {
  static const char *const names[] = {"'no'", "\"a: b # c\"", "\"quote \\\" slash \\\\\"",
                                      "12",   "'Präge'",      "\"tab\\tbell\\x07\"",
                                      "' x '"};
  text_fixture *fixture = *state;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char text[160];
    snprintf(text, sizeof text, "name: %s\nsigma0_um: 1\ntau_um: 2\nindex: Au\n", names[i]);
    hetab_surface *surface = load(fixture, text);
    free(assert_round_trip(fixture, surface));
    hetab_surface_free(surface);
  }
}

static void test_diffuse_list_round_trip(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface = load(fixture, "sigma0_um: 1\ntau_um: 2\nindex: Cu\n"
                                         "diffuse_reflectance: [0.1, 0.3, 0.7]\n"
                                         "wavelengths_nm: 500:600:50\n");
  free(assert_round_trip(fixture, surface));
  /* Linear between, held at the ends. */
  const double lambda_um[] = {0.45, 0.525, 0.55, 0.575, 0.65};
  const double reflectance[] = {0.1, 0.2, 0.3, 0.5, 0.7};
  assert_int_equal(hetab_surface_set_wavelengths(fixture->ctx, surface, lambda_um, 5), HETAB_OK);
  for (int i = 0; i < 5; i++)
    assert_true(fabs(hetab_surface_bands(surface)[i].diffuse_brdf - reflectance[i] / pi) < 1e-15);
  free(assert_round_trip(fixture, surface));
  hetab_surface_free(surface);
}

static void test_comma_locale(void **state) {
  text_fixture *fixture = *state;
  if (!use_decimal_comma(fixture))
    skip();
  hetab_surface *surface = load(fixture, "sigma0_um: 1.5\ntau_um: 2.5\nindex: {n: 1.5, k: 0.25}\n"
                                         "wavelengths_nm: 400.5:500.5:12.5\n");
  assert_true(hetab_surface_sigma0_um(surface) == 1.5);
  char *text = assert_round_trip(fixture, surface);
  assert_non_null(strstr(text, "sigma0_um: 1.5\n"));
  setlocale(LC_ALL, "C");
  unsetenv("LOCPATH");
  free(text);
  hetab_surface_free(surface);
}

/* ---- bounds ---- */

static void assert_bounds(const hetab_surface *surface, double low, double high, double tau_low,
                          double tau_high) {
  double sigma0_um[2], tau_um[2];
  hetab_surface_bounds(surface, sigma0_um, tau_um);
  assert_true(sigma0_um[0] == low && sigma0_um[1] == high);
  assert_true(tau_um[0] == tau_low && tau_um[1] == tau_high);
}

static void test_bounds(void **state) {
  text_fixture *fixture = *state;
  hetab_surface *surface = load(fixture, "slope: 0.1\ntau_um: 5\nindex: Al\n"
                                         "sigma0_bounds_um: [0.45, 0.52]\n");
  assert_bounds(surface, 0.45, 0.52, 0, 0);
  assert_int_equal(
      hetab_surface_set_bounds(fixture->ctx, surface, (double[]){0.4, 0.6}, (double[]){4.5, 5}),
      HETAB_OK);
  hetab_surface *by_slope = load(fixture, "sigma0_um: 0.5\ntau_um: 5\nindex: Al\n"
                                          "slope_bounds: [0.09, 0.1]\n");
  assert_bounds(by_slope, 0.09 * 5, 0.5, 0, 0);
  hetab_surface_free(by_slope);
  char *text = assert_round_trip(fixture, surface);
  hetab_surface *again = load(fixture, text);
  assert_bounds(again, 0.4, 0.6, 4.5, 5);
  assert_int_equal(
      hetab_surface_set_bounds(fixture->ctx, again, (double[]){0.55, 0.6}, (double[]){0, 0}),
      HETAB_ERR_ARGUMENT);
  assert_bounds(again, 0.4, 0.6, 4.5, 5);
  free(text);
  hetab_surface_free(again);
  hetab_surface_free(surface);
}

/* ---- from parameters ---- */

static void test_create_refused(void **state) {
  text_fixture *fixture = *state;
  const double good = 0.5, twice[] = {0.5, 0.5}, negative = -1;
  const struct {
    double sigma0_um, tau_um, n, k;
    const double *lambda_um;
    size_t count;
    const char *word;
  } cases[] = {
      {0, 1, 1, 1, &good, 1, "sigma0_um"},
      {NAN, 1, 1, 1, &good, 1, "sigma0_um"},
      {1, -1, 1, 1, &good, 1, "tau_um"},
      {1, INFINITY, 1, 1, &good, 1, "tau_um"},
      {1, 1, 0, 1, &good, 1, "n > 0"},
      {1, 1, 1, -1, &good, 1, "k >= 0"},
      {1, 1, 1, 1, &good, 0, "wavelengths"},
      {1, 1, 1, 1, twice, 2, "ascend"},
      {1, 1, 1, 1, &negative, 1, "no wavelength"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_surface *surface;
    assert_int_equal(hetab_surface_create(fixture->ctx, cases[i].sigma0_um, cases[i].tau_um,
                                          cases[i].n, cases[i].k, cases[i].lambda_um,
                                          cases[i].count, &surface),
                     HETAB_ERR_ARGUMENT);
    assert_null(surface);
    assert_message(fixture, (const char *const[]){cases[i].word, NULL});
  }
}

static void test_set_wavelengths_refused(void **state) {
  text_fixture *fixture = *state;
  const double infrared = 250, descending[] = {0.6, 0.5};
  hetab_surface *surface;
  assert_int_equal(hetab_surface_preset(fixture->ctx, "NGGAL", &surface), HETAB_OK);
  assert_int_equal(hetab_surface_set_wavelengths(fixture->ctx, surface, &infrared, 1),
                   HETAB_ERR_RANGE);
  assert_int_equal(hetab_surface_set_wavelengths(fixture->ctx, surface, descending, 2),
                   HETAB_ERR_ARGUMENT);
  assert_message(fixture, (const char *const[]){"500 nm follows 600 nm", "sort", NULL});
  assert_int_equal(hetab_surface_band_count(surface), 31);
  hetab_surface_free(surface);
  hetab_surface_free(NULL);
}

/* ---- wavelengths as text ---- */

static void test_parse_wavelengths(void **state) {
  text_fixture *fixture = *state;
  double *lambda_um;
  size_t count;
  assert_int_equal(hetab_parse_wavelengths(fixture->ctx, "400:700:0.1", &lambda_um, &count),
                   HETAB_OK);
  assert_int_equal(count, 3001);
  assert_true(lambda_um[3] == 400.3 / 1000 && lambda_um[3000] == 0.7);
  free(lambda_um);
  assert_int_equal(hetab_parse_wavelengths(fixture->ctx, " 400, 550.5 ,700 ", &lambda_um, &count),
                   HETAB_OK);
  assert_int_equal(count, 3);
  assert_true(lambda_um[1] == 0.5505);
  free(lambda_um);
  assert_int_equal(hetab_parse_wavelengths(fixture->ctx, "550:550:10", &lambda_um, &count),
                   HETAB_OK);
  assert_int_equal(count, 1);
  assert_true(lambda_um[0] == 0.55);
  free(lambda_um);
}

static void test_parse_wavelengths_refused(void **state) {
  static const struct {
    const char *text, *words[3];
  } cases[] = {
      {"", {"400:700:10"}},
      {"red", {"'red'", "400:700:10"}},
      {"400:700", {"no range", "400:700:10"}},
      {"400:700:10:1", {"too many"}},
      {"400:700:7", {"stop to 694 or 701", "change step"}},
      {"400:700:0", {"step > 0"}},
      {"400:700:-10", {"step > 0"}},
      {"700:400:10", {"start <= stop"}},
      {"400:700:1e-9", {"more than 100000", "enlarge step"}},
      {"400:1e300:1", {"more than 100000"}},
      {"400:nan:1", {"'nan'"}},
      {"400,,500", {"''"}},
      {"500,400", {"400 nm follows 500 nm"}},
      {"500,500", {"ascend"}},
      {"-5", {"-5 nm", "no wavelength"}},
      {"0:10:5", {"0 nm", "no wavelength"}},
      {"1e999", {"1e999"}},
  };
  text_fixture *fixture = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    double *lambda_um = (double *)fixture;
    size_t count;
    assert_int_not_equal(hetab_parse_wavelengths(fixture->ctx, cases[i].text, &lambda_um, &count),
                         HETAB_OK);
    assert_null(lambda_um);
    assert_message(fixture, cases[i].words);
  }
}

/* ---- bad files ---- */

static void test_bad_files(void **state) {
#define ROUGH "sigma0_um: 1\ntau_um: 2\n"
#define METAL ROUGH "index: Al\n"
  static const struct {
    const char *text, *words[6];
  } cases[] = {
      {"", {"s.yml:1", "empty"}},
      {"\n\n", {"s.yml:1", "empty"}},
      {"just text\n", {"s.yml:1", "key: value"}},
      {"a: b: c\n", {"s.yml:1", "not valid YAML"}},
      {"name: 'x\n", {"s.yml:2", "not valid YAML"}},
      {"tau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", "missing", "slope"}},
      {"sigma0_um: 1\nindex: Al\n", {"s.yml:1", "key tau_um", "missing"}},
      {ROUGH, {"s.yml:1", "key index", "missing", "{file: PATH}"}},
      {METAL "sigma0_bounds_um: 1\n", {"s.yml:4", "key sigma0_bounds_um", "[LOW, HIGH]"}},
      {METAL "sigma0_bounds_um: [0.9, 2]\nslope_bounds: [0.1, 2]\n", {"s.yml:5", "keep one"}},
      {METAL "sigma0_bounds_um: [0.9]\n", {"s.yml:4", "the value, 1, between"}},
      {METAL "sigma0_bounds_um: [-1, 2]\n", {"s.yml:4", "key sigma0_bounds_um", "length"}},
      {METAL "tau_bounds_um: [3, 1]\n", {"s.yml:4", "the value, 2, between"}},
      {METAL "sigma_um: 1\n", {"s.yml:4", "key sigma_um", "did you mean sigma0_um?"}},
      {"sigma: 1\n", {"s.yml:1", "key sigma", "did you mean sigma0_um?"}},
      {METAL "wavelength_nm: 1\n", {"s.yml:4", "did you mean wavelengths_nm?"}},
      {METAL "Name: x\n", {"s.yml:4", "key Name", "did you mean name?"}},
      {METAL "zzz: 1\n", {"s.yml:4", "key zzz", "not known", "diffuse_brdf"}},
      {METAL "[1]: 1\n", {"s.yml:4", "not known"}},
      {METAL "tau_um: 2\n", {"s.yml:4", "key tau_um", "line 2"}},
      {METAL "slope: 1\n", {"s.yml:4", "key slope", "besides sigma0_um"}},
      {"slope: -1\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key slope", "-1"}},
      {"slope: 1e9\ntau_um: 1e6\nindex: Al\n", {"s.yml:1", "key slope", "length"}},
      {"sigma0_um: 0\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", "0 is out", "um"}},
      {"sigma0_um: -0.5\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", "-0.5"}},
      {"sigma0_um: .nan\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", ".nan"}},
      {"sigma0_um: 1\ntau_um: .inf\nindex: Al\n", {"s.yml:2", "key tau_um", ".inf"}},
      {"sigma0_um: 1\ntau_um: 0\nindex: Al\n", {"s.yml:2", "key tau_um", "0 is out"}},
      {"sigma0_um: 1\ntau_um: -2\nindex: Al\n", {"s.yml:2", "key tau_um", "-2"}},
      {"sigma0_um: 1\ntau_um: 1e999\nindex: Al\n", {"s.yml:2", "key tau_um", "1e999"}},
      {"sigma0_um: 1\ntau_um: 1e300\nindex: Al\n", {"s.yml:2", "key tau_um", "1e300"}},
      {"sigma0_um: 1\ntau_um: 0x10\nindex: Al\n", {"s.yml:2", "key tau_um", "0x10"}},
      {"sigma0_um: 1\ntau_um: 6,5\nindex: Al\n", {"s.yml:2", "key tau_um", "'.'"}},
      {"sigma0_um: 1\ntau_um:\nindex: Al\n", {"key tau_um", "is empty"}},
      {"sigma0_um: [1]\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", "a list"}},
      {"sigma0_um: \"1\\0\"\ntau_um: 1\nindex: Al\n", {"s.yml:1", "key sigma0_um", "NUL"}},
      {METAL "name: [x]\n", {"s.yml:4", "key name", "a list"}},
      {METAL "name: ''\n", {"s.yml:4", "key name", "is empty"}},
      {METAL "extrapolate_index: yes\n", {"s.yml:4", "key extrapolate_index", "true or false"}},
      {ROUGH "index: Xx\n", {"s.yml:3", "key index", "'Xx'", "stainless", "{file: PATH}"}},
      {ROUGH "index: [Al]\n", {"s.yml:3", "key index", "a list"}},
      {ROUGH "index: {}\n", {"s.yml:3", "key n", "missing", "{file: PATH}"}},
      {ROUGH "index: {k: 1}\n", {"s.yml:3", "key n", "missing"}},
      {ROUGH "index: {n: 0}\n", {"s.yml:3", "key n", "n > 0"}},
      {ROUGH "index: {n: 1, k: -1}\n", {"s.yml:3", "key k", "k >= 0"}},
      {ROUGH "index: {n: 1, K: 1}\n", {"s.yml:3", "key K", "did you mean k?"}},
      {ROUGH "index: {n: 1, n: 2}\n", {"s.yml:3", "key n", "already"}},
      {ROUGH "index: {file: a.csv, n: 2}\n", {"s.yml:3", "key file", "keep"}},
      {ROUGH "index: {file: [a]}\n", {"s.yml:3", "key file", "a list"}},
      {ROUGH "index: {file: no.csv}\n", {"s.yml:3", "key file", "/no.csv", "No such file"}},
      {ROUGH "index: {file: .}\n", {"s.yml:3", "key file", "directory"}},
      {ROUGH "index: {file: bad.csv}\n", {"bad.csv:2", "n = -1"}},
      {METAL "diffuse_brdf: 0\ndiffuse_reflectance: 0\n", {"s.yml:4", "key diffuse_brdf", "keep"}},
      {METAL "diffuse_brdf: -1\n", {"s.yml:4", "key diffuse_brdf", "-1"}},
      {METAL "diffuse_reflectance: 20\n", {"s.yml:4", "key diffuse_reflectance", "0 to 1"}},
      {METAL "diffuse_reflectance: {a: 1}\n", {"s.yml:4", "key diffuse_reflectance", "mapping"}},
      {METAL "diffuse_brdf: [0, 0]\n", {"s.yml:4", "key diffuse_brdf", "2 values", "31"}},
      {METAL "diffuse_brdf: []\n", {"s.yml:4", "key diffuse_brdf", "0 values"}},
      {METAL "diffuse_brdf:\n  - 0\n  - x\n", {"s.yml:6", "key diffuse_brdf", "'x'"}},
      {METAL "wavelengths_nm: 400:700:7\n", {"s.yml:4", "key wavelengths_nm", "694 or 701"}},
      {METAL "wavelengths_nm: 400:700:1e-6\n", {"s.yml:4", "key wavelengths_nm", "100000"}},
      {METAL "wavelengths_nm: []\n", {"s.yml:4", "key wavelengths_nm", "0 wavelengths"}},
      {METAL "wavelengths_nm: [500, 400]\n", {"s.yml:4", "key wavelengths_nm", "sort"}},
      {METAL "wavelengths_nm: [500, 500]\n", {"s.yml:4", "key wavelengths_nm", "sort"}},
      {METAL "wavelengths_nm: [500, [6]]\n", {"s.yml:4", "key wavelengths_nm", "a list"}},
      {METAL "wavelengths_nm: [0]\n", {"s.yml:4", "key wavelengths_nm", "0 nm"}},
      {METAL "wavelengths_nm: {a: 1}\n", {"s.yml:4", "key wavelengths_nm", "a mapping"}},
      {METAL "wavelengths_nm: 500\nwavelengths_um: 0.5\n", {"s.yml:5", "key wavelengths_um"}},
      {METAL "wavelengths_um: 500\n", {"s.yml:4", "key wavelengths_um", "to 200000 nm"}},
      {METAL "---\n" METAL, {"s.yml:5", "second YAML document"}},
  };
  text_fixture *fixture = *state;
  write_text_file(fixture, "bad.csv", "wl_nm,n\n400,-1\n");
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    fails(fixture, write_text_file(fixture, "s.yml", cases[i].text), cases[i].words);
}

/* What a user names as a surface by mistake. */
static void test_other_files(void **state) {
  text_fixture *fixture = *state;
  fails(fixture, "/no/such.yml", (const char *const[]){"/no/such.yml", "cannot open", NULL});
  fails(fixture, fixture->folder, (const char *const[]){"directory", NULL});
  fails(fixture, write_bytes(fixture, "a.yml", "\x89HDF\r\n\x1a\n\0\0\0", 11),
        (const char *const[]){"a.yml:3", "not text", NULL});
  fails(fixture, write_text_file(fixture, "b.yml", "name: caf\xe9\n"),
        (const char *const[]){"b.yml:1", "UTF-8", NULL});
  fails(fixture, "tests/data/index/N-BK7.yml",
        (const char *const[]){"N-BK7.yml:5", "key REFERENCES", "not known", NULL});
  char hostile[] = "/tmp/no\n\x1b[31mfile.yml";
  fails(fixture, hostile, (const char *const[]){"/tmp/no??[31mfile.yml", NULL});
}

static void test_deep_nesting(void **state) {
  static char text[1000001] = "name: x\n";
  memset(text + 8, '[', sizeof text - 9);
  fails(*state, write_text_file(*state, "deep.yml", text),
        (const char *const[]){"deep.yml:2", "too many open brackets", NULL});
  memset(text + 8, '&', sizeof text - 9);
  fails(*state, write_text_file(*state, "anchors.yml", text),
        (const char *const[]){"anchors.yml:2", "too many anchors", NULL});
}

/* Aliases stay references: this would be 10^9 numbers if they were copied out. */
static void test_alias_bomb(void **state) {
  char text[2048] = METAL "diffuse_brdf:\n  - &a [0,0,0,0,0,0,0,0,0,0]\n", line[96];
  for (char c = 'b'; c <= 'i'; c++) {
    char p = (char)(c - 1);
    snprintf(line, sizeof line, "  - &%c [*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c]\n", c, p, p, p,
             p, p, p, p, p, p, p);
    strcat(text, line);
  }
  fails(*state, write_text_file(*state, "bomb.yml", text),
        (const char *const[]){"bomb.yml:5", "key diffuse_brdf", "a list", NULL});
  fails(*state, write_text_file(*state, "loop.yml", "index: &a {n: *a}\n" ROUGH),
        (const char *const[]){"loop.yml:1", "key n", "a mapping", NULL});
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, text_fixture_setup, text_fixture_teardown)
  const struct CMUnitTest tests[] = {
      TEST(test_presets),
      TEST(test_preset_names),
      TEST(test_full_file),
      TEST(test_defaults),
      TEST(test_slope),
      TEST(test_index_file),
      TEST(test_extrapolation),
      TEST(test_exact_round_trip),
      TEST(test_fine_steps_round_trip),
      TEST(test_names_round_trip),
      TEST(test_diffuse_list_round_trip),
      TEST(test_comma_locale),
      TEST(test_bounds),
      TEST(test_create_refused),
      TEST(test_set_wavelengths_refused),
      TEST(test_parse_wavelengths),
      TEST(test_parse_wavelengths_refused),
      TEST(test_bad_files),
      TEST(test_other_files),
      TEST(test_deep_nesting),
      TEST(test_alias_bomb),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
