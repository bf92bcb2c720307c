/* Look-ups: tables of files against the literal model, their samplers, reflectances, and files that
 * are not what they say. */
#include "degrees.h"
#include "table_support.h"

#include "lookup_support.h"
#include "tolerances.h"

static const char *const presets[] = {"BBQAL1", "BBQAL2", "GGAL120", "GGAL240", "NGGAL"};
enum { PRESETS = sizeof presets / sizeof *presets };

static const double three_bands_um[3] = {0.45, 0.55, 0.65};

/* --- tables ---------------------------------------------------------------------------------- */

static hetab_engine *new_engine(hetab_context *ctx) {
  hetab_engine *engine;
  assert_ok(ctx, hetab_engine_create(ctx, NULL, &engine));
  return engine;
}

/* A preset, "needle": sigma0 0.05 um, tau 60 um, or "steep": slope 1. */
static hetab_surface *surface_of(hetab_context *ctx, const char *name, const double *lambda_um,
                                 size_t count) {
  hetab_surface *surface;
  if (strcmp(name, "needle") == 0)
    assert_ok(ctx, hetab_surface_create(ctx, 0.05, 60, 0.958, 6.69, three_bands_um, 3, &surface));
  else if (strcmp(name, "steep") == 0)
    assert_ok(ctx, hetab_surface_open(ctx, "steep.yml", &surface));
  else
    assert_ok(ctx, hetab_surface_preset(ctx, name, &surface));
  if (lambda_um)
    assert_ok(ctx, hetab_surface_set_wavelengths(ctx, surface, lambda_um, count));
  return surface;
}

static hetab_lookup *open_table(hetab_context *ctx, const char *path, hetab_lookup_rule rule) {
  hetab_lookup *table;
  assert_ok(ctx, hetab_lookup_open(ctx, path, rule, &table));
  return table;
}

static hetab_lookup *merl_table(hetab_context *ctx, const hetab_surface *surface) {
  hetab_merl_options bands = {.colour = HETAB_MERL_BANDS,
                              .band_um = {three_bands_um[0], three_bands_um[1], three_bands_um[2]}};
  hetab_merl_options srgb = {.colour = HETAB_MERL_SRGB};
  hetab_engine *engine = new_engine(ctx);
  int colour = hetab_surface_band_count(surface) == MOST_BANDS;
  assert_ok(ctx, save_merl(ctx, engine, surface, colour ? &srgb : &bands, "t.binary"));
  hetab_engine_free(engine);
  return open_table(ctx, "t.binary", HETAB_LOOKUP_INTERPOLATE);
}

static hetab_lookup *h5_table(hetab_context *ctx, const hetab_surface *surface) {
  hetab_engine *engine = new_engine(ctx);
  assert_ok(ctx, save_h5(ctx, engine, surface, NULL, "t.h5"));
  hetab_engine_free(engine);
  return open_table(ctx, "t.h5", HETAB_LOOKUP_INTERPOLATE);
}

/* --- error against the model ----------------------------------------------------------------- */

static const double incidences_deg[] = {0, 15, 30, 45, 60, 75, 80, 85};
enum { INCIDENCES = sizeof incidences_deg / sizeof *incidences_deg };

static void assert_accurate(const char *what, int steep, const hetab_lookup *table,
                            const lookup_model *m) {
  uint64_t random = 1;
  char line[256];
  int length = snprintf(line, sizeof line, "  %-22s", what);
  for (int t = 0; t < INCIDENCES; t++) {
    lookup_error e =
        error_at(look_up_table, table, m, incidences_deg[t] * M_PI / 180, 600, &random);
    double bound = incidences_deg[t] <= 75 ? TOL_LOOKUP_L1 : TOL_LOOKUP_L1_GRAZING;
    if (steep)
      bound = incidences_deg[t] <= 75 ? TOL_LOOKUP_STEEP : TOL_LOOKUP_STEEP_GRAZING;
    length += snprintf(line + length, sizeof line - (size_t)length, " %.2f", 100 * e.l1);
    if (!(e.l1 <= bound))
      fail_msg("%s at %g degrees: L1 %g", what, incidences_deg[t], e.l1);
  }
  print_message("%s %% at 0 15 30 45 60 75 80 85 degrees\n", line);
}

static void tables_are_close_to_the_model(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const char steep[] = "name: steep\nsigma0_um: 2\ntau_um: 2\nindex: Al\n";
  put_file("steep.yml", steep, sizeof steep - 1);
  for (int s = 0; s <= PRESETS; s++) {
    const char *name = s < PRESETS ? presets[s] : "steep";
    char what[64];
    hetab_surface *colour = surface_of(ctx, name, NULL, 0);
    hetab_surface *bands = surface_of(ctx, name, three_bands_um, 3);
    lookup_model srgb = model_of(ctx, colour, 1), spectral = model_of(ctx, bands, 0);
    hetab_lookup *merl = merl_table(ctx, colour), *h5 = h5_table(ctx, bands);
    snprintf(what, sizeof what, "%s MERL, L1", name);
    assert_accurate(what, s == PRESETS, merl, &srgb);
    snprintf(what, sizeof what, "%s HDF5, L1", name);
    assert_accurate(what, s == PRESETS, h5, &spectral);
    hetab_lookup_free(merl);
    hetab_lookup_free(h5);
    hetab_surface_free(colour);
    hetab_surface_free(bands);
  }
}

/* --- single, batch, nearest ------------------------------------------------------------------ */

enum { PAIRS = 1000 };
typedef struct pair_list {
  float wi[PAIRS][3], wo[PAIRS][3];
} pair_list;

static void random_direction(uint64_t *random, float w[3]) {
  direction_at(acos(lookup_random(random)), 2 * M_PI * lookup_random(random), w);
}

static void fill_pairs(pair_list *p) {
  uint64_t random = 5;
  for (size_t n = 0; n < PAIRS; n++) {
    random_direction(&random, p->wi[n]);
    random_direction(&random, p->wo[n]);
  }
}

static void assert_near(const char *what, double value, double expected, double relative) {
  if (!(fabs(value - expected) <= relative * fabs(expected) + 1e-12))
    fail_msg("%s: %.9g in place of %.9g", what, value, expected);
}

/* Also that a batch writes its own numbers and none after them, and that the two directions may be
 * exchanged. */
