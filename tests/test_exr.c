/* OpenEXR tables: layout and values, read back by OpenEXR's own reader; slabs in any order; and
 * everything that can be wrong with a table or a disk. tests/test_cli_exr.sh reads them with other
 * programs. */
#include "table_support.h"

#include <math.h>
#include <openexr.h>

enum { BANDS = 31, THETA_I = 3, THETA_R = 20, PHI = 4, BLOCK = THETA_R * PHI };
static const double theta_i_deg[THETA_I] = {0, 30.5, 90};

/* --- a small table -------------------------------------------------------------------------- */

/* Half of them beyond what half precision resolves, one in 64 beyond what it holds. */
static double value_at(size_t wavelength, size_t theta_i, size_t p) {
  uint64_t bits = ((wavelength * THETA_I + theta_i) * BLOCK + p + 1) * 0x9e3779b97f4a7c15ULL;
  double unit = (double)((bits ^ bits >> 31) >> 11 & 0xfffffffffffff) / 4503599627370496.0;
  return bits >> 58 ? unit : 1e5 * (1 + unit);
}

static double rho_at(size_t wavelength, size_t theta_i) {
  return (double)(wavelength * THETA_I + theta_i) / (BANDS * THETA_I);
}

typedef struct job {
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_table_writer *writer;
} job;

static hetab_status open_job(hetab_context *ctx, const char *path, const hetab_exr_options *options,
                             size_t bands, job *job) {
  double lambda_um[BANDS];
  for (size_t i = 0; i < bands; i++)
    lambda_um[i] = 0.4 + 0.01 * (double)i;
  assert_ok(ctx,
            hetab_surface_create(ctx, 0.54, 6.5, 0.958, 6.69, lambda_um, bands, &job->surface));
  assert_ok(ctx, hetab_grid_create(ctx, &job->grid));
  assert_ok(ctx, hetab_grid_set_values(ctx, job->grid, HETAB_THETA_I, theta_i_deg, THETA_I));
  assert_ok(ctx, hetab_grid_set_axis(ctx, job->grid, HETAB_THETA_R, "0:90:20"));
  assert_ok(ctx, hetab_grid_set_axis(ctx, job->grid, HETAB_PHI, "0:180:4"));
  return hetab_exr_create(ctx, path, job->surface, job->grid, options, &job->writer);
}

static void close_job(job *job) {
  hetab_table_abort(job->writer);
  hetab_grid_free(job->grid);
  hetab_surface_free(job->surface);
}

static hetab_status write_slab(hetab_context *ctx, const job *job, hetab_precision precision,
                               size_t wavelength, size_t first, size_t count) {
  static double doubles[THETA_I * BLOCK];
  static float floats[THETA_I * BLOCK];
  for (size_t i = 0; i < count * BLOCK; i++) {
    doubles[i] = value_at(wavelength, first + i / BLOCK, i % BLOCK);
    floats[i] = (float)doubles[i];
  }
  hetab_slab slab = {wavelength, first, count,
                     precision == HETAB_FLOAT ? (void *)floats : (void *)doubles};
  return hetab_table_write_slab(ctx, job->writer, &slab);
}

/* Last wavelength first, last incidence first. */
static void write_brdf(hetab_context *ctx, const job *job, hetab_precision precision,
                       size_t bands) {
  for (size_t w = bands; w-- > 0;) {
    assert_ok(ctx, write_slab(ctx, job, precision, w, 1, 2));
    assert_ok(ctx, write_slab(ctx, job, precision, w, 0, 1));
  }
}

static void write_specular(hetab_context *ctx, const job *job, size_t bands) {
  double rho[BANDS * THETA_I];
  for (size_t i = 0; i < bands * THETA_I; i++)
    rho[i] = rho_at(i / THETA_I, i % THETA_I);
  assert_ok(ctx, hetab_table_write_specular(ctx, job->writer, rho));
}

