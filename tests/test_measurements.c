/* The readers of measured BRDFs: conventions, every format against the others, and bad input.
 *
 * tests/data/measurements/synthetic.* hold one set of numbers in three formats: f(band) = 0.01
 * (band + 1) + 0.8 exp(-25 d^2), d being the distance from the mirror direction in lateral
 * direction cosines, to six decimals; theta_i 15, 45, 70, theta_s 0, 15, 45, 70 degrees, phi_i 20
 * degrees, phi_s 0, 90, 180 below it. paint.* (make_paint) are a paint of the model in the manner
 * of a gonioreflectometer; paints that one has measured are read too where ../shared has them. */
#include <fcntl.h>
#include <math.h>

#include <hetab/measurements.h>

#include "text_fixture.h"

#include <hetab/hetab.h>

static const double pi = 3.14159265358979323846;
static const char data[] = "tests/data/measurements/";
static const char measured[] = "../shared/data/measurements/";

static void assert_ok(const text_fixture *f, hetab_status status) {
  if (status != HETAB_OK)
    fail_msg("%s: %s", hetab_status_name(status), hetab_error_message(f->ctx));
}

static hetab_measurements *load(const text_fixture *f, const char *path) {
  hetab_measurements *m = NULL;
  assert_ok(f, hetab_measurements_load(f->ctx, path, &m));
  return m;
}

static hetab_measurements *load_from(const text_fixture *f, const char *folder, const char *name) {
  char path[160];
  snprintf(path, sizeof path, "%s%s", folder, name);
  return load(f, path);
}

static hetab_measurements *load_text(text_fixture *f, const char *name, const char *text) {
  return load(f, write_text_file(f, name, text));
}

static double value(const hetab_measurements *m, size_t pair, size_t band) {
  return hetab_measurements_values(m)[pair * hetab_measurements_wavelength_count(m) + band];
}

static void assert_shape(const hetab_measurements *m, size_t count, size_t wavelengths) {
  assert_int_equal(hetab_measurements_pair_count(m), count);
  assert_int_equal(hetab_measurements_wavelength_count(m), wavelengths);
}

static void assert_near(double value, double expected, double error) {
  if (!(fabs(value - expected) <= error))
    fail_msg("%.17g instead of %.17g", value, expected);
}

static int is_there(const char *folder) {
  return access(folder, R_OK) == 0;
}

/* ---- one set of numbers, three formats ----------------------------------------------------- */

static void assert_identical(const hetab_measurements *a, const hetab_measurements *b) {
  size_t count = hetab_measurements_pair_count(a), bands = hetab_measurements_wavelength_count(a);
  assert_shape(b, count, bands);
  assert_memory_equal(hetab_measurements_lambda_um(a), hetab_measurements_lambda_um(b),
                      bands * sizeof(double));
  assert_memory_equal(hetab_measurements_pairs(a), hetab_measurements_pairs(b),
                      count * sizeof(hetab_directions));
  assert_memory_equal(hetab_measurements_values(a), hetab_measurements_values(b),
                      count * bands * sizeof(double));
}

static double formula(const hetab_directions *p, size_t band) {
  double x = sin(p->theta_r) * cos(p->phi) + sin(p->theta_i), y = sin(p->theta_r) * sin(p->phi);
  return 0.01 * (double)(band + 1) + 0.8 * exp(-25 * (x * x + y * y));
}

/* What the files say, from the formula at the directions as they were read: a wrong azimuth or a
 * wrong order of columns moves the lobe. */
static void assert_formula(const hetab_measurements *m) {
  static const double nm[] = {450, 550, 650};
  assert_shape(m, 30, 3);
  for (size_t b = 0; b < 3; b++)
    assert_near(hetab_measurements_lambda_um(m)[b], nm[b] / 1000, 1e-15);
  for (size_t i = 0; i < 30; i++)
    for (size_t b = 0; b < 3; b++)
      assert_near(value(m, i, b), formula(&hetab_measurements_pairs(m)[i], b), 3e-6);
  hetab_measurements_skipped s = hetab_measurements_skipped_of(m);
  assert_int_equal(s.below_horizon + s.negative + s.not_finite, 0);
  assert_string_equal(hetab_measurements_name(m), "synthetic");
}

