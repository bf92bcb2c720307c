#include "targets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <hdf5.h>
#include <zip.h>
#include <hetab/hetab.h>

/* ---- what every target does ---------------------------------------------------------------- */

static hetab_context *ctx;
static const char *running; /* the target's name */

#define PROMISE(condition)                                                                         \
  do {                                                                                             \
    if (!(condition)) {                                                                            \
      fprintf(stderr, "%s:%d: %s broke: %s\n", __FILE__, __LINE__, running, #condition);           \
      abort();                                                                                     \
    }                                                                                              \
  } while (0)

/* A status as promised: a failure has its one line. */
static int accepted(hetab_status status, const void *handle) {
  const char *message = hetab_error_message(ctx);
  PROMISE((status == HETAB_OK) == (handle != NULL));
  PROMISE(status == HETAB_OK || (*message && !strchr(message, '\n')));
  return status == HETAB_OK;
}

static hetab_status result; /* of the reader: it comes before the handle is looked at */
#define ACCEPTED(call, handle) (result = (call), accepted(result, handle))

static void write_file(const char *path, const void *data, size_t size) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(data, 1, size, file) != size || fclose(file))
    abort();
}

/* ---- surfaces and indices ------------------------------------------------------------------ */

static void check_index(const hetab_index *index) {
  double low, high, n, k;
  hetab_index_range(index, &low, &high);
  PROMISE(low > 0.0 && low <= high);
  for (int i = 0; i <= 4; i++)
    if (hetab_index_at(ctx, index, low + (high - low) * i / 4.0, 0, &n, &k) == HETAB_OK)
      PROMISE(isfinite(n) && isfinite(k) && n > 0.0 && k >= 0.0);
}

static void run_index(const uint8_t *data, size_t size, const char *path) {
  hetab_index *index;
  write_file(path, data, size);
  if (ACCEPTED(hetab_index_load(ctx, path, &index), index))
    check_index(index);
  hetab_index_free(index);
}

static void run_surface(const uint8_t *data, size_t size, const char *path) {
  hetab_surface *surface;
  char *text;
  write_file(path, data, size);
  if (ACCEPTED(hetab_surface_load(ctx, path, &surface), surface)) {
    const hetab_band *bands = hetab_surface_bands(surface);
    PROMISE(hetab_surface_sigma0_um(surface) > 0.0 && isfinite(hetab_surface_sigma0_um(surface)));
    PROMISE(hetab_surface_tau_um(surface) > 0.0 && isfinite(hetab_surface_tau_um(surface)));
    for (size_t i = 0; i < hetab_surface_band_count(surface); i++)
      PROMISE(bands[i].lambda_um > 0.0 && bands[i].n > 0.0 && bands[i].k >= 0.0);
    if (hetab_surface_yaml(ctx, surface, &text) == HETAB_OK)
      free(text);
  }
  hetab_surface_free(surface);
}

/* ---- texts of the command line ------------------------------------------------------------- */

static void run_axis(const uint8_t *data, size_t size, const char *path) {
  hetab_grid *grid;
  char *text = strndup((const char *)data, size);
  if (hetab_grid_create(ctx, &grid) != HETAB_OK)
    abort();
  if (hetab_grid_set_axis(ctx, grid, HETAB_PHI, text) == HETAB_OK) {
    const double *deg = hetab_grid_deg(grid, HETAB_PHI);
    for (size_t i = 0; i < hetab_grid_count(grid, HETAB_PHI); i++)
      PROMISE(deg[i] >= 0.0 && deg[i] <= 180.0 && (i == 0 || deg[i] > deg[i - 1]));
  }
  hetab_grid_free(grid);
  free(text);
}

static void run_wavelengths(const uint8_t *data, size_t size, const char *path) {
  double *lambda_um;
  size_t count = 0;
  char *text = strndup((const char *)data, size);
  if (ACCEPTED(hetab_parse_wavelengths(ctx, text, &lambda_um, &count), lambda_um))
    for (size_t i = 0; i < count; i++)
      PROMISE(lambda_um[i] > 0.0 && isfinite(lambda_um[i]));
  free(lambda_um);
  free(text);
}

/* ---- height scans -------------------------------------------------------------------------- */

