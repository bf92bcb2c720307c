/* The literal reference against 40-digit values and against the device; the model's symmetries and
 * limits. */
#include "golden_support.h"

#include <complex.h>

#include "core/angle.h"

static void test_golden(void **state) {
  size_t count;
  golden_point *golden = golden_points(&count);
  hetab_point *points = calloc(2 * count, sizeof *points);
  worst dd = {0};
  double g = 0, x = 0;
  for (size_t i = 0; i < count; i++) {
    points[i] = golden[i].point;
    points[count + i] = swapped(golden[i].point);
  }
  hetab_value *values = literal_values(*state, points, 2 * count);
  for (size_t i = 0; i < 2 * count; i++) {
    const golden_point *p = &golden[i % count];
    worst_add(&dd, i, values[i].dd, p->dd);
    g = fmax(g, relative_error(values[i].g, p->g));
    x = fmax(x, fabs(values[i].x - p->x) / fmax(p->x, 1e-6));
  }
  assert_worst(golden[dd.at % count].name, &dd, TOL_LITERAL_GOLDEN, TOL_BELOW_FLOOR);
  assert_below("g", g, TOL_LITERAL_GX);
  assert_below("x", x, TOL_LITERAL_GX);
  free(values);
  free(points);
  free(golden);
}

static void test_golden_specular(void **state) {
  size_t count;
  golden_reflectance *golden = golden_reflectances(&count);
  double rho_s = 0;
  for (size_t i = 0; i < count; i++) {
    hetab_value *value = literal_values(*state, &golden[i].point, 1);
    rho_s = fmax(rho_s, relative_error(value->specular, golden[i].rho_s));
    free(value);
  }
  assert_below("rho_s", rho_s, TOL_LITERAL);
  free(golden);
}

/* --- random points --------------------------------------------------------------------------- */

enum { COUNT = 10000 };

/* Values within a few lobe widths of the mirror direction, for most of them to be above the floor.
 */
static hetab_point *random_points(size_t count) {
  hetab_point *points = calloc(count, sizeof *points);
  uint64_t r = 17;
  for (size_t i = 0; i < count; i++) {
    hetab_point *p = &points[i];
    double g = log_uniform(&r, 1e-4, 5000);
    p->lambda_um = uniform(&r, 0.38, 0.75);
    p->sigma0_um = sqrt(g) * p->lambda_um / (4 * M_PI);
    p->tau_um = p->sigma0_um / log_uniform(&r, 0.01, 1);
    p->theta_i = uniform(&r, 0, 1.57);
    double width = p->lambda_um / (M_PI * p->tau_um) * fmax(1, sqrt(g));
    p->theta_r = fmin(fabs(p->theta_i + width * uniform(&r, -2, 2)), M_PI_2);
    p->phi = M_PI * (1 - fmin(1, width) * uniform(&r, 0, 1));
    p->n = i % 3 ? uniform(&r, 0.1, 4) : uniform(&r, 1.3, 4);
    p->k = i % 3 ? uniform(&r, 1, 8) : 0;
    p->diffuse_brdf = i % 4 ? 0 : uniform(&r, 0, 0.3);
  }
  return points;
}

static void test_stable_form(void **state) {
  hetab_point *points = random_points(COUNT);
  hetab_value *literal = literal_values(*state, points, COUNT);
  hetab_value *stable = device_values(*state, HETAB_DOUBLE, points, COUNT);
  hetab_value *narrow = device_values(*state, HETAB_FLOAT, points, COUNT);
  worst dd = {0}, specular = {0}, single = {0};
  for (size_t i = 0; i < COUNT; i++) {
    worst_add(&dd, i, stable[i].dd, literal[i].dd);
    worst_add(&specular, i, stable[i].specular, literal[i].specular);
    worst_add(&single, i, narrow[i].dd, stable[i].dd);
    assert_true(literal[i].ud == points[i].diffuse_brdf && stable[i].ud == literal[i].ud);
    assert_true(stable[i].total == stable[i].dd + stable[i].ud);
    assert_true(literal[i].total == literal[i].dd + literal[i].ud);
  }
  assert_true(dd.compared > COUNT / 2);
  assert_worst("double", &dd, TOL_LITERAL, TOL_BELOW_FLOOR);
  assert_worst("double, rho_s", &specular, TOL_LITERAL, TOL_BELOW_FLOOR);
  assert_worst("float against double", &single, TOL_GOLDEN_FLOAT, TOL_BELOW_FLOOR);
  free(points);
  free(literal);
  free(stable);
  free(narrow);
}

