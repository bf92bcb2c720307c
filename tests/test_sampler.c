/* The exact sampler: its densities against what it draws, its weights against the reference's
 * hemispherical reflectances. */
#include "degrees.h"
#include "golden_support.h"

#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include "model/model.h"
#include "model/lobe.h"

/* Al at 550 nm. */
static const double N_AL = 0.958, K_AL = 6.69, LAMBDA_UM = 0.55;

static const struct {
  const char *name;
  double sigma0_um, tau_um;
} surfaces[] = {{"BBQAL1", 0.72, 5.6},  {"BBQAL2", 0.54, 6.5}, {"GGAL120", 0.86, 5.6},
                {"GGAL240", 0.61, 4.7}, {"NGGAL", 0.13, 5.4},  {"needle", 0.05, 60},
                {"subwave", 0.05, 0.3}, {"slope 1", 1, 1}};
static const double incidences[] = {0, DEG(30), DEG(60), DEG(80), DEG(85), DEG(89)};
enum {
  SURFACES = sizeof surfaces / sizeof *surfaces,
  INCIDENCES = sizeof incidences / sizeof *incidences,
  CASES = SURFACES * INCIDENCES
};

static hetab_surface *surface_of(hetab_context *ctx, double sigma0_um, double tau_um) {
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_create(ctx, sigma0_um, tau_um, N_AL, K_AL, &LAMBDA_UM, 1, &surface));
  return surface;
}

static hetab_model_sampler *sampler_of(hetab_context *ctx, double sigma0_um, double tau_um) {
  hetab_surface *surface = surface_of(ctx, sigma0_um, tau_um);
  hetab_model_sampler *sampler;
  assert_ok(ctx, hetab_model_sampler_create(ctx, surface, 0, &sampler));
  hetab_surface_free(surface);
  return sampler;
}

/* Of the mirror direction: neither axis of the plane is special. phi is counted from it. */
static const double AZIMUTH = 2.1;

