/* Predictions: the envelope against brute force on the literal equations, curves in the plane, and
 * measured points made with a known roughness. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <hetab/hetab.h>
#include <hetab/measurements.h>
#include <hetab/predict.h>

#include "degrees.h"

static const double pi = 3.14159265358979323846;

typedef struct fixture {
  hetab_context *ctx;
  hetab_engine *engine; /* literal: no device */
} fixture;

static void assert_ok(const fixture *f, hetab_status status) {
  if (status != HETAB_OK)
    fail_msg("%s: %s", hetab_status_name(status), hetab_error_message(f->ctx));
}

static int set_up(void **state) {
  static fixture made;
  hetab_engine_options options = {.precision = HETAB_DOUBLE, .method = HETAB_METHOD_LITERAL};
  *state = &made;
  return hetab_context_create(&made.ctx) != HETAB_OK ||
         hetab_engine_create(made.ctx, &options, &made.engine) != HETAB_OK;
}

static int tear_down(void **state) {
  fixture *made = *state;
  hetab_engine_free(made->engine);
  hetab_context_free(made->ctx);
  return 0;
}

/* 0 to 1, always the same. */
static double random_number(void) {
  static uint64_t state = 88172645463325252ULL;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return (double)(state >> 11) / 9007199254740992.0;
}

static hetab_point random_point(void) {
  return (hetab_point){0.4 + 0.3 * random_number(),
                       1.5 * random_number(),
                       1.5 * random_number(),
                       pi * sqrt(random_number()), /* more of the mirror's side */
                       0.1 * pow(10, random_number()),
                       3 + 5 * random_number(),
                       1.2,
                       7,
                       random_number() < 0.2 ? 0.02 : 0};
}

/* ---- the envelope -------------------------------------------------------------------------- */

static hetab_interval around(double value, double share) {
  return (hetab_interval){value * (1 - share), value * (1 + share)};
}

static double quantity_at(const fixture *f, const hetab_point *point, hetab_bounded quantity) {
  hetab_value value;
  assert_ok(f, hetab_evaluate_literal(f->ctx, point, 1, &value));
  return quantity == HETAB_BOUNDED_TOTAL ? value.total : value.specular;
}

/* Samples spread evenly, not in the logarithm as the envelope's own. */
static void brute_force(const fixture *f, hetab_point point, const hetab_roughness_bounds *bounds,
                        hetab_bounded quantity, int samples, double extremes[2]) {
  int rectangle = bounds->tau_um.high > 0;
  hetab_interval s = bounds->sigma0_um, t = bounds->tau_um;
  extremes[0] = INFINITY;
  extremes[1] = -INFINITY;
  for (int i = 0; i < samples; i++)
    for (int k = 0; k < (rectangle ? samples : 1); k++) {
      point.sigma0_um = s.low + (s.high - s.low) * i / (samples - 1);
      if (rectangle)
        point.tau_um = t.low + (t.high - t.low) * k / (samples - 1);
      double value = quantity_at(f, &point, quantity);
      extremes[0] = fmin(extremes[0], value);
      extremes[1] = fmax(extremes[1], value);
    }
}

/* What of the true envelope lies outside the computed one: no more than `error` says, and no more
 * than `most` of the value. Below 1e-12 / sr differences are rounding. */
static double check_envelope(const fixture *f, const hetab_point *point,
                             const hetab_roughness_bounds *bounds, hetab_bounded quantity,
                             int samples, double most) {
  hetab_bounds found;
  double truth[2];
  assert_ok(f, hetab_envelope(f->ctx, f->engine, point, 1, bounds, quantity, &found));
  brute_force(f, *point, bounds, quantity, samples, truth);
  double outside = fmax(found.low - truth[0], truth[1] - found.high);
  double slack = 1e-12 + 1e-10 * found.high;
  assert_true(found.low <= found.nominal && found.nominal <= found.high);
  if (!(outside <= found.error + slack))
    fail_msg("%g outside the bounds, with a stated error of %g", outside, found.error);
  if (!(outside <= most * truth[1] + slack))
    fail_msg("%g outside the bounds %g to %g", outside, found.low, found.high);
  assert_true(found.error <= 1e-3 * found.high + slack);
  return outside / (truth[1] + 1e-12);
}

