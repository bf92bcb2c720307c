/* Hemispherical reflectances: golden values, closed forms, independent sums, and whether the error
 * estimates can be believed. */
#include "degrees.h"
#include "golden_support.h"

#include <time.h>

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static hetab_surface *new_surface(hetab_context *ctx, const hetab_point *p) {
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_create(ctx, p->sigma0_um, p->tau_um, p->n, p->k, &p->lambda_um, 1,
                                      &surface));
  return surface;
}

/* The reflectance at the point's wavelength and theta_i. */
static hetab_reflectance reflectance_at(hetab_context *ctx, hetab_engine *engine,
                                        const hetab_point *p, double tolerance) {
  hetab_surface *surface = new_surface(ctx, p);
  hetab_reflectance r;
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, &p->theta_i, 1, tolerance, &r));
  hetab_surface_free(surface);
  return r;
}

static hetab_engine *series_engine(hetab_context *ctx, hetab_precision precision) {
  return new_engine(ctx, precision, HETAB_METHOD_SERIES, 0);
}

static const hetab_point aluminium = {
    .lambda_um = 0.55, .sigma0_um = 0.13, .tau_um = 5.4, .n = 0.958, .k = 6.69};

static hetab_point point_of(double sigma0_um, double tau_um, double theta_deg) {
  hetab_point p = aluminium;
  p.sigma0_um = sigma0_um;
  p.tau_um = tau_um;
  p.theta_i = theta_deg * M_PI / 180;
  return p;
}

/* ---- golden values -------------------------------------------------------------------------- */

static void check_golden(hetab_context *ctx, hetab_precision precision, double bound) {
  size_t count;
  golden_reflectance *golden = golden_reflectances(&count);
  hetab_engine *engine = series_engine(ctx, precision);
  double worst_dd = 0, worst_s = 0, worst_honesty = 0;
  assert_int_equal(count, 50);
  for (size_t i = 0; i < count; i++) {
    const golden_reflectance *g = &golden[i];
    hetab_reflectance r = reflectance_at(ctx, engine, &g->point, 0);
    double error = fabs(r.dd.value - g->rho_dd);
    worst_dd = fmax(worst_dd, error / g->rho_dd);
    worst_s = fmax(worst_s, relative_error(r.specular, g->rho_s));
    assert_true(relative_error(r.fresnel, g->fresnel) < 1e-13);
    assert_true(r.dh == r.dd.value + r.specular && r.ud == 0 && r.dd.evaluations > 0);
    assert_int_equal(r.dd.stop, HETAB_STOP_TOLERANCE);
    worst_honesty = fmax(worst_honesty, error / r.dd.error);
  }
  assert_below("rho_dd", worst_dd, bound);
  assert_below("rho_s", worst_s, TOL_REFLECTANCE_SPECULAR);
  assert_below("error / estimate", worst_honesty, 0.25);
  hetab_engine_free(engine);
  free(golden);
}

static void test_golden_float(void **state) {
  check_golden(*state, HETAB_FLOAT, TOL_REFLECTANCE_FLOAT);
}

static void test_golden_double(void **state) {
  check_golden(*state, HETAB_DOUBLE, TOL_REFLECTANCE_DOUBLE);
}

/* ---- closed forms --------------------------------------------------------------------------- */

/* f_dd of a surface smooth as glass is nothing: the diffuse part and the mirror are left. */
static void test_mirror_limit(void **state) {
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  for (double deg = 0; deg < 90; deg += 10) {
    hetab_point p = point_of(1e-6, 3, deg);
    hetab_reflectance r = reflectance_at(ctx, engine, &p, 0);
    assert_true(r.dd.value >= 0 && r.dd.value < 1e-8);
    assert_true(relative_error(r.specular, r.fresnel) < 1e-8);
  }
  hetab_engine_free(engine);
}

/* Small roughness: the Gaussian of the first term alone, rho_dd = g F at normal incidence. */
static void test_first_order(void **state) {
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  hetab_point p = point_of(1e-4, 1000, 0);
  hetab_reflectance r = reflectance_at(ctx, engine, &p, 0);
  double g = pow(4 * M_PI * p.sigma0_um / p.lambda_um, 2);
  assert_below("rho_dd + rho_s against F", relative_error(r.dh, r.fresnel), 1e-7);
  assert_below("rho_dd against g F", relative_error(r.dd.value, g * r.fresnel), 2 * g);
  hetab_engine_free(engine);
}