static hetab_status commit(hetab_context *ctx, job *job) {
  hetab_table_writer *writer = job->writer;
  job->writer = NULL;
  return hetab_table_commit(ctx, writer);
}

static void write_table(hetab_context *ctx, const char *path, const hetab_exr_options *options) {
  job job;
  assert_ok(ctx, open_job(ctx, path, options, BANDS, &job));
  write_brdf(ctx, &job, options->slabs, BANDS);
  write_specular(ctx, &job, BANDS);
  assert_ok(ctx, commit(ctx, &job));
  close_job(&job);
}

/* --- OpenEXR's own reader ------------------------------------------------------------------- */

static void read_chunks(exr_context_t exr, int part, int height, const char *channel, float *out,
                        int width) {
  int32_t lines;
  assert_int_equal(exr_get_scanlines_per_chunk(exr, part, &lines), EXR_ERR_SUCCESS);
  for (int y = 0; y < height; y += lines) {
    exr_chunk_info_t chunk;
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    int found = 0;
    assert_int_equal(exr_read_scanline_chunk_info(exr, part, y, &chunk), EXR_ERR_SUCCESS);
    assert_int_equal(exr_decoding_initialize(exr, part, &chunk, &pipeline), EXR_ERR_SUCCESS);
    for (int c = 0; c < pipeline.channel_count; c++) {
      exr_coding_channel_info_t *info = &pipeline.channels[c];
      if (strcmp(info->channel_name, channel) != 0)
        continue;
      info->decode_to_ptr = (uint8_t *)(out + (size_t)y * (size_t)width);
      info->user_pixel_stride = 4;
      info->user_line_stride = 4 * width;
      info->user_bytes_per_element = 4;
      info->user_data_type = EXR_PIXEL_FLOAT;
      found = 1;
    }
    assert_true(found);
    assert_int_equal(exr_decoding_choose_default_routines(exr, part, &pipeline), EXR_ERR_SUCCESS);
    assert_int_equal(exr_decoding_run(exr, part, &pipeline), EXR_ERR_SUCCESS);
    exr_decoding_destroy(exr, &pipeline);
  }
}

static exr_context_t open_exr(const char *path) {
  exr_context_t exr;
  exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
  assert_int_equal(exr_start_read(&exr, path, &start), EXR_ERR_SUCCESS);
  return exr;
}

/* The part's number; its channel's values are in out. */
static int read_part(exr_context_t exr, const char *part, const char *channel, int width,
                     int height, float *out) {
  int count, number = -1;
  exr_attr_box2i_t window;
  assert_int_equal(exr_get_count(exr, &count), EXR_ERR_SUCCESS);
  for (int p = 0; p < count; p++) {
    const char *name;
    assert_int_equal(exr_get_name(exr, p, &name), EXR_ERR_SUCCESS);
    if (strcmp(name, part) == 0)
      number = p;
  }
  assert_true(number >= 0);
  assert_int_equal(exr_get_data_window(exr, number, &window), EXR_ERR_SUCCESS);
  assert_int_equal(window.max.x - window.min.x + 1, width);
  assert_int_equal(window.max.y - window.min.y + 1, height);
  read_chunks(exr, number, height, channel, out, width);
  return number;
}

static void channel_name(size_t wavelength, char *name) {
  sprintf(name, "T.%zu,000000nm", 400 + 10 * wavelength);
}

/* --- values --------------------------------------------------------------------------------- */

