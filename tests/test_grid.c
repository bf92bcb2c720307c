/* Axes of the grid: exact end points, cells, lists, and what is refused and how. */
#include "table_support.h"

#include <locale.h>
#include <math.h>

static hetab_grid *make_grid(hetab_context *ctx) {
  hetab_grid *grid;
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  return grid;
}

static void test_default(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_I), 90);
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_R), 90);
  assert_int_equal(hetab_grid_count(grid, HETAB_PHI), 181);
  assert_true(hetab_grid_deg(grid, HETAB_THETA_I)[0] == 0);
  assert_true(hetab_grid_deg(grid, HETAB_THETA_I)[89] == 90);
  for (size_t i = 0; i < 181; i++)
    assert_true(hetab_grid_deg(grid, HETAB_PHI)[i] == (double)i);
  assert_string_equal(hetab_axis_name(HETAB_PHI), "phi");
  hetab_grid_free(grid);
  hetab_grid_free(NULL);
}

static void test_ranges_end_exactly(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  for (int count = 2; count < 400; count++) {
    char spec[32];
    snprintf(spec, sizeof spec, "0.1:90:%d", count);
    assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_R, spec));
    const double *deg = hetab_grid_deg(grid, HETAB_THETA_R);
    assert_int_equal(hetab_grid_count(grid, HETAB_THETA_R), count);
    assert_true(deg[0] == 0.1 && deg[count - 1] == 90);
  }
  hetab_grid_free(grid);
}

static void test_cells_and_lists(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, "cells:4"));
  assert_int_equal(hetab_grid_count(grid, HETAB_PHI), 4);
  for (size_t i = 0; i < 4; i++)
    assert_true(hetab_grid_deg(grid, HETAB_PHI)[i] == 22.5 + 45 * (double)i);
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_I, "0,10, 20.5,90"));
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_I), 4);
  assert_true(hetab_grid_deg(grid, HETAB_THETA_I)[2] == 20.5);
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_I, "45"));
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_I), 1);
  hetab_grid_free(grid);
}

static void test_values(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  double good[] = {0, 30, 90}, nan[] = {0, NAN}, falling[] = {10, 5};
  assert_ok(f->ctx, hetab_grid_set_values(f->ctx, grid, HETAB_THETA_I, good, 3));
  good[1] = 7;
  assert_true(hetab_grid_deg(grid, HETAB_THETA_I)[1] == 30);
  assert_failure(f->ctx, hetab_grid_set_values(f->ctx, grid, HETAB_THETA_I, nan, 2),
                 HETAB_ERR_ARGUMENT, "theta_i");
  assert_failure(f->ctx, hetab_grid_set_values(f->ctx, grid, HETAB_PHI, falling, 2),
                 HETAB_ERR_ARGUMENT, "ascending");
  assert_failure(f->ctx, hetab_grid_set_values(f->ctx, grid, HETAB_PHI, good, 0),
                 HETAB_ERR_ARGUMENT, "count");
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_I), 3);
  hetab_grid_free(grid);
}

/* Every message names the axis, the text (or its beginning) and the remedy; the grid stays. */
static void test_malformed(void **state) {
  static const struct {
    const char *spec, *word;
  } cases[] = {
      {"", "start:stop:count"},
      {" ", "start:stop:count"},
      {"0:90", "start:stop:count"},
      {"a:b:c", "start:stop:count"},
      {"0:90:10:2", "start:stop:count"},
      {"0:90:10x", "start:stop:count"},
      {"nan", "start:stop:count"},
      {"inf", "start:stop:count"},
      {"0,10,", "start:stop:count"},
      {"0,,10", "start:stop:count"},
      {"0;10", "start:stop:count"},
      {"cells:", "start:stop:count"},
      {"cells:4,5", "start:stop:count"},
      {"0:nan:10", "start:stop:count"},
      {"90:0:10", "ascending"},
      {"10:10:2", "ascending"},
      {"0,20,10", "ascending"},
      {"0,10,10", "ascending"},
      {"0:91:10", "0 to 90"},
      {"-1:90:10", "0 to 90"},
      {"0,90.0000001", "0 to 90"},
      {"0:90:1", "2 to 100000"},
      {"0:90:2.5", "whole number"},
      {"0:90:-3", "whole number"},
      {"0:90:1e9", "2 to 100000"},
      {"cells:0", "1 to 100000"},
      {"cells:-1", "1 to 100000"},
      {"cells:100001", "1 to 100000"},
  };
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_status status = hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_R, cases[i].spec);
    assert_failure(f->ctx, status, HETAB_ERR_ARGUMENT, cases[i].word);
    assert_failure(f->ctx, status, HETAB_ERR_ARGUMENT, cases[i].spec);
    assert_failure(f->ctx, status, HETAB_ERR_ARGUMENT, "axis theta_r");
  }
  assert_int_equal(hetab_grid_count(grid, HETAB_THETA_R), 90);
  hetab_grid_free(grid);
}

static void test_long_text_keeps_the_remedy(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  char spec[5000];
  memset(spec, '7', sizeof spec - 1);
  spec[sizeof spec - 1] = '\0';
  spec[70] = 'x';
  assert_failure(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, spec), HETAB_ERR_ARGUMENT,
                 "cells:N");
  hetab_grid_free(grid);
}

static void test_largest(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, "0:180:100000"));
  assert_int_equal(hetab_grid_count(grid, HETAB_PHI), 100000);
  hetab_grid_free(grid);
}

static void test_other_locales(void **state) {
  fixture *f = *state;
  hetab_grid *grid = make_grid(f->ctx);
  if (!setlocale(LC_NUMERIC, "de_DE.UTF-8"))
    print_message("note: no locale with a decimal comma here, tried in the C locale\n");
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_I, "0.5,20.5"));
  assert_true(hetab_grid_deg(grid, HETAB_THETA_I)[1] == 20.5);
  setlocale(LC_NUMERIC, "C");
  hetab_grid_free(grid);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_default), TEST(test_ranges_end_exactly), TEST(test_cells_and_lists),
      TEST(test_values),  TEST(test_malformed),          TEST(test_long_text_keeps_the_remedy),
      TEST(test_largest), TEST(test_other_locales),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