static void test_white_conductor(void **state) {
  hetab_context *ctx = *state;
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_engine *engine = series_engine(ctx, (hetab_precision)precision);
    hetab_point p = point_of(1, 1000, 0); /* g = 522, slope 0.001 */
    p.n = 1e-3;
    p.k = 900;
    hetab_reflectance r = reflectance_at(ctx, engine, &p, 0);
    assert_below("1 - rho_dh", fabs(1 - r.dh), 1e-5);
    hetab_engine_free(engine);
  }
}

static hetab_surface *diffuse_surface(hetab_context *ctx) {
  static const char path[] = "/tmp/hetab-test-reflectance.yml";
  hetab_surface *surface;
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs("sigma0_um: 1e-6\ntau_um: 3\nindex: {n: 1.0, k: 0.0}\ndiffuse_reflectance: 0.5\n", file);
  fclose(file);
  assert_ok(ctx, hetab_surface_load(ctx, path, &surface));
  remove(path);
  return surface;
}

/* An index of 1 reflects nothing: what is left is Lambert's. */
static void test_lambertian(void **state) {
  enum { BANDS = 31, COUNT = 3 };
  static const double theta_i[COUNT] = {0, DEG(45), DEG(89.9)};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_FLOAT);
  hetab_surface *surface = diffuse_surface(ctx);
  hetab_reflectance dh[BANDS * COUNT], hh[BANDS];
  hetab_reflectance_colour colour[COUNT], polished[COUNT];
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, COUNT, 0, dh));
  assert_ok(ctx, hetab_reflectance_hh(ctx, engine, surface, 0, hh));
  assert_ok(ctx, hetab_reflectance_rgb(ctx, surface, dh, COUNT, colour, polished));
  for (int i = 0; i < BANDS * COUNT; i++)
    assert_true(fabs(dh[i].dh - 0.5) < 1e-15 && dh[i].dd.value < 1e-20);
  for (int i = 0; i < BANDS; i++)
    assert_true(fabs(hh[i].dh - 0.5) < 1e-15);
  for (int i = 0; i < COUNT; i++) {
    assert_true(fabs(colour[i].luminance - 0.5) < 1e-12 && polished[i].luminance < 1e-20);
    for (int c = 0; c < 3; c++) /* white is (1, 1, 1) to the matrix's digits */
      assert_true(fabs(colour[i].rgb[c] - 0.5) < 1e-3);
  }
  hetab_surface_free(surface);
  hetab_engine_free(engine);
}

/* ---- an independent sum --------------------------------------------------------------------- */

/* The printed equations on a product grid of midpoints in theta_r and phi; sin(2 theta) / 2 is the
 * cosine and the solid angle. */
static double product_rule(hetab_context *ctx, hetab_point p, size_t thetas, size_t phis) {
  hetab_point *points = calloc(thetas * phis, sizeof *points);
  double sum = 0, step_theta = M_PI_2 / (double)thetas, step_phi = M_PI / (double)phis;
  for (size_t t = 0; t < thetas; t++)
    for (size_t f = 0; f < phis; f++) {
      points[t * phis + f] = p;
      points[t * phis + f].theta_r = ((double)t + 0.5) * step_theta;
      points[t * phis + f].phi = ((double)f + 0.5) * step_phi;
    }
  hetab_value *values = literal_values(ctx, points, thetas * phis);
  for (size_t i = 0; i < thetas * phis; i++)
    sum += values[i].dd * sin(2 * points[i].theta_r);
  free(points);
  free(values);
  return sum * step_theta * step_phi;
}

static void test_brute_force(void **state) {
  static const double cases[][3] = {{0.72, 5.6, 0}, {0.72, 5.6, 50}, {1, 1.6, 30},
                                    {0.05, 0.3, 0}, {0.05, 0.3, 60}, {0.3, 2, 80}};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  double worst = 0;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_point p = point_of(cases[i][0], cases[i][1], cases[i][2]);
    double coarse = product_rule(ctx, p, 120, 120), fine = product_rule(ctx, p, 240, 240);
    /* the midpoint rule's error is of order 2 in theta */
    double extrapolated = fine + (fine - coarse) / 3;
    hetab_reflectance r = reflectance_at(ctx, engine, &p, 0);
    worst = fmax(worst, relative_error(r.dd.value, extrapolated));
  }
  assert_below("against the literal equations, summed", worst, TOL_REFLECTANCE_BRUTE);
  hetab_engine_free(engine);
}

