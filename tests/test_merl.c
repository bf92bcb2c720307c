/* MERL tables of surfaces: cells against the literal reference, colour, the horizon, look-ups and
 * the specular cone. */
#include "degrees.h"
#include "golden_support.h"

enum { SIDE = 90, PHIS = 180, CELLS = SIDE * SIDE * PHIS, BANDS = 31 };

/* CIE 1931 x, y, z times D65 / 1, 400 to 700 nm by 10 nm, typed apart from the library's. */
static const double observer[BANDS][4] = {
    {0.01431, 0.000396, 0.06785001, 82.7549},
    {0.04351, 0.00121, 0.2074, 91.486},
    {0.13438, 0.004, 0.6456, 93.4318},
    {0.2839, 0.0116, 1.3856, 86.6823},
    {0.34828, 0.023, 1.74706, 104.865},
    {0.3362, 0.038, 1.77211, 117.008},
    {0.2908, 0.06, 1.6692, 117.812},
    {0.19536, 0.09098, 1.28764, 114.861},
    {0.09564, 0.13902, 0.8129501, 115.923},
    {0.03201, 0.20802, 0.46518, 108.811},
    {0.0049, 0.323, 0.272, 109.354},
    {0.0093, 0.503, 0.1582, 107.802},
    {0.06327, 0.71, 0.07824999, 104.79},
    {0.1655, 0.862, 0.04216, 107.689},
    {0.2904, 0.954, 0.0203, 104.405},
    {0.4334499, 0.9949501, 0.008749999, 104.046},
    {0.5945, 0.995, 0.0039, 100},
    {0.7621, 0.952, 0.0021, 96.3342},
    {0.9163, 0.87, 0.001650001, 95.788},
    {1.0263, 0.757, 0.0011, 88.6856},
    {1.0622, 0.631, 0.0008, 90.0062},
    {1.0026, 0.503, 0.00034, 89.5991},
    {0.8544499, 0.381, 0.00019, 87.6987},
    {0.6424, 0.265, 4.999999e-05, 83.2886},
    {0.4479, 0.175, 2e-05, 83.6992},
    {0.2835, 0.107, 0, 80.0268},
    {0.1649, 0.061, 0, 80.2146},
    {0.0874, 0.032, 0, 82.2778},
    {0.04677, 0.017, 0, 78.2842},
    {0.0227, 0.00821, 0, 69.7213},
    {0.01135916, 0.004102, 0, 71.6091},
};

static void spectrum_to_rgb(const double *spectrum, double rgb[3]) {
  static const double white[3] = {0.950470, 1, 1.088830}; /* of D65: (1, 1, 1) */
  static const double matrix[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                      {-0.9692660, 1.8760108, 0.0415560},
                                      {0.0556434, -0.2040259, 1.0572252}};
  double xyz[3] = {0}, sum[3] = {0};
  for (int b = 0; b < BANDS; b++) {
    for (int c = 0; c < 3; c++) {
      sum[c] += observer[b][c] * observer[b][3];
      xyz[c] += white[c] * observer[b][c] * observer[b][3] * spectrum[b];
    }
  }
  for (int c = 0; c < 3; c++) {
    rgb[c] = 0;
    for (int k = 0; k < 3; k++)
      rgb[c] += matrix[c][k] * xyz[k] / sum[k];
    const double *m = matrix[c];
    rgb[c] /= m[0] * white[0] + m[1] * white[1] + m[2] * white[2];
  }
}

/* --- directions ------------------------------------------------------------------------------ */

typedef struct directions {
  double i[3], r[3];
} directions;

/* The light is the difference direction turned about y by theta_h; the viewer is its reflection
 * in the half vector. */
static directions directions_of(double theta_h, double theta_d, double phi_d) {
  directions d;
  double x = sin(theta_d) * cos(phi_d), y = sin(theta_d) * sin(phi_d), z = cos(theta_d);
  double h[3] = {sin(theta_h), 0, cos(theta_h)};
  d.i[0] = cos(theta_h) * x + sin(theta_h) * z;
  d.i[1] = y;
  d.i[2] = -sin(theta_h) * x + cos(theta_h) * z;
  double i_h = d.i[0] * h[0] + d.i[1] * h[1] + d.i[2] * h[2];
  for (int a = 0; a < 3; a++)
    d.r[a] = 2 * i_h * h[a] - d.i[a];
  return d;
}