static void test_formats_agree(void **state) {
  text_fixture *f = *state;
  hetab_measurements *text = load_from(f, data, "synthetic.brdf");
  hetab_measurements *astm = load_from(f, data, "synthetic.astm");
  hetab_measurements *csv = load_from(f, data, "synthetic.csv");
  assert_formula(text);
  assert_formula(astm);
  assert_formula(csv);
  assert_identical(text, astm);
  hetab_measurements_free(text);
  hetab_measurements_free(astm);
  hetab_measurements_free(csv);
}

static void check_both_formats(const text_fixture *f, const char *folder, const char *name,
                               size_t count, size_t wavelengths, double first) {
  char text_name[64], astm_name[64];
  snprintf(text_name, sizeof text_name, "%s.brdf", name);
  snprintf(astm_name, sizeof astm_name, "%s.astm", name);
  hetab_measurements *text = load_from(f, folder, text_name);
  hetab_measurements *astm = load_from(f, folder, astm_name);
  assert_shape(text, count, wavelengths);
  assert_identical(text, astm);
  assert_near(value(text, 0, 0), first, 0);
  hetab_measurements_free(text);
  hetab_measurements_free(astm);
}

static void test_paint_in_both_formats(void **state) {
  check_both_formats(*state, data, "paint", 320, 7, 0.1191);
  if (is_there(measured))
    check_both_formats(*state, measured, "cornell-cayman", 1439, 31, 0.000874);
}

/* ---- the mirror direction ------------------------------------------------------------------ */

/* The brightest view of an incidence at a wavelength. */
static hetab_directions brightest(const hetab_measurements *m, double theta_i, size_t band) {
  const hetab_directions *pairs = hetab_measurements_pairs(m);
  hetab_directions best = {0};
  double most = -1;
  for (size_t i = 0; i < hetab_measurements_pair_count(m); i++)
    if (fabs(pairs[i].theta_i - theta_i) < 0.01 && value(m, i, band) > most) {
      most = value(m, i, band);
      best = pairs[i];
    }
  assert_true(most > 0);
  return best;
}

/* The gonioreflectometer's views are 8 to 10 degrees apart in theta_r. */
static void check_lobes(const text_fixture *f, const char *folder, const char *name,
                        double most_off_specular) {
  hetab_measurements *m = load_from(f, folder, name);
  for (int deg = 20; deg <= 80; deg += 10) {
    hetab_directions peak =
        brightest(m, deg * pi / 180, hetab_measurements_wavelength_count(m) - 1);
    assert_near(peak.phi, pi, 1e-3);
    double off_specular = peak.theta_r * 180 / pi - deg;
    assert_true(off_specular > -5 && off_specular < most_off_specular);
  }
  hetab_measurements_free(m);
}

static void test_paints_shine_in_the_mirror_direction(void **state) {
  text_fixture *f = *state;
  check_lobes(f, data, "paint.brdf", 12);
  if (!is_there(measured))
    return;
  check_lobes(f, measured, "cornell-cayman.brdf", 5);
  check_lobes(f, measured, "cornell-krylon_blue.brdf", 5);
  check_lobes(f, measured, "cornell-garnet_red.brdf",
              20); /* rough: its lobe peaks towards grazing */
}

/* Azimuths of any size and sign, polar angles of the other side. */
static void test_azimuths_fold(void **state) {
  text_fixture *f = *state;
  static const char rows[] = "1\n550\n0.5 0 0.5 3.141593 1\n0.5 6 0.5 2.858407 2\n"
                             "0.5 -1 0.5 2.141593 3\n-0.5 0 0.5 0 4\n0.5 0 -0.5 0 5\n"
                             "-0.5 0 -0.5 3.141593 6\n0.5 0.25 0.5 -0.75 7\n0.5 0 0.5 6.283185 8\n";
  hetab_measurements *m = load_text(f, "folds.brdf", rows);
  assert_shape(m, 8, 1);
  for (size_t i = 0; i < 8; i++) {
    hetab_directions pair = hetab_measurements_pairs(m)[i];
    assert_near(pair.theta_i, 0.5, 0);
    assert_near(pair.theta_r, 0.5, 0);
    assert_near(pair.phi, i < 6 ? pi : i == 6 ? 1 : 0, 1e-6);
    assert_near(value(m, i, 0), (double)i + 1, 0);
  }
  hetab_measurements_free(m);
}

