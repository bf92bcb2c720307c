/* HDF5 tables: layout, round trips, and everything that can be wrong with a file or a disk. */
#include "table_support.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <math.h>

static const double wavelengths_um[] = {0.4, 0.55, 0.7};
enum { WAVELENGTHS = 3 };

/* --- a small table -------------------------------------------------------------------------- */

static hetab_surface *make_surface(hetab_context *ctx) {
  hetab_surface *surface;
  assert_ok(ctx, hetab_surface_create(ctx, 0.54, 6.5, 0.958, 6.69, wavelengths_um, WAVELENGTHS,
                                      &surface));
  return surface;
}

static hetab_grid *make_grid(hetab_context *ctx, const char *theta_i, const char *theta_r,
                             const char *phi) {
  hetab_grid *grid;
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_I, theta_i));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_R, theta_r));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_PHI, phi));
  return grid;
}

static size_t block_size(const hetab_grid *grid) {
  return hetab_grid_count(grid, HETAB_THETA_R) * hetab_grid_count(grid, HETAB_PHI);
}

/* The entry's place as a value that no compressor can guess, positive and below 1. */
static double value_at(size_t place) {
  uint64_t bits = (place + 1) * 0x9e3779b97f4a7c15ULL;
  bits ^= bits >> 29;
  return (double)((bits * 0xbf58476d1ce4e5b9ULL) >> 11) / 9007199254740992.0;
}

/* Rows first .. first + count - 1 of a wavelength, as slabs of the given precision. */
static hetab_status write_rows(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_grid *grid, hetab_precision precision, size_t wavelength,
                               size_t first, size_t count) {
  size_t block = block_size(grid), rows = hetab_grid_count(grid, HETAB_THETA_I);
  double *doubles = malloc(count * block * sizeof *doubles);
  float *floats = malloc(count * block * sizeof *floats);
  for (size_t i = 0; i < count * block; i++) {
    doubles[i] = value_at((wavelength * rows + first) * block + i);
    floats[i] = (float)doubles[i];
  }
  hetab_slab slab = {wavelength, first, count,
                     precision == HETAB_FLOAT ? (void *)floats : (void *)doubles};
  hetab_status status = hetab_table_write_slab(ctx, writer, &slab);
  free(floats);
  free(doubles);
  return status;
}

/* All rows, last wavelength first, in two slabs each. */
static hetab_status write_brdf(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_grid *grid, hetab_precision precision) {
  size_t rows = hetab_grid_count(grid, HETAB_THETA_I), half = rows / 2;
  hetab_status status = HETAB_OK;
  for (size_t w = WAVELENGTHS; w-- > 0 && status == HETAB_OK;) {
    status = write_rows(ctx, writer, grid, precision, w, half, rows - half);
    if (status == HETAB_OK && half)
      status = write_rows(ctx, writer, grid, precision, w, 0, half);
  }
  return status;
}

static hetab_status write_specular(hetab_context *ctx, hetab_table_writer *writer,
                                   const hetab_grid *grid) {
  size_t count = WAVELENGTHS * hetab_grid_count(grid, HETAB_THETA_I);
  double *rho = malloc(count * sizeof *rho);
  for (size_t i = 0; i < count; i++)
    rho[i] = (double)i / (double)count;
  hetab_status status = hetab_table_write_specular(ctx, writer, rho);
  free(rho);
  return status;
}

static hetab_status create(hetab_context *ctx, const char *path, const hetab_grid *grid,
                           const hetab_h5_options *options, hetab_table_writer **writer) {
  hetab_surface *surface = make_surface(ctx);
  hetab_status status = hetab_h5_create(ctx, path, surface, grid, options, writer);
  hetab_surface_free(surface);
  return status;
}

static hetab_status write_table(hetab_context *ctx, const char *path, const hetab_grid *grid,
                                const hetab_h5_options *options) {
  hetab_table_writer *writer;
  hetab_status status = create(ctx, path, grid, options, &writer);
  if (status != HETAB_OK)
    return status;
  status = write_brdf(ctx, writer, grid, options->slabs);
  if (status == HETAB_OK)
    status = write_specular(ctx, writer, grid);
  if (status == HETAB_OK)
    return hetab_table_commit(ctx, writer);
  hetab_table_abort(writer);
  return status;
}