/* Against Simpson's rule in theta_i. */
static void test_white_sky(void **state) {
  enum { INTERVALS = 360 };
  static const double cases[][2] = {{0.13, 5.4}, {0.72, 5.6}, {0.05, 0.3}, {1, 1.6}};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_point p = point_of(cases[i][0], cases[i][1], 0);
    hetab_surface *surface = new_surface(ctx, &p);
    double theta_i[INTERVALS + 1], sum = 0;
    hetab_reflectance dh[INTERVALS + 1], hh;
    for (int j = 0; j <= INTERVALS; j++)
      theta_i[j] = DEG(90.0 * j / INTERVALS);
    assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, INTERVALS + 1, 0, dh));
    for (int j = 0; j <= INTERVALS; j++)
      sum += (j == 0 || j == INTERVALS ? 1 : j % 2 ? 4 : 2) * dh[j].dh * sin(2 * theta_i[j]);
    sum *= M_PI_2 / INTERVALS / 3;
    assert_ok(ctx, hetab_reflectance_hh(ctx, engine, surface, 0, &hh));
    assert_below("white sky", relative_error(hh.dh, sum), TOL_REFLECTANCE_SKY);
    assert_true(hh.dd.error > 0 && hh.dd.error < 1e-8 && hh.dh < hh.fresnel);
    hetab_surface_free(surface);
  }
  hetab_engine_free(engine);
}

static void test_white_sky_honesty(void **state) {
  static const double cases[][2] = {{0.13, 5.4}, {1, 1.6}, {0.05, 50}, {0.02, 3}, {1, 400}};
  static const double tolerances[] = {1e-2, 1e-4, 1e-6};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  double worst = 0;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_point p = point_of(cases[i][0], cases[i][1], 0);
    hetab_surface *surface = new_surface(ctx, &p);
    hetab_reflectance truth, hh;
    assert_ok(ctx, hetab_reflectance_hh(ctx, engine, surface, 1e-8, &truth));
    for (size_t t = 0; t < sizeof tolerances / sizeof *tolerances; t++) {
      assert_ok(ctx, hetab_reflectance_hh(ctx, engine, surface, tolerances[t], &hh));
      assert_true(hh.dd.error <= tolerances[t] * hh.dh);
      worst = fmax(worst, fabs(hh.dh - truth.dh) / (hh.dd.error + truth.dd.error));
    }
    hetab_surface_free(surface);
  }
  assert_below("error / estimate", worst, 1);
  hetab_engine_free(engine);
}

/* With n < 1 the kink of |F|^2 at the critical angle lies between nodes unless they are cut there.
 * The values are sums of Gauss's rules in another coordinate, cut at the kink, with scipy's erfc
 * and lambertw, good to the digits given. */
static void test_total_reflection(void **state) {
  static const struct {
    hetab_point at;
    double rho_dd;
  } cases[] = {
      {{1, 0, 0, 0, 0.02196979094961916, 1.2258696268548923, 0.5612630559454999, 1e-4, 0},
       0.005817670197428},
      {{1, 0, 0, 0, 0.10778197348926526, 3.575640310790666, 0.4874325373449687, 0, 0},
       0.09980292172017},
      {{1, 40, 0, 0, 0.10778197348926526, 3.575640310790666, 0.4874325373449687, 0, 0},
       0.658979912801100},
      {{1, 75, 0, 0, 0.10778197348926526, 3.575640310790666, 0.4874325373449687, 0, 0},
       0.117294143021451},
  };
  static const double digits = 1e-12;
  hetab_context *ctx = *state;
  for (int precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    hetab_engine *engine = series_engine(ctx, (hetab_precision)precision);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
      hetab_point p = cases[i].at;
      p.theta_i *= M_PI / 180;
      hetab_integral dd = reflectance_at(ctx, engine, &p, 0).dd;
      double right = cases[i].rho_dd;
      if (fabs(dd.value - right) > dd.error + digits * right)
        fail_msg("%.0f deg: %.15f +- %.1e, not %.15f", cases[i].at.theta_i, dd.value, dd.error,
                 right);
      assert_true(dd.error <= (precision == HETAB_FLOAT ? 2e-5 : 1e-9) * right);
      assert_int_not_equal(dd.stop, HETAB_STOP_BUDGET);
    }
    hetab_engine_free(engine);
  }
}

/* ---- convergence and honesty ---------------------------------------------------------------- */

/* Faster than any power that a rule would be chosen for: the order, per dimension of the two, from
 * the true errors and the evaluations of a loose and a tight tolerance. */
