/* The microfacet material in a surface's place: its integrals, and where it is good. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <hetab/hetab.h>

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

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_where_it_is_good),
                                     cmocka_unit_test(test_share)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