static hetab_grid *small_grid(hetab_context *ctx) {
  return make_grid(ctx, "0:90:5", "0,30,60,90", "0:180:7");
}

static void write_small(hetab_context *ctx, const char *path) {
  hetab_grid *grid = small_grid(ctx);
  assert_ok(ctx, write_table(ctx, path, grid, &(hetab_h5_options){.overwrite = 1}));
  hetab_grid_free(grid);
}

static void assert_same_axes(const hetab_h5_table *table, const hetab_grid *grid) {
  assert_int_equal(hetab_h5_wavelength_count(table), WAVELENGTHS);
  for (size_t i = 0; i < WAVELENGTHS; i++)
    assert_true(hetab_h5_wavelengths_um(table)[i] == wavelengths_um[i]);
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    size_t count = hetab_grid_count(grid, axis);
    assert_int_equal(hetab_grid_count(hetab_h5_grid(table), axis), count);
    assert_memory_equal(hetab_grid_deg(hetab_h5_grid(table), axis), hetab_grid_deg(grid, axis),
                        count * sizeof(double));
  }
}

static void assert_same_values(hetab_context *ctx, hetab_h5_table *table, const hetab_grid *grid,
                               int as_float) {
  size_t rows = hetab_grid_count(grid, HETAB_THETA_I), count = rows * block_size(grid);
  double *values =
      malloc((count > rows * WAVELENGTHS ? count : rows * WAVELENGTHS) * sizeof *values);
  for (size_t w = 0; w < WAVELENGTHS; w++) {
    assert_ok(ctx, hetab_h5_read(ctx, table, w, values));
    for (size_t i = 0; i < count; i++) {
      double expected = value_at(w * count + i);
      if (values[i] != (as_float ? (double)(float)expected : expected))
        fail_msg("wavelength %zu, entry %zu: %.17g", w, i, values[i]);
    }
  }
  assert_ok(ctx, hetab_h5_read_specular(ctx, table, values));
  for (size_t i = 0; i < rows * WAVELENGTHS; i++)
    assert_true(values[i] == (double)i / (double)(rows * WAVELENGTHS));
  free(values);
}

/* --- round trips ---------------------------------------------------------------------------- */

static void round_trip(hetab_context *ctx, const hetab_grid *grid,
                       const hetab_h5_options *options) {
  hetab_h5_table *table;
  assert_ok(ctx, write_table(ctx, "a.h5", grid, options));
  assert_ok(ctx, hetab_h5_open(ctx, "a.h5", &table));
  assert_same_axes(table, grid);
  assert_same_values(ctx, table, grid,
                     options->element == HETAB_FLOAT || options->slabs == HETAB_FLOAT);
  hetab_h5_free(table);
}

/* Chunks of several theta_i that slabs share, of one, and of a part of one with a rest. */
static void test_round_trips(void **state) {
  static const char *const shapes[][3] = {{"0:90:5", "0,30,60,90", "0:180:7"},
                                          {"0:90:41", "45", "cells:1"},
                                          {"0:90:4", "0:90:60", "0:180:181"},
                                          {"30,60", "0:90:701", "0:180:400"}};
  fixture *f = *state;
  for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
    hetab_grid *grid = make_grid(f->ctx, shapes[i][0], shapes[i][1], shapes[i][2]);
    for (int n = 0; n < 8; n++)
      round_trip(f->ctx, grid,
                 &(hetab_h5_options){.element = n & 1 ? HETAB_DOUBLE : HETAB_FLOAT,
                                     .slabs = n & 2 ? HETAB_DOUBLE : HETAB_FLOAT,
                                     .compression = n & 4 ? 1 : 0,
                                     .overwrite = 1});
    hetab_grid_free(grid);
  }
}

