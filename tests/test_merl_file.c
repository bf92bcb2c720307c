/* MERL files: every byte of them, the reference reader's cell, and bad input. */
#include "table_support.h"

#include <math.h>

enum { BYTES = 34992012 };

static const double pi = 3.14159265358979323846;

static hetab_merl *make_merl(hetab_context *ctx) {
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  return merl;
}

/* A value that tells its place; some cells are below the horizon. */
static double value_at(int channel, size_t h, size_t d, size_t p) {
  if ((h + d + p) % 7 == 3)
    return -1;
  return 1e-3 * (double)(1 + channel) + 10.0 * (double)h + 0.1 * (double)d + 1e-5 * (double)p;
}

static hetab_merl *make_filled(hetab_context *ctx) {
  hetab_merl *merl = make_merl(ctx);
  for (int c = 0; c < 3; c++) {
    double *next = hetab_merl_channel(merl, c);
    for (size_t h = 0; h < 90; h++)
      for (size_t d = 0; d < 90; d++)
        for (size_t p = 0; p < 180; p++)
          *next++ = value_at(c, h, d, p);
  }
  return merl;
}

/* --- layout --------------------------------------------------------------------------------- */

static double little_endian_double(const unsigned char *bytes) {
  uint64_t bits = 0;
  double value;
  for (int i = 7; i >= 0; i--)
    bits = bits << 8 | bytes[i];
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* The whole file, from the last byte of the format's description and nothing of the library's. */
static void test_every_byte(void **state) {
  static const unsigned char header[12] = {90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0};
  static const double scale[3] = {1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0};
  fixture *f = *state;
  hetab_merl *merl = make_filled(f->ctx);
  size_t size;
  assert_ok(f->ctx, hetab_merl_save(f->ctx, merl, "a.binary", 0));
  hetab_merl_free(merl);
  unsigned char *bytes = get_file("a.binary", &size);
  assert_int_equal(size, BYTES);
  assert_memory_equal(bytes, header, sizeof header);
  for (size_t i = 0; i < 3 * 90 * 90 * 180; i++) {
    size_t p = i % 180, d = i / 180 % 90, h = i / 16200 % 90;
    int c = (int)(i / 1458000);
    double expected = value_at(c, h, d, p), stored = little_endian_double(bytes + 12 + 8 * i);
    if (!(expected < 0 ? stored == -1 : fabs(stored * scale[c] - expected) <= 1e-15 * expected))
      fail_msg("channel %d, cell %zu %zu %zu holds %g", c, h, d, p, stored);
  }
  free(bytes);
}

static void test_round_trip(void **state) {
  fixture *f = *state;
  hetab_merl *merl = make_filled(f->ctx), *read;
  assert_ok(f->ctx, hetab_merl_save(f->ctx, merl, "a.binary", 0));
  assert_ok(f->ctx, hetab_merl_load(f->ctx, "a.binary", &read));
  for (int c = 0; c < 3; c++)
    for (size_t i = 0; i < HETAB_MERL_CELLS; i++) {
      double wrote = hetab_merl_channel(merl, c)[i], got = hetab_merl_channel_const(read, c)[i];
      if (!(fabs(got - wrote) <= 1e-15 * fabs(wrote)))
        fail_msg("channel %d, cell %zu: %.17g became %.17g", c, i, wrote, got);
    }
  hetab_merl_free(read);
  hetab_merl_free(merl);
  hetab_merl_free(NULL);
}

/* --- cells ---------------------------------------------------------------------------------- */

/* The position in the table, not yet truncated, in long double and from other formulas than the
 * library's: theta_d is half the angle between the directions, phi_d is measured in the tangent
 * frame of the half vector. The light's azimuth is any. */
static void position(double theta_i, double theta_r, double azimuth, double phi,
                     long double out[3]) {
  const long double pi_l = 3.14159265358979323846264338327950288L;
  long double ai = azimuth, ar = (long double)azimuth + phi;
  long double i[3] = {sinl(theta_i) * cosl(ai), sinl(theta_i) * sinl(ai), cosl(theta_i)};
  long double r[3] = {sinl(theta_r) * cosl(ar), sinl(theta_r) * sinl(ar), cosl(theta_r)};
  long double h[3], dot = 0, length = 0;
  for (int k = 0; k < 3; k++) {
    h[k] = i[k] + r[k];
    dot += i[k] * r[k];
    length += h[k] * h[k];
  }
  long double theta_h = acosl(h[2] / sqrtl(length)), phi_h = atan2l(h[1], h[0]);
  long double east = i[1] * cosl(phi_h) - i[0] * sinl(phi_h);
  long double south =
      (i[0] * cosl(phi_h) + i[1] * sinl(phi_h)) * cosl(theta_h) - i[2] * sinl(theta_h);
  long double phi_d = atan2l(east, south);
  out[0] = 90 * sqrtl(2 * theta_h / pi_l);
  out[1] = 90 * acosl(dot) / pi_l;
  out[2] = 180 * (phi_d < 0 ? phi_d + pi_l : phi_d) / pi_l;
}

static double uniform(uint64_t *seed) {
  *seed = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(*seed >> 11) / 9007199254740992.0;
}

/* Truncation is only decided by more than rounding errors. */
static int agrees(size_t index, long double position, size_t count) {
  long double low = floorl(position - 1e-9L), high = floorl(position + 1e-9L);
  long double last = (long double)count - 1;
  long double found = (long double)index;
  return found == fminl(low, last) || found == fminl(high, last);
}

static void test_cells_of_random_directions(void **state) {
  uint64_t seed = 1;
  for (int n = 0; n < 100000; n++) {
    double theta_i = uniform(&seed) * pi / 2, theta_r = uniform(&seed) * pi / 2;
    double azimuth = uniform(&seed) * 2 * pi, phi = (uniform(&seed) - 0.5) * 4 * pi;
    size_t cell = hetab_merl_cell((hetab_directions){theta_i, theta_r, phi});
    long double at[3];
    position(theta_i, theta_r, azimuth, phi, at);
    if (!agrees(cell / 16200, at[0], 90) || !agrees(cell / 180 % 90, at[1], 90) ||
        !agrees(cell % 180, at[2], 180))
      fail_msg("(%.17g, %.17g, %.17g) is at (%Lg, %Lg, %Lg), not in cell %zu", theta_i, theta_r,
               phi, at[0], at[1], at[2], cell);
  }
}

static void assert_cell(double theta_i, double theta_r, double phi, size_t h, size_t d, size_t p) {
  double deg = pi / 180;
  assert_int_equal(hetab_merl_cell((hetab_directions){theta_i * deg, theta_r * deg, phi * deg}),
                   (h * 90 + d) * 180 + p);
}

/* Where angles are undefined: rounding noise must not choose the cell. */
static void test_cells_of_special_directions(void **state) {
  assert_cell(0, 0, 0, 0, 0, 0);
  assert_cell(0, 0, 123, 0, 0, 0);
  for (int i = 1; i < 89; i++) {
    double theta = i + 0.5;
    assert_cell(theta, theta, 180, 0, (size_t)i, 0);
    assert_cell(theta, theta, -180, 0, (size_t)i, 0);
    assert_cell(theta, theta, 0, (size_t)sqrt(theta * 90), 0, 0);
    assert_cell(theta, theta, 360, (size_t)sqrt(theta * 90), 0, 0);
  }
  assert_cell(61, 0, 77, (size_t)sqrt(30.5 * 90), 30, 0);
  assert_cell(0, 61, 0, (size_t)sqrt(30.5 * 90), 30, 179);
  assert_cell(90, 90, 180, 0, 89, 0);
  assert_cell(90, 90, 0, 89, 0, 0);
  assert_true(hetab_merl_cell((hetab_directions){NAN, 1, 1}) < HETAB_MERL_CELLS);
  assert_true(hetab_merl_cell((hetab_directions){1, 1, INFINITY}) < HETAB_MERL_CELLS);
}

static void test_lookup(void **state) {
  fixture *f = *state;
  hetab_merl *merl = make_filled(f->ctx);
  uint64_t seed = 2;
  for (int n = 0; n < 1000; n++) {
    double theta_i = uniform(&seed) * pi / 2, theta_r = uniform(&seed) * pi / 2;
    double phi = uniform(&seed) * pi, rgb[3];
    size_t cell = hetab_merl_cell((hetab_directions){theta_i, theta_r, phi});
    hetab_merl_lookup(merl, (hetab_directions){theta_i, theta_r, phi}, rgb);
    for (int c = 0; c < 3; c++)
      assert_true(rgb[c] == value_at(c, cell / 16200, cell / 180 % 90, cell % 180));
  }
  hetab_merl_free(merl);
}

/* --- refusals ------------------------------------------------------------------------------- */

static void test_bad_cells_are_not_written(void **state) {
  static const double bad[][3] = {{NAN, 1, 1},   {1, INFINITY, 1}, {1, 1, -1},
                                  {-1, -1, 0.1}, {-2, -2, -2},     {-1e-9, 0, 0}};
  fixture *f = *state;
  hetab_merl *merl = make_merl(f->ctx);
  size_t cell = (12 * 90 + 34) * 180 + 56;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    for (int c = 0; c < 3; c++)
      hetab_merl_channel(merl, c)[cell] = bad[i][c];
    assert_failure(f->ctx, hetab_merl_save(f->ctx, merl, "a.binary", 0), HETAB_ERR_ARGUMENT,
                   "theta_h 12, theta_d 34, phi_d 56");
  }
  assert_int_equal(count_files("."), 0);
  hetab_merl_free(merl);
}