/* A point of a cell, offsets in [0, 1] of it. */
static directions cell_directions(size_t cell, double h, double d, double p) {
  double u = ((double)(cell / PHIS / SIDE) + h) / SIDE;
  return directions_of(u * u * M_PI_2, ((double)(cell / PHIS % SIDE) + d) / SIDE * M_PI_2,
                       ((double)(cell % PHIS) + p) / PHIS * M_PI);
}

static hetab_point point_of(const hetab_surface *surface, const hetab_band *band,
                            const directions *d) {
  hetab_point p = {.lambda_um = band->lambda_um,
                   .n = band->n,
                   .k = band->k,
                   .diffuse_brdf = band->diffuse_brdf,
                   .sigma0_um = hetab_surface_sigma0_um(surface),
                   .tau_um = hetab_surface_tau_um(surface)};
  p.theta_i = fmin(atan2(hypot(d->i[0], d->i[1]), d->i[2]), M_PI_2);
  p.theta_r = fmin(atan2(hypot(d->r[0], d->r[1]), d->r[2]), M_PI_2);
  p.phi = atan2(d->r[1], d->r[0]) - atan2(d->i[1], d->i[0]);
  return p;
}

/* --- tables ---------------------------------------------------------------------------------- */

static hetab_merl *table_of(hetab_context *ctx, const hetab_surface *surface,
                            hetab_precision precision, const hetab_merl_options *options,
                            hetab_report *report) {
  hetab_merl *merl;
  hetab_engine *engine = new_engine(ctx, precision, HETAB_METHOD_ROWS, 0);
  assert_ok(ctx, hetab_tabulate_merl(ctx, engine, surface, options, &merl, report));
  hetab_engine_free(engine);
  return merl;
}

static hetab_surface *preset(hetab_context *ctx, const char *name) {
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_preset(ctx, name, &surface));
  return surface;
}

static hetab_surface *constant(hetab_context *ctx, double sigma0_um, double tau_um) {
  hetab_surface *surface;
  double lambda_um = 0.55;
  assert_ok(ctx,
            hetab_surface_create(ctx, sigma0_um, tau_um, 0.958, 6.69, &lambda_um, 1, &surface));
  return surface;
}

/* The cell's value computed here: rgb of the mean over valid sub-samples; 0 if there are none. */
static int literal_cell(hetab_context *ctx, const hetab_surface *surface,
                        const hetab_merl_options *options, size_t cell, double rgb[3]) {
  static const double mean[] = {1.0 / 6, 0.5, 5.0 / 6}, centre[] = {0.5}, edge[] = {0};
  int n = options->sampling == HETAB_MERL_MEAN ? 3 : 1, valid = 0;
  const double *offset = n == 3 ? mean : options->sampling == HETAB_MERL_EDGE ? edge : centre;
  double spectrum[BANDS] = {0};
  hetab_band bands[BANDS];
  int count = options->colour == HETAB_MERL_SRGB   ? BANDS
              : options->colour == HETAB_MERL_MONO ? 1
                                                   : 3;
  for (int b = 0; b < count; b++)
    if (options->colour == HETAB_MERL_SRGB)
      bands[b] = hetab_surface_bands(surface)[b];
    else
      assert_ok(ctx, hetab_surface_at(ctx, surface, options->band_um[b], &bands[b]));
  for (int s = 0; s < n * n * n; s++) {
    directions d = cell_directions(cell, offset[s / n / n], offset[s / n % n], offset[s % n]);
    if (d.i[2] <= 1e-14 || d.r[2] <= 1e-14)
      continue;
    valid++;
    for (int b = 0; b < count; b++) {
      hetab_point point = point_of(surface, &bands[b], &d);
      hetab_value value;
      assert_ok(ctx, hetab_evaluate_literal(ctx, &point, 1, &value));
      spectrum[b] += value.total;
    }
  }
  for (int b = 0; b < count && valid; b++)
    spectrum[b] /= valid;
  if (options->colour == HETAB_MERL_SRGB)
    spectrum_to_rgb(spectrum, rgb);
  else
    for (int c = 0; c < 3; c++)
      rgb[c] = spectrum[count == 1 ? 0 : c];
  return valid;
}

/* Random cells, against the reference: relative to the largest channel, since colour's sums
 * cancel. */