static void test_same_bytes_twice(void **state) {
  fixture *f = *state;
  size_t first_size, second_size;
  write_small(f->ctx, "a.h5");
  unsigned char *first = get_file("a.h5", &first_size);
  sleep(1); /* time stamps would show */
  write_small(f->ctx, "a.h5");
  unsigned char *second = get_file("a.h5", &second_size);
  assert_int_equal(first_size, second_size);
  assert_memory_equal(first, second, first_size);
  free(second);
  free(first);
}

/* --- layout, as HDF5 itself sees it --------------------------------------------------------- */

static void assert_text(hid_t object, const char *name, const char *expected) {
  char *text = NULL;
  hid_t attribute = H5Aopen(object, name, H5P_DEFAULT), type = H5Aget_type(attribute);
  assert_true(H5Tis_variable_str(type) > 0 && H5Tget_cset(type) == H5T_CSET_UTF8);
  assert_true(H5Aread(attribute, type, &text) >= 0);
  assert_string_equal(text, expected);
  H5free_memory(text);
  H5Tclose(type);
  H5Aclose(attribute);
}

static void assert_layout(hid_t file, const char *name, int rank, const char *units) {
  static const char *const axes[4] = {"wavelength", "theta_i", "theta_r", "phi"};
  static const hsize_t sizes[4] = {WAVELENGTHS, 5, 4, 7};
  hsize_t dims[4];
  hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  assert_int_equal(H5Sget_simple_extent_ndims(space), rank);
  H5Sget_simple_extent_dims(space, dims, NULL);
  assert_text(dataset, "units", units);
  for (int i = 0; i < rank; i++) {
    hid_t scale = H5Dopen2(file, axes[i], H5P_DEFAULT);
    assert_int_equal(dims[i], sizes[i]);
    assert_true(H5DSis_scale(scale) > 0);
    assert_true(H5DSis_attached(dataset, scale, (unsigned)i) > 0);
    H5Dclose(scale);
  }
  H5Sclose(space);
  H5Dclose(dataset);
}

static void assert_axis_units(hid_t file, const char *name, const char *units) {
  hid_t scale = H5Dopen2(file, name, H5P_DEFAULT);
  assert_text(scale, "units", units);
  H5Dclose(scale);
}