static void spectral(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const char *const parts[] = {"theta_i_00_00deg", "theta_i_30_50deg", "theta_i_90_00deg"};
  for (hetab_precision precision = HETAB_FLOAT; precision <= HETAB_DOUBLE; precision++) {
    float values[BLOCK], rho[THETA_I];
    char name[32];
    write_table(
        ctx, "a.exr",
        &(hetab_exr_options){.bands = HETAB_EXR_SPECTRAL, .slabs = precision, .overwrite = 1});
    exr_context_t exr = open_exr("a.exr");
    for (size_t w = 0; w < BANDS; w++) {
      channel_name(w, name);
      for (size_t i = 0; i < THETA_I; i++) {
        assert_int_equal(read_part(exr, parts[i], name, PHI, THETA_R, values), i);
        for (size_t p = 0; p < BLOCK; p++)
          assert_true(values[p] == (float)value_at(w, i, p));
      }
      read_part(exr, "specular_reflectance", name, THETA_I, 1, rho);
      for (size_t i = 0; i < THETA_I; i++)
        assert_true(rho[i] == (float)rho_at(w, i));
    }
    exr_finish(&exr);
  }
}

static void by_wavelength(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static float values[THETA_I * BLOCK];
  write_table(ctx, "a.exr",
              &(hetab_exr_options){.bands = HETAB_EXR_SPECTRAL, .parts = HETAB_EXR_BY_WAVELENGTH});
  exr_context_t exr = open_exr("a.exr");
  for (size_t w = 0; w < BANDS; w++) {
    char name[32], part[32];
    channel_name(w, name);
    sprintf(part, "wavelength_%zu_00nm", 400 + 10 * w);
    assert_int_equal(read_part(exr, part, name, PHI, THETA_I * THETA_R, values), w);
    for (size_t p = 0; p < THETA_I * BLOCK; p++)
      assert_true(values[p] == (float)value_at(w, p / BLOCK, p % BLOCK));
  }
  exr_finish(&exr);
}

/* 11 bits: half a unit in the last place, or half the step below 2^-14; larger than 65504: that. */
static void half(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_exr_options options = {.bands = HETAB_EXR_SPECTRAL, .element = HETAB_EXR_HALF};
  float values[BLOCK];
  size_t saturated = 0;
  job job;
  assert_ok(ctx, open_job(ctx, "a.exr", &options, BANDS, &job));
  write_brdf(ctx, &job, HETAB_FLOAT, BANDS);
  write_specular(ctx, &job, BANDS);
  size_t counted = hetab_table_saturated_count(job.writer);
  assert_ok(ctx, commit(ctx, &job));
  close_job(&job);
  exr_context_t exr = open_exr("a.exr");
  for (size_t w = 0; w < BANDS; w++) {
    char name[32];
    channel_name(w, name);
    for (size_t i = 0; i < THETA_I; i++) {
      static const char *const parts[] = {"theta_i_00_00deg", "theta_i_30_50deg",
                                          "theta_i_90_00deg"};
      read_part(exr, parts[i], name, PHI, THETA_R, values);
      for (size_t p = 0; p < BLOCK; p++) {
        double exact = value_at(w, i, p), kept = fmin(exact, 65504);
        saturated += exact > 65504;
        assert_true(fabs((double)values[p] - kept) <= fmax(kept / 2048, 3e-8));
      }
    }
  }
  exr_finish(&exr);
  assert_true(saturated > 10);
  assert_int_equal(counted, saturated);
}

/* A grey table stays grey, D65's white being R = G = B; and colour is linear. */
static void colour(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  float grey[BLOCK], plane[3][BLOCK];
  static const char *const channels[] = {"R", "G", "B"};
  job job;
  hetab_exr_options options = {.bands = HETAB_EXR_RGB};
  assert_ok(ctx, open_job(ctx, "a.exr", &options, BANDS, &job));
  for (size_t p = 0; p < BLOCK; p++)
    grey[p] = (float)value_at(0, 0, p);
  for (size_t w = 0; w < BANDS; w++)
    for (size_t i = 0; i < THETA_I; i++)
      assert_ok(ctx, hetab_table_write_slab(ctx, job.writer, &(hetab_slab){w, i, 1, grey}));
  write_specular(ctx, &job, BANDS);
  assert_ok(ctx, commit(ctx, &job));
  close_job(&job);
  exr_context_t exr = open_exr("a.exr");
  for (int c = 0; c < 3; c++) {
    read_part(exr, "theta_i_30_50deg", channels[c], PHI, THETA_R, plane[c]);
    for (size_t p = 0; p < BLOCK; p++)
      assert_true(fabs((double)(plane[c][p] / grey[p]) - 1) < 2e-6); /* measured 6e-7 */
  }
  exr_finish(&exr);
}