static void direction(double theta, double phi, double out[3]) {
  out[0] = sin(theta) * cos(phi + AZIMUTH);
  out[1] = sin(theta) * sin(phi + AZIMUTH);
  out[2] = cos(theta);
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- many samples, on two threads with one sampler ------------------------------------------ */

enum { THREADS = 2 };

typedef struct run {
  const hetab_model_sampler *sampler;
  double wi[3];
  size_t count;
  uint64_t seed;
  double (*angles)[2]; /* theta_r and phi, or NULL: weights; theta_r < 0: no sample */
  double sum, sum2, most;
  size_t kept;
} run;

static void *run_thread(void *user) {
  run *r = user;
  for (size_t i = 0; i < r->count; i++) {
    double u[3], wo[3], weight;
    for (int k = 0; k < 3; k++)
      u[k] = uniform(&r->seed, 0, 1);
    double density =
        hetab_model_sampler_sample(r->sampler, r->wi, u, wo, r->angles ? NULL : &weight);
    r->kept += density > 0;
    if (r->angles) {
      r->angles[i][0] = density > 0 ? atan2(hypot(wo[0], wo[1]), wo[2]) : -1;
      r->angles[i][1] = remainder(atan2(wo[1], wo[0]) - AZIMUTH, 2 * M_PI);
    } else {
      r->sum += weight;
      r->sum2 += weight * weight;
      r->most = fmax(r->most, weight);
    }
  }
  return NULL;
}

static run run_all(const hetab_model_sampler *sampler, double theta_i, size_t count, uint64_t seed,
                   double (*angles)[2]) {
  run parts[THREADS], all = {0};
  pthread_t threads[THREADS];
  for (size_t t = 0; t < THREADS; t++) {
    parts[t] = (run){.sampler = sampler,
                     .count = count / THREADS,
                     .seed = (seed * THREADS + t + 1) * 0x9E3779B97F4A7C15u};
    parts[t].angles = angles ? angles + t * parts[t].count : NULL;
    direction(theta_i, M_PI, parts[t].wi);
    assert_int_equal(pthread_create(&threads[t], NULL, run_thread, &parts[t]), 0);
  }
  for (size_t t = 0; t < THREADS; t++) {
    pthread_join(threads[t], NULL);
    all.sum += parts[t].sum;
    all.sum2 += parts[t].sum2;
    all.most = fmax(all.most, parts[t].most);
    all.kept += parts[t].kept;
  }
  all.count = parts[0].count * THREADS;
  return all;
}

/* ---- chi-square ----------------------------------------------------------------------------- */

enum { SIDE = 20, CELLS = SIDE * SIDE, PILOT = 20000, SAMPLES = 1000000 };
static const double SIGNIFICANCE = 0.01;
/* of all cells together; measured 1.1e-5 */
static const double INTEGRATION_ERROR = 5e-5;

typedef struct cells {
  const hetab_model_sampler *sampler;
  double wi[3];
  double theta[SIDE + 1], phi[SIDE + 1];
  double share[CELLS + 1]; /* of the samples: [theta][phi], and none */
} cells;

/* 4 x 4 Gauss-Legendre points of the density over intervals of theta_r and phi. */
static double gauss_rule(const cells *c, const double t[2], const double p[2]) {
  static const double x[4] = {-0.861136311594053, -0.339981043584856, 0.339981043584856,
                              0.861136311594053};
  static const double w[4] = {0.347854845137454, 0.652145154862546, 0.652145154862546,
                              0.347854845137454};
  double sum = 0, half_t = 0.5 * (t[1] - t[0]), half_p = 0.5 * (p[1] - p[0]), wo[3];
  for (int i = 0; i < 4; i++) {
    double theta = t[0] + half_t * (1 + x[i]);
    for (int j = 0; j < 4; j++) {
      direction(theta, p[0] + half_p * (1 + x[j]), wo);
      sum += w[i] * w[j] * sin(theta) * hetab_model_sampler_pdf(c->sampler, c->wi, wo);
    }
  }
  return sum * half_t * half_p;
}

/* Halved both ways until that changes it by a hundredth of the standard deviation of the samples in
 * it, twice in a row: where a density has a step, once may be luck. */
static double integral(const cells *c, const double t[2], const double p[2], double whole,
                       int agreed, int depth) {
  double ts[3] = {t[0], 0.5 * (t[0] + t[1]), t[1]}, ps[3] = {p[0], 0.5 * (p[0] + p[1]), p[1]};
  double parts[4], sum = 0;
  for (int i = 0; i < 4; i++)
    sum += parts[i] = gauss_rule(c, ts + i / 2, ps + i % 2);
  int agrees = fabs(sum - whole) <= 0.01 * sqrt((sum + 1e-6) / SAMPLES);
  if ((agrees && agreed) || depth == 0)
    return sum;
  sum = 0;
  for (int i = 0; i < 4; i++)
    sum += integral(c, ts + i / 2, ps + i % 2, parts[i], agrees, depth - 1);
  return sum;
}

/* The outermost cells reach far beyond the lobe: from the lobe's side on in pieces that double. */
enum { MOST_PIECES = 48 };

static size_t pieces(const double *at, size_t i, double *out) {
  double length = at[i + 1] - at[i], distance[MOST_PIECES];
  double step = fmax(i == 0 ? at[2] - at[1] : at[i] - at[i - 1], 1e-6 * length), from = step;
  size_t count = 0;
  for (; (i == 0 || i == SIDE - 1) && from < length && count < MOST_PIECES - 2; from += step *= 2)
    distance[count++] = from;
  out[0] = at[i];
  for (size_t k = 0; k < count; k++)
    out[k + 1] = i == 0 ? at[1] - distance[count - 1 - k] : at[i] + distance[k];
  out[count + 1] = at[i + 1];
  return count + 2;
}

static double cell_integral(const cells *c, size_t t, size_t p) {
  double theta[MOST_PIECES], phi[MOST_PIECES], sum = 0;
  size_t thetas = pieces(c->theta, t, theta), phis = pieces(c->phi, p, phi);
  for (size_t i = 0; i + 1 < thetas; i++)
    for (size_t j = 0; j + 1 < phis; j++)
      sum += integral(c, theta + i, phi + j, gauss_rule(c, theta + i, phi + j), 0, 10);
  return sum;
}

typedef struct cell_rows {
  cells *cells;
  size_t first;
} cell_rows;

static void *integrate_rows(void *user) {
  cell_rows *rows = user;
  for (size_t t = rows->first; t < SIDE; t += THREADS)
    for (size_t p = 0; p < SIDE; p++)
      rows->cells->share[t * SIDE + p] = cell_integral(rows->cells, t, p);
  return NULL;
}

/* The density's integral over every cell; returns that over all. */
static double integrate(cells *c) {
  pthread_t threads[THREADS];
  cell_rows rows[THREADS];
  double total = 0;
  for (size_t i = 0; i < THREADS; i++) {
    rows[i] = (cell_rows){c, i};
    assert_int_equal(pthread_create(&threads[i], NULL, integrate_rows, &rows[i]), 0);
  }
  for (size_t i = 0; i < THREADS; i++)
    pthread_join(threads[i], NULL);
  for (size_t i = 0; i < CELLS; i++)
    total += c->share[i];
  c->share[CELLS] = fmax(1 - total, 0);
  return total;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Edges with as many of the pilot's samples between any two. */
static void edges(double (*pilot)[2], int axis, double low, double high, double *out) {
  static double values[PILOT];
  size_t count = 0;
  for (size_t i = 0; i < PILOT; i++)
    if (pilot[i][0] >= 0)
      values[count++] = pilot[i][axis];
  qsort(values, count, sizeof *values, ascending);
  out[0] = low;
  out[SIDE] = high;
  for (size_t i = 1; i < SIDE; i++)
    out[i] = values[i * count / SIDE];
}

static size_t interval(const double *at, double value) {
  size_t i = 0;
  while (i < SIDE - 1 && value >= at[i + 1])
    i++;
  return i;
}

/* The probability of a chi-square variable of so many degrees of freedom to exceed it: Wilson and
 * Hilferty. */
static double tail(double chi2, double freedom) {
  double v = 2 / (9 * freedom);
  return 0.5 * erfc((cbrt(chi2 / freedom) - (1 - v)) / sqrt(2 * v));
}

/* Cells with few samples expected are taken together. */
static double p_value(const double *share, const double *found, size_t count) {
  double chi2 = 0, rest_expected = 0, rest_found = 0, freedom = -1;
  for (size_t i = 0; i < count; i++) {
    double expected = share[i] * SAMPLES, excess = found[i] - expected;
    if (expected >= 10) {
      chi2 += excess * excess / expected;
      freedom++;
    } else {
      rest_expected += expected;
      rest_found += found[i];
    }
  }
  if (rest_expected >= 10) {
    chi2 += (rest_found - rest_expected) * (rest_found - rest_expected) / rest_expected;
    freedom++;
  } else if (rest_found > 60) {
    return 0;
  }
  return tail(chi2, freedom);
}

/* p of one sampler and incidence; *kept: the share of the samples that is, *total: what the
 * density's integral says of it. */
static double chi_square(const hetab_model_sampler *sampler, double theta_i, uint64_t seed,
                         double *kept, double *total) {
  static double angles[SAMPLES][2], found[CELLS + 1];
  cells c = {.sampler = sampler};
  direction(theta_i, M_PI, c.wi);
  run_all(sampler, theta_i, PILOT, seed + 1, angles);
  edges(angles, 0, 0, M_PI_2, c.theta);
  edges(angles, 1, -M_PI, M_PI, c.phi);
  *total = integrate(&c);
  *kept = (double)run_all(sampler, theta_i, SAMPLES, seed, angles).kept / SAMPLES;
  memset(found, 0, sizeof found);
  for (size_t i = 0; i < SAMPLES; i++)
    found[angles[i][0] < 0
              ? CELLS
              : interval(c.theta, angles[i][0]) * SIDE + interval(c.phi, angles[i][1])]++;
  return p_value(c.share, found, CELLS + 1);
}

/* 10^6 samples a case; 0.01 for all cases together, by Sidak's correction. */
static void test_chi_square(void **state) {
  hetab_context *ctx = *state;
  double bound = 1 - pow(1 - SIGNIFICANCE, 1.0 / CASES), least = 1, worst = 0, start = seconds();
  int failed = 0;
  for (int s = 0; s < SURFACES; s++) {
    hetab_model_sampler *sampler = sampler_of(ctx, surfaces[s].sigma0_um, surfaces[s].tau_um);
    print_message("  %-8s p:", surfaces[s].name);
    for (int a = 0; a < INCIDENCES; a++) {
      double kept, total;
      double p = chi_square(sampler, incidences[a], 1000 + 10 * (uint64_t)a, &kept, &total);
      print_message(" %.3f (%.0f deg, %.3f kept)", p, hetab_degrees(incidences[a]), kept);
      failed += !(p > bound);
      least = fmin(least, p);
      double deviation = sqrt(total * fabs(1 - total) / SAMPLES);
      worst = fmax(worst, fabs(kept - total) / (3.5 * deviation + INTEGRATION_ERROR));
    }
    print_message("\n");
    hetab_model_sampler_free(sampler);
  }
  print_message("  %d cases in %.1f s: least p %.4f (%.1e)\n", CASES, seconds() - start, least,
                bound);
  assert_int_equal(failed, 0);
  assert_below("kept, against the integral", worst, 1);
}

/* A density that is a per cent off in a part of its range is found: the test can fail. */
static void test_chi_square_power(void **state) {
  enum { COUNT = 100 };
  double share[COUNT], found[COUNT];
  for (int i = 0; i < COUNT; i++) {
    share[i] = 1.0 / COUNT;
    found[i] = share[i] * SAMPLES * (i % 2 ? 1.015 : 0.985);
  }
  assert_true(p_value(share, found, COUNT) < 1e-4);
  assert_true(fabs(tail(123.2252, 100) - 0.0573) < 2e-4); /* of tables: 124.342 is 0.05 */
  assert_true(fabs(tail(124.342, 100) - 0.05) < 1e-4);
}

/* ---- weights -------------------------------------------------------------------------------- */

/* Three standard errors, and what a sampler is judged by. */
static void check_mean(const char *name, double theta_i, const run *r, double expected,
                       double *worst) {
  double n = (double)r->count, mean = r->sum / n;
  double deviations = (mean - expected) / sqrt((r->sum2 / n - mean * mean) / n);
  print_message("  %-8s %5.1f deg  rho_dd %.6f, mean %.6f (%+.2f), effective %.2f, mean / max "
                "%.2f, kept %.3f\n",
                name, theta_i * 180 / M_PI, expected, mean, deviations, mean * mean * n / r->sum2,
                mean / r->most, (double)r->kept / n);
  *worst = fmax(*worst, fabs(deviations));
}

static void test_mean_weight_golden(void **state) {
  enum { COUNT = 60000 };
  hetab_context *ctx = *state;
  size_t count;
  golden_reflectance *golden = golden_reflectances(&count);
  double worst = 0;
  for (size_t i = 0; i < count; i++) {
    const hetab_point *p = &golden[i].point;
    hetab_surface *surface;
    hetab_model_sampler *sampler;
    assert_ok(ctx, hetab_surface_create(ctx, p->sigma0_um, p->tau_um, p->n, p->k, &p->lambda_um, 1,
                                        &surface));
    assert_ok(ctx, hetab_model_sampler_create(ctx, surface, 0, &sampler));
    run r = run_all(sampler, p->theta_i, COUNT, 31 * i, NULL);
    check_mean(golden[i].name, p->theta_i, &r, golden[i].rho_dd, &worst);
    hetab_model_sampler_free(sampler);
    hetab_surface_free(surface);
  }
  assert_below("standard errors", worst, 3);
  free(golden);
}

/* The same up to 89 degrees, against the integrals of the device. */
static void test_mean_weight(void **state) {
  enum { COUNT = 60000 };
  hetab_context *ctx = *state;
  hetab_engine *engine = new_engine(ctx, HETAB_DOUBLE, HETAB_METHOD_SERIES, 0);
  double worst = 0;
  for (int s = 0; s < SURFACES; s++) {
    hetab_surface *surface = surface_of(ctx, surfaces[s].sigma0_um, surfaces[s].tau_um);
    hetab_model_sampler *sampler = sampler_of(ctx, surfaces[s].sigma0_um, surfaces[s].tau_um);
    hetab_reflectance rho[INCIDENCES];
    assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, incidences, INCIDENCES, 0, rho));
    for (int a = 0; a < INCIDENCES; a++) {
      double theta_i = incidences[a];
      run r = run_all(sampler, theta_i, COUNT, (uint64_t)(100 * s + a), NULL);
      check_mean(surfaces[s].name, theta_i, &r, rho[a].dd.value, &worst);
    }
    hetab_model_sampler_free(sampler);
    hetab_surface_free(surface);
  }
  assert_below("standard errors", worst, 3);
  hetab_engine_free(engine);
}