static void test_layout(void **state) {
  fixture *f = *state;
  double nm[WAVELENGTHS];
  write_small(f->ctx, "a.h5");
  hid_t file = H5Fopen("a.h5", H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_layout(file, "brdf", 4, "1/sr");
  assert_layout(file, "specular_reflectance", 2, "1");
  assert_layout(file, "uniform_diffuse", 1, "1/sr");
  assert_layout(file, "n", 1, "1");
  assert_layout(file, "k", 1, "1");
  assert_axis_units(file, "wavelength", "nm");
  assert_axis_units(file, "theta_i", "degree");
  assert_axis_units(file, "theta_r", "degree");
  assert_axis_units(file, "phi", "degree");
  assert_text(file, "hetab_version", hetab_version());
  assert_true(H5LTread_dataset_double(file, "wavelength", nm) >= 0);
  assert_true(nm[0] == 400 && nm[1] == 550 && nm[2] == 700);
  hid_t brdf = H5Dopen2(file, "brdf", H5P_DEFAULT);
  hid_t type = H5Dget_type(brdf), list = H5Dget_create_plist(brdf);
  assert_true(H5Tequal(type, H5T_IEEE_F32LE) > 0);
  assert_int_equal(H5Pget_layout(list), H5D_CONTIGUOUS);
  H5Pclose(list);
  H5Tclose(type);
  H5Dclose(brdf);
  H5Fclose(file);
}

static void test_h5py_and_h5dump(void **state) {
  static const char script[] =
      "/usr/bin/python3 -c '\n"
      "import h5py\n"
      "f = h5py.File(\"a.h5\", \"r\")\n"
      "b = f[\"brdf\"]\n"
      "assert b.shape == (3, 5, 4, 7) and b.dtype == \"float32\"\n"
      "assert [d.label for d in b.dims] == [\"wavelength\", \"theta_i\", \"theta_r\", \"phi\"]\n"
      "assert list(b.dims[0][0]) == [400, 550, 700] and b.dims[3][0].attrs[\"units\"] == "
      "\"degree\"\n"
      "assert isinstance(f.attrs[\"name\"], str) and f.attrs[\"sigma0_um\"] == 0.54\n"
      "assert \"no cosine\" in b.attrs[\"long_name\"]\n"
      "assert 0 < b[:].min() and b[:].max() < 1\n"
      "'";
  fixture *f = *state;
  write_small(f->ctx, "a.h5");
  if (system("/usr/bin/python3 -c 'import h5py' 2>/dev/null; exit $?") ||
      system("command -v h5dump >/dev/null")) {
    print_message("skipped: h5py or h5dump is not installed\n");
    skip();
  }
  assert_int_equal(system(script), 0);
  assert_int_equal(system("h5dump a.h5 >/dev/null"), 0);
}

static void assert_number(fixture *f, hetab_h5_table *table, const char *name, double expected) {
  double value;
  assert_ok(f->ctx, hetab_h5_number(f->ctx, table, name, &value));
  if (!(fabs(value - expected) <= 1e-12 * expected))
    fail_msg("%s is %.17g, not %.17g", name, value, expected);
}

static const hetab_report measured = {
    .error = {.samples = 2000, .compared = 1900, .max_rel = 1e-6, .p99_rel = 1e-7, .rms_rel = 8e-8},
    .method = HETAB_METHOD_LITERAL,
    .precision = HETAB_DOUBLE,
    .tolerance = 1e-9,
    .device = "a device"};

static hetab_h5_table *table_with_report(fixture *f, const hetab_h5_options *options) {
  hetab_grid *grid = small_grid(f->ctx);
  hetab_table_writer *writer;
  hetab_h5_table *table;
  assert_ok(f->ctx, create(f->ctx, "a.h5", grid, options, &writer));
  assert_ok(f->ctx, write_brdf(f->ctx, writer, grid, options->slabs));
  assert_ok(f->ctx, write_specular(f->ctx, writer, grid));
  assert_ok(f->ctx, hetab_table_write_report(f->ctx, writer, &measured));
  assert_ok(f->ctx, hetab_table_commit(f->ctx, writer));
  assert_ok(f->ctx, hetab_h5_open(f->ctx, "a.h5", &table));
  hetab_grid_free(grid);
  return table;
}

static void test_report(void **state) {
  fixture *f = *state;
  double value;
  hetab_h5_table *table = table_with_report(f, &(hetab_h5_options){0});
  assert_number(f, table, "error_samples", 2000);
  assert_number(f, table, "error_compared", 1900);
  assert_number(f, table, "error_max_sampled", 1e-6);
  assert_number(f, table, "tolerance", 1e-9);
  assert_number(f, table, "sigma0_um", 0.54);
  assert_failure(f->ctx, hetab_h5_number(f->ctx, table, "method", &value), HETAB_ERR_PARSE,
                 "'method' is not a number");
  assert_failure(f->ctx, hetab_h5_number(f->ctx, table, "nothing", &value), HETAB_ERR_PARSE,
                 "'nothing' is missing");
  hetab_h5_free(table);
}

/* Doubles rounded to float: the stored error is the file's. */
static void test_report_of_rounded_values(void **state) {
  fixture *f = *state;
  hetab_h5_options options = {.element = HETAB_FLOAT, .slabs = HETAB_DOUBLE};
  hetab_h5_table *table = table_with_report(f, &options);
  assert_number(f, table, "error_max_sampled", 1.06e-6);
  assert_number(f, table, "error_p99_rel", 1.6e-7);
  assert_number(f, table, "error_rms_rel", 1e-7);
  assert_number(f, table, "error_max_abs_below_floor", 6e-17);
  hetab_h5_free(table);
}

/* Chunks at the end of an axis are stored whole: they should not reach far beyond it. */
static void test_chunks_fit(void **state) {
  fixture *f = *state;
  hetab_grid *grid;
  hetab_table_writer *writer;
  hsize_t chunk[4];
  assert_ok(f->ctx, hetab_grid_create(f->ctx, &grid));
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_I, "0"));
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_THETA_R, "0:90:360"));
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, "0:180:1261"));
  assert_ok(f->ctx, create(f->ctx, "a.h5", grid, &(hetab_h5_options){.compression = 1}, &writer));
  assert_ok(f->ctx, write_brdf(f->ctx, writer, grid, HETAB_FLOAT));
  assert_ok(f->ctx, write_specular(f->ctx, writer, grid));
  assert_ok(f->ctx, hetab_table_commit(f->ctx, writer));
  hid_t file = H5Fopen("a.h5", H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t brdf = H5Dopen2(file, "brdf", H5P_DEFAULT), list = H5Dget_create_plist(brdf);
  assert_int_equal(H5Pget_chunk(list, 4, chunk), 4);
  assert_int_equal(chunk[2], 180);
  assert_int_equal(chunk[3], 1261);
  H5Pclose(list);
  H5Dclose(brdf);
  H5Fclose(file);
  hetab_grid_free(grid);
}