/* ---- what is left out ---------------------------------------------------------------------- */

static void assert_skipped(const hetab_measurements *m, size_t below, size_t negative,
                           size_t not_finite) {
  hetab_measurements_skipped s = hetab_measurements_skipped_of(m);
  assert_int_equal(s.below_horizon, below);
  assert_int_equal(s.negative, negative);
  assert_int_equal(s.not_finite, not_finite);
}

static void test_unusable_values_are_counted(void **state) {
  text_fixture *f = *state;
  static const char brdf[] = "2\n500 600\n0.5 0 1 0 1 -0.1\n0.5 0 1.6 0 1 1\n2 0 1 0 1 1\n"
                             "0.5 0 1 1 nan 2\n0.5 0 1 2 -inf NaN\n0.5 0 1 3 1e999 3\n";
  static const char astm[] = "NUM_POINTS 6\nVARS theta_i,phi_i,theta_s,phi_s,500nm,0.6um\n"
                             "0.5,0,1,0,1,-0.1\n0.5,0,1.6,0,1,1\n2,0,1,0,1,1\n0.5,0,1,1,,2\n"
                             "0.5,0,1,2,-inf,NaN\n0.5,0,1,3,1e999,3\n";
  for (int i = 0; i < 2; i++) {
    hetab_measurements *m = i ? load_text(f, "odd.astm", astm) : load_text(f, "odd.brdf", brdf);
    assert_shape(m, 4, 2);
    assert_skipped(m, 2, 1, 4);
    assert_near(value(m, 0, 0), 1, 0);
    assert_near(value(m, 0, 1), -0.1, 0); /* counted, and kept */
    assert_true(isnan(value(m, 1, 0)) && isnan(value(m, 2, 0)));
    assert_near(value(m, 1, 1), 2, 0);
    assert_near(value(m, 3, 1), 3, 0);
    hetab_measurements_free(m);
  }
}

/* Holes in a CSV are missing, not skipped; repeated measurements stay apart. */
static void test_csv_rows_become_pairs(void **state) {
  text_fixture *f = *state;
  hetab_measurements *m = load_text(f, "a.csv",
                                    "\"F\";Phi_deg;theta_r_deg;theta_i_deg;remark;lambda_um\n"
                                    "1;180;30;30;a;0.55\n2;180;30;30;b;0.45\n# a comment\n"
                                    "3;90;30;30;c;0.55\n4;180;30;30;again;0.55\n"
                                    "-1;0;30;30;d;0.45\n9;0;90;30;e;0.45\n");
  assert_shape(m, 4, 2);
  assert_skipped(m, 1, 1, 0);
  assert_near(hetab_measurements_lambda_um(m)[0], 0.45, 0);
  for (size_t i = 0; i < 4; i++)
    assert_near(hetab_measurements_pairs(m)[i].theta_i, pi / 6, 1e-15);
  assert_near(value(m, 0, 0), -1, 0);
  assert_true(isnan(value(m, 0, 1))); /* phi 0: no row */
  assert_near(value(m, 1, 1), 3, 0);
  assert_near(value(m, 2, 0), 2, 0);
  assert_near(value(m, 2, 1), 1, 0);
  assert_true(isnan(value(m, 3, 0)));
  assert_near(value(m, 3, 1), 4, 0);
  hetab_measurements_free(m);
}

/* Columns and wavelengths in any order; formats told apart by what is in them. */
static void test_content_decides(void **state) {
  text_fixture *f = *state;
  hetab_measurements *m = load_text(f, "no-extension",
                                    "# comment\nSAMPLE x\nVARS 600nm,phi_s,theta_s,phi_i,theta_i,x,"
                                    "500nm\n6,0,0.5,3.141593,0.25,ignored,5\n");
  assert_near(hetab_measurements_lambda_um(m)[0], 0.5, 0);
  assert_near(value(m, 0, 0), 5, 0);
  assert_near(value(m, 0, 1), 6, 0);
  assert_near(hetab_measurements_pairs(m)[0].theta_i, 0.25, 0);
  assert_near(hetab_measurements_pairs(m)[0].theta_r, 0.5, 0);
  hetab_measurements_free(m);
  m = load_text(f, "cornell.txt", "# c\n 2 600\n500\n0.25 0\t0.5 3.14 6\n5\n");
  assert_near(value(m, 0, 0), 5, 0);
  hetab_measurements_free(m);
  m = load_text(f, "table.txt",
                "\xEF\xBB\xBFwavelength_nm,theta_i_rad,theta_r_rad,phi_rad,total\r\n"
                "550,0.5,0.25,1,0.125\r\n");
  assert_near(value(m, 0, 0), 0.125, 0);
  assert_near(hetab_measurements_pairs(m)[0].phi, 1, 0);
  hetab_measurements_free(m);
}

