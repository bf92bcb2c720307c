/* The microfacet material in a surface's place: its integrals, and where it is good. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <hetab/hetab.h>

#include "model/model.h"

static hetab_stand_in stand_in(hetab_microfacets distribution, const char *preset, double deg) {
  hetab_context *ctx;
  hetab_surface *surface;
  hetab_stand_in out;
  double theta_i = deg / 180.0 * M_PI;
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  assert_int_equal(hetab_surface_preset(ctx, preset, &surface), HETAB_OK);
  assert_int_equal(hetab_stand_in_compare(ctx, surface, distribution, 0.55, &theta_i, 1, &out),
                   HETAB_OK);
  hetab_surface_free(surface);
  hetab_context_free(ctx);
  return out;
}

/* The model's limit for rough surfaces: at normal incidence they agree to 1 %, share and energy
 * too; nearly a mirror at grazing, they have nothing in common. */
static void test_where_it_is_good(void **state) {
  static const char *const rough[] = {"BBQAL1", "GGAL120"};
  for (int i = 0; i < 2; i++) {
    hetab_stand_in at = stand_in(HETAB_BECKMANN, rough[i], 0.0);
    print_message("%s: error %.4f, energy %.4f\n", rough[i], at.error, at.energy);
    assert_true(at.error < 0.01 && fabs(at.energy - 1.0) < 0.01 && at.specular_share < 1e-6);
    assert_true(stand_in(HETAB_GGX, rough[i], 0.0).error > 0.1); /* another shape */
  }
  hetab_stand_in smooth = stand_in(HETAB_BECKMANN, "NGGAL", 75.0);
  print_message("NGGAL at 75: share %.4f, error %.4f\n", smooth.specular_share, smooth.error);
  assert_true(smooth.error > 1.0 && smooth.specular_share > 0.4);
}

/* The integral of f_dd here against the engine's, which tests/test_reflectance.c compares with 40
 * digits. */
static void test_share(void **state) {
  hetab_context *ctx;
  hetab_engine *engine;
  hetab_surface *surface;
  hetab_reflectance rho;
  double theta_i = 75.0 / 180.0 * M_PI, lambda_um = 0.55;
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  assert_int_equal(hetab_surface_preset(ctx, "NGGAL", &surface), HETAB_OK);
  assert_int_equal(hetab_surface_set_wavelengths(ctx, surface, &lambda_um, 1), HETAB_OK);
  assert_int_equal(hetab_engine_create(ctx, NULL, &engine), HETAB_OK);
  assert_int_equal(hetab_reflectance_dh(ctx, engine, surface, &theta_i, 1, 0.0, &rho), HETAB_OK);
  double share = rho.specular / (rho.specular + rho.dd.value);
  assert_true(fabs(stand_in(HETAB_BECKMANN, "NGGAL", 75.0).specular_share / share - 1.0) < 0.01);
  hetab_engine_free(engine);
  hetab_surface_free(surface);
  hetab_context_free(ctx);
}

/* The error by another rule: the literal equations and microfacets, from their definitions, at the
 * midpoints of (theta_r, phi). */
static double error_on_a_grid(hetab_microfacets distribution, hetab_point p) {
  enum { THETA = 300, PHI = 200 };
  double alpha = 2.0 * p.sigma0_um / p.tau_um, sums[2] = {0.0};
  for (int j = 0; j < THETA; j++)
    for (int k = 0; k < PHI; k++) {
      p.theta_r = (j + 0.5) / THETA * M_PI_2;
      p.phi = M_PI * (1.0 - pow((k + 0.5) / PHI, 2.0)); /* crowds about the mirror direction */
      double ci = cos(p.theta_i), cr = cos(p.theta_r), si = sin(p.theta_i), sr = sin(p.theta_r);
      double cos_d = sqrt(0.5 * (1.0 + ci * cr + si * sr * cos(p.phi)));
      double m = (ci + cr) / (2.0 * cos_d), t2 = (1.0 / (m * m) - 1.0) / (alpha * alpha);
      double a[2] = {ci / (si * alpha), cr / (sr * alpha)}, smith = 1.0, d;
      for (int end = 0; end < 2; end++)
        smith /=
            distribution == HETAB_GGX
                ? 0.5 + 0.5 * sqrt(1.0 + 1.0 / (a[end] * a[end]))
                : 0.5 * (1.0 + erf(a[end])) + exp(-a[end] * a[end]) / (2.0 * a[end] * sqrt(M_PI));
      d = (distribution == HETAB_GGX ? pow(1.0 + t2, -2.0) : exp(-t2)) /
          (M_PI * alpha * alpha * pow(m, 4.0));
      hetab_value value = hetab_literal(&p);
      double weight = cr * sr * (k + 0.5), f = d * smith / (4.0 * ci * cr);
      sums[0] += weight * fabs(hetab_fresnel_at(cos_d * cos_d, p.n, p.k) * f - value.dd);
      sums[1] += weight * value.dd;
    }
  return sums[0] / sums[1];
}

static void test_error_by_another_rule(void **state) {
  static const char *const presets[] = {"BBQAL1", "GGAL120", "NGGAL"};
  hetab_context *ctx;
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  for (int i = 0; i < 6; i++) {
    hetab_surface *surface;
    hetab_band band;
    hetab_microfacets distribution = i % 2 ? HETAB_GGX : HETAB_BECKMANN;
    assert_int_equal(hetab_surface_preset(ctx, presets[i / 2], &surface), HETAB_OK);
    assert_int_equal(hetab_surface_at(ctx, surface, 0.55, &band), HETAB_OK);
    hetab_point p = {.lambda_um = 0.55,
                     .n = band.n,
                     .k = band.k,
                     .sigma0_um = hetab_surface_sigma0_um(surface),
                     .tau_um = hetab_surface_tau_um(surface)};
    for (int deg = 30; deg <= 75; deg += 45) {
      p.theta_i = deg / 180.0 * M_PI;
      double error = stand_in(distribution, presets[i / 2], deg).error;
      assert_true(fabs(error / error_on_a_grid(distribution, p) - 1.0) < 0.01);
    }
    hetab_surface_free(surface);
  }
  hetab_context_free(ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_where_it_is_good),
                                     cmocka_unit_test(test_error_by_another_rule),
                                     cmocka_unit_test(test_share)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