/* The tiles of an atlas are the parts by theta_i. */
static void atlas(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  static const char *const parts[] = {"theta_i_00_00deg", "theta_i_30_50deg", "theta_i_90_00deg"};
  hetab_exr_options options = {.parts = HETAB_EXR_ATLAS};
  float rho[THETA_I], tile[BLOCK], all[THETA_I * BLOCK];
  const float *vector;
  double across;
  int32_t length;
  int count;
  write_table(ctx, "parts.exr", &(hetab_exr_options){0});
  write_table(ctx, "atlas.exr", &options);
  exr_context_t exr = open_exr("parts.exr"), whole = open_exr("atlas.exr");
  assert_int_equal(exr_get_count(whole, &count), EXR_ERR_SUCCESS);
  assert_int_equal(count, 1);
  read_part(whole, "atlas", "G", THETA_I * PHI, THETA_R, all);
  for (size_t i = 0; i < THETA_I; i++) {
    read_part(exr, parts[i], "G", PHI, THETA_R, tile);
    for (size_t p = 0; p < BLOCK; p++)
      assert_true(all[(p / PHI * THETA_I + i) * PHI + p % PHI] == tile[p]);
  }
  read_part(exr, "specular_reflectance", "G", THETA_I, 1, rho);
  assert_int_equal(exr_attr_get_double(whole, 0, "tiles_across", &across), EXR_ERR_SUCCESS);
  assert_true(across == THETA_I);
  assert_int_equal(exr_attr_get_float_vector(whole, 0, "specular_reflectance_G", &length, &vector),
                   EXR_ERR_SUCCESS);
  assert_int_equal(length, THETA_I);
  assert_memory_equal(vector, rho, sizeof rho);
  exr_finish(&exr);
  exr_finish(&whole);
}

/* What half floats do not hold is refused, and leaves nothing behind. */
static void atlas_too_bright(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_exr_options options = {.parts = HETAB_EXR_ATLAS, .element = HETAB_EXR_HALF};
  float bright[BLOCK] = {[BLOCK - 1] = 65600};
  hetab_status status = HETAB_OK;
  job job;
  assert_ok(ctx, open_job(ctx, "a.exr", &options, BANDS, &job));
  for (size_t w = 0; w < BANDS && status == HETAB_OK; w++)
    status = hetab_table_write_slab(ctx, job.writer, &(hetab_slab){w, 0, 1, bright});
  assert_failure(ctx, status, HETAB_ERR_RANGE, "above 65504");
  close_job(&job);
  assert_int_equal(count_files("."), 0);
}