/* All bands by the samples of one; a diffuse part too. */
static void test_bands(void **state) {
  enum { COUNT = 20000, MOST_BANDS = 31 };
  static const char yaml[] = "name: painted\nsigma0_um: 0.2\ntau_um: 4\nindex: Al\n"
                             "diffuse_reflectance: 0.1\nwavelengths_nm: 400:700:60\n";
  hetab_context *ctx = *state;
  hetab_engine *engine = new_engine(ctx, HETAB_DOUBLE, HETAB_METHOD_SERIES, 0);
  hetab_surface *surface;
  hetab_model_sampler *sampler;
  char path[] = "/tmp/hetab_sampler_XXXXXX.yml";
  int fd = mkstemps(path, 4);
  assert_true(fd >= 0 && write(fd, yaml, sizeof yaml - 1) == (ssize_t)(sizeof yaml - 1));
  close(fd);
  assert_ok(ctx, hetab_surface_load(ctx, path, &surface));
  unlink(path);
  size_t bands = hetab_surface_band_count(surface);
  assert_ok(ctx, hetab_model_sampler_create(ctx, surface, bands / 2, &sampler));
  assert_int_equal(hetab_model_sampler_band_count(sampler), bands);
  const double theta_i = DEG(50);
  hetab_reflectance rho[MOST_BANDS];
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, &theta_i, 1, 0, rho));
  double sum[MOST_BANDS] = {0}, sum2[MOST_BANDS] = {0}, weight[MOST_BANDS], wi[3], wo[3], worst = 0;
  uint64_t seed = 5;
  direction(theta_i, 0, wi);
  for (int i = 0; i < COUNT; i++) {
    double u[3] = {uniform(&seed, 0, 1), uniform(&seed, 0, 1), uniform(&seed, 0, 1)};
    hetab_model_sampler_sample(sampler, wi, u, wo, weight);
    for (size_t b = 0; b < bands; b++) {
      sum[b] += weight[b];
      sum2[b] += weight[b] * weight[b];
    }
  }
  double specular[MOST_BANDS];
  hetab_model_sampler_specular(sampler, wi, specular);
  for (size_t b = 0; b < bands; b++) {
    double mean = sum[b] / COUNT, error = sqrt((sum2[b] / COUNT - mean * mean) / COUNT);
    double expected = rho[b].dd.value + 0.1;
    print_message("  band %zu: effective %.2f\n", b, mean * mean * COUNT / sum2[b]);
    worst = fmax(worst, fabs(mean - expected) / error);
    assert_true(relative_error(specular[b], rho[b].specular) < 1e-12);
  }
  assert_below("standard errors", worst, 3);
  hetab_model_sampler_free(sampler);
  hetab_surface_free(surface);
  hetab_engine_free(engine);
}