/* Columns by wavelength, by colour or without, in the words of spreadsheets; BRDFs times the cosine
 * and reflectance factors. */
static void test_names_of_values(void **state) {
  text_fixture *f = *state;
  const double third = pi / 3, f_cos = 0.25 / cos(40 * pi / 180), factor = 0.25 / pi;
  static const double given[] = {0.633};
  const struct {
    const char *name, *text;
    size_t wavelengths, given;
    double um, value; /* of the last wavelength */
  } cases[] = {
      {"wide.csv", "theta_i_deg,theta_r_deg,phi_deg,450nm,0.65 um\n60,40,180,1,0.25\n", 2, 0, 0.65,
       0.25},
      {"wide.csv", "theta_i (deg);theta_s (deg);phi (deg);brdf_450nm\n60;40,0;180;0,25\n", 1, 0,
       0.45, 0.25},
      {"long.csv",
       "made by hand\nWavelength (nm)\tTheta i [deg]\tTheta r [deg]\tPhi [deg]\tBRDF [1/sr]\n"
       "550\t60\t40\t180\t0.25\n",
       1, 0, 0.55, 0.25},
      {"cos.csv", "wavelength_um,theta_i_deg,theta_r_deg,phi_deg,BRDF*cos\n0.5,60,40,180,0.25\n", 1,
       0, 0.5, f_cos},
      {"factor.csv",
       "wavelength_um,theta_i_deg,theta_r_deg,phi_deg,reflectance factor\n0.5,60,40,180,0.25\n", 1,
       0, 0.5, factor},
      {"rgb.astm", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n1.0471975511965976,0,0.5,0,0.25,1,2\n",
       3, 0, 0.61, 0.25},
      {"mono.astm", "VARS theta_i,phi_i,theta_s,phi_s,BRDF\n1.0471975511965976,0,0.5,0,0.25\n", 1,
       1, 0.633, 0.25},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_measurements *m = NULL;
    const char *path = write_text_file(f, cases[i].name, cases[i].text);
    assert_ok(f, hetab_measurements_load_at(f->ctx, path, given, cases[i].given, &m));
    assert_shape(m, 1, cases[i].wavelengths);
    assert_near(hetab_measurements_lambda_um(m)[cases[i].wavelengths - 1], cases[i].um, 1e-15);
    assert_near(value(m, 0, cases[i].wavelengths - 1), cases[i].value, 1e-15);
    assert_near(hetab_measurements_pairs(m)->theta_i, third, 1e-15);
    hetab_measurements_free(m);
  }
}

static void test_rgl_is_sampled(void **state) {
  text_fixture *f = *state;
  char path[200];
  hetab_surface *surface;
  hetab_rgl *rgl;
  snprintf(path, sizeof path, "%s/a.bsdf", f->folder);
  assert_ok(f, hetab_surface_preset(f->ctx, "BBQAL2", &surface));
  assert_ok(f, hetab_tabulate_rgl(f->ctx, surface, NULL, &rgl, NULL));
  assert_ok(f, hetab_rgl_save(f->ctx, rgl, path, 0));
  hetab_measurements *m = load(f, path);
  assert_shape(m, 3579, 3);
  for (size_t i = 0; i < 3579; i += 97) {
    const hetab_directions *p = &hetab_measurements_pairs(m)[i];
    float wi[3] = {(float)sin(p->theta_i), 0, (float)cos(p->theta_i)}, found[3];
    float wo[3] = {(float)(sin(p->theta_r) * cos(p->phi)), (float)(sin(p->theta_r) * sin(p->phi)),
                   (float)cos(p->theta_r)};
    hetab_rgl_eval(rgl, wi, wo, found);
    for (size_t c = 0; c < 3; c++) /* blue first */
      /* The last bit of a direction in float is up to 6e-8, and the lobe's slope some hundreds. */
      assert_near(value(m, i, c), (double)found[2 - c], 5e-5 * (double)found[2 - c]);
  }
  hetab_measurements_free(m);
  hetab_rgl_free(rgl);
  hetab_surface_free(surface);
}