static void attributes(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_exr_options options = {
      .method = HETAB_METHOD_SERIES, .tolerance = 1e-5, .device = "abacus"};
  hetab_error_stats error = {.samples = 20,
                             .compared = 12,
                             .max_rel = 3e-6,
                             .p99_rel = 2e-6,
                             .rms_rel = 1e-6,
                             .max_abs_below = 1e-15};
  double number;
  const char *text;
  const float *vector;
  int32_t length;
  job job;
  assert_ok(ctx, open_job(ctx, "a.exr", &options, BANDS, &job));
  write_brdf(ctx, &job, HETAB_FLOAT, BANDS);
  write_specular(ctx, &job, BANDS);
  assert_ok(ctx, hetab_table_write_report(ctx, job.writer, &(hetab_report){.error = error}));
  assert_ok(ctx, commit(ctx, &job));
  close_job(&job);
  exr_context_t exr = open_exr("a.exr");
  assert_int_not_equal(exr_attr_get_double(exr, 1, "sigma0_um", &number), EXR_ERR_SUCCESS);
  /* once: readers show the first part's */
  assert_int_equal(exr_attr_get_double(exr, 0, "sigma0_um", &number), EXR_ERR_SUCCESS);
  assert_true(number == 0.54);
  assert_int_equal(exr_attr_get_double(exr, 0, "error_max_sampled", &number), EXR_ERR_SUCCESS);
  assert_true(number == 3e-6);
  assert_int_equal(exr_attr_get_double(exr, 0, "error_compared", &number), EXR_ERR_SUCCESS);
  assert_true(number == 12);
  assert_int_equal(exr_attr_get_string(exr, 0, "device", &length, &text), EXR_ERR_SUCCESS);
  assert_string_equal(text, "abacus");
  assert_int_equal(exr_attr_get_string(exr, 0, "method", &length, &text), EXR_ERR_SUCCESS);
  assert_string_equal(text, "series");
  assert_int_equal(exr_attr_get_float_vector(exr, 0, "theta_i_deg", &length, &vector),
                   EXR_ERR_SUCCESS);
  assert_int_equal(length, THETA_I);
  assert_true(vector[1] == 30.5f);
  assert_int_equal(exr_attr_get_double(exr, 1, "part_theta_i_deg", &number), EXR_ERR_SUCCESS);
  assert_true(number == 30.5);
  exr_finish(&exr);
}

/* --- bad tables ----------------------------------------------------------------------------- */

static void bad_options(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  job job;
  assert_failure(
      ctx,
      open_job(ctx, "a.exr", &(hetab_exr_options){.parts = HETAB_EXR_BY_WAVELENGTH}, BANDS, &job),
      HETAB_ERR_ARGUMENT, "spectral bands");
  close_job(&job);
  assert_failure(
      ctx,
      open_job(ctx, "a.exr",
               &(hetab_exr_options){.parts = HETAB_EXR_ATLAS, .bands = HETAB_EXR_SPECTRAL}, BANDS,
               &job),
      HETAB_ERR_ARGUMENT, "R, G and B");
  close_job(&job);
  assert_failure(ctx, open_job(ctx, "a.exr", &(hetab_exr_options){0}, 5, &job), HETAB_ERR_RANGE,
                 "400 to 700");
  close_job(&job);
  assert_int_equal(count_files("."), 0);
}

static hetab_status try_grid(hetab_context *ctx, const char *theta_i, const char *theta_r,
                             const char *phi, hetab_exr_parts parts) {
  job job;
  hetab_exr_options options = {
      .bands = parts == HETAB_EXR_ATLAS ? HETAB_EXR_RGB : HETAB_EXR_SPECTRAL, .parts = parts};
  assert_ok(ctx,
            open_job(ctx, "b.exr", &(hetab_exr_options){.bands = HETAB_EXR_SPECTRAL}, BANDS, &job));
  hetab_table_abort(job.writer);
  assert_ok(ctx, hetab_grid_set_axis(ctx, job.grid, HETAB_THETA_I, theta_i));
  assert_ok(ctx, hetab_grid_set_axis(ctx, job.grid, HETAB_THETA_R, theta_r));
  assert_ok(ctx, hetab_grid_set_axis(ctx, job.grid, HETAB_PHI, phi));
  hetab_status status =
      hetab_exr_create(ctx, "b.exr", job.surface, job.grid, &options, &job.writer);
  close_job(&job);
  return status;
}

