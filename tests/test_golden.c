/* The device against 40-digit values, and the hard cases by name against the literal reference. */
#include "golden_support.h"

#include "engine/points.h"
#include "model/model.h"

static const char *precision_name(hetab_precision precision) {
  return hetab_precision_name(precision);
}

static double dd_bound(hetab_precision precision) {
  return precision == HETAB_FLOAT ? TOL_GOLDEN_FLOAT : TOL_GOLDEN_DOUBLE;
}

/* --- golden points --------------------------------------------------------------------------- */

static void check_points(hetab_context *ctx, hetab_precision precision) {
  size_t count;
  golden_point *golden = golden_points(&count);
  hetab_point *points = calloc(2 * count, sizeof *points);
  worst dd = {0};
  double worst_g = 0, worst_x = 0;
  assert_int_equal(count, 358);
  for (size_t i = 0; i < count; i++) {
    points[i] = golden[i].point;
    points[count + i] = swapped(golden[i].point);
  }
  hetab_value *values = device_values(ctx, precision, points, 2 * count);
  for (size_t i = 0; i < 2 * count; i++) {
    const golden_point *p = &golden[i % count];
    worst_add(&dd, i, values[i].dd, p->dd);
    worst_g = fmax(worst_g, relative_error(values[i].g, p->g));
    /* x vanishes at the mirror direction, where the double nearest to an angle is not the angle */
    worst_x = fmax(worst_x, fabs(values[i].x - p->x) / fmax(p->x, 1e-6));
    assert_true(values[i].total == values[i].dd && values[i].ud == 0);
  }
  print_message("%s: worst dd at case %s\n", precision_name(precision), golden[dd.at % count].name);
  assert_worst("dd", &dd, dd_bound(precision), TOL_BELOW_FLOOR);
  assert_below("g", worst_g, precision == HETAB_FLOAT ? TOL_GX_FLOAT : TOL_GX_DOUBLE);
  assert_below("x", worst_x, precision == HETAB_FLOAT ? TOL_GX_FLOAT : TOL_GX_DOUBLE);
  free(values);
  free(points);
  free(golden);
}

static void test_points_float(void **state) {
  check_points(*state, HETAB_FLOAT);
}

static void test_points_double(void **state) {
  check_points(*state, HETAB_DOUBLE);
}

/* The factors, from the host's double copy of the shared source. */
static void test_factors(void **state) {
  size_t count;
  golden_point *golden = golden_points(&count);
  double fresnel = 0, shadow = 0, ratio = 0;
  for (size_t i = 0; i < count; i++) {
    const golden_point *p = &golden[i];
    const hetab_point *q = &p->point;
    double tau_2sigma = q->tau_um / (2 * q->sigma0_um);
    hetab_direction in = hetab_direction_at(q->theta_i, tau_2sigma);
    hetab_direction out = hetab_direction_at(q->theta_r, tau_2sigma);
    hetab_pair pair = hetab_pair_of(&in, &out);
    double cos2 = (pair.mu2 + pair.d2 + pair.p * hetab_one_plus_cos(q->phi)) / 4;
    fresnel =
        fmax(fresnel, relative_error(hetab_fresnel_at(fmin(cos2, 1), q->n, q->k), p->fresnel));
    shadow = fmax(shadow, relative_error(in.shadow_over_cos * in.mu, p->shadow_i));
    shadow = fmax(shadow, relative_error(out.shadow_over_cos * out.mu, p->shadow_r));
    ratio = fmax(ratio, relative_error(sqrt(pair.ratio2), p->sigma_ratio));
  }
  assert_below("|F|^2", fresnel, TOL_FACTORS);
  assert_below("S", shadow, TOL_FACTORS);
  assert_below("sigma / sigma0", ratio, TOL_FACTORS);
  free(golden);
}