/* A hero in the middle serves 400 to 700 nm: smooth surfaces are the hard ones. */
static void test_hero(void **state) {
  enum { COUNT = 20000, BANDS = 3 };
  static const double lambda_um[BANDS] = {0.4, 0.55, 0.7}, sigmas[] = {0.02, 0.05, 0.13, 0.3};
  hetab_context *ctx = *state;
  uint64_t seed = 6;
  double least = 1;
  for (int s = 0; s < 4; s++) {
    hetab_surface *surface;
    hetab_model_sampler *sampler;
    assert_ok(ctx, hetab_surface_create(ctx, sigmas[s], 4, N_AL, K_AL, lambda_um, BANDS, &surface));
    assert_ok(ctx, hetab_model_sampler_create(ctx, surface, 1, &sampler));
    for (int deg = 30; deg <= 80; deg += 50) {
      double sum[BANDS] = {0}, sum2[BANDS] = {0}, wi[3], wo[3], weight[BANDS];
      direction(deg * M_PI / 180, 0, wi);
      for (int i = 0; i < COUNT; i++) {
        double u[3] = {uniform(&seed, 0, 1), uniform(&seed, 0, 1), uniform(&seed, 0, 1)};
        hetab_model_sampler_sample(sampler, wi, u, wo, weight);
        for (int b = 0; b < BANDS; b++) {
          sum[b] += weight[b];
          sum2[b] += weight[b] * weight[b];
        }
      }
      print_message(
          "  sigma0 %.2f, %d deg, 550 nm sampled; effective at 400, 550, 700 nm:", sigmas[s], deg);
      for (int b = 0; b < BANDS; b++) {
        double effective = sum[b] * sum[b] / sum2[b] / COUNT;
        least = fmin(least, effective);
        print_message(" %.2f", effective);
      }
      print_message("\n");
    }
    hetab_model_sampler_free(sampler);
    hetab_surface_free(surface);
  }
  assert_true(least > 0.5);
}