static void test_convergence(void **state) {
  static const double tolerances[] = {1e-3, 1e-5, 1e-7};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  hetab_point p = point_of(0.13, 5.4, 75);
  hetab_integral truth = reflectance_at(ctx, engine, &p, 5e-11).dd, r[3];
  print_message("  tolerance  error    estimate  evaluations\n");
  for (int i = 0; i < 3; i++) {
    r[i] = reflectance_at(ctx, engine, &p, tolerances[i]).dd;
    double error = fabs(r[i].value / truth.value - 1);
    print_message("  %-9.0e  %.1e  %.1e   %zu\n", tolerances[i], error, r[i].error / r[i].value,
                  r[i].evaluations);
    assert_true(error <= tolerances[i]);
  }
  double gain = fabs(r[0].value - truth.value) / fmax(fabs(r[2].value - truth.value), truth.error);
  double order = log(gain) / log(sqrt((double)r[2].evaluations / (double)r[0].evaluations));
  print_message("  order %.1f\n", order);
  assert_true(order >= 6);
  hetab_engine_free(engine);
}

/* Worst and mean (geometric) of true error over estimate. */
typedef struct honesty {
  double worst, log_sum;
  size_t count, above, budget;
} honesty;

/* Less the other rule's own rounding. */
static double error_over_estimate(const hetab_integral *value, double truth) {
  static const double rounding = 1e-12;
  return fmax(fabs(value->value - truth) - rounding * truth, 0) / value->error;
}

static void honesty_add(honesty *h, const hetab_integral *value, double truth,
                        const hetab_point *p) {
  double ratio = error_over_estimate(value, truth);
  if (!(ratio <= 1))
    print_message("  lambda %.17g, sigma0 %.17g, tau %.17g, n %.17g, k %.17g, %.17g degrees: value "
                  "%.13g, right %.13g, estimate %.2g\n",
                  p->lambda_um, p->sigma0_um, p->tau_um, p->n, p->k, p->theta_i * 180 / M_PI,
                  value->value, truth, value->error);
  h->above += !(ratio <= 1);
  h->worst = fmax(h->worst, ratio);
  h->log_sum += log(fmax(ratio, 1e-6));
  h->budget += value->stop == HETAB_STOP_BUDGET;
  h->count++;
}

static hetab_point random_point(uint64_t *seed) {
  hetab_point p = aluminium;
  p.lambda_um = uniform(seed, 0.4, 0.7);
  p.sigma0_um = log_uniform(seed, 0.005, 3);
  p.tau_um = fmax(log_uniform(seed, 0.1, 500), p.sigma0_um * uniform(seed, 0.8, 2));
  double kind = uniform(seed, 0, 1);
  if (kind < 0.6) { /* glass, or total reflection where it ends */
    p.n = kind < 0.3 ? 1.5 : uniform(seed, 0.1, 0.999);
    p.k = kind < 0.45 ? 0 : log_uniform(seed, 1e-6, 0.1);
  }
  return p;
}

/* ---- another rule: polar coordinates about the incident direction ------------------------------
 *
 * gamma from wi to wo, where |F|^2 has its kink on a circle, and beta about it from the plane of
 * incidence, where the horizon is one of beta: Gauss's rule on panels that shrink by a constant
 * factor towards all that may be sharp: the mirror direction, the kink, the horizon. */

enum { MOST_ORDER = 20, MOST_PANELS = 80, BATCH = 1 << 16 };

typedef struct gauss_rule {
  int order;
  double shrink;                               /* of the panels */
  double node[MOST_ORDER], weight[MOST_ORDER]; /* of [0, 1] */
} gauss_rule;