static void absurd_sizes(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  assert_failure(ctx, try_grid(ctx, "0:90:5000", "0:90:2", "0:180:2", HETAB_EXR_BY_THETA_I),
                 HETAB_ERR_RANGE, "5000 parts");
  assert_failure(ctx, try_grid(ctx, "0:90:2", "0:90:20000", "0:180:20000", HETAB_EXR_BY_THETA_I),
                 HETAB_ERR_RANGE, "GiB");
  assert_failure(ctx, try_grid(ctx, "0:90:2000", "0:90:2000", "0:180:2", HETAB_EXR_BY_WAVELENGTH),
                 HETAB_ERR_RANGE, "4000000 rows");
  assert_failure(ctx, try_grid(ctx, "0:90:300", "0:90:300", "0:180:721", HETAB_EXR_BY_WAVELENGTH),
                 HETAB_ERR_RANGE, "GiB");
  assert_failure(ctx, try_grid(ctx, "0:90:2", "0:90:2", "0:180:20000", HETAB_EXR_ATLAS),
                 HETAB_ERR_RANGE, "20000 x 4 pixels");
  assert_int_equal(count_files("."), 0);
}

static void bad_slabs(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  float values[BLOCK] = {0};
  job job;
  assert_ok(ctx, open_job(ctx, "a.exr", &(hetab_exr_options){0}, BANDS, &job));
  assert_ok(ctx, write_slab(ctx, &job, HETAB_FLOAT, 3, 1, 1));
  assert_failure(ctx, write_slab(ctx, &job, HETAB_FLOAT, 3, 0, 2), HETAB_ERR_ARGUMENT, "twice");
  assert_failure(ctx, write_slab(ctx, &job, HETAB_FLOAT, BANDS, 0, 1), HETAB_ERR_ARGUMENT,
                 "not in the table");
  assert_failure(ctx, write_slab(ctx, &job, HETAB_FLOAT, 0, 2, 2), HETAB_ERR_ARGUMENT,
                 "not in the table");
  values[7] = NAN;
  assert_failure(ctx, hetab_table_write_slab(ctx, job.writer, &(hetab_slab){0, 0, 1, values}),
                 HETAB_ERR_ARGUMENT, "NaN");
  assert_failure(ctx, commit(ctx, &job), HETAB_ERR_ARGUMENT, "92 theta_i rows and the specular");
  close_job(&job);
  assert_int_equal(count_files("."), 0);
}

/* --- bad disks ------------------------------------------------------------------------------ */

static void existing(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  job job;
  put_file("a.exr", "old", 3);
  assert_failure(ctx, open_job(ctx, "a.exr", &(hetab_exr_options){0}, BANDS, &job),
                 HETAB_ERR_EXISTS, "a.exr");
  close_job(&job);
  assert_failure(ctx, open_job(ctx, "none/a.exr", &(hetab_exr_options){0}, BANDS, &job),
                 HETAB_ERR_IO, "none");
  close_job(&job);
  assert_ok(ctx, open_job(ctx, "a.exr", &(hetab_exr_options){.overwrite = 1}, BANDS, &job));
  close_job(&job); /* abandoned */
  assert_content("a.exr", "old");
}

static void full_disk(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  hetab_exr_options options = {.bands = HETAB_EXR_SPECTRAL};
  hetab_status status;
  job job;
  require_mounting();
  mount_small(16384);
  status = open_job(ctx, "small/a.exr", &options, BANDS, &job);
  for (size_t w = 0; w < BANDS && status == HETAB_OK; w++)
    status = write_slab(ctx, &job, HETAB_FLOAT, w, 0, THETA_I);
  assert_failure(ctx, status, HETAB_ERR_IO, "No space left");
  close_job(&job);
  assert_int_equal(count_files("small"), 0);
  unmount_small();
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(spectral),         TEST(by_wavelength), TEST(half),
      TEST(colour),           TEST(attributes),    TEST(atlas),
      TEST(atlas_too_bright), TEST(bad_options),   TEST(absurd_sizes),
      TEST(bad_slabs),        TEST(existing),      TEST(full_disk),
  };
  return cmocka_run_group_tests_name("exr", tests, NULL, NULL);
}