static void test_text_file(void **state) {
  fixture *f = *state;
  char text[16] = "";
  assert_failure(f->ctx, hetab_output_check(f->ctx, "none/a.csv", 0), HETAB_ERR_IO, "create it");
  assert_ok(f->ctx, hetab_output_check(f->ctx, "a.csv", 0));
  assert_int_equal(access("a.csv", F_OK), -1);
  assert_ok(f->ctx, hetab_text_save(f->ctx, "a.csv", "one,two\n", 8, 0));
  assert_failure(f->ctx, hetab_output_check(f->ctx, "a.csv", 0), HETAB_ERR_EXISTS, "a.csv");
  assert_failure(f->ctx, hetab_text_save(f->ctx, "a.csv", "3", 1, 0), HETAB_ERR_EXISTS, "a.csv");
  FILE *file = fopen("a.csv", "rb");
  assert_int_equal(fread(text, 1, sizeof text, file), 8);
  fclose(file);
  assert_string_equal(text, "one,two\n");
}

/* --- whole or not at all -------------------------------------------------------------------- */

static void test_holes_are_not_published(void **state) {
  fixture *f = *state;
  hetab_grid *grid = small_grid(f->ctx);
  hetab_table_writer *writer;
  hetab_h5_options options = {0};
  assert_ok(f->ctx, create(f->ctx, "a.h5", grid, &options, &writer));
  assert_ok(f->ctx, write_specular(f->ctx, writer, grid));
  assert_ok(f->ctx, write_rows(f->ctx, writer, grid, HETAB_FLOAT, 0, 0, 5));
  assert_failure(f->ctx, write_rows(f->ctx, writer, grid, HETAB_FLOAT, 0, 4, 1), HETAB_ERR_ARGUMENT,
                 "twice");
  assert_ok(f->ctx, write_rows(f->ctx, writer, grid, HETAB_FLOAT, 1, 0, 5));
  assert_ok(f->ctx, write_rows(f->ctx, writer, grid, HETAB_FLOAT, 2, 0, 4));
  assert_failure(f->ctx, hetab_table_commit(f->ctx, writer), HETAB_ERR_ARGUMENT, "1 theta_i row");
  assert_ok(f->ctx, create(f->ctx, "a.h5", grid, &options, &writer));
  assert_ok(f->ctx, write_brdf(f->ctx, writer, grid, HETAB_FLOAT));
  assert_failure(f->ctx, hetab_table_commit(f->ctx, writer), HETAB_ERR_ARGUMENT, "specular");
  assert_int_equal(count_files("."), 0);
  hetab_grid_free(grid);
}