static void check_reflectances(hetab_context *ctx, hetab_precision precision) {
  size_t count;
  golden_reflectance *golden = golden_reflectances(&count);
  hetab_point *points = calloc(count, sizeof *points);
  double relative = 0, absolute = 0, fresnel = 0;
  assert_int_equal(count, 50);
  for (size_t i = 0; i < count; i++)
    points[i] = golden[i].point;
  hetab_value *values = device_values(ctx, precision, points, count);
  for (size_t i = 0; i < count; i++) {
    double rho_s = golden[i].rho_s, cosine = cos(points[i].theta_i);
    assert_true(isfinite(values[i].specular) && values[i].specular >= 0);
    if (rho_s >= TOL_SPECULAR_FLOOR)
      relative = fmax(relative, relative_error(values[i].specular, rho_s));
    else
      absolute = fmax(absolute, fabs(values[i].specular - rho_s));
    fresnel =
        fmax(fresnel, relative_error(hetab_fresnel_at(cosine * cosine, points[i].n, points[i].k),
                                     golden[i].fresnel));
  }
  assert_below(precision_name(precision), relative, dd_bound(precision));
  assert_below("rho_s below its floor", absolute, TOL_SPECULAR_FLOOR);
  assert_below("|F|^2", fresnel, TOL_FACTORS);
  free(values);
  free(points);
  free(golden);
}

static void test_specular_float(void **state) {
  check_reflectances(*state, HETAB_FLOAT);
}

static void test_specular_double(void **state) {
  check_reflectances(*state, HETAB_DOUBLE);
}

/* hetab_specular_reflectance, which the tables take, through a surface of one wavelength. */
static void test_specular_of_surface(void **state) {
  size_t count;
  golden_reflectance *golden = golden_reflectances(&count);
  double relative = 0;
  for (size_t i = 0; i < count; i++) {
    const hetab_point *p = &golden[i].point;
    hetab_surface *surface;
    double rho_s;
    assert_ok(*state, hetab_surface_create(*state, p->sigma0_um, p->tau_um, p->n, p->k,
                                           &p->lambda_um, 1, &surface));
    assert_ok(*state, hetab_specular_reflectance(*state, surface, &p->theta_i, 1, &rho_s));
    relative = fmax(relative, relative_error(rho_s, golden[i].rho_s));
    hetab_surface_free(surface);
  }
  assert_below("rho_s", relative, TOL_GOLDEN_DOUBLE);
  free(golden);
}

/* --- one surface at many places -------------------------------------------------------------- */

enum { PLACES = 13200 /* more than a batch of the bands */, BANDS = 5 };

/* dd + ud of every band at every place, and the bands' weighted sums, against the literal
 * reference. */
static void check_places(hetab_context *ctx, hetab_precision precision) {
  static hetab_point points[PLACES * BANDS];
  static hetab_directions at[PLACES];
  static double spectra[PLACES][BANDS], sums[PLACES][3];
  hetab_band bands[BANDS];
  double weights[BANDS][3];
  uint64_t r = 3;
  for (size_t b = 0; b < BANDS; b++) {
    bands[b] = (hetab_band){0.4 + 0.07 * (double)b, 0.9 + 0.1 * (double)b, 6.0, 0.01 * (double)b};
    for (int c = 0; c < 3; c++)
      weights[b][c] = uniform(&r, 0, 1);
  }
  for (size_t i = 0; i < PLACES; i++) {
    hetab_point p = {.theta_i = uniform(&r, 0, 1.5), .sigma0_um = 0.3, .tau_um = 3.0};
    p.theta_r = i % 3 ? fmin(p.theta_i + uniform(&r, -0.1, 0.1), 1.5) : uniform(&r, 0, 1.5);
    p.theta_r = fmax(p.theta_r, 0);
    p.phi = i % 3 ? M_PI - uniform(&r, 0, 0.1) : uniform(&r, 0, M_PI);
    at[i] = (hetab_directions){p.theta_i, p.theta_r, p.phi};
    for (size_t b = 0; b < BANDS; b++) {
      p.lambda_um = bands[b].lambda_um;
      p.n = bands[b].n;
      p.k = bands[b].k;
      p.diffuse_brdf = bands[b].diffuse_brdf;
      points[i * BANDS + b] = p;
    }
  }
  hetab_engine *engine = new_engine(ctx, precision, HETAB_METHOD_SERIES, 0);
  hetab_places *places;
  assert_ok(ctx, hetab_places_create(ctx, engine, &places));
  assert_ok(ctx, hetab_places_evaluate(ctx, places, 0.3, 3.0, bands, BANDS, NULL, at, PLACES,
                                       spectra[0]));
  assert_ok(ctx, hetab_places_evaluate(ctx, places, 0.3, 3.0, bands, BANDS,
                                       (const double(*)[3])weights, at, PLACES, sums[0]));
  hetab_places_free(places);
  hetab_engine_free(engine);
  hetab_value *reference = literal_values(ctx, points, PLACES * BANDS);
  worst bands_worst = {0}, sums_worst = {0};
  for (size_t i = 0; i < PLACES; i++)
    for (size_t c = 0; c < 3; c++) {
      double sum = 0;
      for (size_t b = 0; b < BANDS; b++) {
        sum += weights[b][c] * reference[i * BANDS + b].total;
        worst_add(&bands_worst, i, spectra[i][b], reference[i * BANDS + b].total);
      }
      worst_add(&sums_worst, i, sums[i][c], sum);
    }
  assert_worst("bands", &bands_worst, dd_bound(precision), TOL_BELOW_FLOOR);
  assert_worst("channels", &sums_worst, dd_bound(precision), TOL_BELOW_FLOOR);
  free(reference);
}