static void test_envelope_of_sigma0(void **state) {
  static const double shares[] = {0.1, 0.3, 0.6};
  fixture *f = *state;
  double worst = 0;
  size_t inside = 0;
  for (int i = 0; i < 150; i++) {
    hetab_point point = random_point();
    hetab_roughness_bounds bounds = {.sigma0_um = around(point.sigma0_um, shares[i % 3])};
    hetab_bounds ends[2], found;
    worst = fmax(worst, check_envelope(f, &point, &bounds, HETAB_BOUNDED_TOTAL, 4001, 1e-6));
    assert_ok(f,
              hetab_envelope(f->ctx, f->engine, &point, 1, &bounds, HETAB_BOUNDED_TOTAL, &found));
    for (int end = 0; end < 2; end++) {
      hetab_point at = point;
      at.sigma0_um = end ? bounds.sigma0_um.high : bounds.sigma0_um.low;
      ends[end] = (hetab_bounds){.nominal = quantity_at(f, &at, HETAB_BOUNDED_TOTAL)};
    }
    inside += found.high > (1 + 1e-6) * fmax(ends[0].nominal, ends[1].nominal);
  }
  print_message("envelope of sigma0: at most %.2g of the value missed; %zu of 150 maxima lie "
                "inside the interval\n",
                worst, inside);
  assert_true(inside >= 10); /* or the test would not see that only the ends were looked at */
}

static void test_envelope_of_wide_interval(void **state) {
  fixture *f = *state;
  double worst = 0;
  for (int i = 0; i < 40; i++) {
    hetab_point point = random_point();
    hetab_roughness_bounds bounds = {.sigma0_um = {0.05, 2}};
    worst = fmax(worst, check_envelope(f, &point, &bounds, HETAB_BOUNDED_TOTAL, 4001, 1e-6));
  }
  print_message("envelope of sigma0 0.05 to 2 um: at most %.2g of the value missed\n", worst);
}

static void test_envelope_of_rectangle(void **state) {
  fixture *f = *state;
  double worst = 0;
  for (int i = 0; i < 50; i++) {
    hetab_point point = random_point();
    hetab_roughness_bounds bounds = {around(point.sigma0_um, i & 1 ? 0.1 : 0.4),
                                     around(point.tau_um, i & 2 ? 0.1 : 0.4)};
    worst = fmax(worst, check_envelope(f, &point, &bounds, HETAB_BOUNDED_TOTAL, 65, 1e-6));
  }
  print_message("envelope of sigma0 and tau: at most %.2g of the value missed\n", worst);
}

/* Larger sigma0, less of the specular delta: the ends are the bounds. */
static void test_envelope_of_specular(void **state) {
  fixture *f = *state;
  for (int i = 0; i < 20; i++) {
    hetab_point point = random_point();
    point.sigma0_um *= 0.2;
    hetab_roughness_bounds bounds = {.sigma0_um = around(point.sigma0_um, 0.1)};
    check_envelope(f, &point, &bounds, HETAB_BOUNDED_SPECULAR, 401, 1e-6);
  }
}

static void test_no_interval_no_width(void **state) {
  fixture *f = *state;
  hetab_point point = random_point();
  hetab_roughness_bounds none = {0}, still = {around(point.sigma0_um, 0), {0, 0}};
  for (int i = 0; i < 2; i++) {
    hetab_bounds found;
    assert_ok(f, hetab_envelope(f->ctx, f->engine, &point, 1, i ? &still : &none,
                                HETAB_BOUNDED_TOTAL, &found));
    assert_true(found.low == found.nominal && found.high == found.nominal && found.error == 0);
  }
}

static void test_bad_intervals(void **state) {
  static const hetab_interval bad[] = {{-1, 1}, {0, 1}, {2, 1}, {NAN, 1}, {1, INFINITY}};
  fixture *f = *state;
  hetab_point point = random_point();
  hetab_bounds found;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    hetab_roughness_bounds bounds = {.tau_um = bad[i]};
    assert_int_equal(
        hetab_envelope(f->ctx, f->engine, &point, 1, &bounds, HETAB_BOUNDED_TOTAL, &found),
        HETAB_ERR_ARGUMENT);
    assert_non_null(strstr(hetab_error_message(f->ctx), "tau"));
  }
}

/* ---- curves -------------------------------------------------------------------------------- */