/* ---- values --------------------------------------------------------------------------------- */

/* Against the literal equations, and densities as sampled against densities as asked for. */
static void test_eval(void **state) {
  enum { COUNT = 400 };
  hetab_context *ctx = *state;
  uint64_t seed = 3;
  worst w = {0};
  double worst_density = 0;
  for (int s = 0; s < SURFACES; s++) {
    hetab_model_sampler *sampler = sampler_of(ctx, surfaces[s].sigma0_um, surfaces[s].tau_um);
    for (size_t i = 0; i < COUNT; i++) {
      hetab_point p = {.lambda_um = LAMBDA_UM,
                       .sigma0_um = surfaces[s].sigma0_um,
                       .tau_um = surfaces[s].tau_um,
                       .n = N_AL,
                       .k = K_AL,
                       .theta_i = uniform(&seed, 0, 1.56)};
      double wi[3], wo[3], value, weight, u[3];
      for (int k = 0; k < 3; k++)
        u[k] = uniform(&seed, 0, 1);
      direction(p.theta_i, 0, wi);
      double density = hetab_model_sampler_sample(sampler, wi, u, wo, &weight);
      if (density == 0)
        continue;
      hetab_value literal;
      p.theta_r = atan2(hypot(wo[0], wo[1]), wo[2]);
      p.phi = atan2(wo[1], wo[0]) - AZIMUTH;
      assert_ok(ctx, hetab_evaluate_literal(ctx, &p, 1, &literal));
      hetab_model_sampler_eval(sampler, wi, wo, &value);
      worst_add(&w, i, value, literal.total);
      worst_density =
          fmax(worst_density, relative_error(hetab_model_sampler_pdf(sampler, wi, wo), density));
      assert_true(relative_error(weight * density, value * wo[2]) < 1e-9);
    }
    hetab_model_sampler_free(sampler);
  }
  assert_worst("eval against the literal equations", &w, TOL_SAMPLER_EVAL, TOL_BELOW_FLOOR);
  assert_below("density asked for", worst_density, TOL_SAMPLER_DENSITY);
}

