/* Refractive indices: built-in metals, files in both formats, dispersion formulas, bad input. */
#include "text_fixture.h"

#include <locale.h>
#include <math.h>

typedef struct bad_file {
  const char *name, *text;
  const char *words[4]; /* what the message has to hold; the last one NULL */
} bad_file;

static hetab_index *load(text_fixture *fixture, const char *name, const char *text) {
  hetab_index *index;
  if (hetab_index_load(fixture->ctx, write_text_file(fixture, name, text), &index) != HETAB_OK)
    fail_msg("%s", hetab_error_message(fixture->ctx));
  return index;
}

static void assert_index(text_fixture *fixture, const hetab_index *index, double lambda_um,
                         double n, double k, double relative) {
  double n_got, k_got;
  assert_int_equal(hetab_index_at(fixture->ctx, index, lambda_um, 0, &n_got, &k_got), HETAB_OK);
  assert_true(fabs(n_got - n) <= relative * n);
  assert_true(fabs(k_got - k) <= relative * k);
}

static void fails(text_fixture *fixture, const char *path, const char *const *words) {
  hetab_index *index = (hetab_index *)fixture;
  assert_int_not_equal(hetab_index_load(fixture->ctx, path, &index), HETAB_OK);
  assert_null(index);
  assert_message(fixture, words);
}

/* ---- constants and metals ---- */

static void test_constant(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index;
  double min_um, max_um;
  assert_int_equal(hetab_index_constant(fixture->ctx, 0.958, 6.69, &index), HETAB_OK);
  assert_index(fixture, index, 1e-3, 0.958, 6.69, 0);
  assert_index(fixture, index, 1e3, 0.958, 6.69, 0);
  hetab_index_range(index, &min_um, &max_um);
  assert_true(min_um == 0 && isinf(max_um));
  assert_string_equal(hetab_index_source(index), "constant");
  hetab_index_free(index);
  hetab_index_free(NULL);
}

static void test_constant_refused(void **state) {
  text_fixture *fixture = *state;
  const double bad[][2] = {{0, 1}, {-1, 1}, {NAN, 1}, {INFINITY, 1}, {1, -1e-9}, {1, NAN}};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    hetab_index *index;
    assert_int_equal(hetab_index_constant(fixture->ctx, bad[i][0], bad[i][1], &index),
                     HETAB_ERR_ARGUMENT);
    assert_null(index);
    assert_message(fixture, (const char *const[]){"out of range", NULL});
  }
}

static void test_metals(void **state) {
  static const double used_um[] = {0.36, 0.55, 0.83, 0.905, 1.55}; /* eyes, renderers, lidar */
  text_fixture *fixture = *state;
  assert_int_equal(hetab_metal_count(), 10);
  for (size_t i = 0; i < hetab_metal_count(); i++) {
    hetab_index *index;
    double min_um, max_um;
    assert_int_equal(hetab_index_metal(fixture->ctx, hetab_metal_symbol(i), &index), HETAB_OK);
    hetab_index_range(index, &min_um, &max_um);
    assert_true(min_um >= 0.1 && min_um <= 0.2 && max_um >= 1.937);
    for (size_t w = 0; w < sizeof used_um / sizeof *used_um; w++) {
      double n, k;
      assert_int_equal(hetab_index_at(fixture->ctx, index, used_um[w], 0, &n, &k), HETAB_OK);
      assert_true(n > 0.03 && n < 6 && k > 1 && k < 20);
    }
    assert_string_equal(hetab_index_source(index), hetab_metal_citation(i));
    assert_non_null(strstr(hetab_metal_citation(i), "doi:10."));
    assert_true(strlen(hetab_metal_name(i)) > 0);
    hetab_index_free(index);
  }
}

/* Rows as in the sources, and what lies between them at 550 nm. */
static void test_metal_values(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index;
  assert_int_equal(hetab_index_metal(fixture->ctx, "al", &index), HETAB_OK);
  assert_index(fixture, index, 0.4, 0.487869, 4.83552, 5e-6);
  assert_index(fixture, index, 0.55, 1.01519, 6.62728, 5e-6);
  assert_index(fixture, index, 0.7, 1.92139, 8.14197, 5e-6);
  hetab_index_free(index);
  assert_int_equal(hetab_index_metal(fixture->ctx, "Tungsten", &index), HETAB_OK);
  assert_index(fixture, index, 0.7, 3.86833, 2.88026, 5e-6);
  hetab_index_free(index);
}