static gauss_rule gauss_rule_of(int order, double shrink) {
  gauss_rule rule = {.order = order, .shrink = shrink};
  for (int i = 0; i < order; i++) {
    double x = cos(M_PI * (i + 0.75) / (order + 0.5)), slope = 1;
    for (int newton = 0; newton < 8; newton++) {
      double p = 1, before = 0;
      for (int n = 1; n <= order; n++) {
        double next = ((2 * n - 1) * x * p - (n - 1) * before) / n;
        before = p;
        p = next;
      }
      slope = order * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.node[i] = 0.5 + 0.5 * x;
    rule.weight[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

/* A panel's place is an end of its interval and a distance from there: nothing cancels. */
typedef struct panel {
  double from, near, far; /* |x - from| */
  double sign;
} panel;

/* Panels of [low, high], the smallest at its ends at most `least` wide. */
static size_t graded(double low, double high, const double least[2], double shrink, panel *out) {
  size_t count = 0;
  for (int side = 0; side < 2; side++)
    for (double far = 0.5 * (high - low), near; far > 0; far = near) {
      near = far > least[side] ? far / shrink : 0;
      out[count++] = (panel){side ? high : low, near, far, side ? -1 : 1};
      assert_true(count < MOST_PANELS);
    }
  return count;
}

typedef struct polar_sum {
  hetab_context *ctx;
  hetab_engine *engine;
  gauss_rule rule;
  hetab_point at;
  hetab_point *points; /* [BATCH] */
  double *weights;
  hetab_value *values;
  size_t count;
  double sum;
} polar_sum;

static void add_batch(polar_sum *s) {
  assert_ok(s->ctx, hetab_evaluate(s->ctx, s->engine, s->points, s->count, s->values));
  for (size_t i = 0; i < s->count; i++)
    s->sum += s->weights[i] * s->values[i].dd;
  s->count = 0;
}

/* At gamma and beta; beta is `back` short of the horizon, where cos(theta_r) is a product. */
static void add_point(polar_sum *s, double gamma, double beta, double back, double horizon,
                      double weight) {
  double mu = cos(s->at.theta_i), sine = sin(s->at.theta_i), out = sin(gamma) * cos(beta);
  double z = horizon < M_PI ? 2 * sine * sin(gamma) * sin(0.5 * back) * sin(0.5 * (horizon + beta))
                            : mu * cos(gamma) + sine * out;
  if (!(z > 0))
    return;
  double x = sine * cos(gamma) - mu * out, y = sin(gamma) * sin(beta);
  hetab_point *p = &s->points[s->count];
  *p = s->at;
  p->theta_r = fmin(atan2(hypot(x, y), z), M_PI_2);
  p->phi = atan2(y, x);
  s->weights[s->count++] = 2 * weight * sin(gamma) * z; /* and the other half of the sphere */
  if (s->count == BATCH)
    add_batch(s);
}

static void add_ring(polar_sum *s, double gamma, double weight) {
  static const double least[2] = {1e-4, 1e-6}; /* well within the narrowest lobe; at the horizon */
  panel panels[MOST_PANELS];
  double cot = cos(gamma) * cos(s->at.theta_i), across = sin(gamma) * sin(s->at.theta_i);
  double horizon = cot >= across ? M_PI : acos(fmax(-cot / across, -1));
  size_t count = graded(0, horizon, least, s->rule.shrink, panels);
  for (size_t i = 0; i < count; i++)
    for (int n = 0; n < s->rule.order; n++) {
      double width = panels[i].far - panels[i].near;
      double distance = panels[i].near + width * s->rule.node[n];
      int past = panels[i].sign < 0; /* the middle */
      add_point(s, gamma, past ? horizon - distance : distance,
                past ? distance : horizon - distance, horizon, weight * width * s->rule.weight[n]);
    }
}

static double kink_gamma(const hetab_point *p) {
  double cos2 = (1 - p->n) * (1 + p->n) + p->k * p->k;
  return cos2 > 0 && cos2 < 1 ? 2 * acos(sqrt(cos2)) : 0;
}

/* rho_dd; the values by the series in double, which other tests
 * compare with the printed equations.
 */
static double polar_rho_dd(polar_sum *s, const hetab_point *p, gauss_rule rule) {
  double ends[] = {
      0, p->theta_i, 2 * p->theta_i, kink_gamma(p), M_PI_2 - p->theta_i, M_PI_2 + p->theta_i};
  enum { ENDS = sizeof ends / sizeof *ends };
  static const double least[2] = {1e-6, 1e-6};
  s->rule = rule;
  s->at = *p;
  s->sum = 0;
  for (int i = 0; i < ENDS; i++) /* in order, none beyond the last */
    for (int j = ENDS - 1; j > i; j--)
      if (ends[j] < ends[j - 1]) {
        double t = ends[j];
        ends[j] = ends[j - 1];
        ends[j - 1] = t;
      }
  for (int i = 0; i + 1 < ENDS && ends[i] < M_PI_2 + p->theta_i; i++) {
    panel panels[MOST_PANELS];
    size_t count =
        ends[i + 1] > ends[i] ? graded(ends[i], ends[i + 1], least, s->rule.shrink, panels) : 0;
    for (size_t k = 0; k < count; k++)
      for (int n = 0; n < s->rule.order; n++) {
        double width = panels[k].far - panels[k].near;
        add_ring(s, panels[k].from + panels[k].sign * (panels[k].near + width * s->rule.node[n]),
                 width * s->rule.weight[n]);
      }
  }
  add_batch(s);
  return s->sum;
}

static polar_sum new_polar_sum(hetab_context *ctx, hetab_engine *engine) {
  polar_sum s = {.ctx = ctx, .engine = engine};
  s.points = calloc(BATCH, sizeof *s.points);
  s.weights = calloc(BATCH, sizeof *s.weights);
  s.values = calloc(BATCH, sizeof *s.values);
  return s;
}

static void polar_sum_clear(polar_sum *s) {
  free(s->points);
  free(s->weights);
  free(s->values);
}

enum { KINDS = 4 };
static const struct {
  const char *name;
  hetab_precision precision;
  double tolerance;
} kinds[KINDS] = {{"float", HETAB_FLOAT, 0},
                  {"double, tolerance 1e-2", HETAB_DOUBLE, 1e-2},
                  {"double, tolerance 1e-7", HETAB_DOUBLE, 1e-7},
                  {"double", HETAB_DOUBLE, 0}};

/* What is in doubt is compared with a finer rule. */
static void compare_rules(hetab_context *ctx, hetab_engine *const *engines, polar_sum *other,
                          const hetab_point *p, honesty *h) {
  double truth = polar_rho_dd(other, p, gauss_rule_of(16, 3)), worst = 0;
  hetab_integral dd[KINDS];
  for (int k = 0; k < KINDS; k++) {
    dd[k] = reflectance_at(ctx, engines[kinds[k].precision], p, kinds[k].tolerance).dd;
    worst = fmax(worst, error_over_estimate(&dd[k], truth));
  }
  if (worst > 0.5)
    truth = polar_rho_dd(other, p, gauss_rule_of(MOST_ORDER, 2));
  for (int k = 0; k < KINDS; k++)
    honesty_add(&h[k], &dd[k], truth, p);
}

/* Needles to 0.05 degrees, mirrors, steep and sub-wavelength surfaces, total reflection, normal to
 * 89.9 degrees, against the other rule. HETAB_TRIALS=500 is the study (`make honesty`). */
static void test_honesty(void **state) {
  enum { SURFACES = 4, ANGLES = 4 };
  hetab_context *ctx = *state;
  hetab_engine *engines[] = {series_engine(ctx, HETAB_FLOAT), series_engine(ctx, HETAB_DOUBLE)};
  polar_sum other = new_polar_sum(ctx, engines[HETAB_DOUBLE]);
  honesty h[KINDS] = {{0}};
  const char *asked = getenv("HETAB_TRIALS");
  size_t surfaces = asked ? strtoul(asked, NULL, 10) : SURFACES;
  uint64_t seed = 11;
  for (size_t i = 0; i < surfaces; i++) {
    hetab_point p = random_point(&seed);
    const double deg[ANGLES] = {0, uniform(&seed, 0, 90), uniform(&seed, 80, 90), 89.9};
    for (size_t a = i % 2; a < ANGLES; a += 2) { /* of two surfaces, all four */
      p.theta_i = deg[a] * M_PI / 180;
      compare_rules(ctx, engines, &other, &p, h);
    }
  }
  for (int k = 0; k < KINDS; k++) {
    print_message("  %-24s error / estimate: at most %.2f, mean %.0e, %zu of %zu out of budget\n",
                  kinds[k].name, h[k].worst, exp(h[k].log_sum / (double)h[k].count), h[k].budget,
                  h[k].count);
    assert_int_equal(h[k].above + h[k].budget, 0);
  }
  polar_sum_clear(&other);
  hetab_engine_free(engines[HETAB_FLOAT]);
  hetab_engine_free(engines[HETAB_DOUBLE]);
}

/* What the study found, needles that the horizon cuts: on a slope of 1.7e-4, all of the shadow is
 * within 0.02 degrees of the rim, between the nodes of rules that agree with each other; and with a
 * kink far from the lobe, rays were sparse where the lobe is. */
static void test_found(void **state) {
  static const struct {
    hetab_point at;
    double right; /* by the other rule */
  } cases[] = {{{0.67537696510861722, 83.985092642641035, 0, 0, 0.013342958542437281,
                 79.023480544110811, 0.958, 6.69, 0},
                5.9275777926935e-4},
               {{0.68318325433832805, 89.9, 0, 0, 0.0082180765231259327, 107.84664615790211,
                 0.82309213250012991, 1.09925297192601e-05, 0},
                6.0554635743333e-5}};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    for (double tolerance = 1e-2; tolerance > 1e-10; tolerance /= 100) {
      hetab_point p = cases[i].at;
      p.theta_i *= M_PI / 180;
      hetab_integral dd = reflectance_at(ctx, engine, &p, tolerance).dd;
      assert_true(fabs(dd.value - cases[i].right) <= dd.error + 1e-12 * cases[i].right);
    }
  hetab_engine_free(engine);
}

/* ---- one call for many ---------------------------------------------------------------------- */

/* Batched integrals are those made one by one; wavelengths an octave apart share nothing. */
static void test_batches(void **state) {
  enum { BANDS = 4, COUNT = 5 };
  static const double lambda[BANDS] = {0.4, 0.79, 0.9, 4},
                      theta_i[COUNT] = {0, DEG(20), DEG(60), DEG(89), DEG(90)};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_DOUBLE);
  hetab_surface *surface;
  hetab_reflectance all[BANDS * COUNT];
  assert_ok(ctx, hetab_surface_create(ctx, 0.2, 4, 0.958, 6.69, lambda, BANDS, &surface));
  assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, COUNT, 0, all));
  for (int b = 0; b < BANDS; b++)
    for (int a = 0; a < COUNT; a++) {
      hetab_point p = point_of(0.2, 4, 0);
      p.theta_i = theta_i[a];
      p.lambda_um = lambda[b];
      hetab_reflectance one = reflectance_at(ctx, engine, &p, 0), *r = &all[b * COUNT + a];
      assert_true(fabs(one.dd.value - r->dd.value) <= one.dd.error + r->dd.error);
      assert_true(one.specular == r->specular && one.fresnel == r->fresnel);
    }
  for (int b = 0; b < BANDS; b++) {
    const hetab_reflectance *grazing = &all[b * COUNT + 4];
    assert_true(grazing->dd.value == 0 && grazing->dd.error == 0 && grazing->specular == 0);
    assert_true(grazing->fresnel == 1);
  }
  hetab_surface_free(surface);
  hetab_engine_free(engine);
}

/* The preset of the report over 31 wavelengths and 90 incidences, beside the product rule of 1 x 1
 * degree: times are printed, errors compared. */
static void test_speed(void **state) {
  enum { BANDS = 31, COUNT = 90, RUNS = 8 };
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_FLOAT);
  hetab_engine *reference = series_engine(ctx, HETAB_DOUBLE);
  hetab_surface *surface;
  static hetab_reflectance out[BANDS * COUNT];
  double theta_i[COUNT], best = HUGE_VAL, product = 0, worst = 0, worst_product = 0;
  for (int i = 0; i < COUNT; i++)
    theta_i[i] = DEG(i);
  assert_ok(ctx, hetab_surface_preset(ctx, "NGGAL", &surface));
  for (int run = 0; run < RUNS; run++) {
    double start = seconds();
    assert_ok(ctx, hetab_reflectance_dh(ctx, engine, surface, theta_i, COUNT, 0, out));
    best = fmin(best, seconds() - start);
  }
  const hetab_band *band = &hetab_surface_bands(surface)[15];
  static const int sample[] = {0, 20, 45, 70, 85};
  for (size_t i = 0; i < sizeof sample / sizeof *sample; i++) {
    hetab_point p = point_of(0.13, 5.4, sample[i]);
    p.sigma0_um = hetab_surface_sigma0_um(surface);
    p.tau_um = hetab_surface_tau_um(surface);
    p.lambda_um = band->lambda_um;
    p.n = band->n;
    p.k = band->k;
    double truth = reflectance_at(ctx, reference, &p, 0).dd.value, start = seconds();
    worst_product = fmax(worst_product, relative_error(product_rule(ctx, p, 90, 180), truth));
    product += (seconds() - start) / (sizeof sample / sizeof *sample);
    worst = fmax(worst, relative_error(out[15 * COUNT + sample[i]].dd.value, truth));
  }
  print_message("  %d x %d integrals in %.3f s, error %.1e; the 1 x 1 degree rule with the literal "
                "equations\n  would take %.0f s, error %.1e: %.0f times as long\n",
                BANDS, COUNT, best, worst, product * BANDS * COUNT, worst_product,
                product * BANDS * COUNT / best);
  assert_true(worst <= worst_product);
  hetab_surface_free(surface);
  hetab_engine_free(reference);
  hetab_engine_free(engine);
}