static void load_heights(const char *path) {
  hetab_heights *heights;
  hetab_heights_options options = {0};
  if (ACCEPTED(hetab_heights_load(ctx, path, &options, &heights), heights)) {
    size_t count = hetab_heights_column_count(heights) * hetab_heights_row_count(heights);
    PROMISE(hetab_heights_spacing_um(heights) > 0.0);
    for (size_t i = 0; i < count; i++)
      PROMISE(!isinf(hetab_heights_z_um(heights)[i]));
  }
  hetab_heights_free(heights);
}

static void run_heights(const uint8_t *data, size_t size, const char *path) {
  write_file(path, data, size);
  load_heights(path);
}

static void add_member(zip_t *zip, const char *name, const void *data, size_t size) {
  zip_source_t *source = zip_source_buffer(zip, data, size, 0);
  if (!source || zip_file_add(zip, name, source, ZIP_FL_OVERWRITE) < 0)
    abort();
}

/* The bytes up to a NUL are the description, the others the points: a zip of its own would hide
 * them behind checksums. */
static void run_x3p(const uint8_t *data, size_t size, const char *path) {
  int code;
  size_t xml = strnlen((const char *)data, size);
  unlink(path);
  zip_t *zip = zip_open(path, ZIP_CREATE | ZIP_TRUNCATE, &code);
  if (!zip)
    abort();
  add_member(zip, "main.xml", data, xml);
  if (xml < size)
    add_member(zip, "bindata/data.bin", data + xml + 1, size - xml - 1);
  if (zip_close(zip))
    zip_discard(zip);
  else
    load_heights(path);
}

static void run_published(const uint8_t *data, size_t size, const char *path) {
  hetab_published *published;
  write_file(path, data, size);
  ACCEPTED(hetab_published_load(ctx, &path, 1, &published), published);
  hetab_published_free(published);
}

/* ---- measurements -------------------------------------------------------------------------- */

static void run_measurements(const uint8_t *data, size_t size, const char *path) {
  hetab_measurements *m;
  write_file(path, data, size);
  if (ACCEPTED(hetab_measurements_load(ctx, path, &m), m)) {
    size_t bands = hetab_measurements_wavelength_count(m), pairs = hetab_measurements_pair_count(m);
    for (size_t i = 0; i < bands; i++)
      PROMISE(hetab_measurements_lambda_um(m)[i] >= 0.01 &&
              hetab_measurements_lambda_um(m)[i] <= 100.0);
    for (size_t i = 0; i < bands * pairs; i++)
      PROMISE(!(fabs(hetab_measurements_values(m)[i]) > 1e12)); /* NaN: missing */
  }
  hetab_measurements_free(m);
}

/* ---- tables -------------------------------------------------------------------------------- */

enum { MOST_CHANNELS = 4096, DIRECTIONS = 6 };

static int is_radiant(float value) {
  return isfinite(value) && value >= 0.0f;
}

static void check_rgl(const hetab_rgl *rgl) {
  static const float polar[DIRECTIONS] = {0.0f, 0.3f, 0.8f, 1.4f, 1.57f, 1.5707f};
  static float value[MOST_CHANNELS];
  size_t channels = hetab_rgl_channel_count(rgl);
  PROMISE(channels <= MOST_CHANNELS);
  for (int i = 0; i < DIRECTIONS * DIRECTIONS; i++) {
    float a = polar[i / DIRECTIONS], b = polar[i % DIRECTIONS], turn = 0.7f * (float)i;
    float wi[3] = {sinf(a), 0.0f, cosf(a)}, u[2] = {0.13f * (float)(i % 7), 0.24f * (float)(i % 4)};
    float wo[3] = {sinf(b) * cosf(turn), sinf(b) * sinf(turn), cosf(b)}, drawn[3];
    hetab_rgl_eval(rgl, wi, wo, value);
    for (size_t c = 0; c < channels; c++)
      PROMISE(is_radiant(value[c]));
    PROMISE(is_radiant(hetab_rgl_pdf(rgl, wi, wo)));
    PROMISE(is_radiant(hetab_rgl_sample(rgl, wi, u, drawn)));
    for (int k = 0; k < 3; k++)
      PROMISE(isfinite(drawn[k]));
  }
}

static void run_bsdf(const uint8_t *data, size_t size, const char *path) {
  hetab_rgl *rgl;
  write_file(path, data, size);
  if (ACCEPTED(hetab_rgl_load(ctx, path, &rgl), rgl))
    check_rgl(rgl);
  hetab_rgl_free(rgl);
}