static void test_unknown_metal(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index;
  assert_int_equal(hetab_index_metal(fixture->ctx, "Unobtainium", &index), HETAB_ERR_ARGUMENT);
  assert_message(fixture, (const char *const[]){"Unobtainium",
                                                "Al, Ag, Au, Cu, Cr, Ni, Ti, Fe, W, "
                                                "stainless",
                                                "{file: PATH}", NULL});
}

/* ---- refractiveindex.info files ---- */

/* Expected: the definitions evaluated by mpmath with 30 digits. Published values: n_d of fused
 * silica 1.4585, N-BK7 1.5168, TIM11 1.620955; CO2 at 0 C 1.000449; Si at 4 um 3.43. */
static void test_formulas(void **state) {
  static const struct {
    int formula;
    const char *range, *coefficients;
    double lambda_um, n;
  } cases[] = {
      {1, "0.21 6.7", "0 0.6961663 0.0684043 0.4079426 0.1162414 0.8974794 9.896161", 0.5875618,
       1.45846368713722597},
      {1, "1.357 11.04", "0 10.6684293 0.301516485 0.0030434748 1.13475115 1.54133408 1104", 2.5,
       3.43943711255905819},
      {2, "0.3 2.5", "0 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653",
       0.5875618, 1.51680003450058846},
      {3, "0.3 2.4",
       "2.5613591 -0.01200739 2 0.020780357 -2 0.001425606 -4 -0.00011027477 -6 1.1477786e-05 -8",
       0.5875618, 1.62095533278494794},
      {4, "0.45 4.0", "2.80333 0.94470 2 0.3004 2 0 0 0 1 -0.00714 2", 0.6, 2.01531163553635684},
      {4, "0.81 18", "11.62264 0.43221 0 0.15597 1 18868.52 0 3953.34 1", 1.5, 2.65584607057048551},
      {4, "0.3 1.06", "2.1823 0.0125 0 0.0300 1", 0.6, 1.49002643865093477},
      {5, "0.4765 0.83", "1.41545 0.00369 -2 0.00004 -4", 0.5893, 1.42640727665287409},
      {6, "0.1807 1.6945",
       "0 6.99100e-2 166.175 1.44720e-3 79.609 6.42941e-5 56.3064 5.21306e-5 46.0196 1.46847e-6 "
       "0.0584738",
       0.5893, 1.000448872105867},
      {7, "2.4373 25", "3.41983 0.159906 -0.123109 1.26878E-6 -1.95104E-9", 4, 3.42937886430251432},
      {8, "0.495 0.67", "0.452505 0.09939 0.070537 -0.000150", 0.5893, 2.25724480700696732},
      {9, "0.3 1.06", "2.51527 0.0240 0.0300 0.020 1.52 0.8771", 0.6, 1.60540378803145197},
  };
  text_fixture *fixture = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char text[512];
    snprintf(text, sizeof text,
             "DATA:\n  - type: formula %d\n    wavelength_range: %s\n    coefficients: %s\n",
             cases[i].formula, cases[i].range, cases[i].coefficients);
    hetab_index *index = load(fixture, "formula.yml", text);
    assert_index(fixture, index, cases[i].lambda_um, cases[i].n, 0, 1e-15);
    hetab_index_free(index);
  }
}

/* A glass as it stands in the database: a formula for n, a table for k, more keys to ignore. */
static void test_database_glass(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index;
  double min_um, max_um;
  assert_int_equal(hetab_index_load(fixture->ctx, "tests/data/index/N-BK7.yml", &index), HETAB_OK);
  assert_index(fixture, index, 0.5875618, 1.5168, 9.74995e-9, 1e-4);
  assert_index(fixture, index, 0.4861327, 1.52238, 9.823513e-9, 1e-5); /* n_F of the data sheet */
  hetab_index_range(index, &min_um, &max_um);
  assert_true(min_um == 0.3 && max_um == 2.5);
  assert_true(*hetab_index_source(index) == '/');
  hetab_index_free(index);
}

/* The built-in gold is this file. */
static void test_database_metal(void **state) {
  text_fixture *fixture = *state;
  hetab_index *file, *builtin;
  assert_int_equal(hetab_index_load(fixture->ctx, "tests/data/index/Au-Johnson.yml", &file),
                   HETAB_OK);
  assert_int_equal(hetab_index_metal(fixture->ctx, "Au", &builtin), HETAB_OK);
  for (int nm = 188; nm <= 1937; nm++) {
    double n, k;
    assert_int_equal(hetab_index_at(fixture->ctx, builtin, nm / 1000.0, 0, &n, &k), HETAB_OK);
    assert_index(fixture, file, nm / 1000.0, n, k, 1e-12);
  }
  hetab_index_free(file);
  hetab_index_free(builtin);
}

