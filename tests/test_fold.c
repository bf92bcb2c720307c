/* The specular delta as a lobe: its energy, integrated by another rule, and its reciprocity. */
#include "golden_support.h"

#include "model/fold.h"

/* int f cos over the viewers of theta_i, per wavelength: midpoints in theta_r and phi. */
static void energy(const hetab_fold *fold, const hetab_surface *surface, double theta_i,
                   double cone, size_t bands, double *out) {
  enum { N = 300 };
  double low = fmax(theta_i - 2.2 * cone, 0.0), high = fmin(theta_i + 2.2 * cone, M_PI_2);
  double wide = fmin(M_PI, 2.2 * cone / fmax(sin(low), 1e-3)), step = (high - low) / N;
  double tau_2sigma = hetab_tau_2sigma(surface);
  hetab_direction in = hetab_direction_at(theta_i, tau_2sigma);
  memset(out, 0, bands * sizeof *out);
  for (int t = 0; t < N; t++) {
    hetab_direction to = hetab_direction_at(low + (t + 0.5) * step, tau_2sigma);
    hetab_pair pair = hetab_pair_of(&in, &to);
    for (int p = 0; p < N; p++) { /* one side of the plane of incidence */
      double value[31] = {0.0}, weight = 2.0 * to.mu * to.s * step * wide / N;
      double sin2_h = hetab_sin2_h(&pair, hetab_one_plus_cos(M_PI - (p + 0.5) * wide / N));
      hetab_fold_add(fold, theta_i, to.theta, sin2_h, value);
      for (size_t b = 0; b < bands; b++)
        out[b] += value[b] * weight;
    }
  }
}

static void check_energy(hetab_context *ctx, hetab_surface *surface, double cone_deg,
                         double bound) {
  size_t bands = hetab_surface_band_count(surface);
  double worst = 0.0, found[31], rho[31], cone = hetab_radians(cone_deg);
  hetab_fold *fold;
  assert_ok(ctx, hetab_fold_create(ctx, surface, hetab_surface_bands(surface), bands, cone, &fold));
  for (double deg = 0.0; deg <= 85.0; deg += 8.5) {
    double theta_i = hetab_radians(deg);
    assert_ok(ctx, hetab_specular_reflectance(ctx, surface, &theta_i, 1, rho));
    energy(fold, surface, theta_i, cone, bands, found);
    for (size_t b = 0; b < bands; b++)
      worst = fmax(worst, rho[b] > 1e-3 ? relative_error(found[b], rho[b]) : 0.0);
  }
  hetab_fold_free(fold);
  print_message("  %s, %g degrees\n", hetab_surface_name(surface), cone_deg);
  assert_below("energy against rho_s", worst, bound);
}

static void test_energy(void **state) {
  static const char *const names[] = {"NGGAL", "BBQAL2"};
  for (size_t i = 0; i < 2; i++) {
    hetab_surface *surface;
    assert_ok(*state, hetab_surface_open(*state, names[i], &surface));
    check_energy(*state, surface, 2.0, 2e-3);
    check_energy(*state, surface, 0.5, 2e-3);
    check_energy(*state, surface, i ? 5.0 : 20.0, 1e-2); /* what rises by orders in 20 degrees */
    hetab_surface_free(surface);
  }
}

static void test_reciprocity(void **state) {
  hetab_surface *surface;
  hetab_fold *fold;
  double a[31] = {0.0}, b[31] = {0.0};
  assert_ok(*state, hetab_surface_open(*state, "NGGAL", &surface));
  assert_ok(*state, hetab_fold_create(*state, surface, hetab_surface_bands(surface), 31,
                                      hetab_radians(3.0), &fold));
  hetab_fold_add(fold, 1.0, 1.03, 2e-4, a);
  hetab_fold_add(fold, 1.03, 1.0, 2e-4, b);
  assert_memory_equal(a, b, sizeof a);
  assert_true(a[0] > 0.0);
  memset(a, 0, sizeof a);
  hetab_fold_add(fold, 1.0, 1.2, sin(0.06) * sin(0.06), a);
  assert_true(a[0] == 0.0); /* outside the cone */
  hetab_fold_free(fold);
  hetab_surface_free(surface);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(test_energy), TEST(test_reciprocity)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