static void batches_equal_single_calls(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const double seven_um[] = {0.40, 0.45, 0.50, 0.55, 0.60, 0.65, 0.70};
  for (int wide = 0; wide < 2; wide++) {
    hetab_surface *surface = surface_of(ctx, "NGGAL", seven_um, wide ? 7 : 2);
    hetab_lookup *table = h5_table(ctx, surface);
    size_t channels = hetab_lookup_channel_count(table);
    assert_int_equal(channels, wide ? 7 : 2);
    assert_true(hetab_lookup_wavelengths_um(table)[1] == seven_um[1]);
    pair_list *p = malloc(sizeof *p);
    float *all = calloc(PAIRS * channels + 1, sizeof *all), one[8], turned[8];
    fill_pairs(p);
    for (size_t count = PAIRS - 20; count <= PAIRS; count += 7) {
      all[count * channels] = -7;
      hetab_lookup_eval(table, NULL, count, p->wi[0], p->wo[0], all, NULL);
      assert_true(all[count * channels] == -7);
    }
    for (size_t n = 0; n < PAIRS - 6; n++) {
      hetab_lookup_eval(table, NULL, 1, p->wi[n], p->wo[n], one, NULL);
      hetab_lookup_eval(table, NULL, 1, p->wo[n], p->wi[n], turned, NULL);
      for (size_t c = 0; c < channels; c++) {
        assert_near("batch", (double)all[n * channels + c], (double)one[c], 1e-4);
        assert_near("reciprocity", (double)turned[c], (double)one[c], 1e-4);
      }
    }
    free(all);
    free(p);
    hetab_lookup_free(table);
    hetab_surface_free(surface);
  }
}

static void nearest_is_the_files_own_number(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "GGAL240", three_bands_um, 3);
  hetab_lookup_free(merl_table(ctx, surface));
  hetab_lookup_free(h5_table(ctx, surface));
  hetab_lookup *merl = open_table(ctx, "t.binary", HETAB_LOOKUP_NEAREST);
  hetab_lookup *h5 = open_table(ctx, "t.h5", HETAB_LOOKUP_NEAREST);
  hetab_merl *cells;
  hetab_h5_table *nodes;
  double *band = malloc((size_t)90 * 90 * 181 * sizeof *band);
  assert_ok(ctx, hetab_merl_load(ctx, "t.binary", &cells));
  assert_ok(ctx, hetab_h5_open(ctx, "t.h5", &nodes));
  assert_ok(ctx, hetab_h5_read(ctx, nodes, 1, band));
  uint64_t random = 3;
  for (int n = 0; n < 1000; n++) {
    double theta_i = lookup_random(&random) * 1.5, theta_r = lookup_random(&random) * 1.5;
    double phi = lookup_random(&random) * M_PI, expected[3];
    float wi[3], wo[3], value[3];
    direction_at(theta_i, 0.3, wi);
    direction_at(theta_r, 0.3 + phi, wo);
    hetab_lookup_eval(h5, NULL, 1, wi, wo, value, NULL);
    double step = M_PI_2 / 89;
    size_t i = (size_t)lround(theta_i / step), r = (size_t)lround(theta_r / step);
    size_t p = (size_t)lround(phi * 180 / M_PI);
    assert_near("HDF5", (double)value[1], band[(i * 90 + r) * 181 + p], 1e-6);
    hetab_lookup_eval(merl, NULL, 1, wi, wo, value, NULL);
    hetab_merl_lookup(cells, (hetab_directions){theta_i, theta_r, phi}, expected);
    assert_near("MERL", (double)value[2], fmax(expected[2], 0), 1e-6);
  }
  free(band);
  hetab_merl_free(cells);
  hetab_h5_free(nodes);
  hetab_lookup_free(merl);
  hetab_lookup_free(h5);
  hetab_surface_free(surface);
}

static void any_direction_is_answered(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "BBQAL2", three_bands_um, 3);
  hetab_lookup *table = merl_table(ctx, surface);
  static const float odd[][3] = {{0, 0, 1},
                                 {0, 0, -1},
                                 {1, 0, 0},
                                 {-1, 0, 0},
                                 {0, 0, 0},
                                 {NAN, NAN, NAN},
                                 {NAN, 0, 1},
                                 {0, 1, 1e-30f},
                                 {INFINITY, 0, 1},
                                 {0, 0, INFINITY},
                                 {1e20f, 1e20f, 1e20f},
                                 {0, -1, 1e-6f}};
  enum { ODD = sizeof odd / sizeof *odd };
  for (int i = 0; i < ODD; i++)
    for (int r = 0; r < ODD; r++) {
      float value[3], weight[3], wo[3], u[2] = {0.999999f, (float)r / ODD};
      hetab_lookup_eval(table, NULL, 1, odd[i], odd[r], value, NULL);
      for (int c = 0; c < 3; c++)
        assert_true(value[c] >= 0 && isfinite(value[c]));
      if (odd[i][2] <= 0 || odd[r][2] <= 0) {
        assert_true(value[0] == 0);
        assert_true(density_at(table, odd[i], odd[r]) == 0);
      }
      density_at(table, odd[i], odd[r]);
      hetab_lookup_albedo(table, NULL, 1, odd[i], value, NULL);
      hetab_lookup_albedo(table, NULL, 1, odd[i], NULL, value);
      float density = sample_at(table, odd[i], u[1], u, wo, weight);
      if (odd[i][2] <= 0)
        assert_true(density == 0 && weight[0] == 0);
    }
  hetab_lookup_free(table);
  hetab_surface_free(surface);
}

/* --- sampling -------------------------------------------------------------------------------- */

/* Bins of directions: of cos(theta_o) and phi; or, for lobes narrower than those, of the half
 * vector, where dwo = 4 (wo.h) dh. Neither is aligned with the sampler's cells. */
enum { BINS_A = 18, BINS_B = 38, BINS = BINS_A * BINS_B, SAMPLES = 1000000, CHUNK = 10000 };

static size_t bin_at(double a, double b) {
  size_t i = (size_t)fmin(fmax(a, 0) * BINS_A, BINS_A - 1);
  return i * BINS_B + (size_t)fmin(fmax(b, 0) * BINS_B, BINS_B - 1);
}