static void test_tabulated_n_and_k(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index = load(fixture, "nk.yaml",
                            "\xEF\xBB\xBF"
                            "DATA:\r\n  - type: tabulated n\r\n    data: |\r\n"
                            "        0.6 3  \r\n        0.4 1\r\n\r\n        0.5 2\r\n"
                            "  - type: tabulated k\r\n    data: |\r\n"
                            "        0.45 10\r\n        0.7 20\r\n");
  double min_um, max_um;
  hetab_index_range(index, &min_um, &max_um);
  assert_true(min_um == 0.45 && max_um == 0.6);
  assert_index(fixture, index, 0.55, 2.5, 14, 1e-14);
  hetab_index_free(index);
}

static void test_bad_yaml(void **state) {
#define ENTRY "DATA:\n  - type: tabulated nk\n    data: |\n"
#define FORMULA "DATA:\n  - type: formula 1\n"
  static const bad_file files[] = {
      {"a.yml", "", {"a.yml:1", "empty"}},
      {"a.yml", "# nothing\n", {"a.yml:1", "empty"}},
      {"a.yml", "- 1\n", {"a.yml:1", "key: value"}},
      {"a.yml", "DATA: [\n", {"a.yml:2", "not valid YAML"}},
      {"a.yml", "DATA:\n\t- type\n", {"a.yml:2", "not valid YAML"}},
      {"a.yml", "REFERENCES: x\n\nDATA: \xFF\n", {"a.yml:3", "UTF-8"}},
      {"a.yml", "SPECS: 1\n", {"a.yml:1", "DATA", "missing"}},
      {"a.yml", "DATA: 1\n", {"a.yml:1", "key DATA", "not a list"}},
      {"a.yml", "DATA: []\n", {"a.yml:1", "key DATA", "no n"}},
      {"a.yml", "DATA:\n  - 1\n", {"a.yml:2", "key DATA", "- type"}},
      {"a.yml", "DATA: []\nDATA: []\n", {"a.yml:2", "key DATA", "line 1"}},
      {"a.yml", "DATA: []\n---\nDATA: []\n", {"a.yml:3", "second YAML document"}},
      {"a.yml", "DATA:\n  - data: 1\n", {"a.yml:2", "key type", "tabulated nk"}},
      {"a.yml", "DATA:\n  - type: formula 10\n", {"a.yml:2", "formula 10", "formula 9"}},
      {"a.yml", "DATA:\n  - type: formula A\n", {"a.yml:2", "formula A", "formula 9"}},
      {"a.yml", "DATA:\n  - type: [1]\n", {"a.yml:2", "key type", "a list"}},
      {"a.yml", "DATA:\n  - type: tabulated nk\n", {"a.yml:2", "key data", "missing"}},
      {"a.yml", "DATA:\n  - type: tabulated k\n    data: |\n      1 2\n", {"a.yml:2", "no n"}},
      {"a.yml", ENTRY, {"a.yml:3", "key data", "empty"}},
      {"a.yml", ENTRY "      0.4 1 2\n      0.5 1\n", {"a.yml:5", "key data", "give 3"}},
      {"a.yml", ENTRY "\n      0.4 1 2\n      0.5 1\n", {"a.yml:6", "key data", "give 3"}},
      {"a.yml", ENTRY "      0.4 1 2 3\n", {"a.yml:4", "key data", "more than 3"}},
      {"a.yml", ENTRY "      0.4 1 x\n", {"a.yml:4", "key data", "'x' is not a number"}},
      {"a.yml", ENTRY "      0.4 nan 1\n", {"a.yml:4", "key data", "'nan' is not a number"}},
      {"a.yml", ENTRY "      0.4 1 inf\n", {"a.yml:4", "key data", "'inf' is not a number"}},
      {"a.yml", ENTRY "      0.4 1e999 1\n", {"a.yml:4", "key data", "1e999"}},
      {"a.yml", ENTRY "      0.4 0 1\n", {"a.yml:4", "n = 0", "n > 0"}},
      {"a.yml", ENTRY "      0.4 1 -1\n", {"a.yml:4", "k = -1", "k >= 0"}},
      {"a.yml", ENTRY "      0 1 1\n", {"a.yml:4", "key data", "length"}},
      {"a.yml", ENTRY "      0.4 1 1\n      0.4 2 2\n", {"a.yml:5", "0.4 um", "line 4"}},
      {"a.yml",
       ENTRY "      0.4 1 1\n  - type: tabulated n\n    data: |\n      1 2\n",
       {"a.yml:5", "key type", "second time"}},
      {"a.yml",
       "DATA:\n  - type: tabulated n\n    data: |\n      0.4 1\n      0.5 1\n"
       "  - type: tabulated k\n    data: |\n      0.6 1\n",
       {"a.yml:2", "key DATA", "no wavelength"}},
      {"a.yml", FORMULA, {"a.yml:2", "key coefficients", "missing"}},
      {"a.yml", FORMULA "    coefficients: 1 2\n", {"a.yml:3", "key coefficients", "odd number"}},
      {"a.yml", FORMULA "    coefficients: 1\n", {"a.yml:2", "key wavelength_range", "missing"}},
      {"a.yml", FORMULA "    coefficients: 1 x 2\n", {"a.yml:3", "key coefficients", "'x'"}},
      {"a.yml",
       FORMULA "    coefficients: 1\n    wavelength_range: 2 1\n",
       {"a.yml:4", "key wavelength_range", "ascending"}},
      {"a.yml",
       FORMULA "    coefficients: 1\n    coefficients: 1\n",
       {"a.yml:4", "key coefficients", "line 3"}},
  };
  for (size_t i = 0; i < sizeof files / sizeof *files; i++)
    fails(*state, write_text_file(*state, files[i].name, files[i].text), files[i].words);
}

