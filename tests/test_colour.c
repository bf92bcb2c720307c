/* Spectra to linear sRGB. */
#include "golden_support.h"

#include "model/colour.h"

/* Normal-incidence reflectance of a polished metal, at any wavelengths. */
static void metal_rgb(hetab_context *ctx, const char *symbol, const double *lambda_um, size_t count,
                      double rgb[3]) {
  double(*weights)[3] = calloc(count, sizeof *weights), xyz[3] = {0};
  hetab_index *index = NULL;
  if (symbol)
    assert_ok(ctx, hetab_index_metal(ctx, symbol, &index));
  assert_ok(ctx, hetab_xyz_weights(ctx, lambda_um, count, weights));
  for (size_t w = 0; w < count; w++) {
    double n = 1, k = 0, reflectance = 1;
    if (symbol) {
      assert_ok(ctx, hetab_index_at(ctx, index, lambda_um[w], 0, &n, &k));
      reflectance = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k);
    }
    for (int c = 0; c < 3; c++) {
      assert_true(weights[w][c] >= 0);
      xyz[c] += weights[w][c] * reflectance;
    }
  }
  hetab_xyz_to_srgb(xyz, rgb);
  if (!symbol) {
    assert_true(fabs(xyz[0] - 0.950470) < 1e-5 && fabs(xyz[1] - 1) < 1e-14);
    assert_true(fabs(xyz[2] - 1.088830) < 1e-5);
    for (int c = 0; c < 3; c++)
      assert_true(fabs(rgb[c] - 1) < 1e-13);
  }
  free(weights);
  hetab_index_free(index);
}

static void fill(double *lambda_um, size_t count) {
  for (size_t w = 0; w < count; w++)
    lambda_um[w] = 0.4 + 0.3 * (double)w / (double)(count - 1);
}

static const struct {
  const char *symbol;
  double rgb[3];
} metals[] = {{"Al", {0.9075, 0.9158, 0.9221}},
              {"Cu", {0.9316, 0.6225, 0.5224}},
              {"Au", {1.0376, 0.7285, 0.3645}},
              {NULL, {1, 1, 1}}};

static void check(hetab_context *ctx, const double *lambda_um, size_t count, double bound) {
  double error = 0;
  for (size_t m = 0; m < sizeof metals / sizeof *metals; m++) {
    double rgb[3];
    metal_rgb(ctx, metals[m].symbol, lambda_um, count, rgb);
    for (int c = 0; c < 3; c++)
      error = fmax(error, fabs(rgb[c] - metals[m].rgb[c]));
  }
  assert_below("linear sRGB", error, bound);
}

static void test_metals(void **state) {
  double lambda_um[31];
  fill(lambda_um, 31);
  check(*state, lambda_um, 31, TOL_COLOUR);
}

/* Finer grids hold the 31 bands, and see the same. */
static void test_finer_grids(void **state) {
  static const size_t counts[] = {61, 91, 301, 3001};
  double lambda_um[3001];
  for (size_t i = 0; i < 4; i++) {
    fill(lambda_um, counts[i]);
    check(*state, lambda_um, counts[i], TOL_COLOUR_FINE);
  }
}

/* Steps of every length, and more range than needed. */
static void test_uneven_grid(void **state) {
  double lambda_um[200];
  size_t count = 0;
  uint64_t r = 29;
  for (double nm = 400; nm < 700; nm += uniform(&r, 0.5, 10))
    lambda_um[count++] = nm / 1e3;
  lambda_um[count++] = 0.7;
  check(*state, lambda_um, count, TOL_COLOUR_UNEVEN);
}

static void test_wide_range(void **state) {
  double lambda_um[46], rgb[3];
  for (size_t w = 0; w < 46; w++)
    lambda_um[w] = 0.35 + 0.01 * (double)w;
  metal_rgb(*state, NULL, lambda_um, 46, rgb);
  for (int c = 0; c < 3; c++)
    assert_true(fabs(rgb[c] - 1) < TOL_COLOUR_FINE);
}

static void test_refused(void **state) {
  double lambda_um[31], weights[31][3];
  fill(lambda_um, 31);
  assert_fails(*state, hetab_xyz_weights(*state, lambda_um + 1, 30, weights), HETAB_ERR_RANGE,
               (const char *const[]){"400 to 700 nm", "410", NULL});
  assert_fails(*state, hetab_xyz_weights(*state, lambda_um, 30, weights), HETAB_ERR_RANGE,
               (const char *const[]){"690", "400:700:10", NULL});
  assert_fails(*state, hetab_xyz_weights(*state, lambda_um, 1, weights), HETAB_ERR_RANGE,
               (const char *const[]){"400:700:10", NULL});
  fill(lambda_um, 30);
  assert_fails(*state, hetab_xyz_weights(*state, lambda_um, 30, weights), HETAB_ERR_RANGE,
               (const char *const[]){"10 nm", "10.3448", NULL});
}

/* Rec. 709's primaries and white, as chromaticities. */
static void test_primaries(void **state) {
  static const double xy[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
  double worst_error = 0;
  for (int primary = 0; primary < 3; primary++) {
    double x = xy[primary][0], y = xy[primary][1], rgb[3];
    hetab_xyz_to_srgb((double[]){x / y, 1, (1 - x - y) / y}, rgb);
    for (int c = 0; c < 3; c++)
      if (c != primary)
        worst_error = fmax(worst_error, fabs(rgb[c] / rgb[primary]));
  }
  assert_below("primaries", worst_error, TOL_PRIMARIES);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_metals),     TEST(test_finer_grids), TEST(test_uneven_grid),
      TEST(test_wide_range), TEST(test_refused),     TEST(test_primaries),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