/* ---- tables as measurements ---------------------------------------------------------------- */

/* A smooth reciprocal function of the cell's centre, different in every channel. */
static double merl_value(double theta_h, double theta_d, double phi_d, int channel) {
  return (1 + channel) * (0.1 + exp(-3 * theta_h * theta_h)) * (1 + 0.2 * cos(2 * phi_d)) *
         (1 + 0.3 * theta_d);
}

static void fill_merl(hetab_merl *merl) {
  for (int c = 0; c < 3; c++) {
    double *next = hetab_merl_channel(merl, c);
    for (int h = 0; h < 90; h++)
      for (int d = 0; d < 90; d++)
        for (int p = 0; p < 180; p++) {
          double root = (h + 0.5) / 90;
          *next++ = merl_value(root * root * pi / 2, (d + 0.5) * pi / 180, (p + 0.5) * pi / 180, c);
        }
  }
}

static void unit_vector(double theta, double phi, double v[3]) {
  v[0] = sin(theta) * cos(phi);
  v[1] = sin(theta) * sin(phi);
  v[2] = cos(theta);
}

/* Half and difference angles from vectors, by another way than the library's. */
static void half_angles(const hetab_directions *pair, double *theta_h, double *theta_d,
                        double *phi_d) {
  double l[3], v[3], h[3], n_in_plane[3], l_in_plane[3], length = 0, dot_n = 0, dot_l = 0, a = 0;
  double nn = 0, ll = 0;
  unit_vector(pair->theta_i, 0, l);
  unit_vector(pair->theta_r, pair->phi, v);
  for (int i = 0; i < 3; i++)
    length += (l[i] + v[i]) * (l[i] + v[i]);
  for (int i = 0; i < 3; i++)
    h[i] = (l[i] + v[i]) / sqrt(length);
  for (int i = 0; i < 3; i++)
    dot_l += h[i] * l[i];
  dot_n = h[2];
  *theta_h = acos(fmin(1, dot_n));
  *theta_d = acos(fmin(1, dot_l));
  /* Seen along h, phi_d is the angle between the light and the direction away from the normal. */
  for (int i = 0; i < 3; i++) {
    n_in_plane[i] = dot_n * h[i] - (i == 2);
    l_in_plane[i] = l[i] - dot_l * h[i];
    a += n_in_plane[i] * l_in_plane[i];
    nn += n_in_plane[i] * n_in_plane[i];
    ll += l_in_plane[i] * l_in_plane[i];
  }
  *phi_d = nn > 1e-20 && ll > 1e-20 ? acos(fmax(-1, fmin(1, a / sqrt(nn * ll)))) : 0;
}

static void test_merl_is_sampled(void **state) {
  text_fixture *f = *state;
  hetab_merl *merl;
  char path[200];
  snprintf(path, sizeof path, "%s/a.binary", f->folder);
  assert_ok(f, hetab_merl_create(f->ctx, &merl));
  fill_merl(merl);
  assert_ok(f, hetab_merl_save(f->ctx, merl, path, 0));
  hetab_merl_free(merl);
  hetab_measurements *m = load(f, path);
  assert_near(hetab_measurements_lambda_um(m)[0], 0.46, 0); /* blue first */
  assert_shape(m, 3579, 3);
  size_t mirrors = 0;
  double worst = 0;
  for (size_t i = 0; i < hetab_measurements_pair_count(m); i++) {
    const hetab_directions *pair = &hetab_measurements_pairs(m)[i];
    double theta_h, theta_d, phi_d;
    half_angles(pair, &theta_h, &theta_d, &phi_d);
    mirrors += fabs(pair->theta_i - pair->theta_r) < 1e-9 && fabs(pair->phi - pi) < 1e-9;
    /* phi_d has no meaning around theta_h or theta_d = 0 */
    if (theta_h < 0.03 || theta_d < 0.03)
      continue;
    for (int c = 0; c < 3; c++) {
      double expected = merl_value(theta_h, theta_d, phi_d, 2 - c);
      worst = fmax(worst, fabs(value(m, i, (size_t)c) - expected) / expected);
    }
  }
  assert_int_equal(mirrors, 9);
  print_message("MERL, interpolated between centres: error %.2g of the function\n", worst);
  assert_true(worst < 2e-3); /* a shift by half a cell would be 1e-2 */
  hetab_measurements_free(m);
}