static void test_too_many_coefficients(void **state) {
  char text[1024] = FORMULA "    coefficients:";
  for (int i = 0; i < 100; i++)
    strcat(text, " 1");
  fails(*state, write_text_file(*state, "many.yml", strcat(text, "\n")),
        (const char *const[]){"many.yml:3", "key coefficients", "more than 64", NULL});
}

/* ---- CSV ---- */

static void test_csv_headers(void **state) {
  static const char *const headers[] = {
      "wavelength_nm,n,k", "Wavelength (nm), N, K", "wl_nm;n;k",
      "lambda [nm]\tn\tk", "\"wavelength nm\",n,k", "wavelength in nm , n , k"};
  text_fixture *fixture = *state;
  for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
    char text[256];
    char c = strchr(headers[i], ';') ? ';' : strchr(headers[i], '\t') ? '\t' : ',';
    snprintf(text, sizeof text, "%s\n500%c2%c3\n400%c1%c2\n", headers[i], c, c, c, c);
    hetab_index *index = load(fixture, "header.csv", text);
    assert_index(fixture, index, 0.45, 1.5, 2.5, 1e-14);
    hetab_index_free(index);
  }
}

static void test_csv_forms(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index = load(fixture, "forms.csv",
                            "\xEF\xBB\xBF# gold\r\n\r\n k , n,wavelength (\xC2\xB5m) # header\r\n"
                            "3,1,0.4  \r\n\r\n# half way\r\n4,2,0.5 # done\r\n");
  assert_index(fixture, index, 0.45, 1.5, 3.5, 1e-14);
  hetab_index_free(index);
  index = load(fixture, "dielectric.CSV", "lambda_um,n\n0.4,1.5\n0.8,1.4");
  assert_index(fixture, index, 0.8, 1.4, 0, 0);
  hetab_index_free(index);
}

/* refractiveindex.info: two tables in a download, and rows that nobody asks for. */
static void test_database(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index = load(fixture, "download.csv",
                            "wl,n\n0.4,1.5\n0.5,2.5\n1200,1120\n\nwl,k\n0.2,-0.0005\n0.4,3\n"
                            "0.4,3\n0.5,4\n");
  assert_index(fixture, index, 0.45, 2, 3.5, 1e-14);
  hetab_index_free(index);
  index = load(fixture, "far.yml",
               "DATA:\n  - type: tabulated nk\n    data: |\n      0.2 1.4 -0.05\n"
               "      0.25 1.5 -0.0009\n      0.4 1.5 0\n      0.5 2.45 1\n      0.5 2.55 1\n"
               "      3 -256 1\n      1.1e6 1100 2000\n");
  assert_index(fixture, index, 0.45, 2, 0.5, 1e-14);
  assert_index(fixture, index, 0.3, 1.5, 0, 0); /* of -0.0009 and 0 */
  double n, k;
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.21, 0, &n, &k), HETAB_ERR_RANGE);
  assert_message(fixture, (const char *const[]){"far.yml", "k = -0.04", "0.21 um", NULL});
  assert_int_equal(hetab_index_at(fixture->ctx, index, 1e6, 0, &n, &k), HETAB_ERR_RANGE);
  hetab_index_free(index);
}

