/* The parts of the model's source texts: the few wavelengths that hold a colour. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "core/random.h"
#include "model/colour.h"
#include "model/model.h"
#include "shader/shader_parts.h"

enum { BANDS = 31, SURFACES = 400 };

/* A surface of a random metal and roughness at random directions near the mirror's; what it
 * reflects there, dd and the delta. */
static void spectra(hetab_context *ctx, uint64_t *random, double dd[BANDS], double rho[BANDS]) {
  hetab_index *index;
  size_t metal = (size_t)(hetab_random_unit(random) * (double)hetab_metal_count());
  double sigma0 = pow(10.0, -2.0 + 2.3 * hetab_random_unit(random));
  double tau = pow(10.0, 1.2 * hetab_random_unit(random));
  double theta_i = 1.45 * hetab_random_unit(random);
  hetab_point p = {.theta_i = theta_i,
                   .theta_r = fmin(1.5, fabs(theta_i + 0.6 * hetab_random_unit(random) - 0.3)),
                   .phi = M_PI + 0.6 * hetab_random_unit(random) - 0.3,
                   .sigma0_um = sigma0,
                   .tau_um = tau};
  assert_int_equal(hetab_index_metal(ctx, hetab_metal_symbol(metal), &index), HETAB_OK);
  for (int b = 0; b < BANDS; b++) {
    p.lambda_um = 0.4 + 0.01 * b;
    assert_int_equal(hetab_index_at(ctx, index, p.lambda_um, 1, &p.n, &p.k), HETAB_OK);
    hetab_value value = hetab_literal(&p);
    dd[b] = value.dd;
    rho[b] = value.specular;
  }
  hetab_index_free(index);
}

/* The largest difference of a channel, relative to luminance; 0 for what is all but black. */
static double error_of(const double spectrum[BANDS], double (*weights)[3], double (*xyz)[3],
                       size_t count) {
  const hetab_colour_node *nodes = hetab_colour_nodes(count);
  double luminance = 0.0, worst = 0.0;
  for (int b = 0; b < BANDS; b++)
    luminance += xyz[b][1] * spectrum[b];
  for (int c = 0; c < 3; c++) {
    double difference = 0.0;
    for (int b = 0; b < BANDS; b++)
      difference += weights[b][c] * spectrum[b];
    for (size_t i = 0; i < count; i++)
      difference -= nodes[i].rgb[c] * spectrum[(nodes[i].nm - 400) / 10];
    worst = fmax(worst, fabs(difference) / luminance);
  }
  return luminance > 1e-4 ? worst : 0.0;
}

static void test_colour_nodes(void **state) {
  hetab_context *ctx;
  uint64_t random = 7;
  double lambda_um[BANDS], weights[BANDS][3], xyz[BANDS][3], dd[BANDS], rho[BANDS];
  static const struct {
    size_t count;
    double bound;
  } sets[] = {{8, 6e-3}, {16, 5e-4}};
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  for (int b = 0; b < BANDS; b++)
    lambda_um[b] = 0.4 + 0.01 * b;
  assert_int_equal(hetab_srgb_weights(ctx, lambda_um, BANDS, weights), HETAB_OK);
  assert_int_equal(hetab_xyz_weights(ctx, lambda_um, BANDS, xyz), HETAB_OK);
  double worst[2] = {0.0};
  for (int i = 0; i < SURFACES; i++) {
    spectra(ctx, &random, dd, rho);
    for (int s = 0; s < 2; s++)
      worst[s] = fmax(worst[s], fmax(error_of(dd, weights, xyz, sets[s].count),
                                     error_of(rho, weights, xyz, sets[s].count)));
  }
  for (int s = 0; s < 2; s++) {
    print_message("%zu wavelengths: %.2e of luminance\n", sets[s].count, worst[s]);
    assert_true(worst[s] < sets[s].bound);
  }
  hetab_context_free(ctx);
}

/* Every mark of a template is filled in, and what cannot be is refused. */
static void test_texts(void **state) {
  hetab_context *ctx;
  char *text;
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  for (int language = 0;
       hetab_shader_text(ctx, NULL, (hetab_shader_language)language, &text) == HETAB_OK;
       language++) {
    assert_null(strstr(text, "@TABLE"));
    assert_null(strstr(text, "@he_torrance"));
    free(text);
  }
  assert_non_null(strstr(hetab_error_message(ctx), "no language"));
  assert_null(text);
  hetab_context_free(ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_colour_nodes),
                                     cmocka_unit_test(test_texts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