static hetab_surface *make_surface(const fixture *f) {
  static const double lambda_um[] = {0.5, 0.6};
  hetab_surface *surface;
  assert_ok(f, hetab_surface_create(f->ctx, 0.5, 5, 1.1, 6, lambda_um, 2, &surface));
  return surface;
}

static void test_curves(void **state) {
  static const double theta_i[] = {DEG(20), DEG(60)};
  fixture *f = *state;
  hetab_surface *surface = make_surface(f);
  hetab_prediction *p;
  hetab_predict_options options = {.bounds = {.sigma0_um = {0.45, 0.55}},
                                   .theta_i = theta_i,
                                   .theta_i_count = 2,
                                   .step = DEG(5)};
  assert_ok(f, hetab_predict(f->ctx, f->engine, surface, &options, &p));
  assert_int_equal(p->curve_count, 4);
  assert_int_equal(p->theta_r_count, 37);
  assert_true(p->bounds.tau_um.low == 5 && p->bounds.tau_um.high == 5);
  for (size_t c = 0; c < 4; c++) {
    const hetab_prediction_curve *curve = &p->curves[c];
    assert_true(fabs(curve->lambda_um - (c < 2 ? 0.5 : 0.6)) < 1e-12);
    assert_true(fabs(curve->peak - theta_i[c % 2]) <= DEG(15.1) && curve->peak > 0);
    for (size_t i = 0; i < 37; i++) {
      double theta_r_deg = -90 + 5 * (double)i;
      hetab_point point = {curve->lambda_um,
                           theta_i[c % 2],
                           fabs(theta_r_deg) * pi / 180,
                           theta_r_deg > 0 ? pi : 0,
                           0.5,
                           5,
                           1.1,
                           6,
                           0};
      double expected = quantity_at(f, &point, HETAB_BOUNDED_TOTAL);
      assert_true(fabs(p->theta_r[i] - DEG(theta_r_deg)) < 1e-14);
      assert_true(fabs(curve->f[i].nominal - expected) <= 1e-12 * expected);
    }
    assert_true(curve->specular.low < curve->specular.high);
  }
  print_message("largest stated error of the curves' bounds: %.2g of the value\n", p->error);
  assert_true(p->error > 0 && p->error < 1e-4);
  hetab_prediction_free(p);
  hetab_surface_free(surface);
}

/* ---- measured points ----------------------------------------------------------------------- */

enum { VIEWS = 36 };

/* The model at another roughness, in the plane and across it. */
static hetab_measurements *make_measurements(const fixture *f, double sigma0_um, double factor) {
  static const double lambda_um[] = {0.5, 0.6};
  hetab_directions pairs[VIEWS];
  double values[VIEWS][2];
  hetab_measurements *m;
  for (int i = 0; i < VIEWS; i++) {
    pairs[i] = (hetab_directions){pi / 6, (i % 12) * pi / 26, (i / 12) * pi / 2};
    for (int b = 0; b < 2; b++) {
      hetab_point point = {
          lambda_um[b], pairs[i].theta_i, pairs[i].theta_r, pairs[i].phi, sigma0_um, 5, 1.1, 6, 0};
      values[i][b] = factor * quantity_at(f, &point, HETAB_BOUNDED_TOTAL);
    }
  }
  values[0][0] = NAN;
  assert_ok(f, hetab_measurements_create(f->ctx, lambda_um, 2, pairs, VIEWS, &values[0][0], &m));
  return m;
}

static hetab_prediction *judge(const fixture *f, double sigma0_um, double factor, double accuracy,
                               double exclude_mirror) {
  static const double theta_i[] = {DEG(30), DEG(50)};
  hetab_surface *surface = make_surface(f);
  hetab_measurements *m = make_measurements(f, sigma0_um, factor);
  hetab_prediction *p;
  hetab_predict_options options = {.bounds = {.sigma0_um = {0.45, 0.55}},
                                   .theta_i = theta_i,
                                   .theta_i_count = 2,
                                   .step = DEG(30),
                                   .measurements = m,
                                   .accuracy = accuracy,
                                   .exclude_mirror = exclude_mirror};
  assert_ok(f, hetab_predict(f->ctx, f->engine, surface, &options, &p));
  hetab_measurements_free(m);
  hetab_surface_free(surface);
  return p;
}

