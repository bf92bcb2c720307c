/* The atlas of polynomials against the series it was made from. */
#include "golden_support.h"

#include "kernels/tables.h"
#include "model/atlas_fit.h"
#include "model/model.h"

enum { POINTS = 20000 };

/* The panel that holds g: panels ascend and touch. */
static const double *panel_of(const hetab_atlas *atlas, double g) {
  for (size_t p = 0; p < atlas->panel_count; p++) {
    const double *panel = atlas->panels + p * HETAB_PANEL_REALS;
    if (g >= panel[HETAB_PANEL_CENTRE] - 1 / panel[HETAB_PANEL_SCALE] &&
        g <= panel[HETAB_PANEL_CENTRE] + 1 / panel[HETAB_PANEL_SCALE])
      return panel;
  }
  fail_msg("no panel holds g = %g", g);
  return NULL;
}

/* ln h by the polynomials; table is either of the two layouts. */
static double atlas_ln_h(const hetab_atlas *atlas, const double *transposed, double g, double x) {
  const double *panel = panel_of(atlas, g);
  size_t first = (size_t)panel[HETAB_PANEL_FIRST],
         segment = first + (size_t)panel[HETAB_PANEL_COUNT] - 1;
  while (segment > first && x < atlas->segments[segment * HETAB_SEGMENT_REALS])
    segment--;
  const double *head = atlas->segments + segment * HETAB_SEGMENT_REALS;
  double u = (g - panel[HETAB_PANEL_CENTRE]) * panel[HETAB_PANEL_SCALE],
         t = (x - head[HETAB_SEGMENT_CENTRE]) * head[HETAB_SEGMENT_SCALE], sum = 0;
  size_t nx = (size_t)atlas->degree_x, ng = (size_t)atlas->degree_g;
  size_t pad_x = (size_t)atlas->pad_x, pad_g = (size_t)atlas->pad_g;
  for (size_t j = nx; j-- > 0;) {
    double c = 0;
    for (size_t k = ng; k-- > 0;)
      c = c * u + (transposed ? transposed[(segment * nx + j) * pad_g + k]
                              : atlas->coefficients[(segment * ng + k) * pad_x + j]);
    sum = sum * t + c;
  }
  return sum + log(head[HETAB_SEGMENT_H]);
}

static void check(hetab_context *ctx, double tolerance, double ln_h_end, int width) {
  hetab_atlas atlas = {0};
  double *transposed, worst_error = 0, worst_at[2] = {0}, most_start = 0;
  uint64_t r = 23;
  hetab_atlas_degrees(tolerance, width, &atlas);
  assert_true(atlas.pad_x % width == 0 && atlas.pad_x >= atlas.degree_x);
  assert_true(atlas.pad_g % width == 0 && atlas.pad_g >= atlas.degree_g);
  atlas.ln_h_end = ln_h_end;
  assert_ok(ctx, hetab_atlas_build(ctx, 1e-4, 1e5, tolerance, &atlas));
  assert_ok(ctx, hetab_atlas_transpose(ctx, &atlas, &transposed));
  for (int i = 0; i < POINTS; i++) {
    double g = i == 0 ? 1e-4 : i == 1 ? 1e5 : log_uniform(&r, 1e-4, 1e5);
    double end = panel_of(&atlas, g)[4], x = end;
    if (i % 4 == 0)
      x = i % 3 ? end * log_uniform(&r, 1e-6, 1) : 0;
    else if (i % 5)
      x = uniform(&r, 0, end);
    /* nothing above the end's value is left out */
    assert_true(hetab_ln_h(g, end) <= ln_h_end + 1e-6);
    double reference = hetab_ln_h(g, x);
    double error = fabs(expm1(atlas_ln_h(&atlas, NULL, g, x) - reference));
    assert_true(fabs(atlas_ln_h(&atlas, transposed, g, x) - atlas_ln_h(&atlas, NULL, g, x)) <
                1e-11);
    if (!(error <= worst_error)) {
      worst_error = error;
      worst_at[0] = g;
      worst_at[1] = x / end;
    }
  }
  /* segments start in order and cover each panel from 0 on */
  for (size_t p = 0; p < atlas.panel_count; p++) {
    const double *panel = atlas.panels + p * HETAB_PANEL_REALS;
    for (size_t s = 0; s < (size_t)panel[HETAB_PANEL_COUNT]; s++) {
      double start = atlas.segments[((size_t)panel[HETAB_PANEL_FIRST] + s) * HETAB_SEGMENT_REALS];
      assert_true(s == 0 ? start == 0 : start > most_start && start < panel[HETAB_PANEL_X_END]);
      most_start = start;
    }
  }
  print_message("  %zu panels, %zu segments, %d x %d coefficients; worst at g %g, x/end %g\n",
                atlas.panel_count, atlas.segment_count, atlas.degree_x, atlas.degree_g, worst_at[0],
                worst_at[1]);
  assert_below("atlas", worst_error, tolerance);
  free(transposed);
  hetab_atlas_clear(&atlas);
}

static void test_coarse(void **state) {
  check(*state, 1e-3, -45, 16);
}

static void test_float(void **state) {
  check(*state, 1e-6, -45, 16);
}

static void test_double(void **state) {
  check(*state, 1e-10, -45, 8);
}

static void test_scalar_device(void **state) {
  check(*state, 2e-6, -33, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_coarse),
      TEST(test_float),
      TEST(test_double),
      TEST(test_scalar_device),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