static void test_bad_csv(void **state) {
#define HEADER "wavelength_nm,n,k\n"
  static const bad_file files[] = {
      {"a.csv", "", {"a.csv:1", "empty", "wavelength_nm,n,k"}},
      {"a.csv", "# only\n\n", {"a.csv:2", "empty"}},
      {"a.csv", "wl,n\n40,2\n41,2\n\nwl,k\n0.4,0\n0.5,0\n", {"a.csv:7", "share no wavelength"}},
      {"a.csv", "400,1,2\n", {"a.csv:1", "no header", "wavelength_nm,n,k"}},
      {"a.csv", "wavelength,n,k\n", {"a.csv:1", "column 'wavelength'", "wavelength_nm"}},
      {"a.csv", "wl (eV),n,k\n", {"a.csv:1", "column 'wl (eV)'", "unit"}},
      {"a.csv", "wl_nm,n,kappa\n", {"a.csv:1", "column 'kappa'"}},
      {"a.csv", "wl_nm,n,n\n", {"a.csv:1", "column 'n'", "twice"}},
      {"a.csv", "wl_nm,k\n400,1\n", {"a.csv:1", "column n missing"}},
      {"a.csv", "n,k\n1,1\n", {"a.csv:1", "column wavelength missing"}},
      {"a.csv", HEADER, {"a.csv:1", "no rows"}},
      {"a.csv", HEADER "400,1\n", {"a.csv:2", "2 fields", "names 3"}},
      {"a.csv", HEADER "400,1,2,3\n", {"a.csv:2", "4 fields", "names 3"}},
      {"a.csv", "wl_nm;n;k\n400.0;1,5;2\n", {"a.csv:2", "column 'n'", "'.'"}},
      {"a.csv", HEADER "\n# c\n400,1,\n", {"a.csv:4", "column 'k'", "'' is not a number"}},
      {"a.csv", HEADER "400,0x1p3,1\n", {"a.csv:2", "column 'n'", "0x1p3"}},
      {"a.csv", HEADER "400,NaN,1\n", {"a.csv:2", "column 'n'", "NaN"}},
      {"a.csv", HEADER "inf,1,1\n", {"a.csv:2", "column 'wavelength_nm'", "inf"}},
      {"a.csv", HEADER "400,1e400,1\n", {"a.csv:2", "column 'n'", "1e400"}},
      {"a.csv", HEADER "400,0,1\n", {"a.csv:2", "n = 0", "n > 0"}},
      {"a.csv", HEADER "400,1,-1\n", {"a.csv:2", "k = -1", "k >= 0"}},
      {"a.csv", HEADER "-400,1,1\n", {"a.csv:2", "column 'wavelength_nm'", "length"}},
      {"a.csv", HEADER "500,1,1\n400,1,1\n500,1,2\n", {"a.csv:4", "500 nm", "1 1; here 1 2"}},
  };
  for (size_t i = 0; i < sizeof files / sizeof *files; i++)
    fails(*state, write_text_file(*state, files[i].name, files[i].text), files[i].words);
}

/* ---- files that are none ---- */

static void test_unreadable(void **state) {
  text_fixture *fixture = *state;
  char path[160];
  const char *const missing[] = {"cannot open", "No such file", "check the path", NULL};
  fails(fixture, "/no/such/file.yml", missing);
  fails(fixture, "/no/such/file.csv", missing);
  snprintf(path, sizeof path, "%s/folder.yml", fixture->folder);
  assert_int_equal(mkdir(path, 0700), 0);
  fails(fixture, path, (const char *const[]){"folder.yml", "directory", "text file", NULL});
  fails(fixture, fixture->folder, (const char *const[]){"directory", NULL});
}

static void test_binary(void **state) {
  text_fixture *fixture = *state;
  const char junk[] = "\x7f"
                      "ELF\n\n\0\1\2\xff";
  fails(fixture, write_bytes(fixture, "junk.yml", junk, sizeof junk),
        (const char *const[]){"junk.yml:3", "not text", NULL});
  fails(fixture, write_bytes(fixture, "junk.csv", junk, sizeof junk),
        (const char *const[]){"junk.csv:3", "not text", NULL});
  fails(fixture, write_text_file(fixture, "control.yml", "DATA: 1\nX: \x01\n"),
        (const char *const[]){"control.yml:2", NULL});
}