/* --- symmetries ------------------------------------------------------------------------------ */

/* f(i, r) = f(r, i) and f(phi) = f(-phi), bit for bit; phi + 2 pi within rounding. */
static void test_reciprocity(void **state) {
  hetab_point *points = random_points(COUNT), *changed = random_points(COUNT);
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_value *values = device_values(*state, (hetab_precision)precision, points, COUNT);
    for (size_t i = 0; i < COUNT; i++)
      changed[i] = swapped(points[i]);
    hetab_value *others = device_values(*state, (hetab_precision)precision, changed, COUNT);
    for (size_t i = 0; i < COUNT; i++)
      assert_true(values[i].dd == others[i].dd && values[i].g == others[i].g);
    free(others);
    for (size_t i = 0; i < COUNT; i++) {
      changed[i] = points[i];
      changed[i].phi = -points[i].phi;
    }
    others = device_values(*state, (hetab_precision)precision, changed, COUNT);
    for (size_t i = 0; i < COUNT; i++)
      assert_true(values[i].dd == others[i].dd && values[i].x == others[i].x);
    free(others);
    free(values);
  }
  hetab_value *values = literal_values(*state, points, COUNT);
  for (size_t i = 0; i < COUNT; i++)
    changed[i] = swapped(points[i]);
  hetab_value *others = literal_values(*state, changed, COUNT);
  worst literal = {0};
  for (size_t i = 0; i < COUNT; i++)
    worst_add(&literal, i, others[i].dd, values[i].dd);
  assert_worst("literal, swapped", &literal, TOL_LITERAL_SYMMETRY, TOL_BELOW_FLOOR);
  free(values);
  free(others);
  free(points);
  free(changed);
}

static void test_whole_turns(void **state) {
  hetab_point *points = random_points(COUNT), *turned = random_points(COUNT);
  hetab_value *values = device_values(*state, HETAB_DOUBLE, points, COUNT);
  for (size_t i = 0; i < COUNT; i++)
    turned[i].phi += i % 2 ? 2 * M_PI : -4 * M_PI;
  hetab_value *others = device_values(*state, HETAB_DOUBLE, turned, COUNT);
  worst error = {0};
  for (size_t i = 0; i < COUNT; i++)
    worst_add(&error, i, others[i].dd, values[i].dd);
  assert_worst("phi + 2 pi", &error, TOL_TURN, TOL_BELOW_FLOOR);
  free(points);
  free(turned);
  free(values);
  free(others);
}

static void scaled(hetab_point *points, size_t count, double factor) {
  for (size_t i = 0; i < count; i++) {
    points[i].lambda_um *= factor;
    points[i].sigma0_um *= factor;
    points[i].tau_um *= factor;
  }
}