/* ---- bad input ------------------------------------------------------------------------------ */

static void test_bad_input(void **state) {
  static const double bad_theta_i[] = {DEG(91), -1, NAN, INFINITY};
  static const double bad_tolerance[] = {-1, 1, NAN};
  const char *const angle[] = {"theta_i", "[0, pi/2]", NULL}, *const tolerance[] = {"1e-5", NULL};
  const char *const literal[] = {"literal", NULL}, *const colour[] = {"400 to 700 nm", NULL};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_FLOAT);
  hetab_engine *host = new_engine(ctx, HETAB_DOUBLE, HETAB_METHOD_LITERAL, 0);
  hetab_surface *surface = new_surface(ctx, &aluminium);
  hetab_reflectance r = {.dh = 7};
  hetab_reflectance_colour c = {.error = 7};
  double theta_i = DEG(30);
  for (size_t i = 0; i < sizeof bad_theta_i / sizeof *bad_theta_i; i++)
    assert_fails(ctx, hetab_reflectance_dh(ctx, engine, surface, &bad_theta_i[i], 1, 0, &r),
                 HETAB_ERR_ARGUMENT, angle);
  for (size_t i = 0; i < sizeof bad_tolerance / sizeof *bad_tolerance; i++) {
    assert_fails(ctx, hetab_reflectance_dh(ctx, engine, surface, &theta_i, 1, bad_tolerance[i], &r),
                 HETAB_ERR_ARGUMENT, tolerance);
    assert_fails(ctx, hetab_reflectance_hh(ctx, engine, surface, bad_tolerance[i], &r),
                 HETAB_ERR_ARGUMENT, tolerance);
  }
  assert_fails(ctx, hetab_reflectance_dh(ctx, host, surface, &theta_i, 1, 0, &r),
               HETAB_ERR_UNSUPPORTED, literal);
  assert_fails(ctx, hetab_reflectance_rgb(ctx, surface, &r, 1, &c, NULL), HETAB_ERR_RANGE, colour);
  assert_true(r.dh == 7 && c.error == 7);
  hetab_surface_free(surface);
  hetab_engine_free(host);
  hetab_engine_free(engine);
}