static hetab_grid *make_grid(const text_fixture *f) {
  hetab_grid *grid;
  assert_ok(f, hetab_grid_create(f->ctx, &grid));
  assert_ok(f, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_I, "0:90:19"));
  assert_ok(f, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_R, "0:90:55"));
  assert_ok(f, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, "0:180:37"));
  return grid;
}

static hetab_surface *make_surface(const text_fixture *f) {
  static const double lambda_um[] = {0.45, 0.65};
  hetab_surface *surface;
  assert_ok(f, hetab_surface_create(f->ctx, 0.5, 5, 1.1, 6, lambda_um, 2, &surface));
  return surface;
}

/* A table of the model, by its literal equations. */
static void write_table(const text_fixture *f, const char *path) {
  hetab_grid *grid = make_grid(f);
  hetab_surface *surface = make_surface(f);
  hetab_engine *engine;
  hetab_table_writer *writer;
  hetab_report report;
  double rho_s[2 * 19] = {0};
  hetab_h5_options options = {.element = HETAB_DOUBLE, .slabs = HETAB_DOUBLE};
  hetab_engine_options literal = {.precision = HETAB_DOUBLE, .method = HETAB_METHOD_LITERAL};
  assert_ok(f, hetab_engine_create(f->ctx, &literal, &engine));
  assert_ok(f, hetab_h5_create(f->ctx, path, surface, grid, &options, &writer));
  assert_ok(f, hetab_tabulate(f->ctx, engine, surface, grid, &(hetab_tabulate_options){0},
                              hetab_table_write_slab, writer, &report));
  assert_ok(f, hetab_table_write_specular(f->ctx, writer, rho_s));
  assert_ok(f, hetab_table_commit(f->ctx, writer));
  hetab_engine_free(engine);
  hetab_surface_free(surface);
  hetab_grid_free(grid);
}

static void assert_model(const text_fixture *f, const hetab_measurements *m, size_t i) {
  const hetab_directions *pair = &hetab_measurements_pairs(m)[i];
  hetab_point point = {0, pair->theta_i, pair->theta_r, pair->phi, 0.5, 5, 1.1, 6, 0};
  for (size_t b = 0; b < 2; b++) {
    hetab_value expected;
    point.lambda_um = hetab_measurements_lambda_um(m)[b];
    assert_ok(f, hetab_evaluate_literal(f->ctx, &point, 1, &expected));
    assert_near(value(m, i, b), expected.total, 1e-9 * expected.total + 1e-13);
  }
}

static void test_h5_is_thinned(void **state) {
  text_fixture *f = *state;
  char path[200];
  snprintf(path, sizeof path, "%s/a.h5", f->folder);
  write_table(f, path);
  hetab_measurements *m = load(f, path);
  size_t mirrors = 0;
  for (size_t i = 0; i < hetab_measurements_pair_count(m); i++) {
    const hetab_directions *pair = &hetab_measurements_pairs(m)[i];
    mirrors += fabs(pair->theta_i - pair->theta_r) < 1e-9 && fabs(pair->phi - pi) < 1e-9;
    assert_model(f, m, i);
  }
  /* 10 x 28 x 13 less what is at the horizon, and the normal's other azimuths */
  assert_int_equal(mirrors, 9);
  assert_int_equal(hetab_measurements_pair_count(m), 27 + 8 * (1 + 26 * 13));
  assert_int_equal(hetab_measurements_skipped_of(m).below_horizon, 1 + 8 * 13 + 1 + 27 * 13);
  hetab_measurements_free(m);
}

/* ---- bad input ----------------------------------------------------------------------------- */