static void test_points_within(void **state) {
  fixture *f = *state;
  hetab_prediction *p = judge(f, 0.52, 1, 0, 0);
  assert_int_equal(p->point_count, 2 * VIEWS - 1);
  assert_int_equal(p->hemisphere.points, p->point_count);
  assert_int_equal(p->hemisphere.within, p->point_count);
  /* 12 views at phi 0 and 180 each, and the normal's of phi 90 */
  assert_int_equal(p->plane.points, 2 * 25 - 1);
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_predicted_point *point = &p->points[i];
    assert_true(p->curves[point->curve].theta_i == DEG(30));
    if (point->in_plane && point->directions.theta_r > 0)
      assert_int_equal(point->plane_theta_r > 0, point->directions.phi > 3);
  }
  hetab_prediction_free(p);
}

static void test_points_outside(void **state) {
  fixture *f = *state;
  hetab_prediction *p = judge(f, 0.5, 3, 0, 0);
  assert_true(p->hemisphere.above > p->point_count / 2 && p->hemisphere.below == 0);
  assert_true(fabs(p->hemisphere.bias - 2) < 1e-9);
  size_t above = p->hemisphere.above;
  hetab_prediction_free(p);
  p = judge(f, 0.5, 3, 0.5, 0); /* half of a measured value may be the instrument's */
  assert_true(p->hemisphere.above < above);
  hetab_prediction_free(p);
  p = judge(f, 0.5, 0.2, 0, 0);
  assert_true(p->hemisphere.below > p->point_count / 2 && p->hemisphere.above == 0);
  hetab_prediction_free(p);
  p = judge(f, 0.5, 1, 0, DEG(8)); /* of theta_r 27.7 and 34.6 degrees, the mirror's neighbours */
  assert_int_equal(p->point_count, 2 * VIEWS - 1 - 2 * 2);
  hetab_prediction_free(p);
}

static void test_bad_options(void **state) {
  static const double good[] = {DEG(30)}, grazing[] = {DEG(90)}, other[] = {DEG(12)}, far[] = {0.9};
  fixture *f = *state;
  hetab_surface *surface = make_surface(f);
  hetab_measurements *m = make_measurements(f, 0.5, 1);
  const struct {
    hetab_predict_options options;
    hetab_status status;
    const char *word;
  } cases[] = {
      {{.theta_i_count = 0}, HETAB_ERR_ARGUMENT, "no incidence"},
      {{.theta_i = grazing, .theta_i_count = 1}, HETAB_ERR_ARGUMENT, "below 90"},
      {{.theta_i = good, .theta_i_count = 1, .step = -1}, HETAB_ERR_ARGUMENT, "step"},
      {{.theta_i = good, .theta_i_count = 1, .accuracy = 2}, HETAB_ERR_ARGUMENT, "accuracy"},
      {{.theta_i = good, .theta_i_count = 1, .bounds = {.sigma0_um = {0.6, 0.7}}},
       HETAB_ERR_ARGUMENT,
       "sigma0, 0.5 um"},
      {{.theta_i = other, .theta_i_count = 1, .measurements = m},
       HETAB_ERR_RANGE,
       "no measurement"},
      {{.theta_i = good,
        .theta_i_count = 1,
        .lambda_um = far,
        .lambda_count = 1,
        .measurements = m},
       HETAB_ERR_RANGE,
       "no measurement"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_prediction *p = (void *)f;
    assert_int_equal(hetab_predict(f->ctx, f->engine, surface, &cases[i].options, &p),
                     cases[i].status);
    assert_null(p);
    if (!strstr(hetab_error_message(f->ctx), cases[i].word))
      fail_msg("'%s' is not in: %s", cases[i].word, hetab_error_message(f->ctx));
  }
  hetab_measurements_free(m);
  hetab_surface_free(surface);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_envelope_of_sigma0),
      cmocka_unit_test(test_envelope_of_wide_interval),
      cmocka_unit_test(test_envelope_of_rectangle),
      cmocka_unit_test(test_envelope_of_specular),
      cmocka_unit_test(test_no_interval_no_width),
      cmocka_unit_test(test_bad_intervals),
      cmocka_unit_test(test_curves),
      cmocka_unit_test(test_points_within),
      cmocka_unit_test(test_points_outside),
      cmocka_unit_test(test_bad_options),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