static void test_bad_slabs_and_options(void **state) {
  static const hetab_slab bad[] = {
      {3, 0, 1, ""}, {0, 5, 1, ""}, {0, 4, 2, ""}, {0, 0, 0, ""}, {0, 1, (size_t)-1, ""}};
  fixture *f = *state;
  hetab_grid *grid = small_grid(f->ctx);
  hetab_table_writer *writer;
  assert_ok(f->ctx, create(f->ctx, "a.h5", grid, &(hetab_h5_options){0}, &writer));
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
    assert_failure(f->ctx, hetab_table_write_slab(f->ctx, writer, &bad[i]), HETAB_ERR_ARGUMENT,
                   "slab");
  hetab_table_abort(writer);
  hetab_table_abort(NULL);
  assert_failure(f->ctx,
                 create(f->ctx, "a.h5", grid, &(hetab_h5_options){.compression = 10}, &writer),
                 HETAB_ERR_ARGUMENT, "compression");
  assert_null(writer);
  assert_int_equal(count_files("."), 0);
  hetab_grid_free(grid);
}

static void test_output_refused(void **state) {
  fixture *f = *state;
  hetab_grid *grid = small_grid(f->ctx);
  hetab_h5_options options = {0};
  put_file("a.h5", "old", 3);
  assert_failure(f->ctx, write_table(f->ctx, "a.h5", grid, &options), HETAB_ERR_EXISTS, "'a.h5'");
  assert_failure(f->ctx, write_table(f->ctx, "no/a.h5", grid, &options), HETAB_ERR_IO, "'no'");
  assert_failure(f->ctx, write_table(f->ctx, ".", grid, &options), HETAB_ERR_IO, "directory");
  assert_content("a.h5", "old");
  assert_int_equal(count_files("."), 1);
  hetab_grid_free(grid);
}

static void fill_disk(hetab_context *ctx, const hetab_grid *grid, int compression, long long size) {
  hetab_h5_options options = {.compression = compression, .overwrite = 1};
  mount_small(size);
  put_file("small/a.h5", "old", 3);
  hetab_status status = write_table(ctx, "small/a.h5", grid, &options);
  assert_content("small/a.h5", "old");
  assert_int_equal(count_files("small"), 1);
  unmount_small();
  assert_failure(ctx, status, HETAB_ERR_IO, "'small/a.h5': No space left on device");
}

/* Whichever write it is that fails: of the structure, of a slab, or the last, when HDF5 closes the
 * file and lets go of what it held back. */
static void test_full_disk(void **state) {
  fixture *f = *state;
  require_mounting();
  hetab_grid *grid = make_grid(f->ctx, "0:90:12", "0:90:60", "0:180:181");
  for (int compression = 0; compression < 2; compression++) {
    struct stat about;
    hetab_h5_options options = {.compression = compression, .overwrite = 1};
    assert_ok(f->ctx, write_table(f->ctx, "a.h5", grid, &options));
    assert_int_equal(stat("a.h5", &about), 0);
    for (int n = 0; n < 16; n++)
      fill_disk(f->ctx, grid, compression, about.st_size * (16 - n) / 16);
  }
  hetab_grid_free(grid);
  assert_true(H5close() >= 0); /* nothing is left that HDF5 would try again at exit */
}

/* The disk is found to be too small before anything is computed. */
static void test_no_room_from_the_start(void **state) {
  fixture *f = *state;
  require_mounting();
  hetab_grid *grid = small_grid(f->ctx);
  hetab_table_writer *writer;
  assert_ok(f->ctx, hetab_grid_set_axis(f->ctx, grid, HETAB_PHI, "0:180:100000"));
  mount_small(1 << 20);
  hetab_status status = create(f->ctx, "small/a.h5", grid, &(hetab_h5_options){0}, &writer);
  assert_int_equal(count_files("small"), 0);
  unmount_small();
  hetab_grid_free(grid);
  assert_failure(f->ctx, status, HETAB_ERR_IO, "'small/a.h5': No space left on device");
}

static void write_half(hetab_context *ctx) {
  hetab_grid *grid = make_grid(ctx, "0:90:20", "0:90:60", "0:180:181");
  hetab_table_writer *writer;
  if (create(ctx, "a.h5", grid, &(hetab_h5_options){.overwrite = 1}, &writer) == HETAB_OK &&
      write_rows(ctx, writer, grid, HETAB_FLOAT, 0, 0, 15) == HETAB_OK)
    pause_to_be_killed();
}