static void fails(text_fixture *f, const char *path, const char *const *words) {
  hetab_measurements *m = (void *)f;
  hetab_status status = hetab_measurements_load(f->ctx, path, &m);
  if (status == HETAB_OK)
    fail_msg("%s was read; wanted a message with '%s'", path, words[0]);
  assert_null(m);
  assert_message(f, words);
}

#define VARS "VARS theta_i,phi_i,theta_s,phi_s,550nm\n"
#define HEAD "wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f\n"

static void test_bad_text(void **state) {
  static const struct {
    const char *name, *text, *words[4];
  } cases[] = {
      {"a.brdf", "", {"a.brdf", "number of wavelengths", "complete"}},
      {"a.brdf", "# only\n", {"a.brdf:1", "ends"}},
      {"a.brdf", "1\n", {"wavelengths in nm", "complete"}},
      {"a.brdf", "x\n", {"a.brdf:1", "'x' is not a number"}},
      {"a.brdf", "-3\n550\n", {"a.brdf:1", "-3 wavelengths"}},
      {"a.brdf", "1.5\n550\n", {"1.5 wavelengths"}},
      {"a.brdf", "1e9\n550\n", {"1e+09 wavelengths"}},
      {"a.brdf", "1\n0.55\n0 0 0 0 1\n", {"a.brdf:2", "0.00055 um", "unit"}},
      {"a.brdf", "2\n550 550\n0 0 0 0 1 1\n", {"a.brdf:2", "550 nm is there twice"}},
      {"a.brdf", "1\n550\n", {"a.brdf:2", "no usable value"}},
      {"a.brdf", "1\n550\n0 0 0 0\n", {"a.brdf:3", "1 numbers short"}},
      {"a.brdf", "1\n550\n0 0 0 0\n0 0 0 1 1\n", {"a.brdf:4", "starts at line 3", "1 values"}},
      {"a.brdf", "1\n550\n0 0 0 0 1 2\n", {"a.brdf:3", "ends within"}},
      {"a.brdf", "1\n550 560\n0 0 0 0 1\n", {"a.brdf:2", "more than 1 wavelengths"}},
      {"a.brdf", "1\n550\n0 nan 0 0 1\n", {"a.brdf:3", "'nan'", "radians"}},
      {"a.brdf", "1\n550\n0 0 0 0 zero\n", {"a.brdf:3", "'zero'"}},
      {"a.brdf", "1\n550\n\n30 0 30 180 1\n", {"a.brdf:4", "too large for radians", "degrees"}},
      {"a.brdf",
       "1\n550\n0 0 2 0 1\n0 0 0 0 nan\n",
       {"no usable value", "1 rows below the horizon", "1 values not finite"}},
      {"a.astm", "", {"a.astm", "no VARS"}},
      {"a.astm", "NUM_POINTS many\n" VARS, {"a.astm:1", "NUM_POINTS", "'many'"}},
      {"a.astm", "NUM_POINTS 2\n" VARS "0,0,0,0,1\n", {"a.astm:3", "1 rows", "says 2"}},
      {"a.astm", "VARS theta_i,phi_i,theta_s,550nm\n", {"a.astm:1", "no column phi_s"}},
      {"a.astm", "VARS theta_i,phi_i,theta_s,phi_s,BRDF\n", {"a.astm:1", "no wavelength", "550nm"}},
      {"a.astm", "VARS theta_i,theta_i,theta_s,phi_s,5nm\n", {"a.astm:1", "'theta_i'", "twice"}},
      {"a.astm", "VARS theta_i,phi_i,theta_s,phi_s,0.5nm\n", {"a.astm:1", "unit"}},
      {"a.astm", VARS "0,0,0,1\n", {"a.astm:2", "4 fields", "names 5"}},
      {"a.astm", VARS "0,0,x,0,1\n", {"a.astm:2", "theta_s", "'x'"}},
      {"a.astm", VARS "0,0,nan,0,1\n", {"a.astm:2", "theta_s", "'nan'"}},
      {"a.astm", VARS "0,0,0,0,one\n", {"a.astm:2", "'one'"}},
      {"a.astm", VARS "45,0,45,180,1\n", {"a.astm:2", "radians"}},
      {"a.csv", "", {"a.csv", "no header"}},
      {"a.csv", "1,2,3\n", {"a.csv:1", "no header", "wavelength_nm"}},
      {"a.csv", "wavelength,theta_i_deg\n", {"a.csv:1", "'wavelength'", "unit"}},
      {"a.csv", "wavelength_nm,theta_i_grad\n", {"a.csv:1", "'theta_i_grad'", "unit"}},
      {"a.csv", "wavelength_nm,theta_i_deg,theta_r_deg,f\n", {"no column phi_deg"}},
      {"a.csv", "f,brdf\n", {"'brdf'", "remove one"}},
      {"a.csv", HEAD, {"a.csv:1", "no rows"}},
      {"a.csv", HEAD "550,30,30,180\n", {"a.csv:2", "4 fields", "names 5"}},
      {"a.csv", HEAD "550,30,30,180,1\n550,30,x,180,1\n", {"a.csv:3", "'x'", "angle"}},
      {"a.csv", HEAD "-550,30,30,180,1\n", {"a.csv:2", "wavelength"}},
      {"a.csv", HEAD "0.55,30,30,180,1\n", {"0.00055 um", "unit"}},
      {"a.csv", HEAD "550,3000,30,180,1\n", {"a.csv:2", "180 degrees"}},
      {"a.csv", HEAD "550,30,30,1e7,1\n", {"a.csv:2", "angles"}},
      {"a.csv", HEAD "550,0.5,0.5,3.14,1\n", {"a.csv:2", "radians", "theta_i_rad"}},
      {"a.csv", HEAD "550,30,30,180,nan\n", {"no usable value", "1 values not finite"}},
  };
  text_fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    fails(f, write_text_file(f, cases[i].name, cases[i].text), cases[i].words);
}