static void check_cells(hetab_context *ctx, const hetab_surface *surface, hetab_precision precision,
                        hetab_merl_options options, size_t samples) {
  hetab_report report;
  double relative = 0, below = 0;
  size_t compared = 0, negative = 0;
  uint64_t r = 41;
  options.samples = 300;
  hetab_merl *merl = table_of(ctx, surface, precision, &options, &report);
  for (size_t s = 0; s < samples; s++) {
    size_t cell = (size_t)uniform(&r, 0, CELLS);
    if (s % 2) /* near the lobe */
      cell = (size_t)uniform(&r, 0, 20) * SIDE * PHIS + cell % (SIDE * PHIS);
    double rgb[3];
    if (!literal_cell(ctx, surface, &options, cell, rgb))
      continue;
    double largest = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    for (int c = 0; c < 3; c++) {
      double value = hetab_merl_channel_const(merl, c)[cell];
      double error = fabs(value - fmax(rgb[c], 0));
      negative += rgb[c] < 0;
      assert_true(value >= 0 && isfinite(value));
      if (largest >= TOL_FLOOR) {
        relative = fmax(relative, error / largest);
        compared++;
      } else {
        below = fmax(below, error);
      }
    }
  }
  print_message("  %zu channels, %zu clamped in all, %zu here; report %.1e of %zu\n", compared,
                report.clamped, negative, report.error.max_rel, report.error.compared);
  assert_int_equal(report.error.bad, 0);
  assert_true(report.error.max_rel <=
              (precision == HETAB_FLOAT ? TOL_MERL_FLOAT : TOL_MERL_DOUBLE));
  assert_below(hetab_precision_name(precision), relative,
               precision == HETAB_FLOAT ? TOL_MERL_FLOAT : TOL_MERL_DOUBLE);
  assert_below("below the floor", below, TOL_MERL_BELOW);
  hetab_merl_free(merl);
}

static void test_colour_cells(void **state) {
  static const char *const names[] = {"BBQAL1", "BBQAL2", "GGAL120", "GGAL240", "NGGAL"};
  for (size_t i = 0; i < 5; i++) {
    hetab_surface *surface = preset(*state, names[i]);
    check_cells(*state, surface, HETAB_FLOAT, (hetab_merl_options){0}, 2000);
    hetab_surface_free(surface);
  }
}

static void test_double_cells(void **state) {
  hetab_surface *surface = preset(*state, "BBQAL2");
  check_cells(*state, surface, HETAB_DOUBLE, (hetab_merl_options){0}, 2000);
  hetab_surface_free(surface);
}

static void test_edge_cells(void **state) {
  hetab_surface *surface = preset(*state, "NGGAL");
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++)
    check_cells(*state, surface, (hetab_precision)precision,
                (hetab_merl_options){.sampling = HETAB_MERL_EDGE}, 1000);
  hetab_surface_free(surface);
}

static void test_mean_cells(void **state) {
  hetab_surface *surface = preset(*state, "GGAL240");
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++)
    check_cells(*state, surface, (hetab_precision)precision,
                (hetab_merl_options){.sampling = HETAB_MERL_MEAN,
                                     .band_um = {0.6, 0.5, 0.45},
                                     .colour = HETAB_MERL_BANDS},
                1000);
  hetab_surface_free(surface);
}

static void test_mono_cells(void **state) {
  hetab_surface *surface = preset(*state, "NGGAL");
  hetab_merl_options options = {.colour = HETAB_MERL_MONO, .band_um = {0.555}};
  check_cells(*state, surface, HETAB_FLOAT, options, 4000);
  hetab_merl *merl = table_of(*state, surface, HETAB_FLOAT, &options, NULL);
  for (int c = 1; c < 3; c++)
    assert_memory_equal(hetab_merl_channel_const(merl, 0), hetab_merl_channel_const(merl, c),
                        CELLS * sizeof(double));
  hetab_merl_free(merl);
  hetab_surface_free(surface);
}

/* --- the horizon ----------------------------------------------------------------------------- */

/* -1 in all channels exactly where a sampled direction is below the horizon (within a rounding
 * error of it either is right); phi_d and 180 - phi_d alike. */