static size_t bin_of(int narrow, const float wi[3], const float wo[3]) {
  double x = (double)wo[0], y = (double)wo[1], z = (double)wo[2];
  if (!narrow)
    return bin_at(z, atan2(y, x) / (2 * M_PI) + 0.5);
  x += (double)wi[0];
  y += (double)wi[1];
  z += (double)wi[2];
  return bin_at(sqrt(atan2(hypot(x, y), z) / M_PI_2), atan2(y, x) / (2 * M_PI) + 0.5);
}

/* The point of [0, 1]^2 as a direction, and d(wo) over the square's area; 0 below the horizon. */
static double bin_direction(int narrow, const float wi[3], double a, double b, float wo[3]) {
  double phi = (2 * b - 1) * M_PI, theta = a * a * M_PI_2;
  if (!narrow) {
    direction_at(acos(a), phi, wo);
    return 2 * M_PI;
  }
  double h[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)}, i_h = 0;
  for (int k = 0; k < 3; k++)
    i_h += (double)wi[k] * h[k];
  for (int k = 0; k < 3; k++)
    wo[k] = (float)(2 * i_h * h[k] - (double)wi[k]);
  return i_h > 0 && wo[2] > 0 ? 4 * i_h * sin(theta) * 2 * a * M_PI_2 * 2 * M_PI : 0;
}

/* The share of samples that the density promises to each bin. The density has steps: points that
 * are not in rows do not miss all of them alike. */
static double expected_shares(const hetab_lookup *table, int narrow, const float wi[3],
                              double *share) {
  enum { FINE = 50 };
  uint64_t random = 29;
  double total = 0;
  for (size_t bin = 0; bin < BINS; bin++) {
    share[bin] = 0;
    for (int p = 0; p < FINE * FINE; p++) {
      float wo[3];
      double a = ((double)(bin / BINS_B) + (p / FINE + lookup_random(&random)) / FINE) / BINS_A;
      double b = ((double)(bin % BINS_B) + (p % FINE + lookup_random(&random)) / FINE) / BINS_B;
      double area = bin_direction(narrow, wi, a, b, wo);
      if (area > 0)
        share[bin] += area * (double)density_at(table, wi, wo) / (FINE * FINE) / BINS;
    }
    total += share[bin];
  }
  return total;
}

typedef struct moments {
  double sum[3], squares[3];
} moments;

/* Draws, counts, and adds up weights; the last of counts[BINS + 1] are the failed ones. */
static moments draw_samples(const hetab_lookup *table, int narrow, const float wi[3],
                            double *counts) {
  typedef struct chunk {
    float wi[CHUNK][3], uc[CHUNK], u[CHUNK][2], weight[CHUNK][3];
    hetab_lookup_drawn drawn[CHUNK];
  } chunk;
  chunk *c = malloc(sizeof *c);
  moments m = {{0}, {0}};
  uint64_t random = 17;
  const hetab_lookup_query query = {.without_delta = 1};
  memset(counts, 0, (BINS + 1) * sizeof *counts);
  for (int first = 0; first < SAMPLES; first += CHUNK) {
    for (int n = 0; n < CHUNK; n++) {
      memcpy(c->wi[n], wi, sizeof c->wi[n]);
      for (int k = 0; k < 2; k++)
        c->u[n][k] = (float)(floor(lookup_random(&random) * 0x1p24) * 0x1p-24);
      c->uc[n] = (float)(floor(lookup_random(&random) * 0x1p24) * 0x1p-24);
    }
    hetab_lookup_sample(table, &query, CHUNK, c->wi[0], c->uc, c->u[0], c->drawn, c->weight[0]);
    for (int n = 0; n < CHUNK; n++) {
      counts[c->drawn[n].pdf > 0 ? bin_of(narrow, wi, c->drawn[n].wo) : BINS]++;
      for (int k = 0; k < 3; k++) {
        m.sum[k] += (double)c->weight[n][k];
        m.squares[k] += (double)c->weight[n][k] * (double)c->weight[n][k];
      }
    }
  }
  free(c);
  return m;
}

/* The probability of a chi-square at least that large (Wilson and Hilferty). */
static double chi_square_tail(double chi_square, double freedom) {
  double spread = 2 / (9 * freedom);
  return 0.5 * erfc((cbrt(chi_square / freedom) - 1 + spread) / sqrt(2 * spread));
}

/* Of the samples that did not fail. Bins that expect fewer than 5 are taken together. */
static double chi_square_test(const double *counts, const double *share, double total) {
  double chi_square = 0, rare = 0, rare_count = 0, freedom = -1, drawn = SAMPLES - counts[BINS];
  for (int bin = 0; bin < BINS; bin++) {
    double expected = share[bin] / total * drawn, difference = counts[bin] - expected;
    if (expected < 5) {
      rare += expected;
      rare_count += counts[bin];
    } else {
      chi_square += difference * difference / expected;
      freedom++;
    }
  }
  if (rare >= 5) {
    chi_square += (rare_count - rare) * (rare_count - rare) / rare;
    freedom++;
  }
  return chi_square_tail(chi_square, freedom);
}

/* Of eval, on a midpoint rule over half vectors; finer for lobes that are. */
static void albedo_of_eval(const hetab_lookup *table, int narrow, const float wi[3],
                           double rho[3]) {
  int rings = narrow ? 4800 : 1200, sectors = narrow ? 360 : 180;
  rho[0] = rho[1] = rho[2] = 0;
  for (int p = 0; p < rings * sectors; p++) {
    float wo[3], value[3];
    double a = (p / sectors + 0.5) / rings, b = (p % sectors + 0.5) / sectors;
    double area = bin_direction(1, wi, a, b, wo) / (rings * sectors);
    if (area > 0) {
      hetab_lookup_eval(table, NULL, 1, wi, wo, value, NULL);
      for (int c = 0; c < 3; c++)
        rho[c] += area * (double)wo[2] * (double)value[c];
    }
  }
}

/* The number of cases that share the level of significance 0.01. */
enum { CASES = 3 * PRESETS + PRESETS + 2 * 3 };