static void test_bad_files(void **state) {
  text_fixture *f = *state;
  fails(f, "/nonexistent/a.brdf",
        (const char *const[]){"/nonexistent/a.brdf", "cannot open", NULL});
  fails(f, f->folder, (const char *const[]){f->folder, "cannot read", NULL});
  fails(f, write_bytes(f, "a.brdf", "1\n550\n\0", 7),
        (const char *const[]){"a.brdf:3", "not text", NULL});
  fails(f, write_bytes(f, "a.h5", "\x89HDF\r\n\x1a\n", 8), (const char *const[]){"a.h5", NULL});
  fails(f, write_bytes(f, "a.binary", "\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", 12),
        (const char *const[]){"a.binary", "bytes", NULL});
  fails(f, write_text_file(f, "b.binary", "short"), (const char *const[]){"b.binary", NULL});
  write_text_file(f, "large.csv", "");
  assert_int_equal(truncate(f->path, 257 << 20), 0);
  fails(f, f->path, (const char *const[]){"large.csv", "256 MiB", NULL});
}

/* Every beginning of a good file is read or refused with a message, in whatever state it ends. */
static void test_truncated_text(void **state) {
  text_fixture *f = *state;
  static const char *const names[] = {"synthetic.brdf", "synthetic.astm", "synthetic.csv"};
  for (int i = 0; i < 3; i++) {
    char path[120], text[4096];
    snprintf(path, sizeof path, "%s%s", data, names[i]);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t length = fread(text, 1, sizeof text, file);
    fclose(file);
    size_t read = 0;
    for (size_t cut = 0; cut + 16 < length; cut += 7) {
      hetab_measurements *m;
      if (hetab_measurements_load(f->ctx, write_bytes(f, names[i], text, cut), &m) == HETAB_OK)
        read++;
      else
        assert_message(f, (const char *const[]){names[i], NULL});
      hetab_measurements_free(m);
    }
    assert_true(i == 1 ? read == 0 : read > 0); /* NUM_POINTS gives an ASTM file away */
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_formats_agree, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_paint_in_both_formats, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_paints_shine_in_the_mirror_direction, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_azimuths_fold, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_unusable_values_are_counted, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_csv_rows_become_pairs, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_content_decides, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_names_of_values, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_rgl_is_sampled, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_merl_is_sampled, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_h5_is_thinned, text_fixture_setup,
                                      text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_bad_text, text_fixture_setup, text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_bad_files, text_fixture_setup, text_fixture_teardown),
      cmocka_unit_test_setup_teardown(test_truncated_text, text_fixture_setup,
                                      text_fixture_teardown),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