static void check_horizon(hetab_context *ctx, hetab_merl_sampling sampling, double cone) {
  static const double offsets[] = {0.5, 0.0};
  hetab_surface *surface = constant(ctx, 0.3, 2);
  hetab_merl_options options = {.sampling = sampling,
                                .colour = HETAB_MERL_MONO,
                                .band_um = {0.55},
                                .specular_cone = DEG(cone)};
  hetab_merl *merl = table_of(ctx, surface, HETAB_FLOAT, &options, NULL);
  const double *values = hetab_merl_channel_const(merl, 0);
  size_t wrong = 0, unsymmetric = 0, invalid = 0, differ = 0;
  for (size_t cell = 0; cell < CELLS; cell++) {
    double highest = -2;
    for (int s = 0; s < 27; s++) {
      double h = (s / 9 + 0.5) / 3, d = (s / 3 % 3 + 0.5) / 3, p = (s % 3 + 0.5) / 3;
      if (sampling != HETAB_MERL_MEAN)
        h = d = p = offsets[sampling];
      directions at = cell_directions(cell, h, d, p);
      highest = fmax(highest, fmin(at.i[2], at.r[2]));
      if (sampling != HETAB_MERL_MEAN)
        break;
    }
    int is_valid = values[cell] != -1;
    invalid += !is_valid;
    assert_true(values[cell] == -1 || (values[cell] >= 0 && isfinite(values[cell])));
    wrong += fabs(highest) > 1e-12 && is_valid != (highest > 0);
    for (int c = 1; c < 3; c++)
      differ += (hetab_merl_channel_const(merl, c)[cell] == -1) != !is_valid;
    size_t p = cell % PHIS;
    size_t mirrored = sampling == HETAB_MERL_EDGE ? PHIS - p : PHIS - 1 - p;
    unsymmetric += mirrored < PHIS && values[cell] != values[cell - p + mirrored];
  }
  print_message("  %zu cells below the horizon\n", invalid);
  assert_int_equal(wrong, 0);
  assert_int_equal(differ, 0);
  assert_int_equal(unsymmetric, 0);
  hetab_merl_free(merl);
  hetab_surface_free(surface);
}

static void test_horizon(void **state) {
  check_horizon(*state, HETAB_MERL_CENTRE, 0);
  check_horizon(*state, HETAB_MERL_CENTRE, 60);
  check_horizon(*state, HETAB_MERL_EDGE, 0);
  check_horizon(*state, HETAB_MERL_MEAN, 0);
}

/* A grey diffuse part is white of its reflectance / pi, off the lobe. */
static void test_diffuse_horizon(void **state) {
  hetab_surface *surface;
  hetab_merl_options options = {.colour = HETAB_MERL_SRGB};
  char path[] = "/tmp/hetab-test-XXXXXX.yml";
  FILE *file = fdopen(mkstemps(path, 4), "w");
  fprintf(file, "sigma0_um: 0.01\ntau_um: 60\nindex: Al\ndiffuse_reflectance: 0.5\n");
  fclose(file);
  assert_ok(*state, hetab_surface_load(*state, path, &surface));
  remove(path);
  hetab_merl *merl = table_of(*state, surface, HETAB_FLOAT, &options, NULL);
  size_t diffuse = 0, invalid = 0;
  for (size_t cell = 0; cell < CELLS; cell++) {
    double value = hetab_merl_channel_const(merl, 1)[cell];
    invalid += value == -1;
    diffuse += fabs(value - 0.5 / M_PI) < 1e-5;
  }
  /* white, off the lobe: everywhere but in the first twelve rows or so */
  assert_true(diffuse > (CELLS - invalid) * 85 / 100);
  hetab_merl_free(merl);
  hetab_surface_free(surface);
}

/* --- looking up ------------------------------------------------------------------------------ */