/* The bytes overwrite the start of a black table and doubles in it; with less it would be short. */
static void run_merl(const uint8_t *data, size_t size, const char *path) {
  const int32_t dims[3] = {HETAB_MERL_THETA_H, HETAB_MERL_THETA_D, HETAB_MERL_PHI_D};
  hetab_merl *merl;
  size_t head = size < 12 ? size : 12;
  write_file(path, dims, sizeof dims);
  FILE *file = fopen(path, "r+b");
  if (!file || truncate(path, 12 + 3 * 8L * HETAB_MERL_CELLS - (size % 5 == 4)))
    abort();
  if (size % 3 == 0)
    fwrite(data, 1, head, file);
  fseek(file, 12, SEEK_SET);
  fwrite(data + head, 1, size - head, file);
  fclose(file);
  if (ACCEPTED(hetab_merl_load(ctx, path, &merl), merl))
    for (int i = 0; i < 1000; i++)
      for (int c = 0; c < 3; c++)
        PROMISE(!isnan(hetab_merl_channel(merl, c)[i]));
  hetab_merl_free(merl);
}

/* ---- HDF5 ---------------------------------------------------------------------------------- */

enum { MOST_ENTRIES = 1 << 20 };

static void open_h5(const char *path) {
  hetab_h5_table *table;
  if (ACCEPTED(hetab_h5_open(ctx, path, &table), table)) {
    const hetab_grid *grid = hetab_h5_grid(table);
    size_t bands = hetab_h5_wavelength_count(table), entries = 1;
    for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
      entries *= hetab_grid_count(grid, axis);
    for (size_t i = 0; i < bands; i++)
      PROMISE(hetab_h5_wavelengths_um(table)[i] > 0.0);
    double *values = entries <= MOST_ENTRIES && bands <= MOST_ENTRIES / entries
                         ? calloc(entries * bands + 1, sizeof *values)
                         : NULL;
    for (size_t i = 0; values && i < bands; i++)
      hetab_h5_read(ctx, table, i, values);
    if (values)
      hetab_h5_read_specular(ctx, table, values);
    free(values);
  }
  hetab_h5_free(table);
}

/* The bytes, one after the other; zeros when they are used up. */
typedef struct choices {
  const uint8_t *next, *end;
} choices;

static unsigned take(choices *c) {
  return c->next < c->end ? *c->next++ : 0;
}

static void fill(choices *c, double *values, size_t count, double first, double step) {
  for (size_t i = 0; i < count; i++)
    values[i] = first + step * (double)i;
  unsigned at = take(c);
  if (at && at <= count)
    memcpy(&values[at - 1], (uint64_t[]){(uint64_t)take(c) << 56 | (uint64_t)take(c) << 48}, 8);
}

static hid_t choose_type(choices *c) {
  static const size_t sizes[] = {4, 8, 2, 16, 200};
  unsigned byte = take(c);
  if (byte < 128)
    return H5Tcopy(byte % 2 ? H5T_IEEE_F32LE : H5T_IEEE_F64BE);
  if (byte < 160)
    return H5Tcopy(byte % 2 ? H5T_STD_I16LE : H5T_C_S1);
  hid_t type = H5Tcopy(H5T_IEEE_F64LE);
  H5Tset_size(type, sizes[byte % 5]);
  return type;
}

/* Whether the numbers lie in the file: HDF5 may not survive writing them elsewhere. */
static int choose_storage(choices *c, hid_t creation, int rank, const hsize_t *dims) {
  unsigned byte = take(c);
  hsize_t chunk[4];
  for (int i = 0; i < rank; i++)
    chunk[i] = 1 + byte % (dims[i] ? dims[i] : 1);
  if (byte % 4 == 1)
    H5Pset_chunk(creation, rank, chunk);
  if (byte % 4 == 1 && byte & 16)
    H5Pset_deflate(creation, 3);
  if (byte % 4 == 1 && byte & 32)
    H5Pset_fletcher32(creation);
  if (byte % 4 == 2)
    H5Pset_layout(creation, H5D_COMPACT);
  if (byte == 3)
    H5Pset_external(creation, "/dev/zero", 0, H5F_UNLIMITED);
  if (byte == 7)
    H5Pset_virtual(creation, H5Screate_simple(rank, dims, NULL), ".", "/theta_i",
                   H5Screate_simple(rank, dims, NULL));
  return byte != 3 && byte != 7;
}