/* A lobe of the series: its density against the series itself, and against the sum of the Gaussians
 * that are drawn. */
static void test_lobe(void **state) {
  static const double gs[] = {1e-6, 0.03, 0.7, 5, 39.9, 40.1, 43, 300, 2000};
  static hetab_lobe lobe;
  double worst_series = 0, worst_sum = 0;
  uint64_t seed = 8;
  for (size_t i = 0; i < sizeof gs / sizeof *gs; i++) {
    double wave_x = log_uniform(&seed, 3, 1e5), top = hetab_ln_h(gs[i], 0);
    hetab_lobe_series(&lobe, gs[i], wave_x);
    for (int k = 0; k < 1000; k++) {
      double root = uniform(&seed, 0, lobe.end), x = root * root, ln_h = hetab_ln_h(gs[i], x);
      /* far enough from the rim for the image of the sample to be on the disc */
      hetab_lobe_pair pair = {1, 0, sqrt(fmax(1 - x / wave_x, 0)), x / wave_x};
      if (ln_h < top - 90 || 2 * (1 - pair.lateral2) <= pair.mu_r * pair.mu_r || !(pair.mu_r > 0))
        continue;
      double density = hetab_lobe_density(&lobe, &pair) / pair.mu_r, sum = 0;
      double series = wave_x / M_PI * gs[i] / -expm1(-gs[i]) * exp(ln_h);
      worst_series = fmax(worst_series, relative_error(density, series));
      for (size_t m = 0; m < lobe.terms; m++) {
        double share = lobe.cumulative[m] - (m ? lobe.cumulative[m - 1] : 0);
        sum += share * wave_x / (M_PI * lobe.m[m]) * exp(-x / lobe.m[m]);
      }
      if (ln_h > top - 25)
        worst_sum = fmax(worst_sum, relative_error(sum, series));
    }
  }
  assert_below("density against the series", worst_series, TOL_SAMPLER_LOBE);
  assert_below("Gaussians against the series", worst_sum, TOL_SAMPLER_TERMS);
}