static void test_killed(void **state) {
  fixture *f = *state;
  put_file("a.h5", "old", 3);
  kill_within(write_half, f->ctx);
  assert_content("a.h5", "old");
  assert_int_equal(count_files("."), 1);
}

/* --- bad files ------------------------------------------------------------------------------ */

static void assert_no_open(hetab_context *ctx, const char *path, hetab_status expected,
                           const char *word) {
  hetab_h5_table *table = (hetab_h5_table *)1;
  hetab_status status = hetab_h5_open(ctx, path, &table);
  assert_failure(ctx, status, expected, word);
  assert_failure(ctx, status, expected, path);
  assert_null(table);
}

static void test_not_a_table(void **state) {
  fixture *f = *state;
  assert_int_equal(mkdir("directory", 0777), 0);
  put_file("empty", "", 0);
  put_file("text", "lambda_um,theta_i_deg\n", 22);
  assert_no_open(f->ctx, "missing", HETAB_ERR_IO, "No such file");
  assert_no_open(f->ctx, "directory", HETAB_ERR_IO, "regular");
  assert_no_open(f->ctx, "empty", HETAB_ERR_PARSE, "not an HDF5 file");
  assert_no_open(f->ctx, "text", HETAB_ERR_PARSE, "not an HDF5 file");
}

static void test_truncated(void **state) {
  fixture *f = *state;
  struct stat about;
  write_small(f->ctx, "a.h5");
  assert_int_equal(stat("a.h5", &about), 0);
  for (off_t size = about.st_size - 1; size >= 8; size -= 501) {
    assert_int_equal(truncate("a.h5", size), 0);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "truncated");
  }
}

/* A table without one of its parts, and with something else in its place. */
static void test_missing_and_wrong_parts(void **state) {
  static const char *const names[] = {
      "wavelength",           "theta_i",        "theta_r", "phi", "brdf", "n", "k",
      "specular_reflectance", "uniform_diffuse"};
  fixture *f = *state;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    hsize_t dims[5] = {1, 1, 1, 1, 1};
    int zero = 0;
    write_small(f->ctx, "a.h5");
    hid_t file = H5Fopen("a.h5", H5F_ACC_RDWR, H5P_DEFAULT);
    H5Ldelete(file, names[i], H5P_DEFAULT);
    H5Fclose(file);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, names[i]);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "missing");
    file = H5Fopen("a.h5", H5F_ACC_RDWR, H5P_DEFAULT);
    H5LTmake_dataset_int(file, names[i], 5, dims, &zero);
    H5Fclose(file);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "5 dimensions");
    file = H5Fopen("a.h5", H5F_ACC_RDWR, H5P_DEFAULT);
    H5Ldelete(file, names[i], H5P_DEFAULT);
    H5Gclose(H5Gcreate2(file, names[i], H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Fclose(file);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "not a dataset");
  }
}

/* Puts another one-dimensional dataset of doubles in the place of `name`. */
static void replace(const char *name, hsize_t count, const double *values) {
  hid_t file = H5Fopen("a.h5", H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, name, H5P_DEFAULT);
  assert_true(H5LTmake_dataset_double(file, name, 1, &count, values) >= 0);
  H5Fclose(file);
}

static void test_wrong_axes(void **state) {
  static const struct {
    const char *name;
    hsize_t count;
    double values[7];
    const char *word;
  } cases[] = {
      {"wavelength", 3, {700, 500, 400}, "ascend"},
      {"wavelength", 3, {0, 500, 600}, "above 10 nm"},
      {"wavelength", 3, {400, 500, NAN}, "above 10 nm"},
      {"wavelength", 2, {400, 500}, "3 entries, but /wavelength has 2"},
      {"theta_i", 5, {0, 20, 10, 30, 40}, "theta_i"},
      {"theta_r", 4, {0, 20, 30, 91}, "theta_r"},
      {"phi", 7, {0, 1, 2, 3, 4, 5, NAN}, "phi"},
      {"phi", 6, {0, 1, 2, 3, 4, 5}, "7 entries, but /phi has 6"},
      {"n", 2, {1, 1}, "/n has 2 entries"},
  };
  fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    write_small(f->ctx, "a.h5");
    replace(cases[i].name, cases[i].count, cases[i].values);
    assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, cases[i].word);
  }
}