/* The BRDF knows ratios of lengths only: bit for bit for powers of two. */
static void test_scale_invariance(void **state) {
  static const double factors[] = {1024, 1.0 / 64, 1000.0 / 7, 0.01};
  hetab_point *points = random_points(COUNT);
  for (size_t f = 0; f < 4; f++) {
    hetab_point *others = random_points(COUNT);
    scaled(others, COUNT, factors[f]);
    for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
      hetab_value *a = device_values(*state, (hetab_precision)precision, points, COUNT);
      hetab_value *b = device_values(*state, (hetab_precision)precision, others, COUNT);
      worst error = {0};
      for (size_t i = 0; i < COUNT; i++)
        worst_add(&error, i, b[i].dd, a[i].dd);
      assert_worst(hetab_precision_name((hetab_precision)precision), &error,
                   f < 2                      ? 0
                   : precision == HETAB_FLOAT ? TOL_SCALE_FLOAT
                                              : TOL_SCALE_DOUBLE,
                   f < 2 ? 0 : TOL_BELOW_FLOOR);
      free(a);
      free(b);
    }
    free(others);
  }
  free(points);
}

/* --- limits ---------------------------------------------------------------------------------- */

/* |F|^2 by complex arithmetic. */
static double fresnel(double c, double n, double k) {
  double complex index = __builtin_complex(n, k), t = csqrt(index * index - (1 - c * c));
  double complex s = (c - t) / (c + t), p = (index * index * c - t) / (index * index * c + t);
  return 0.5 * (creal(s * conj(s)) + creal(p * conj(p)));
}

/* Eqs. 15-17 again, for shadowing of a Gaussian surface with rms slope sqrt(2) sigma0/tau. */
static double smith(double theta, double slope) {
  double u = 1 / (2 * slope * tan(theta));
  double lambda = (exp(-u * u) / (sqrt(M_PI) * u) - erfc(u)) / 2;
  return (1 - erfc(u) / 2) / (1 + lambda);
}

/* W by bisection: W e^W = kappa. */
static double effective_ratio2(double theta_i, double theta_r, double slope) {
  double k = tan(theta_i) * erfc(1 / (2 * slope * tan(theta_i))) +
             tan(theta_r) * erfc(1 / (2 * slope * tan(theta_r)));
  double kappa = k * k / (8 * M_PI), low = 0, high = kappa;
  for (int i = 0; i < 200; i++) {
    double w = (low + high) / 2;
    if (w * exp(w) < kappa)
      low = w;
    else
      high = w;
  }
  return 1 / (1 + low);
}

/* Microfacets of slopes alpha = 2 sigma / tau: D F S_i S_r / (4 mu_i mu_r). */
static double beckmann(const hetab_point *p) {
  double mu_i = cos(p->theta_i), mu_r = cos(p->theta_r), slope = p->sigma0_um / p->tau_um;
  double hx = sin(p->theta_i) + sin(p->theta_r) * cos(p->phi);
  double hy = sin(p->theta_r) * sin(p->phi), hz = mu_i + mu_r;
  double cos2_h = hz * hz / (hx * hx + hy * hy + hz * hz);
  double cos_d = sqrt(hx * hx + hy * hy + hz * hz) / 2;
  double alpha2 = 4 * slope * slope * effective_ratio2(p->theta_i, p->theta_r, slope);
  double d = exp(-(1 / cos2_h - 1) / alpha2) / (M_PI * alpha2 * cos2_h * cos2_h);
  return fresnel(cos_d, p->n, p->k) * d * smith(p->theta_i, slope) * smith(p->theta_r, slope) /
         (4 * mu_i * mu_r);
}

/* The error of the Beckmann model falls as 1 / g: to a quarter when all heights and lengths double,
 * at constant slope. */