/* The reference reader at random directions: within what the model does over the cell. */
static void test_lookup(void **state) {
  enum { LOOKUPS = 3000 };
  hetab_surface *surface = constant(*state, 0.8, 2);
  const hetab_band *band = hetab_surface_bands(surface);
  hetab_merl_options options = {.colour = HETAB_MERL_MONO, .band_um = {0.55}};
  hetab_merl *merl = table_of(*state, surface, HETAB_FLOAT, &options, NULL);
  uint64_t r = 43;
  double worst_outside = 0, sum = 0;
  size_t compared = 0;
  for (int l = 0; l < LOOKUPS; l++) {
    hetab_point point = {.theta_i = uniform(&r, 0, 1.3),
                         .theta_r = uniform(&r, 0, 1.3),
                         .phi = uniform(&r, -M_PI, M_PI),
                         .lambda_um = 0.55,
                         .n = band->n,
                         .k = band->k,
                         .sigma0_um = 0.8,
                         .tau_um = 2};
    double rgb[3], low = 1e300, high = 0;
    hetab_value value;
    size_t cell = hetab_merl_cell((hetab_directions){point.theta_i, point.theta_r, point.phi});
    hetab_merl_lookup(merl, (hetab_directions){point.theta_i, point.theta_r, point.phi}, rgb);
    assert_ok(*state, hetab_evaluate_literal(*state, &point, 1, &value));
    for (int corner = 0; corner < 8; corner++) {
      directions d = cell_directions(cell, corner & 1, corner >> 1 & 1, corner >> 2);
      if (d.i[2] <= 0 || d.r[2] <= 0)
        continue;
      hetab_point at = point_of(surface, band, &d);
      hetab_value v;
      assert_ok(*state, hetab_evaluate_literal(*state, &at, 1, &v));
      low = fmin(low, v.dd);
      high = fmax(high, v.dd);
    }
    if (rgb[0] < 0 || value.dd < 1e-6)
      continue;
    compared++;
    sum += relative_error(rgb[0], value.dd);
    /* both are values of the model in the cell; between its corners, but for a bulge */
    double outside = fmax(fabs(rgb[0] - value.dd) - (high - low), 0) / value.dd;
    worst_outside = fmax(worst_outside, outside);
    assert_true(rgb[0] == rgb[1] && rgb[1] == rgb[2]);
  }
  assert_true(compared > LOOKUPS / 2);
  print_message("  %zu look-ups\n", compared);
  assert_below("mean error of a look-up", sum / (double)compared, TOL_LOOKUP_MEAN);
  assert_below("beyond the cell's own range", worst_outside, TOL_LOOKUP_OUTSIDE);
  hetab_merl_free(merl);
  hetab_surface_free(surface);
}

/* --- the specular cone ----------------------------------------------------------------------- */

/* Integral of (with - without) cos(theta_r) over the hemisphere as the reader sees it, by half
 * vectors: dr = 4 (i.h) dh, in rings that end with the rows of cells. */
static double cone_energy(const hetab_merl *with, const hetab_merl *without, double theta_i,
                          double cone_deg) {
  enum { RINGS = 16 /* of a row */, SPOKES = 360 };
  double i[3] = {sin(theta_i), 0, cos(theta_i)}, sum = 0;
  double rows = ceil(SIDE * sqrt((cone_deg + 3) / 90));
  for (int ring = 0; ring < RINGS * rows; ring++) {
    double u = (ring + 0.5) / RINGS / SIDE, t = M_PI_2 * u * u, dt = M_PI * u / RINGS / SIDE;
    for (int spoke = 0; spoke < SPOKES; spoke++) {
      double a = 2 * M_PI * (spoke + 0.5) / SPOKES, r[3], table[3], bare[3];
      double h[3] = {sin(t) * cos(a), sin(t) * sin(a), cos(t)};
      double i_h = i[0] * h[0] + i[2] * h[2];
      for (int c = 0; c < 3; c++)
        r[c] = 2 * i_h * h[c] - i[c];
      if (i_h <= 0 || r[2] <= 0)
        continue;
      double theta_r = atan2(hypot(r[0], r[1]), r[2]), phi = atan2(r[1], r[0]);
      hetab_merl_lookup(with, (hetab_directions){theta_i, theta_r, phi}, table);
      hetab_merl_lookup(without, (hetab_directions){theta_i, theta_r, phi}, bare);
      if (table[0] >= 0)
        sum += (table[0] - bare[0]) * r[2] * 4 * i_h * sin(t) * dt;
    }
  }
  return sum * (2 * M_PI / SPOKES);
}