static void assert_samples(const char *what, const hetab_lookup *table, double theta_deg) {
  int needle = strncmp(what, "needle", 6) == 0, narrow = needle || strncmp(what, "NGGAL", 5) == 0;
  double albedo_bound = !needle                ? TOL_LOOKUP_ALBEDO
                        : strstr(what, "HDF5") ? TOL_LOOKUP_ALBEDO_NEEDLE_H5
                                               : TOL_LOOKUP_ALBEDO_NEEDLE_MERL;
  static double share[BINS], counts[BINS + 1];
  float wi[3], albedo[3];
  double rho[3], worst_albedo = 0, worst_mean = 0;
  direction_at(theta_deg * M_PI / 180, 0, wi);
  double total = expected_shares(table, narrow, wi, share);
  moments m = draw_samples(table, narrow, wi, counts);
  double p = chi_square_test(counts, share, total);
  hetab_lookup_albedo(table, NULL, 1, wi, albedo, NULL);
  albedo_of_eval(table, needle, wi, rho);
  for (int c = 0; c < 3; c++) {
    double mean = m.sum[c] / SAMPLES;
    double error = sqrt(fmax(m.squares[c] / SAMPLES - mean * mean, 0) / SAMPLES);
    worst_mean = fmax(worst_mean, fabs(mean - rho[c]) / error);
    worst_albedo = fmax(worst_albedo, fabs((double)albedo[c] / rho[c] - 1));
  }
  double spread = sqrt(fmax(m.squares[1] * SAMPLES / (m.sum[1] * m.sum[1]) - 1, 0));
  print_message("  %-14s %2.0f deg: p %.3f, %.3f %% lost, mean weight off by %.1f standard errors, "
                "albedo by %.2f %%, spread %.2f\n",
                what, theta_deg, p, 100 * counts[BINS] / SAMPLES, worst_mean, 100 * worst_albedo,
                spread);
  assert_true(counts[BINS] <= TOL_LOOKUP_LOST * SAMPLES && spread <= (needle ? 0.47 : 0.36));
  if (!(p > 1 - pow(1 - 0.01, 1.0 / CASES)))
    fail_msg("%s at %g degrees: chi-square, p %g", what, theta_deg, p);
  if (!(fabs(1 - total - counts[BINS] / SAMPLES) <= TOL_LOOKUP_LOST))
    fail_msg("%s at %g degrees: the density adds up to %g, %g of the samples fail", what, theta_deg,
             total, counts[BINS] / SAMPLES);
  if (!(worst_mean <= 3))
    fail_msg("%s at %g degrees: mean weight off by %g standard errors", what, theta_deg,
             worst_mean);
  if (!(worst_albedo <= albedo_bound))
    fail_msg("%s at %g degrees: albedo off by %g", what, theta_deg, worst_albedo);
}

static void samples_follow_their_density(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const double degrees[] = {0, 60, 85};
  for (int s = 0; s <= PRESETS; s++) {
    const char *name = s < PRESETS ? presets[s] : "needle";
    hetab_surface *surface = surface_of(ctx, name, three_bands_um, 3);
    hetab_lookup *merl = merl_table(ctx, surface), *h5 = h5_table(ctx, surface);
    char what[64];
    for (int t = 0; t < 3; t++) {
      snprintf(what, sizeof what, "%s MERL", name);
      assert_samples(what, merl, degrees[t]);
      snprintf(what, sizeof what, "%s HDF5", name);
      if (s == PRESETS || t == 2)
        assert_samples(what, h5, degrees[t]);
    }
    hetab_lookup_free(merl);
    hetab_lookup_free(h5);
    hetab_surface_free(surface);
  }
}

/* The table's albedo against the model's reflectance, which is integrated elsewhere. */
static void albedos_are_the_models(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const double theta_i[] = {0, DEG(20), DEG(45), DEG(70), DEG(80), DEG(85)};
  enum { ANGLES = sizeof theta_i / sizeof *theta_i };
  hetab_engine *engine = new_engine(ctx);
  for (int s = 0; s < PRESETS; s++) {
    hetab_surface *surface = surface_of(ctx, presets[s], three_bands_um, 3);
    hetab_lookup *table = h5_table(ctx, surface);
    hetab_reflectance rho[3 * ANGLES];
    double worst = 0;
    assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, ANGLES, 0, rho));
    for (int t = 0; t < ANGLES; t++) {
      float wi[3], value[3];
      direction_at(theta_i[t], 0, wi);
      hetab_lookup_albedo(table, NULL, 1, wi, value, NULL);
      for (int b = 0; b < 3; b++)
        worst = fmax(worst, fabs((double)value[b] / rho[b * ANGLES + t].dd.value - 1));
    }
    print_message("  %-8s albedo against the model's rho_dd, to 85 degrees: off by %.2f %%\n",
                  presets[s], 100 * worst);
    if (!(worst <= TOL_LOOKUP_L1_GRAZING))
      fail_msg("%s: albedo off by %g", presets[s], worst);
    hetab_lookup_free(table);
    hetab_surface_free(surface);
  }
  hetab_engine_free(engine);
}

/* A narrow lobe upon a wide one, the delta folded in: nothing of it is lost between cells. */
static void folded_tables_keep_their_energy(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const double theta_i[] = {0, DEG(20), DEG(45), DEG(60), DEG(75), DEG(85)};
  enum { ANGLES = sizeof theta_i / sizeof *theta_i };
  hetab_engine *engine = new_engine(ctx);
  hetab_surface *surface;
  hetab_merl_options options = {
      .colour = HETAB_MERL_BANDS,
      .band_um = {three_bands_um[0], three_bands_um[1], three_bands_um[2]},
      .specular_cone = DEG(2)};
  hetab_reflectance rho[3 * ANGLES];
  double worst = 0;
  assert_ok(ctx, hetab_surface_create(ctx, 0.03, 3, 2.5, 3.1, three_bands_um, 3, &surface));
  assert_ok(ctx, save_merl(ctx, engine, surface, &options, "folded.binary"));
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, ANGLES, 0, rho));
  hetab_lookup *table = open_table(ctx, "folded.binary", HETAB_LOOKUP_INTERPOLATE);
  for (int t = 0; t < ANGLES; t++) {
    float wi[3], albedo[3];
    direction_at(theta_i[t], 0, wi);
    hetab_lookup_albedo(table, NULL, 1, wi, albedo, NULL);
    for (int b = 0; b < 3; b++)
      worst = fmax(worst, fabs((double)albedo[b] / rho[b * ANGLES + t].dh - 1));
  }
  print_message("  steel folded, 2 degrees: albedo off by %.2f %%\n", 100 * worst);
  if (!(worst <= TOL_CONE_ENERGY))
    fail_msg("folded: albedo off by %g", worst);
  hetab_lookup_free(table);
  hetab_surface_free(surface);
  hetab_engine_free(engine);
}