static void assert_no_load(hetab_context *ctx, const char *path, hetab_status expected,
                           const char *word) {
  hetab_merl *merl = (hetab_merl *)1;
  hetab_status status = hetab_merl_load(ctx, path, &merl);
  assert_failure(ctx, status, expected, word);
  assert_failure(ctx, status, expected, path);
  assert_null(merl);
}

static void put_header(const char *path, const int32_t dims[3], long long size) {
  put_file(path, dims, 12);
  assert_int_equal(truncate(path, (off_t)size), 0);
}

static void test_bad_files(void **state) {
  static const int32_t good[3] = {90, 90, 180}, other[3] = {90, 180, 90};
  static const int32_t swapped[3] = {90 << 24, 90 << 24, (int32_t)(180u << 24)};
  fixture *f = *state;
  assert_int_equal(mkdir("directory", 0777), 0);
  put_file("empty", "", 0);
  put_file("text", "name: BBQAL2\nsigma0_um: 0.54\n", 29);
  put_header("short", good, BYTES - 1);
  put_header("long", good, BYTES + 8);
  put_header("header only", good, 12);
  put_header("other", other, BYTES);
  put_header("swapped", swapped, BYTES);
  put_header("infinite", good, BYTES - 8);
  double infinite = INFINITY; /* NaN is some writers' mark below the horizon */
  FILE *file = fopen("infinite", "ab");
  assert_int_equal(fwrite(&infinite, sizeof infinite, 1, file), 1);
  fclose(file);
  assert_no_load(f->ctx, "missing", HETAB_ERR_IO, "No such file");
  assert_no_load(f->ctx, "directory", HETAB_ERR_IO, "cannot read");
  assert_no_load(f->ctx, "empty", HETAB_ERR_PARSE, "truncated");
  assert_no_load(f->ctx, "text", HETAB_ERR_PARSE, "no MERL file");
  assert_no_load(f->ctx, "short", HETAB_ERR_PARSE, "34992011 bytes");
  assert_no_load(f->ctx, "long", HETAB_ERR_PARSE, "34992020 bytes");
  assert_no_load(f->ctx, "header only", HETAB_ERR_PARSE, "12 bytes");
  assert_no_load(f->ctx, "other", HETAB_ERR_PARSE, "90 x 180 x 90");
  assert_no_load(f->ctx, "swapped", HETAB_ERR_PARSE, "big-endian");
  assert_no_load(f->ctx, "infinite", HETAB_ERR_PARSE, "value 1457999 of channel 2");
}