static void test_edges(void **state) {
  hetab_context *ctx = *state;
  hetab_model_sampler *sampler = sampler_of(ctx, 0.13, 5.4);
  const double up[3] = {0, 0, 1}, flat[3] = {1, 0, 0}, below[3] = {0.6, 0, -0.8};
  const double ends[][3] = {
      {0, 0, 0}, {1 - 0x1p-53, 1 - 0x1p-53, 1 - 0x1p-53}, {0.5, 1 - 0x1p-53, 0}};
  double wo[3], weight = 7;
  assert_true(hetab_model_sampler_sample(sampler, flat, ends[0], wo, &weight) == 0 && weight == 0);
  assert_true(hetab_model_sampler_sample(sampler, below, ends[0], wo, NULL) == 0);
  assert_true(hetab_model_sampler_pdf(sampler, up, below) == 0);
  assert_true(hetab_model_sampler_pdf(sampler, flat, up) == 0);
  hetab_model_sampler_eval(sampler, up, below, &weight);
  assert_true(weight == 0);
  hetab_model_sampler_specular(sampler, flat, &weight);
  assert_true(weight == 0);
  for (int i = 0; i < 3; i++)
    for (double theta = 0; theta < 1.5707; theta += 0.01) {
      double wi[3];
      direction(theta, 0, wi);
      double density = hetab_model_sampler_sample(sampler, wi, ends[i], wo, &weight);
      assert_true(isfinite(density) && isfinite(weight) && weight >= 0 && density >= 0);
      assert_true(fabs(wo[0] * wo[0] + wo[1] * wo[1] + wo[2] * wo[2] - 1) < 1e-12);
    }
  hetab_model_sampler_free(sampler);
}

static void test_bad_input(void **state) {
  const char *const band[] = {"band 1", "0 to 0", NULL}, *const rough[] = {"sigma0 / lambda", NULL};
  hetab_context *ctx = *state;
  hetab_surface *surface = surface_of(ctx, 0.13, 5.4), *wild = surface_of(ctx, 1e4, 1e5);
  hetab_model_sampler *sampler = (void *)ctx;
  assert_fails(ctx, hetab_model_sampler_create(ctx, surface, 1, &sampler), HETAB_ERR_ARGUMENT,
               band);
  assert_null(sampler);
  assert_fails(ctx, hetab_model_sampler_create(ctx, wild, 0, &sampler), HETAB_ERR_ARGUMENT, rough);
  hetab_model_sampler_free(NULL);
  hetab_surface_free(surface);
  hetab_surface_free(wild);
}

/* Printed alone: a busy machine decides nothing. */
static void test_speed(void **state) {
  enum { COUNT = 100000 };
  hetab_context *ctx = *state;
  for (int s = 0; s < SURFACES; s++) {
    double start = seconds();
    hetab_model_sampler *sampler = sampler_of(ctx, surfaces[s].sigma0_um, surfaces[s].tau_um);
    double made = seconds() - start, wi[3], wo[3], weight, sum = 0, times[2];
    uint64_t seed = 1;
    for (int weights = 0; weights < 2; weights++) {
      start = seconds();
      for (int i = 0; i < COUNT; i++) {
        double u[3] = {uniform(&seed, 0, 1), uniform(&seed, 0, 1), uniform(&seed, 0, 1)};
        direction(i % 90 * M_PI / 180, 0, wi);
        sum += hetab_model_sampler_sample(sampler, wi, u, wo, weights ? &weight : NULL);
      }
      times[weights] = seconds() - start;
    }
    assert_true(isfinite(sum));
    print_message("  %-8s made in %.3f s, %.1f M samples/s, %.1f M with weights, one core\n",
                  surfaces[s].name, made, COUNT / times[0] / 1e6, COUNT / times[1] / 1e6);
    hetab_model_sampler_free(sampler);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_chi_square),
      TEST(test_chi_square_power),
      TEST(test_mean_weight_golden),
      TEST(test_mean_weight),
      TEST(test_bands),
      TEST(test_hero),
      TEST(test_eval),
      TEST(test_lobe),
      TEST(test_edges),
      TEST(test_bad_input),
      TEST(test_speed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