static void test_beckmann_limit(void **state) {
  enum { SIZES = 5, DIRECTIONS = 5 };
  static const double directions[DIRECTIONS][3] = {
      {0.2, 0.3, 2.0}, {0.5, 0.5, M_PI}, {0.7, 0.4, 2.8}, {1.2, 1.1, 3.0}, {0.3, 0.6, 1.0}};
  double last = 0;
  for (int d = 0; d < DIRECTIONS; d++) {
    hetab_point points[SIZES];
    for (int s = 0; s < SIZES; s++)
      points[s] = (hetab_point){.lambda_um = 0.5,
                                .theta_i = directions[d][0],
                                .theta_r = directions[d][1],
                                .phi = directions[d][2],
                                .sigma0_um = 2 * exp2(s),
                                .tau_um = 2 * exp2(s) / 0.3,
                                .n = 0.958,
                                .k = 6.69};
    hetab_value *values = device_values(*state, HETAB_DOUBLE, points, SIZES);
    double error[SIZES];
    for (int s = 0; s < SIZES; s++) {
      error[s] = fabs(values[s].dd - beckmann(&points[s])) / values[s].dd;
      if (s > 1)
        assert_true(error[s] / error[s - 1] > 0.2 && error[s] / error[s - 1] < 0.3);
    }
    last = fmax(last, error[SIZES - 1] * values[SIZES - 1].g);
    free(values);
  }
  assert_below("error times g", last, TOL_BECKMANN_G);
}

/* Almost smooth: rho_s is Fresnel's, the rest the first-order term. Errors of order g. */
static void test_smooth_limit(void **state) {
  enum { SIZES = 4, DIRECTIONS = 3 };
  static const double directions[DIRECTIONS][3] = {
      {0.2, 0.3, 2.0}, {0.5, 0.5, M_PI}, {1.2, 1.1, 3.0}};
  double specular = 0, dd = 0;
  for (int d = 0; d < DIRECTIONS; d++)
    for (int s = 0; s < SIZES; s++) {
      hetab_point p = {.lambda_um = 0.5,
                       .theta_i = directions[d][0],
                       .theta_r = directions[d][1],
                       .phi = directions[d][2],
                       .sigma0_um = 1e-3 * pow(0.1, s),
                       .tau_um = 1,
                       .n = 0.958,
                       .k = 6.69};
      hetab_value *v = device_values(*state, HETAB_DOUBLE, &p, 1);
      double mu_i = cos(p.theta_i), mu_r = cos(p.theta_r);
      double cos2 = (1 + mu_i * mu_r + sin(p.theta_i) * sin(p.theta_r) * cos(p.phi)) / 2;
      double first = 16 * pow(M_PI, 3) * pow(p.sigma0_um * p.tau_um, 2) / pow(p.lambda_um, 4) *
                     fresnel(sqrt(cos2), p.n, p.k) * cos2 * cos2 / (mu_i * mu_r) * exp(-v->x);
      double g = pow(4 * M_PI * p.sigma0_um / p.lambda_um, 2);
      specular = fmax(specular, relative_error(v->specular, fresnel(mu_i, p.n, p.k)) / g);
      dd = fmax(dd, relative_error(v->dd, first) / (g * (1 + v->x)));
      free(v);
    }
  assert_below("rho_s against |F|^2, over g", specular, TOL_SMOOTH_G);
  assert_below("dd against first order, over g", dd, TOL_SMOOTH_G);
}

/* Near right angles degrees become the nearest double, as far as another arithmetic can tell: that
 * is what keeps the cosine's digits. */
static void test_radians(void **state) {
  uint64_t seed = 3;
  assert_true(hetab_radians(90) == M_PI_2 && hetab_radians(180) == M_PI && hetab_radians(0) == 0);
  for (int i = 0; i < 10000; i++) {
    double deg = 90 * (double)(1 + i % 4) - log_uniform(&seed, 1e-12, 1);
    long double exact = (long double)deg / 180 * 3.14159265358979323846264338327950288L;
    double ulp = nextafter(fabs(hetab_radians(deg)), HUGE_VAL) - fabs(hetab_radians(deg));
    assert_true(fabsl(hetab_radians(deg) - exact) <= 0.51 * ulp);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_golden),         TEST(test_golden_specular), TEST(test_stable_form),
      TEST(test_reciprocity),    TEST(test_whole_turns),     TEST(test_scale_invariance),
      TEST(test_beckmann_limit), TEST(test_smooth_limit),    TEST(test_radians),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