static void test_places_float(void **state) {
  check_places(*state, HETAB_FLOAT);
}

static void test_places_double(void **state) {
  check_places(*state, HETAB_DOUBLE);
}

/* --- hard cases ------------------------------------------------------------------------------ */

/* Compare points with the literal reference in both precisions; below its own error nothing is
 * asked of the double build. */
static void check_against_literal(hetab_context *ctx, const hetab_point *points, size_t count,
                                  double float_bound) {
  hetab_value *reference = literal_values(ctx, points, count);
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_value *values = device_values(ctx, (hetab_precision)precision, points, count);
    worst dd = {0}, specular = {0};
    for (size_t i = 0; i < count; i++) {
      worst_add(&dd, i, values[i].dd, reference[i].dd);
      worst_add(&specular, i, values[i].specular, reference[i].specular);
      assert_true(isfinite(values[i].g) && values[i].g >= 0);
      assert_true(isfinite(values[i].x) && values[i].x >= 0);
    }
    double bound = precision == HETAB_FLOAT ? float_bound : TOL_LITERAL;
    if (dd.relative > bound) {
      const hetab_point *p = &points[dd.at];
      print_message("  sigma0 %.17g tau %.17g lambda %.17g n %g k %g\n  theta_i %.17g theta_r "
                    "%.17g phi %.17g: %.17g, reference %.17g\n",
                    p->sigma0_um, p->tau_um, p->lambda_um, p->n, p->k, p->theta_i, p->theta_r,
                    p->phi, values[dd.at].dd, reference[dd.at].dd);
    }
    assert_worst(precision_name((hetab_precision)precision), &dd, bound, TOL_BELOW_FLOOR);
    assert_worst("specular", &specular, bound, TOL_BELOW_FLOOR);
    free(values);
  }
  free(reference);
}

/* A metal, a dielectric, or a dielectric that absorbs. */
static void random_index(uint64_t *r, hetab_point *p) {
  double kind = uniform(r, 0, 3);
  p->n = kind < 1 ? log_uniform(r, 0.04, 5) : uniform(r, 1.2, 4);
  p->k = kind < 1 ? uniform(r, 1, 10) : kind < 2 ? 0 : log_uniform(r, 1e-3, 1);
}

/* Any roughness with at most g_most, any index, any directions. */
static hetab_point random_point(uint64_t *r, double g_most) {
  hetab_point p = {.lambda_um = uniform(r, 0.35, 1.0),
                   .theta_i = uniform(r, 0, M_PI_2),
                   .theta_r = uniform(r, 0, M_PI_2),
                   .phi = uniform(r, 0, M_PI)};
  random_index(r, &p);
  double g = log_uniform(r, 1e-6, g_most);
  p.sigma0_um = sqrt(g) * p.lambda_um / (4 * M_PI);
  p.tau_um = p.sigma0_um / log_uniform(r, 1e-3, 2);
  return p;
}