static void put_empty(const char *name, hid_t type, int rank, const hsize_t *dims, int chunked) {
  hid_t file = H5Fopen("a.h5", H5F_ACC_RDWR, H5P_DEFAULT);
  hid_t space = H5Screate_simple(rank, dims, NULL), list = H5Pcreate(H5P_DATASET_CREATE);
  if (chunked)
    H5Pset_chunk(list, rank, dims);
  H5Ldelete(file, name, H5P_DEFAULT);
  H5Dclose(H5Dcreate2(file, name, type, space, H5P_DEFAULT, list, H5P_DEFAULT));
  H5Pclose(list);
  H5Sclose(space);
  H5Fclose(file);
}

static void test_wrong_storage(void **state) {
  static const hsize_t right[4] = {WAVELENGTHS, 5, 4, 7}, huge = 1000000000000, none = 0;
  fixture *f = *state;
  write_small(f->ctx, "a.h5");
  put_empty("brdf", H5T_STD_I32LE, 4, right, 1);
  assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "floating-point");
  put_empty("brdf", H5T_IEEE_F32LE, 4, right, 0);
  assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "0 of 1680 bytes");
  put_empty("brdf", H5T_IEEE_F32LE, 4, right, 1);
  assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "0 of 1 chunks");
  put_empty("theta_i", H5T_IEEE_F64LE, 1, &huge, 0);
  assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "1000000000000 entries");
  put_empty("theta_i", H5T_IEEE_F64LE, 1, &none, 0);
  assert_no_open(f->ctx, "a.h5", HETAB_ERR_PARSE, "0 entries");
}

/* Damage inside compressed data shows when that wavelength is read. */
static void test_damaged_chunk(void **state) {
  fixture *f = *state;
  hetab_grid *grid = small_grid(f->ctx);
  hetab_h5_table *table;
  size_t size;
  double values[5 * 4 * 7];
  assert_ok(f->ctx, write_table(f->ctx, "a.h5", grid, &(hetab_h5_options){.compression = 9}));
  hid_t file = H5Fopen("a.h5", H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t brdf = H5Dopen2(file, "brdf", H5P_DEFAULT), space = H5Dget_space(brdf);
  haddr_t address;
  assert_true(H5Dget_chunk_info(brdf, space, 0, NULL, NULL, &address, NULL) >= 0);
  H5Sclose(space);
  H5Dclose(brdf);
  H5Fclose(file);
  unsigned char *bytes = get_file("a.h5", &size);
  memset(bytes + address, 0xff, 16);
  put_file("a.h5", bytes, size);
  free(bytes);
  assert_ok(f->ctx, hetab_h5_open(f->ctx, "a.h5", &table));
  assert_failure(f->ctx, hetab_h5_read(f->ctx, table, 0, values), HETAB_ERR_PARSE, "/brdf");
  assert_ok(f->ctx, hetab_h5_read(f->ctx, table, 1, values));
  assert_failure(f->ctx, hetab_h5_read(f->ctx, table, 3, values), HETAB_ERR_ARGUMENT, "only 3");
  hetab_h5_free(table);
  hetab_h5_free(NULL);
  hetab_grid_free(grid);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_round_trips),
      TEST(test_same_bytes_twice),
      TEST(test_layout),
      TEST(test_h5py_and_h5dump),
      TEST(test_report),
      TEST(test_report_of_rounded_values),
      TEST(test_chunks_fit),
      TEST(test_text_file),
      TEST(test_holes_are_not_published),
      TEST(test_bad_slabs_and_options),
      TEST(test_output_refused),
      TEST(test_full_disk),
      TEST(test_no_room_from_the_start),
      TEST(test_killed),
      TEST(test_not_a_table),
      TEST(test_truncated),
      TEST(test_missing_and_wrong_parts),
      TEST(test_wrong_axes),
      TEST(test_wrong_storage),
      TEST(test_damaged_chunk),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