/* A tolerance that the arithmetic cannot give is said, not pretended. */
static void test_stops(void **state) {
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_FLOAT);
  hetab_point p = point_of(0.13, 5.4, 30);
  assert_int_equal(reflectance_at(ctx, engine, &p, 1e-8).dd.stop, HETAB_STOP_ROUNDOFF);
  assert_int_equal(reflectance_at(ctx, engine, &p, 1e-4).dd.stop, HETAB_STOP_TOLERANCE);
  assert_string_equal(hetab_stop_name(HETAB_STOP_TOLERANCE), "tolerance");
  assert_string_equal(hetab_stop_name(HETAB_STOP_ROUNDOFF), "roundoff");
  assert_string_equal(hetab_stop_name(HETAB_STOP_BUDGET), "budget");
  hetab_engine_free(engine);
}

static int stop_at_once(void *user, double done, double total) {
  return 1;
}

static void test_cancelled(void **state) {
  const char *const stopped[] = {"stopped", NULL};
  hetab_context *ctx = *state;
  hetab_engine *engine = series_engine(ctx, HETAB_FLOAT);
  hetab_surface *surface = new_surface(ctx, &aluminium);
  hetab_reflectance r = {.dh = 7};
  double theta_i = DEG(30);
  hetab_set_progress(ctx, stop_at_once, NULL);
  assert_fails(ctx, hetab_reflectance_dh(ctx, engine, surface, &theta_i, 1, 0, &r),
               HETAB_ERR_CANCELLED, stopped);
  assert_true(r.dh == 7);
  hetab_surface_free(surface);
  hetab_engine_free(engine);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_golden_float),
      TEST(test_golden_double),
      TEST(test_mirror_limit),
      TEST(test_first_order),
      TEST(test_white_conductor),
      TEST(test_lambertian),
      TEST(test_brute_force),
      TEST(test_white_sky),
      TEST(test_white_sky_honesty),
      TEST(test_convergence),
      TEST(test_total_reflection),
      TEST(test_honesty),
      TEST(test_found),
      TEST(test_batches),
      TEST(test_speed),
      TEST(test_bad_input),
      TEST(test_stops),
      TEST(test_cancelled),
  };
  cmocka_set_test_filter(getenv("HETAB_TESTS")); /* a pattern; NULL: all */
  return cmocka_run_group_tests(tests, NULL, NULL);
}