/* Turn a random point into one near the lobe, where values are not 0. */
static void aim_at_lobe(uint64_t *r, hetab_point *p) {
  double g = 4 * M_PI * p->sigma0_um / p->lambda_um * cos(p->theta_i);
  double width = p->lambda_um / (M_PI * p->tau_um) * fmax(1, g);
  double off = width * uniform(r, -2, 2), turn = width * uniform(r, 0, 2);
  p->theta_r = fmin(fmax(p->theta_i + off, 0), M_PI_2);
  p->phi = M_PI - fmin(turn / fmax(sin(p->theta_i), 1e-3), M_PI);
}

enum { EACH = 2000 };

static void check_case(hetab_context *ctx, void (*change)(uint64_t *, hetab_point *),
                       double float_bound) {
  hetab_point *points = calloc(EACH, sizeof *points);
  uint64_t r = 1;
  for (size_t i = 0; i < EACH; i++) {
    points[i] = random_point(&r, 3000);
    if (i % 2)
      aim_at_lobe(&r, &points[i]);
    change(&r, &points[i]);
  }
  check_against_literal(ctx, points, EACH, float_bound);
  free(points);
}

static void normal_incidence(uint64_t *r, hetab_point *p) {
  p->theta_i = 0;
}

static void normal_both(uint64_t *r, hetab_point *p) {
  p->theta_i = p->theta_r = 0;
}

static void retro(uint64_t *r, hetab_point *p) {
  p->theta_r = p->theta_i;
  p->phi = 0;
}

static void mirror(uint64_t *r, hetab_point *p) {
  p->theta_r = p->theta_i;
  p->phi = M_PI;
}

static void near_mirror(uint64_t *r, hetab_point *p) {
  p->theta_r = fmin(p->theta_i + log_uniform(r, 1e-12, 1e-3), M_PI_2);
  p->phi = M_PI - log_uniform(r, 1e-12, 1e-3);
}

static void near_normal(uint64_t *r, hetab_point *p) {
  p->theta_i = log_uniform(r, 1e-15, 1e-3);
  p->theta_r = log_uniform(r, 1e-15, 1e-3);
}

static void needle(uint64_t *r, hetab_point *p) {
  p->tau_um = p->lambda_um * uniform(r, 100, 1000);
  p->sigma0_um = p->lambda_um * log_uniform(r, 0.01, 1);
  if (p->theta_i < 1)
    aim_at_lobe(r, p);
}

static void grazing_in(uint64_t *r, hetab_point *p) {
  p->theta_i = M_PI_2 - log_uniform(r, 1.7e-6, 0.1);
}

static void grazing_out(uint64_t *r, hetab_point *p) {
  p->theta_r = M_PI_2 - log_uniform(r, 1.7e-6, 0.1);
}

static void grazing_both(uint64_t *r, hetab_point *p) {
  grazing_in(r, p);
  grazing_out(r, p);
  p->phi = M_PI - uniform(r, 0, 0.1);
}

static void gentle(uint64_t *r, hetab_point *p) {
  p->tau_um = p->sigma0_um / log_uniform(r, 1e-4, 1e-2);
}

static void steep(uint64_t *r, hetab_point *p) {
  p->tau_um = p->sigma0_um / log_uniform(r, 0.5, 10);
}

static void dielectric(uint64_t *r, hetab_point *p) {
  p->n = uniform(r, 0, 1) < 0.5 ? 1 + log_uniform(r, 1e-4, 1) : uniform(r, 1.0001, 4);
  p->k = 0;
}

static void rarer(uint64_t *r, hetab_point *p) { /* total reflection */
  p->n = uniform(r, 0.2, 0.9999);
  p->k = 0;
}

static void far_off_specular(uint64_t *r, hetab_point *p) {
  p->phi = uniform(r, 0, 1);
  p->theta_r = uniform(r, 0.5, 1.5);
}

#define HARD(name, bound)                                                                          \
  static void test_##name(void **state) {                                                          \
    check_case(*state, name, bound);                                                               \
  }