static void test_too_large(void **state) {
  text_fixture *fixture = *state;
  write_text_file(fixture, "large.csv", "wavelength_nm,n\n");
  assert_int_equal(truncate(fixture->path, 17 << 20), 0);
  fails(fixture, fixture->path, (const char *const[]){"large.csv", "16 MiB", NULL});
}

/* Aliases nine levels deep that would expand to 10^9 entries: refused at the first entry. */
static void test_alias_bomb(void **state) {
  char text[1024] = "a: &a [x,x,x,x,x,x,x,x,x,x]\n", line[96];
  for (char c = 'b'; c <= 'i'; c++) {
    char p = (char)(c - 1);
    snprintf(line, sizeof line, "%c: &%c [*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c]\n", c, c, p, p,
             p, p, p, p, p, p, p, p);
    strcat(text, line);
  }
  fails(*state, write_text_file(*state, "bomb.yml", strcat(text, "DATA: *i\n")),
        (const char *const[]){"bomb.yml:8", "key DATA", NULL});
  fails(*state, write_text_file(*state, "loop.yml", "DATA: &a [*a]\n"),
        (const char *const[]){"loop.yml:1", "key DATA", NULL});
}

/* ---- range, extrapolation, locale ---- */

static void test_range(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index = load(fixture, "a.csv", "wl_nm,n,k\n400,1,2\n500,2,3\n");
  double n = -1, k = -1;
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.51, 0, &n, &k), HETAB_ERR_RANGE);
  assert_message(fixture, (const char *const[]){"0.51 um", "400 to 500 nm", "0.4 to 0.5 um",
                                                "extrapolate_index: true", NULL});
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.39, 0, &n, &k), HETAB_ERR_RANGE);
  assert_int_equal(hetab_index_at(fixture->ctx, index, NAN, 1, &n, &k), HETAB_ERR_ARGUMENT);
  assert_true(n == -1 && k == -1);
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.9, 1, &n, &k), HETAB_OK);
  assert_true(n == 2 && k == 3);
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.1, 1, &n, &k), HETAB_OK);
  assert_true(n == 1 && k == 2);
  /* One rounding beyond the end is the end. */
  assert_index(fixture, index, nextafter(0.5, 1), 2, 3, 0);
  hetab_index_free(index);
}

static void test_formula_range(void **state) {
  text_fixture *fixture = *state;
  hetab_index *index = load(fixture, "a.yml",
                            "DATA:\n  - type: formula 2\n    range: 0.5 0.6\n"
                            "    coefficients: 0 1 0.04\n");
  double n, k;
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.7, 0, &n, &k), HETAB_ERR_RANGE);
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.7, 1, &n, &k), HETAB_OK);
  assert_true(fabs(n - sqrt(1 + 0.49 / 0.45)) < 1e-15 && k == 0);
  /* Below its pole, at 0.2 um, the formula gives a negative n^2. */
  assert_int_equal(hetab_index_at(fixture->ctx, index, 0.19, 1, &n, &k), HETAB_ERR_RANGE);
  assert_message(fixture, (const char *const[]){"a.yml", "0.19 um", "no index", NULL});
  hetab_index_free(index);
}

static void test_comma_locale(void **state) {
  text_fixture *fixture = *state;
  if (!use_decimal_comma(fixture))
    skip();
  hetab_index *index = load(fixture, "a.csv", "wl_um,n,k\n0.4,1.5,2\n0.5,2,3\n");
  assert_index(fixture, index, 0.4, 1.5, 2, 0);
  setlocale(LC_ALL, "C");
  unsetenv("LOCPATH");
  hetab_index_free(index);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, text_fixture_setup, text_fixture_teardown)
  const struct CMUnitTest tests[] = {
      TEST(test_constant),
      TEST(test_constant_refused),
      TEST(test_metals),
      TEST(test_metal_values),
      TEST(test_unknown_metal),
      TEST(test_formulas),
      TEST(test_database_glass),
      TEST(test_database_metal),
      TEST(test_tabulated_n_and_k),
      TEST(test_bad_yaml),
      TEST(test_too_many_coefficients),
      TEST(test_csv_headers),
      TEST(test_csv_forms),
      TEST(test_database),
      TEST(test_bad_csv),
      TEST(test_unreadable),
      TEST(test_binary),
      TEST(test_too_large),
      TEST(test_alias_bomb),
      TEST(test_range),
      TEST(test_formula_range),
      TEST(test_comma_locale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