static void add_dataset(choices *c, hid_t file, const char *name, int rank, const hsize_t *sound,
                        double first, double step) {
  static double values[4096];
  hsize_t dims[4], count = 1;
  unsigned byte = take(c);
  if (byte == 1 || byte == 2) {
    H5Lcreate_soft(byte == 1 ? name : "/brdf", file, name, H5P_DEFAULT, H5P_DEFAULT);
    return;
  }
  memcpy(dims, sound, (size_t)rank * sizeof *dims);
  if (byte >= 4 && byte < 8)
    dims[0] = take(c) % 16;
  rank -= byte == 8 && rank > 1;
  for (int i = 0; i < rank; i++)
    count *= dims[i];
  hid_t type = choose_type(c), space = H5Screate_simple(rank, dims, NULL);
  hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  int inside = choose_storage(c, creation, rank, dims);
  hid_t set =
      byte == 3 ? -1 : H5Dcreate2(file, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  fill(c, values, count < 4096 ? count : 4096, first, step);
  if (inside && byte != 9)
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  H5Dclose(set);
  H5Pclose(creation);
  H5Sclose(space);
  H5Tclose(type);
}

/* A table of ours, but for what the bytes change. */
static void run_h5(const uint8_t *data, size_t size, const char *path) {
  choices c = {data, data + size};
  const hsize_t dims[4] = {3, 4, 5, 6};
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  add_dataset(&c, file, "wavelength", 1, dims, 400, 100);
  add_dataset(&c, file, "theta_i", 1, dims + 1, 0, 30);
  add_dataset(&c, file, "theta_r", 1, (hsize_t[4]){5}, 0, 20);
  add_dataset(&c, file, "phi", 1, (hsize_t[4]){6}, 0, 36);
  add_dataset(&c, file, "brdf", 4, dims, 0.1, 0);
  add_dataset(&c, file, "specular_reflectance", 2, dims, 0.5, 0);
  add_dataset(&c, file, "uniform_diffuse", 1, dims, 0, 0);
  add_dataset(&c, file, "n", 1, dims, 1, 0.1);
  add_dataset(&c, file, "k", 1, dims, 5, 0);
  H5Fclose(file);
  open_h5(path);
  hetab_measurements *m;
  ACCEPTED(hetab_measurements_load(ctx, path, &m), m);
  hetab_measurements_free(m);
}

static void run_h5_bytes(const uint8_t *data, size_t size, const char *path) {
  write_file(path, data, size);
  open_h5(path);
}

/* ---- all ----------------------------------------------------------------------------------- */

const fuzz_target fuzz_targets[] = {
    {"surface", "input.yml", run_surface},
    {"index_yaml", "input.yml", run_index},
    {"index_csv", "input.csv", run_index},
    {"axis", NULL, run_axis},
    {"wavelengths", NULL, run_wavelengths},
    {"scan", "input.csv", run_heights},
    {"sdf", "input.sdf", run_heights},
    {"x3p", "input.x3p", run_x3p},
    {"published", "input.csv", run_published},
    {"brdf", "input.brdf", run_measurements},
    {"astm", "input.astm", run_measurements},
    {"measured_csv", "input.csv", run_measurements},
    {"merl", "input.binary", run_merl},
    {"bsdf", "input.bsdf", run_bsdf},
    {"h5", "input.h5", run_h5},
    {"h5_bytes", "input.h5", run_h5_bytes},
};
const size_t fuzz_target_count = sizeof fuzz_targets / sizeof *fuzz_targets;

static char folder[64];

static const char *path_of(const fuzz_target *target) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, target->file ? target->file : "none");
  return path;
}

static void remove_folder(void) {
  for (size_t i = 0; i < fuzz_target_count; i++)
    unlink(path_of(&fuzz_targets[i]));
  rmdir(folder);
}

void fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size) {
  if (!*folder) {
    snprintf(folder, sizeof folder, "/dev/shm/hetab-fuzz-%d", (int)getpid());
    if (mkdir(folder, 0700) || hetab_context_create(&ctx) != HETAB_OK)
      abort();
    atexit(remove_folder);
  }
  running = target->name;
  target->run(data, size, path_of(target));
}