HARD(normal_incidence, TOL_GOLDEN_FLOAT)
HARD(normal_both, TOL_GOLDEN_FLOAT)
HARD(retro, TOL_GOLDEN_FLOAT)
HARD(mirror, TOL_GOLDEN_FLOAT)
HARD(near_mirror, TOL_GOLDEN_FLOAT)
HARD(near_normal, TOL_GOLDEN_FLOAT)
HARD(needle, TOL_GOLDEN_FLOAT)
HARD(grazing_in, TOL_GOLDEN_FLOAT)
HARD(grazing_out, TOL_GOLDEN_FLOAT)
HARD(grazing_both, TOL_GOLDEN_FLOAT)
HARD(gentle, TOL_GOLDEN_FLOAT)
HARD(steep, TOL_GOLDEN_FLOAT)
HARD(dielectric, TOL_GOLDEN_FLOAT)
HARD(rarer, TOL_TOTAL_FLOAT)
HARD(far_off_specular, TOL_GOLDEN_FLOAT)

/* Within 0.01 degrees of the critical angle of n < 1 (even i), and beyond that, Fresnel's square
 * root has what a cancellation leaves. */
static void test_critical_angle(void **state) {
  static const double bounds[][2] = {{TOL_CRITICAL_FLOAT, TOL_TOTAL_FLOAT},
                                     {TOL_CRITICAL_DOUBLE, TOL_GOLDEN_DOUBLE}};
  static const double degree = M_PI / 180;
  enum { COUNT = 2000 };
  static hetab_point points[COUNT];
  uint64_t r = 7;
  for (size_t i = 0; i < COUNT; i++) {
    double n = uniform(&r, 0.3, 0.99);
    double offset =
        i % 2 ? log_uniform(&r, 0.01 * degree, degree) : log_uniform(&r, 1e-12, 0.01 * degree);
    double theta = asin(n) + (i % 4 < 2 ? offset : -offset);
    points[i] = (hetab_point){.lambda_um = 0.55,
                              .sigma0_um = 0.1,
                              .tau_um = 3,
                              .n = n,
                              .theta_i = theta,
                              .theta_r = theta,
                              .phi = M_PI};
  }
  hetab_value *exact = literal_values(*state, points, COUNT);
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    worst w[2] = {0};
    hetab_value *values = device_values(*state, (hetab_precision)precision, points, COUNT);
    for (size_t i = 0; i < COUNT; i++)
      worst_add(&w[i % 2], i, values[i].dd, exact[i].dd);
    for (int beyond = 0; beyond < 2; beyond++)
      assert_worst("critical angle", &w[beyond], bounds[precision][beyond], TOL_BELOW_FLOOR);
    free(values);
  }
  free(exact);
}

/* At exactly 90 degrees the BRDF is 0, the specular reflectance too. */
static void test_ninety_degrees(void **state) {
  hetab_point points[300];
  uint64_t r = 5;
  for (size_t i = 0; i < 300; i++) {
    points[i] = random_point(&r, 1e4);
    if (i % 3 != 1)
      points[i].theta_i = M_PI_2;
    if (i % 3 != 0)
      points[i].theta_r = M_PI_2;
    if (i % 2)
      points[i].phi = M_PI;
  }
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_value *values = device_values(*state, (hetab_precision)precision, points, 300);
    for (size_t i = 0; i < 300; i++) {
      assert_true(values[i].dd == 0 && values[i].g == 0);
      assert_true(isfinite(values[i].specular) && values[i].specular >= 0);
      assert_true(points[i].theta_i < M_PI_2 || values[i].specular == 0);
    }
    free(values);
  }
  hetab_value *values = literal_values(*state, points, 300);
  for (size_t i = 0; i < 300; i++)
    assert_true(values[i].dd == 0);
  free(values);
}

