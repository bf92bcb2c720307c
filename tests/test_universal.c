/* The one table of h(g, x): against the series, and against 40-digit values. */
#include "golden_support.h"

#include "model/model.h"
#include "model/universal.h"

/* The worst relative error of h where it is above a part of h(g, 0). */
typedef struct band {
  double part, bound, worst;
} band;

static void add(band *bands, size_t count, double error, double ln_part) {
  for (size_t i = 0; i < count; i++)
    if (ln_part > log(bands[i].part))
      bands[i].worst = fmax(bands[i].worst, error);
}

static void test_against_the_series(void **state) {
  band bands[] = {{1e-6, 2e-5, 0.0}, {1e-9, 2e-4, 0.0}, {1e-14, 2e-2, 0.0}};
  for (double lg = -8.0; lg < 7.0; lg += 0.0537) {
    double g = pow(10.0, lg), top = hetab_ln_h(g, 0.0);
    for (double v = 0.0, part = 0.0; v < 120.0 && part > log(1e-14); v = 1.09 * v + 0.003) {
      double x = v * (1.0 + g), ln_h = hetab_ln_h(g, x);
      part = ln_h - top;
      add(bands, 3, fabs(expm1(hetab_universal_ln_h(g, x) - ln_h)), part);
    }
  }
  for (size_t i = 0; i < 3; i++)
    assert_below("h against the series", bands[i].worst, bands[i].bound);
}

/* dd with h of the table. */
static double dd_of(const hetab_point *p) {
  hetab_band band = {p->lambda_um, p->n, p->k, 0.0};
  hetab_wave wave = hetab_wave_of(p->sigma0_um, p->tau_um, &band);
  double tau_2sigma = p->tau_um / (2.0 * p->sigma0_um);
  hetab_direction in = hetab_direction_at(p->theta_i, tau_2sigma);
  hetab_direction out = hetab_direction_at(p->theta_r, tau_2sigma);
  hetab_pair pair = hetab_pair_of(&in, &out);
  double lateral2 = pair.d2 + pair.p * hetab_one_plus_cos(p->phi);
  double cos2 = fmin(0.25 * (pair.mu2 + lateral2), 1.0);
  return hetab_fresnel_at(cos2, p->n, p->k) * cos2 * cos2 * wave.amplitude * pair.shadow *
         exp(hetab_universal_ln_h(wave.g * pair.mu2 * pair.ratio2, wave.x * lateral2));
}

static void test_against_40_digits(void **state) {
  band bands[] = {{1e-6, 2e-5, 0.0}, {1e-9, 2e-4, 0.0}};
  size_t count;
  golden_point *golden = golden_points(&count);
  for (size_t i = 0; i < count; i++) {
    double part = hetab_ln_h(golden[i].g, golden[i].x) - hetab_ln_h(golden[i].g, 0.0);
    if (golden[i].dd > 0.0)
      add(bands, 2, relative_error(dd_of(&golden[i].point), golden[i].dd), part);
  }
  for (size_t i = 0; i < 2; i++)
    assert_below("dd against 40 digits", bands[i].worst, bands[i].bound);
  free(golden);
}

/* At the ends h is e^-x, and nothing overflows beyond the last node. */
static void test_limits(void **state) {
  assert_true(fabs(hetab_universal_ln_h(0.0, 3.0) + 3.0) < 1e-12);
  assert_true(fabs(hetab_universal_ln_h(1e12, 2e12) + 2.0 + 2.0 * log(1e12)) < 1e-4);
  assert_true(isfinite(hetab_universal_ln_h(1.0, 1e9)));
  assert_true(hetab_universal_ln_h(1.0, 1e9) < -1e8);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(test_against_the_series), TEST(test_against_40_digits),
                                     TEST(test_limits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