/* Truncation leaves the delta what it is up to 70 degrees; beyond, what it makes of it is told. */
static void check_cone(hetab_context *ctx, hetab_merl_sampling sampling, double cone) {
  static const double incidence_deg[] = {0, 10.5, 20, 30, 45.3, 60, 70, 85, 88};
  hetab_surface *surface = constant(ctx, 0.03, 3);
  hetab_merl_options options = {.sampling = sampling, .colour = HETAB_MERL_MONO, .band_um = {0.55}};
  hetab_merl *without = table_of(ctx, surface, HETAB_FLOAT, &options, NULL);
  options.specular_cone = DEG(cone);
  hetab_merl *with = table_of(ctx, surface, HETAB_FLOAT, &options, NULL);
  double error = 0, untold = 0;
  for (size_t i = 0; i < sizeof incidence_deg / sizeof *incidence_deg; i++) {
    double theta_i = DEG(incidence_deg[i]), rho_s, told_rho_s, told;
    double energy = cone_energy(with, without, theta_i, cone);
    assert_ok(ctx, hetab_specular_reflectance(ctx, surface, &theta_i, 1, &rho_s));
    assert_ok(ctx, hetab_merl_cone_read(ctx, surface, &options, &theta_i, 1, &told_rho_s, &told));
    print_message("  cone %g, theta_i %g: %.5f of %.5f, told %.5f\n", cone, incidence_deg[i],
                  energy, rho_s, told);
    assert_true(told_rho_s == rho_s);
    error = incidence_deg[i] <= 70 ? fmax(error, relative_error(energy, rho_s)) : error;
    untold = fmax(untold, relative_error(told, energy));
  }
  assert_below("energy of the cone", error, TOL_CONE_ENERGY);
  assert_below("the cone as read, told", untold, TOL_CONE_TOLD);
  assert_true(relative_error(hetab_merl_specular_cone(with), DEG(cone)) < 1e-12);
  assert_true(hetab_merl_specular_cone(without) == 0);
  /* outside the cone nothing has changed, inside nothing is less */
  for (size_t cell = 0; cell < CELLS; cell++) {
    double more =
        hetab_merl_channel_const(with, 0)[cell] - hetab_merl_channel_const(without, 0)[cell];
    double u = (double)(cell / PHIS / SIDE) / SIDE;
    assert_true(u * u * 90 >= cone ? more == 0 : more >= 0);
  }
  hetab_merl_free(with);
  hetab_merl_free(without);
  hetab_surface_free(surface);
}

static void test_cone(void **state) {
  check_cone(*state, HETAB_MERL_CENTRE, 2);
  check_cone(*state, HETAB_MERL_CENTRE, 5);
}

/* --- bad options ----------------------------------------------------------------------------- */

static void test_refused(void **state) {
  hetab_surface *few = constant(*state, 0.3, 2), *al = preset(*state, "NGGAL");
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  hetab_engine *literal = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_LITERAL, 0);
  hetab_merl *merl = (hetab_merl *)few;
  assert_fails(*state, hetab_tabulate_merl(*state, engine, few, NULL, &merl, NULL), HETAB_ERR_RANGE,
               (const char *const[]){"400 to 700 nm", NULL});
  assert_null(merl);
  hetab_merl_options options = {.colour = HETAB_MERL_MONO, .band_um = {0.09}};
  assert_fails(*state, hetab_tabulate_merl(*state, engine, al, &options, &merl, NULL),
               HETAB_ERR_RANGE, (const char *const[]){"90 nm", "103.32", NULL});
  assert_null(merl);
  options = (hetab_merl_options){.colour = HETAB_MERL_BANDS, .band_um = {0.6, 0.5, 0}};
  assert_int_not_equal(hetab_tabulate_merl(*state, engine, al, &options, &merl, NULL), HETAB_OK);
  assert_null(merl);
  options = (hetab_merl_options){.colour = HETAB_MERL_MONO, .band_um = {NAN}};
  assert_int_not_equal(hetab_tabulate_merl(*state, engine, al, &options, &merl, NULL), HETAB_OK);
  assert_null(merl);
  assert_fails(*state, hetab_tabulate_merl(*state, literal, al, NULL, &merl, NULL),
               HETAB_ERR_UNSUPPORTED, (const char *const[]){"literal", NULL});
  assert_null(merl);
  hetab_engine_free(engine);
  hetab_engine_free(literal);
  hetab_surface_free(few);
  hetab_surface_free(al);
}

static int stop_at_once(void *user, double done, double total) {
  return 1;
}

static void test_cancel(void **state) {
  hetab_surface *surface = preset(*state, "NGGAL");
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_ROWS, 0);
  hetab_merl *merl = (hetab_merl *)surface;
  hetab_set_progress(*state, stop_at_once, NULL);
  assert_int_equal(hetab_tabulate_merl(*state, engine, surface, NULL, &merl, NULL),
                   HETAB_ERR_CANCELLED);
  assert_null(merl);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_colour_cells),    TEST(test_double_cells), TEST(test_edge_cells),
      TEST(test_mean_cells),      TEST(test_mono_cells),   TEST(test_horizon),
      TEST(test_diffuse_horizon), TEST(test_lookup),       TEST(test_cone),
      TEST(test_refused),         TEST(test_cancel),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