/* --- the whole BSDF, and a path's own wavelengths --------------------------------------------- */

/* Weights add up to albedo and delta, densities are eval's, the delta has its share. */
static void assert_whole(const char *what, const hetab_lookup *table, double theta) {
  enum { DRAWS = 200000 };
  uint64_t random = 7;
  float wi[3], albedo[3], rho_s[3], weight[3], value[3], pdf;
  double sum[3] = {0}, squares[3] = {0}, mirrors = 0, share = 0;
  direction_at(theta, 0.4, wi);
  hetab_lookup_albedo(table, NULL, 1, wi, albedo, rho_s);
  for (int n = 0; n < DRAWS; n++) {
    float uc = (float)(lookup_random(&random) * 0.9999999), u[2];
    hetab_lookup_drawn drawn;
    for (int k = 0; k < 2; k++)
      u[k] = (float)(lookup_random(&random) * 0.9999999);
    hetab_lookup_sample(table, NULL, 1, wi, &uc, u, &drawn, weight);
    if (drawn.lobe == HETAB_LOOKUP_SPECULAR) {
      mirrors++;
      share = (double)drawn.pdf;
      assert_true(drawn.wo[0] == -wi[0] && drawn.wo[1] == -wi[1] && drawn.wo[2] == wi[2]);
    } else if (drawn.lobe != HETAB_LOOKUP_NONE && n < 1000) {
      hetab_lookup_eval(table, NULL, 1, wi, drawn.wo, value, &pdf);
      assert_near("pdf", (double)pdf, (double)drawn.pdf, 1e-2);
      assert_near("weight", (double)weight[1], (double)(value[1] * drawn.wo[2] / drawn.pdf), 1e-2);
    }
    for (int c = 0; c < 3; c++) {
      sum[c] += (double)weight[c];
      squares[c] += (double)weight[c] * (double)weight[c];
    }
  }
  if (!(fabs(mirrors / DRAWS - share) <= 4 * sqrt(share * (1 - share) / DRAWS)))
    fail_msg("%s: the delta has %g of the samples in place of %g", what, mirrors / DRAWS, share);
  for (int c = 0; c < 3; c++) {
    double mean = sum[c] / DRAWS, whole = (double)(albedo[c] + rho_s[c]);
    double error = sqrt(fmax(squares[c] / DRAWS - mean * mean, 0) / DRAWS);
    if (!(fabs(mean - whole) <= 4 * error + TOL_LOOKUP_ALBEDO * (double)albedo[c]))
      fail_msg("%s: mean weight %g in place of %g", what, mean, whole);
  }
  print_message("  %-10s %2.0f deg: the delta has %.3f of the samples\n", what, theta * 180 / M_PI,
                share);
}

static void samples_are_of_the_whole_bsdf(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_create(ctx, 0.03, 3, 0.958, 6.69, three_bands_um, 3, &surface));
  hetab_lookup *table = h5_table(ctx, surface);
  assert_whole("mirror", table, 0.1);
  assert_whole("mirror", table, 1.3);
  hetab_lookup_free(table);
  hetab_surface_free(surface);
  surface = surface_of(ctx, "NGGAL", three_bands_um, 3);
  table = h5_table(ctx, surface);
  assert_whole("NGGAL", table, 1.2);
  hetab_lookup_free(table);
  hetab_surface_free(surface);
}

enum { BANDS = 31, OWN = 11 };

/* Values at wavelengths against those of all channels, where a path's own are the table's, between
 * them, and beyond them. */
static void assert_own_wavelengths(const hetab_lookup *table) {
  const double *lambda_um = hetab_lookup_wavelengths_um(table);
  size_t channels = hetab_lookup_channel_count(table);
  pair_list *p = malloc(sizeof *p);
  float(*all)[BANDS] = malloc(PAIRS * sizeof *all), (*own)[OWN] = malloc(PAIRS * sizeof *own);
  float(*um)[OWN] = malloc(PAIRS * sizeof *um);
  fill_pairs(p);
  for (size_t n = 0; n < PAIRS; n++)
    for (size_t k = 0; k < OWN; k++)
      um[n][k] = k == 0 ? 0.3f : (float)(lambda_um[(n + k) % (channels - 1)] + (k & 1 ? 0 : 0.005));
  const hetab_lookup_query query = {.lambda_um = um[0], .lambda_count = OWN};
  for (int what = 0; what < 3; what++) {
    if (what == 0) {
      hetab_lookup_eval(table, NULL, PAIRS, p->wi[0], p->wo[0], all[0], NULL);
      hetab_lookup_eval(table, &query, PAIRS, p->wi[0], p->wo[0], own[0], NULL);
    } else {
      float *a = what == 1 ? all[0] : NULL, *o = what == 1 ? own[0] : NULL;
      hetab_lookup_albedo(table, NULL, PAIRS, p->wi[0], a, a ? NULL : all[0]);
      hetab_lookup_albedo(table, &query, PAIRS, p->wi[0], o, o ? NULL : own[0]);
    }
    for (size_t n = 0; n < PAIRS; n++)
      for (size_t k = 0; k < OWN; k++) {
        const float *at = &all[n][k == 0 ? 0 : (n + k) % (channels - 1)];
        double expected = (double)(k == 0 || k & 1 ? at[0] : 0.5f * (at[0] + at[1]));
        assert_near("own wavelength", (double)own[n][k], expected, 1e-4);
      }
  }
  free(all);
  free(own);
  free(um);
  free(p);
}