/* As readers do: one negative channel, of whatever size, and the cell is below the horizon. */
static void test_any_negative_is_below_the_horizon(void **state) {
  static const int32_t dims[3] = {90, 90, 180};
  fixture *f = *state;
  hetab_merl *merl;
  double negative = -0.25;
  put_header("a", dims, BYTES);
  FILE *file = fopen("a", "r+b");
  fseek(file, 12 + 8 * (1458000 + 5), SEEK_SET);
  assert_int_equal(fwrite(&negative, sizeof negative, 1, file), 1);
  fclose(file);
  assert_ok(f->ctx, hetab_merl_load(f->ctx, "a", &merl));
  for (int c = 0; c < 3; c++) {
    assert_true(hetab_merl_channel(merl, c)[5] == -1);
    assert_true(hetab_merl_channel(merl, c)[6] == 0);
  }
  hetab_merl_free(merl);
}

static void test_output_refused(void **state) {
  fixture *f = *state;
  hetab_merl *merl = make_merl(f->ctx);
  put_file("a", "old", 3);
  assert_failure(f->ctx, hetab_merl_save(f->ctx, merl, "a", 0), HETAB_ERR_EXISTS, "'a'");
  assert_content("a", "old");
  assert_ok(f->ctx, hetab_merl_save(f->ctx, merl, "a", 1));
  assert_int_equal(count_files("."), 1);
  hetab_merl_free(merl);
}

static void test_full_disk(void **state) {
  fixture *f = *state;
  require_mounting();
  hetab_merl *merl = make_merl(f->ctx);
  mount_small(8 << 20);
  put_file("small/a", "old", 3);
  hetab_status status = hetab_merl_save(f->ctx, merl, "small/a", 1);
  assert_content("small/a", "old");
  assert_int_equal(count_files("small"), 1);
  unmount_small();
  assert_failure(f->ctx, status, HETAB_ERR_IO, "'small/a': No space left on device");
  hetab_merl_free(merl);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_every_byte),
      TEST(test_round_trip),
      TEST(test_cells_of_random_directions),
      TEST(test_cells_of_special_directions),
      TEST(test_lookup),
      TEST(test_bad_cells_are_not_written),
      TEST(test_bad_files),
      TEST(test_any_negative_is_below_the_horizon),
      TEST(test_output_refused),
      TEST(test_full_disk),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