/* g from 1e-10 to 1e6: the literal's sum grows with g, so few points are large. */
static void test_any_g(void **state) {
  enum { COUNT = 2000 };
  hetab_point *points = calloc(COUNT, sizeof *points);
  uint64_t r = 3;
  for (size_t i = 0; i < COUNT; i++) {
    hetab_point *p = &points[i];
    *p = random_point(&r, 1);
    double g = log_uniform(&r, 1e-10, 1e6);
    p->theta_i = uniform(&r, 0, 1);
    p->sigma0_um = sqrt(g) * p->lambda_um / (4 * M_PI);
    p->tau_um = p->sigma0_um / log_uniform(&r, 1e-2, 1);
    aim_at_lobe(&r, p);
  }
  check_against_literal(*state, points, COUNT, TOL_GOLDEN_FLOAT);
  free(points);
}

/* Nothing but finite values >= 0, whatever the point. */
static void test_never_bad(void **state) {
  enum { COUNT = 100000 };
  static const double thetas[] = {0,    1e-300,   1e-20,  1e-9,   1e-5,
                                  0.78, 1.570796, M_PI_4, M_PI_2, 1.5707963267948963};
  static const double phis[] = {0, 1e-300, 1e-9, M_PI_2, 3.1415926, M_PI, -M_PI, 2 * M_PI, 1e6};
  static const double lengths[] = {1e-9, 1e-4, 0.1, 1, 50, 1e4, 1e6};
  static const double indices[] = {1e-6, 1, 1.0001, 1.5, 4, 1e3};
#define PICK(array) (array)[(size_t)uniform(&r, 0, sizeof(array) / sizeof *(array))]
  hetab_point *points = calloc(COUNT, sizeof *points);
  uint64_t r = 11;
  for (size_t i = 0; i < COUNT; i++) {
    hetab_point *p = &points[i];
    *p = random_point(&r, 1e6);
    if (i % 2)
      aim_at_lobe(&r, p);
    if (i % 3 == 0)
      p->theta_i = PICK(thetas);
    if (i % 5 < 2)
      p->theta_r = i % 10 ? PICK(thetas) : p->theta_i;
    if (i % 7 < 2)
      p->phi = PICK(phis);
    if (i % 11 == 0)
      p->sigma0_um = PICK(lengths);
    if (i % 13 == 0)
      p->tau_um = PICK(lengths);
    if (i % 17 == 0)
      p->n = PICK(indices);
    if (i % 19 == 0)
      p->k = uniform(&r, 0, 1) < 0.5 ? 0 : PICK(indices);
  }
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_value *values = device_values(*state, (hetab_precision)precision, points, COUNT);
    size_t bad = 0;
    for (size_t i = 0; i < COUNT; i++) {
      const hetab_value *v = &values[i];
      int good = isfinite(v->dd) && v->dd >= 0 && isfinite(v->specular) && v->specular >= 0 &&
                 v->specular <= 1.000001 && isfinite(v->g) && v->g >= 0 && isfinite(v->x) &&
                 v->x >= 0;
      if (!good && bad++ < 3)
        print_message("  %s: dd %g rho_s %g g %g x %g at lambda %.17g theta %.17g %.17g phi %.17g "
                      "sigma0 %.17g tau %.17g n %g k %g\n",
                      precision_name((hetab_precision)precision), v->dd, v->specular, v->g, v->x,
                      points[i].lambda_um, points[i].theta_i, points[i].theta_r, points[i].phi,
                      points[i].sigma0_um, points[i].tau_um, points[i].n, points[i].k);
    }
    assert_int_equal(bad, 0);
    free(values);
  }
  free(points);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_points_float),     TEST(test_points_double),   TEST(test_factors),
      TEST(test_specular_float),   TEST(test_specular_double), TEST(test_specular_of_surface),
      TEST(test_normal_incidence), TEST(test_normal_both),     TEST(test_retro),
      TEST(test_mirror),           TEST(test_near_mirror),     TEST(test_near_normal),
      TEST(test_needle),           TEST(test_grazing_in),      TEST(test_grazing_out),
      TEST(test_grazing_both),     TEST(test_gentle),          TEST(test_steep),
      TEST(test_dielectric),       TEST(test_rarer),           TEST(test_far_off_specular),
      TEST(test_critical_angle),   TEST(test_ninety_degrees),  TEST(test_any_g),
      TEST(test_never_bad),        TEST(test_places_float),    TEST(test_places_double),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