static void paths_have_their_own_wavelengths(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "BBQAL2", NULL, 0);
  const hetab_rgl_options spectral = {.bands = HETAB_RGL_SPECTRAL, .table_error = 0.1};
  hetab_rgl *rgl;
  hetab_lookup *table = h5_table(ctx, surface);
  assert_int_equal(hetab_lookup_channel_count(table), BANDS);
  assert_own_wavelengths(table);
  hetab_lookup_free(table);
  table = open_table(ctx, "t.h5", HETAB_LOOKUP_NEAREST);
  assert_own_wavelengths(table);
  hetab_lookup_free(table);
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &spectral, &rgl, NULL));
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, "s.bsdf", 1));
  hetab_rgl_free(rgl);
  table = open_table(ctx, "s.bsdf", HETAB_LOOKUP_INTERPOLATE);
  assert_own_wavelengths(table);
  hetab_lookup_free(table);
  table = merl_table(ctx, surface); /* linear sRGB has none */
  const float w[3] = {0, 0.6f, 0.8f}, um[2] = {0.5f, 0.6f};
  float value[2] = {1, 1};
  hetab_lookup_eval(table, &(hetab_lookup_query){um, 2, 0}, 1, w, w, value, NULL);
  assert_true(value[0] == 0 && value[1] == 0);
  hetab_lookup_free(table);
  hetab_surface_free(surface);
}

/* --- MERL tables by the reference reader's truncating rule ----------------------------------- */

typedef struct cell_reader {
  const hetab_merl *merl; /* NULL: the model at the cell's centre */
  const lookup_model *model;
} cell_reader;

/* The model at the centre of a cell; 0 if that is below the horizon, which the reader draws black.
 */
static void model_at_centre(const lookup_model *m, size_t cell, double *rgb) {
  double u = ((double)(cell / 180 / 90) + 0.5) / 90, theta_h = u * u * M_PI_2;
  double theta_d = ((double)(cell / 180 % 90) + 0.5) / 90 * M_PI_2;
  double phi_d = ((double)(cell % 180) + 0.5) / 180 * M_PI;
  double x = sin(theta_d) * cos(phi_d), y = sin(theta_d) * sin(phi_d), z = cos(theta_d);
  double i[2] = {cos(theta_h) * x + sin(theta_h) * z, y};
  double r[2] = {2 * cos(theta_d) * sin(theta_h) - i[0], -y};
  double mu_i = cos(theta_h) * z - sin(theta_h) * x, mu_r = 2 * z * cos(theta_h) - mu_i;
  rgb[0] = rgb[1] = rgb[2] = 0;
  if (mu_i > 0 && mu_r > 0)
    model_at(m, atan2(hypot(i[0], i[1]), mu_i), atan2(hypot(r[0], r[1]), mu_r),
             atan2(r[1], r[0]) - atan2(i[1], i[0]), rgb);
}

static void read_cell(const void *user, const float wi[3], const float wo[3], float *value) {
  const cell_reader *reader = user;
  double theta_i = acos(fmin((double)wi[2], 1)), theta_r = acos(fmin((double)wo[2], 1)), rgb[3];
  double phi = atan2((double)wo[1], (double)wo[0]) - atan2((double)wi[1], (double)wi[0]);
  if (reader->merl)
    hetab_merl_lookup(reader->merl, (hetab_directions){theta_i, theta_r, phi}, rgb);
  else
    model_at_centre(reader->model, hetab_merl_cell((hetab_directions){theta_i, theta_r, phi}), rgb);
  for (int c = 0; c < 3; c++)
    value[c] = (float)fmax(rgb[c], 0);
}

/* Over incidences as under uniform light. */
static double truncating_error(const cell_reader *reader, const lookup_model *m) {
  enum { STRATA = 16 };
  uint64_t random = 7;
  double sum = 0;
  for (int t = 0; t < STRATA; t++)
    sum += error_at(read_cell, reader, m, asin(sqrt((t + lookup_random(&random)) / STRATA)), 150,
                    &random)
               .l1;
  return sum / STRATA;
}

static void merl_tables_are_as_good_as_exact_centres(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_engine *engine = new_engine(ctx);
  hetab_merl_options options = {.colour = HETAB_MERL_SRGB};
  for (int s = 0; s < PRESETS; s++) {
    hetab_surface *surface = surface_of(ctx, presets[s], NULL, 0);
    lookup_model m = model_of(ctx, surface, 1);
    hetab_merl *merl;
    assert_ok(ctx, hetab_tabulate_merl(ctx, engine, surface, &options, &merl, NULL));
    cell_reader table = {.merl = merl}, centres = {.model = &m};
    double ours = truncating_error(&table, &m), exact = truncating_error(&centres, &m);
    print_message("  %-8s MERL, truncated: L1 %.3f %%, of exact cell centres %.3f %%\n", presets[s],
                  100 * ours, 100 * exact);
    if (!(ours <= exact * (1 + TOL_LOOKUP_CENTRES)))
      fail_msg("%s: L1 %g, of exact cell centres %g", presets[s], ours, exact);
    hetab_merl_free(merl);
    hetab_surface_free(surface);
  }
  hetab_engine_free(engine);
}

/* --- the specular delta ---------------------------------------------------------------------- */

static const char csv_header[] = "wavelength_nm,theta_i_deg,rho_s\n";

/* rho_s as hetab tabulate writes it beside MERL tables. */
static void save_specular_csv(hetab_context *ctx, const hetab_surface *surface, const char *path) {
  double theta_i[91], *rho = calloc(91 * MOST_BANDS, sizeof *rho);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (int i = 0; i <= 90; i++)
    theta_i[i] = DEG(i);
  assert_ok(ctx, hetab_specular_reflectance(ctx, surface, theta_i, 91, rho));
  fputs(csv_header, file);
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++)
    for (size_t i = 0; i < 91; i++)
      fprintf(file, "%.10g,%zu,%.9g\n", 1000 * hetab_surface_bands(surface)[b].lambda_um, i,
              rho[b * 91 + i]);
  assert_int_equal(fclose(file), 0);
  free(rho);
}

/* Between the table's angles. */
static void the_specular_delta_is_apart(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "NGGAL", NULL, 0);
  lookup_model m = model_of(ctx, surface, 1);
  float wi[3], value[MOST_BANDS];
  hetab_lookup *plain = merl_table(ctx, surface), *h5 = h5_table(ctx, surface);
  save_specular_csv(ctx, surface, "t.specular.csv");
  hetab_lookup *merl = open_table(ctx, "t.binary", HETAB_LOOKUP_NEAREST);
  double worst = 0;
  for (double deg = 0.5; deg < 87; deg += 1.7) {
    double rho[MOST_BANDS], rgb[3] = {0}, theta_i = DEG(deg);
    assert_ok(ctx, hetab_specular_reflectance(ctx, surface, &theta_i, 1, rho));
    direction_at(theta_i, 1, wi);
    hetab_lookup_albedo(h5, NULL, 1, wi, NULL, value);
    for (int b = 0; b < MOST_BANDS; b++) {
      worst = fmax(worst, fabs((double)value[b] - rho[b]) / fmax(rho[b], 1e-6));
      for (int c = 0; c < 3; c++)
        rgb[c] += m.weight[b][c] * rho[b];
    }
    hetab_lookup_albedo(merl, NULL, 1, wi, NULL, value);
    for (int c = 0; c < 3; c++)
      worst = fmax(worst, fabs((double)value[c] - fmax(rgb[c], 0)) / fmax(rgb[0], 1e-6));
    hetab_lookup_albedo(plain, NULL, 1, wi, NULL, value);
    assert_true(value[0] == 0 && value[1] == 0 && value[2] == 0);
  }
  print_message("  rho_s between whole degrees, to 87: off by %.2e at most\n", worst);
  assert_true(worst <= TOL_LOOKUP_SPECULAR);
  hetab_lookup_free(plain);
  hetab_lookup_free(merl);
  hetab_lookup_free(h5);
  hetab_surface_free(surface);
}

/* --- RGL and black tables -------------------------------------------------------------------- */

static void rgl_tables_open_too(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "GGAL120", NULL, 0);
  lookup_model m = model_of(ctx, surface, 1);
  hetab_rgl_options options = {.bands = HETAB_RGL_RGB, .table_error = 0.05};
  hetab_rgl_report report;
  hetab_rgl *rgl;
  assert_ok(ctx, hetab_tabulate_rgl(ctx, surface, &options, &rgl, &report));
  assert_ok(ctx, hetab_rgl_save(ctx, rgl, "t.bsdf", 0));
  save_specular_csv(ctx, surface, "t.specular.csv");
  hetab_lookup *table = open_table(ctx, "t.bsdf", HETAB_LOOKUP_INTERPOLATE);
  assert_int_equal(hetab_lookup_channel_count(table), 3);
  assert_null(hetab_lookup_wavelengths_um(table));
  uint64_t random = 1;
  lookup_error e = error_at(look_up_table, table, &m, 0.7, 300, &random);
  print_message("  GGAL120 RGL at 5 %%: L1 %.2f %% at 40 degrees\n", 100 * e.l1);
  assert_true(e.l1 <= 0.05);
  float wi[3], wo[3], u[2] = {0.3f, 0.8f}, weight[3], value[3], again[3];
  direction_at(0.7, 0.2, wi);
  float density = sample_at(table, wi, u[1], u, wo, weight);
  assert_true(density > 0);
  assert_near("density", (double)density_at(table, wi, wo), (double)density, 1e-2);
  hetab_lookup_eval(table, NULL, 1, wi, wo, value, NULL);
  hetab_rgl_eval(rgl, wi, wo, again);
  for (int c = 0; c < 3; c++)
    assert_near("value", (double)value[c], (double)again[c], 1e-5);
  assert_near("weight", (double)weight[1], (double)(value[1] * wo[2] / density), 1e-5);
  hetab_lookup_albedo(table, NULL, 1, wi, value, NULL);
  assert_true(value[1] > 0.7f && value[1] < 1.0f);
  hetab_rgl_free(rgl);
  hetab_lookup_free(table);
  hetab_surface_free(surface);
}

static void black_tables_stay_black(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  for (int c = 0; c < 3; c++)
    memset(hetab_merl_channel(merl, c), 0, HETAB_MERL_CELLS * sizeof(double));
  for (size_t i = 0; i < HETAB_MERL_CELLS; i++)
    hetab_merl_channel(merl, 1)[i] = 0.1;
  assert_ok(ctx, hetab_merl_save(ctx, merl, "green.binary", 0));
  memset(hetab_merl_channel(merl, 1), 0, HETAB_MERL_CELLS * sizeof(double));
  assert_ok(ctx, hetab_merl_save(ctx, merl, "black.binary", 0));
  hetab_merl_free(merl);
  for (int green = 0; green < 2; green++) {
    hetab_lookup *table =
        open_table(ctx, green ? "green.binary" : "black.binary", HETAB_LOOKUP_INTERPOLATE);
    uint64_t random = 4;
    for (int n = 0; n < 1000; n++) {
      float wi[3], wo[3], value[3], weight[3];
      float u[2] = {(float)n / 1000, (float)lookup_random(&random) * 0.999f};
      random_direction(&random, wi);
      float density = sample_at(table, wi, u[1], u, wo, weight);
      hetab_lookup_eval(table, NULL, 1, wi, wo, value, NULL);
      assert_true(value[0] == 0 && value[2] == 0 && weight[0] == 0);
      if (density > 0)
        assert_near("green", (double)value[1], green ? 0.1 : 0, 3e-4);
      hetab_lookup_albedo(table, NULL, 1, wi, value, NULL);
      assert_near("albedo", (double)value[1], green ? 0.1 * M_PI : 0, 5e-3);
    }
    hetab_lookup_free(table);
  }
}

/* Numbers that no BRDF has, but doubles do. */
static void absurd_numbers_stay_numbers(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  for (size_t i = 0; i < HETAB_MERL_CELLS; i++)
    for (int c = 0; c < 3; c++)
      hetab_merl_channel(merl, c)[i] = i % 7 ? 1e-300 : 1e299;
  assert_ok(ctx, hetab_merl_save(ctx, merl, "absurd.binary", 0));
  hetab_merl_free(merl);
  for (int rule = HETAB_LOOKUP_INTERPOLATE; rule <= HETAB_LOOKUP_NEAREST; rule++) {
    hetab_lookup *table = open_table(ctx, "absurd.binary", (hetab_lookup_rule)rule);
    uint64_t random = 4;
    for (int n = 0; n < 1000; n++) {
      float wi[3], wo[3], value[3], weight[3];
      float u[2] = {(float)n / 1000, (float)lookup_random(&random) * 0.999f};
      random_direction(&random, wi);
      sample_at(table, wi, u[1], u, wo, weight);
      hetab_lookup_eval(table, NULL, 1, wi, wo, value, NULL);
      for (int c = 0; c < 3; c++)
        assert_true(value[c] >= 0 && isfinite(value[c]));
    }
    hetab_lookup_free(table);
  }
}

/* --- files that are not what they say -------------------------------------------------------- */

static void assert_refused(hetab_context *ctx, const char *path, hetab_status expected,
                           const char *word) {
  for (int rule = HETAB_LOOKUP_INTERPOLATE; rule <= HETAB_LOOKUP_NEAREST; rule++) {
    hetab_lookup *table = (hetab_lookup *)&path;
    hetab_status status = hetab_lookup_open(ctx, path, (hetab_lookup_rule)rule, &table);
    assert_failure(ctx, status, expected, word);
    assert_non_null(strstr(hetab_error_message(ctx), path));
    assert_null(table);
  }
}

static void assert_bytes_refused(hetab_context *ctx, const void *data, size_t size,
                                 const char *word) {
  put_file("bad", data, size);
  assert_refused(ctx, "bad", HETAB_ERR_PARSE, word);
}

static void damaged_merl_files_are_refused(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_merl *merl;
  size_t size;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  assert_ok(ctx, hetab_merl_save(ctx, merl, "good.binary", 0));
  hetab_merl_free(merl);
  unsigned char *data = get_file("good.binary", &size);
  assert_bytes_refused(ctx, data, size / 2, "complete");
  assert_bytes_refused(ctx, data, 12, "complete");
  assert_bytes_refused(ctx, data, 11, "is truncated");
  double nan = NAN;
  memcpy(data + 12 + 8 * 1000, &nan, sizeof nan);
  assert_bytes_refused(ctx, data, size, "damaged");
  data[4] = 91;
  assert_bytes_refused(ctx, data, size, "90 x 91 x 180");
  free(data);
}

static void damaged_h5_files_are_refused(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_surface *surface = surface_of(ctx, "BBQAL1", three_bands_um, 1);
  hetab_engine *engine = new_engine(ctx);
  hetab_grid *grid;
  size_t size;
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    assert_ok(ctx, hetab_grid_set_axis(ctx, grid, axis, "0:90:5"));
  assert_ok(ctx, save_h5(ctx, engine, surface, grid, "good.h5"));
  unsigned char *data = get_file("good.h5", &size);
  assert_bytes_refused(ctx, data, size / 2, "bad");
  assert_bytes_refused(ctx, data, 100, "bad");
  /* a NaN among the numbers, which are stored as they are */
  float brdf = NAN, rest[4];
  hetab_lookup *table = open_table(ctx, "good.h5", HETAB_LOOKUP_NEAREST);
  float wi[3], wo[3];
  direction_at(45 * M_PI / 180, 0, wi);
  direction_at(45 * M_PI / 180, M_PI_2, wo);
  hetab_lookup_eval(table, NULL, 1, wi, wo, rest, NULL);
  hetab_lookup_free(table);
  unsigned char *number = memmem(data, size, rest, sizeof *rest);
  assert_non_null(number);
  memcpy(number, &brdf, sizeof brdf);
  assert_bytes_refused(ctx, data, size, "nan");
  free(data);
  hetab_grid_free(grid);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
}

static void other_files_are_refused(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  assert_refused(ctx, "missing.h5", HETAB_ERR_IO, "cannot read");
  mkdir("folder", 0777);
  assert_refused(ctx, "folder", HETAB_ERR_IO, "cannot read");
  assert_bytes_refused(ctx, "", 0, "is empty");
  assert_bytes_refused(ctx, "name: BBQAL2 and more", 20, "neither");
  static const char tensor[32] = "tensor_file\0\1\0\377\377\377\377";
  assert_bytes_refused(ctx, tensor, 12, "bad");
  assert_bytes_refused(ctx, tensor, sizeof tensor, "bad");
}

static void damaged_specular_files_are_refused(void **state) {
  static const struct {
    const char *rows, *word;
  } cases[] = {
      {"", "no rows"},
      {"550,0,0.1\n550,10\n", ":3:"},
      {"550,0,nan\n", ":2:"},
      {"550,0,2\n", ":2:"},
      {"550,95,0.1\n", ":2:"},
      {"-5,0,0.1\n", ":2:"},
      {"550,0,0.1 x\n", ":2:"},
      {"550,10,0.1\n550,0,0.1\n", "ascend"},
      {"550,0,0.1\n550,10,0.1\n560,0,0.1\n", "ascend"},
      {"550,0,0.1\n540,0,0.1\n", "ascend"},
      {"550,0,0.1\n550,18,0.1\n", "ends at theta_i 18"},
  };
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_merl *merl;
  hetab_lookup *table;
  char text[256];
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  assert_ok(ctx, hetab_merl_save(ctx, merl, "m.binary", 0));
  hetab_merl_free(merl);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    snprintf(text, sizeof text, "%s%s", csv_header, cases[i].rows);
    put_file("m.specular.csv", text, strlen(text));
    assert_failure(ctx, hetab_lookup_open(ctx, "m.binary", HETAB_LOOKUP_NEAREST, &table),
                   HETAB_ERR_PARSE, cases[i].word);
    assert_non_null(strstr(hetab_error_message(ctx), "m.specular.csv"));
  }
  put_file("m.specular.csv", "theta", 5);
  assert_failure(ctx, hetab_lookup_open(ctx, "m.binary", HETAB_LOOKUP_NEAREST, &table),
                 HETAB_ERR_PARSE, "header");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(tables_are_close_to_the_model),    TEST(batches_equal_single_calls),
      TEST(nearest_is_the_files_own_number),  TEST(any_direction_is_answered),
      TEST(samples_follow_their_density),     TEST(samples_are_of_the_whole_bsdf),
      TEST(paths_have_their_own_wavelengths), TEST(albedos_are_the_models),
      TEST(folded_tables_keep_their_energy),  TEST(merl_tables_are_as_good_as_exact_centres),
      TEST(the_specular_delta_is_apart),      TEST(rgl_tables_open_too),
      TEST(black_tables_stay_black),          TEST(absurd_numbers_stay_numbers),
      TEST(damaged_merl_files_are_refused),   TEST(damaged_h5_files_are_refused),
      TEST(other_files_are_refused),          TEST(damaged_specular_files_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
