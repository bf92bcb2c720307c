#include <hetab/table.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <hdf5.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/input_file.h"
#include "table/h5_common.h"
#include "table/h5_rows.h"
#include "table/table_format.h"

/* Axes of /brdf, in its order. */
enum { WAVELENGTH, THETA_I, THETA_R, PHI, RANK };

/* Longer axes are damage, or an attack on the memory. */
enum { MAX_COUNT = 100000 };

enum { SRGB_CHANNELS = 3 };

/* Of axes that do not say, as hetab_unit() has them. */
static const double DEGREE = M_PI / 180.0, NANOMETRE = 1e-3;

/* Less is a wavelength in um that passes for one in nm. */
static const double SHORTEST_UM = 0.01;

struct hetab_h5_table {
  char *path; /* for messages */
  hetab_h5_descriptor descriptor;
  hid_t h5, brdf;
  hsize_t dims[RANK];
  int srgb; /* the leading axis is `channel` */
  double *lambda_um;
  hetab_grid *grid;
};

static const char *axis_path(const hetab_h5_table *table, int axis) {
  static const char *const paths[RANK] = {"wavelength", "theta_i", "theta_r", "phi"};
  return axis == WAVELENGTH && table->srgb ? "channel" : paths[axis];
}

/* --- datasets ------------------------------------------------------------------------------- */

/* A dataset over the leading axes, of their sizes. */
static hetab_status open_over_axes(hetab_context *ctx, const hetab_h5_table *table,
                                   const char *name, int rank, hid_t *out) {
  hsize_t dims[RANK];
  hid_t dataset;
  HETAB_TRY(hetab_h5_dataset_open(ctx, table->h5, table->path, name, rank, dims, &dataset));
  for (int i = 0; i < rank; i++)
    if (dims[i] != table->dims[i]) {
      H5Dclose(dataset);
      return hetab_fail(ctx, HETAB_ERR_PARSE,
                        "'%s': dimension %d of /%s has %llu entries, but /%s has %llu", table->path,
                        i, name, (unsigned long long)dims[i], axis_path(table, i),
                        (unsigned long long)table->dims[i]);
    }
  *out = dataset;
  return HETAB_OK;
}

static hetab_status read_failed(hetab_context *ctx, const hetab_h5_table *table, const char *name,
                                const hetab_h5_errors *errors) {
  return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s' is damaged: /%s cannot be read: HDF5: %s",
                    table->path, name, errors->text);
}

/* Every number came from the file. */
static hetab_status check_read(hetab_context *ctx, const hetab_h5_table *table) {
  return table->descriptor.error ? hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %s",
                                              table->path, strerror(table->descriptor.error))
                                 : HETAB_OK;
}

/* --- axes ----------------------------------------------------------------------------------- */

/* Of an angle in radians, of which a float32 may be more than pi. */
static double degrees_of(double radians) {
  static const double SLACK = 1e-5;
  double deg = hetab_degrees(radians), right = 90.0 * round(deg / 90.0);
  return fabs(deg - right) < SLACK ? right : deg;
}

/* Lengths to um, angles to degrees, those in degrees as they are. */
static void convert(int axis, double unit, double *values, hsize_t count) {
  for (hsize_t i = 0; i < count; i++)
    if (axis == WAVELENGTH)
      values[i] = hetab_in_unit(values[i], unit);
    else if (unit != DEGREE)
      values[i] = degrees_of(hetab_in_unit(values[i], unit));
}

/* An axis's values; free() them. */
static hetab_status read_axis(hetab_context *ctx, hetab_h5_table *table, int axis, double **out,
                              const hetab_h5_errors *errors) {
  const char *name = axis_path(table, axis);
  hetab_status status = HETAB_OK;
  double *values = NULL, unit = 1.0;
  hid_t dataset;
  HETAB_TRY(
      hetab_h5_dataset_open(ctx, table->h5, table->path, name, 1, &table->dims[axis], &dataset));
  hsize_t count = table->dims[axis];
  if (!count || count > MAX_COUNT)
    HETAB_GOTO(hetab_fail(ctx, HETAB_ERR_PARSE, "'%s': /%s has %llu entries; 1 to %d make sense",
                          table->path, name, (unsigned long long)count, MAX_COUNT));
  values = hetab_alloc(ctx, (size_t)count, sizeof *values);
  if (!values)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    HETAB_GOTO(read_failed(ctx, table, name, errors));
  if (axis != WAVELENGTH || !table->srgb)
    HETAB_GOTO(hetab_h5_unit(ctx, dataset, table->path, name,
                             axis == WAVELENGTH ? HETAB_LENGTH : HETAB_ANGLE,
                             axis == WAVELENGTH ? NANOMETRE : DEGREE, &unit));
  convert(axis, unit, values, count);
  *out = values;
  values = NULL;
done:
  free(values);
  H5Dclose(dataset);
  return status;
}

static hetab_status read_wavelengths(hetab_context *ctx, hetab_h5_table *table,
                                     const hetab_h5_errors *errors) {
  HETAB_TRY(read_axis(ctx, table, WAVELENGTH, &table->lambda_um, errors));
  double last = SHORTEST_UM;
  for (hsize_t i = 0; i < table->dims[WAVELENGTH]; i++) {
    double um = table->lambda_um[i];
    if (!(um > last && isfinite(um)))
      return hetab_fail(ctx, HETAB_ERR_PARSE,
                        "'%s': entry %llu of /wavelength is %g nm; wavelengths are above 10 nm and "
                        "ascend; its attribute units says what they are in",
                        table->path, (unsigned long long)i, 1e3 * um);
    last = um;
  }
  return HETAB_OK;
}

/* Tables made from linear sRGB have channels in place of wavelengths. */
static hetab_status read_leading_axis(hetab_context *ctx, hetab_h5_table *table,
                                      const hetab_h5_errors *errors) {
  HETAB_FREED double *channels = NULL;
  table->srgb = H5Lexists(table->h5, "wavelength", H5P_DEFAULT) <= 0 &&
                H5Lexists(table->h5, "channel", H5P_DEFAULT) > 0;
  if (!table->srgb)
    return read_wavelengths(ctx, table, errors);
  HETAB_TRY(read_axis(ctx, table, WAVELENGTH, &channels, errors));
  return table->dims[WAVELENGTH] == SRGB_CHANNELS
             ? HETAB_OK
             : hetab_fail(ctx, HETAB_ERR_PARSE, "'%s': /channel has %llu entries in place of 3",
                          table->path, (unsigned long long)table->dims[WAVELENGTH]);
}

static hetab_status read_angles(hetab_context *ctx, hetab_h5_table *table, hetab_axis axis,
                                const hetab_h5_errors *errors) {
  int path = THETA_I + (int)axis;
  double *deg;
  HETAB_TRY(read_axis(ctx, table, path, &deg, errors));
  hetab_status status =
      hetab_grid_set_values(ctx, table->grid, axis, deg, (size_t)table->dims[path]);
  free(deg);
  if (status == HETAB_ERR_ARGUMENT) {
    char reason[256];
    strncpy(reason, hetab_error_message(ctx), sizeof reason - 1);
    reason[sizeof reason - 1] = '\0';
    return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s' has a bad %s", table->path, reason);
  }
  return status;
}

/* --- opening -------------------------------------------------------------------------------- */

static hetab_status open_descriptor(hetab_context *ctx, hetab_h5_table *table) {
  unsigned char start[HETAB_FORMAT_START] = {0};
  hetab_format format;
  HETAB_TRY(hetab_input_open(ctx, table->path, HETAB_INPUT_TABLE, &table->descriptor.fd));
  if (pread(table->descriptor.fd, start, sizeof start, 0) < 0)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", table->path);
  if (!hetab_format_by_start(start, &format) || format != HETAB_FORMAT_H5)
    return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s' is not an HDF5 file, or not a complete copy",
                      table->path);
  return HETAB_OK;
}

static hetab_status incomplete(hetab_context *ctx, const hetab_h5_table *table, hsize_t found,
                               hsize_t expected, const char *parts) {
  return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s' is incomplete: /brdf has %llu of %llu %s",
                    table->path, (unsigned long long)found, (unsigned long long)expected, parts);
}

static hetab_status check_chunks(hetab_context *ctx, const hetab_h5_table *table,
                                 const hsize_t chunk[RANK]) {
  hsize_t expected = 1, found = 0;
  for (int i = 0; i < RANK; i++)
    expected *= (table->dims[i] + chunk[i] - 1) / chunk[i];
  hid_t space = H5Dget_space(table->brdf);
  H5Dget_num_chunks(table->brdf, space, &found);
  H5Sclose(space);
  return found == expected ? HETAB_OK : incomplete(ctx, table, found, expected, "chunks");
}

/* All in one run of bytes, and the file long enough for it. */
static hetab_status check_run(hetab_context *ctx, const hetab_h5_table *table) {
  hid_t type = H5Dget_type(table->brdf);
  hsize_t expected = H5Tget_size(type), found = H5Dget_storage_size(table->brdf);
  haddr_t start = H5Dget_offset(table->brdf);
  struct stat about;
  H5Tclose(type);
  for (int i = 0; i < RANK; i++)
    expected *= table->dims[i];
  if (start == HADDR_UNDEF || fstat(table->descriptor.fd, &about))
    found = 0;
  else if ((haddr_t)about.st_size < start + found)
    found = (haddr_t)about.st_size > start ? (haddr_t)about.st_size - start : 0;
  return found == expected ? HETAB_OK : incomplete(ctx, table, found, expected, "bytes");
}

/* Where a part is missing HDF5 would leave the reader's memory as it is. */
static hetab_status check_complete(hetab_context *ctx, const hetab_h5_table *table) {
  hsize_t chunk[RANK];
  hid_t list = H5Dget_create_plist(table->brdf);
  H5D_layout_t layout = H5Pget_layout(list);
  int has_chunks = layout == H5D_CHUNKED && H5Pget_chunk(list, RANK, chunk) == RANK;
  H5Pclose(list);
  if (has_chunks)
    return check_chunks(ctx, table, chunk);
  if (layout == H5D_CONTIGUOUS)
    return check_run(ctx, table);
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "'%s' is no hetab table: /brdf is neither chunked nor contiguous", table->path);
}

static hetab_status open_datasets(hetab_context *ctx, hetab_h5_table *table,
                                  const hetab_h5_errors *errors) {
  static const struct {
    const char *name;
    int rank;
  } others[] = {{"specular_reflectance", 2}, {"uniform_diffuse", 1}, {"n", 1}, {"k", 1}};
  table->h5 = hetab_h5_file_open(&table->descriptor);
  if (table->h5 < 0)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' is damaged or truncated; get a complete copy: HDF5: %s", table->path,
                      errors->text);
  HETAB_TRY(read_leading_axis(ctx, table, errors));
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    HETAB_TRY(read_angles(ctx, table, axis, errors));
  for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
    hid_t dataset;
    HETAB_TRY(open_over_axes(ctx, table, others[i].name, others[i].rank, &dataset));
    H5Dclose(dataset);
  }
  HETAB_TRY(open_over_axes(ctx, table, "brdf", RANK, &table->brdf));
  return check_complete(ctx, table);
}

hetab_status hetab_h5_open_any(hetab_context *ctx, const char *path, hetab_h5_table **out) {
  hetab_h5_errors errors;
  hetab_status status;
  *out = NULL;
  hetab_h5_table *table = hetab_alloc(ctx, 1, sizeof *table);
  HETAB_NEED(table);
  table->descriptor.fd = -1;
  table->h5 = table->brdf = H5I_INVALID_HID;
  hetab_h5_errors_begin(&errors);
  table->path = strdup(path);
  if (!table->path)
    HETAB_GOTO(hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name '%s'", path));
  HETAB_GOTO(hetab_grid_create(ctx, &table->grid));
  HETAB_GOTO(open_descriptor(ctx, table));
  HETAB_GOTO(open_datasets(ctx, table, &errors));
  status = check_read(ctx, table);
done:
  hetab_h5_errors_end(&errors);
  if (status != HETAB_OK && table->descriptor.error)
    status = check_read(ctx, table); /* which explains the rest */
  *out = table;
  HETAB_MADE(hetab_h5, out, status);
}

hetab_status hetab_h5_open(hetab_context *ctx, const char *path, hetab_h5_table **out) {
  HETAB_TRY(hetab_h5_open_any(ctx, path, out));
  if (!(*out)->srgb)
    return HETAB_OK;
  hetab_h5_free(*out);
  *out = NULL;
  return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                    "'%s' holds linear sRGB in place of wavelengths; convert it to a MERL table "
                    "first: hetab convert '%s' NAME.binary",
                    path, path);
}

void hetab_h5_free(hetab_h5_table *table) {
  hetab_h5_errors errors;
  if (!table)
    return;
  hetab_h5_errors_begin(&errors);
  if (table->h5 >= 0)
    H5Fclose(table->h5); /* and the datasets that are open in it */
  hetab_h5_errors_end(&errors);
  if (table->descriptor.fd >= 0)
    close(table->descriptor.fd);
  hetab_grid_free(table->grid);
  free(table->lambda_um);
  free(table->path);
  free(table);
}

size_t hetab_h5_wavelength_count(const hetab_h5_table *table) {
  return (size_t)table->dims[WAVELENGTH];
}

const double *hetab_h5_wavelengths_um(const hetab_h5_table *table) {
  return table->lambda_um;
}

const hetab_grid *hetab_h5_grid(const hetab_h5_table *table) {
  return table->grid;
}

/* --- reading -------------------------------------------------------------------------------- */

static herr_t read_block(const hetab_h5_table *table, const hsize_t start[RANK],
                         const hsize_t count[RANK], hid_t type, void *values) {
  hid_t memory = H5Screate_simple(RANK, count, NULL);
  hid_t space = H5Dget_space(table->brdf);
  herr_t result = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL);
  if (result >= 0)
    result = H5Dread(table->brdf, type, memory, space, H5P_DEFAULT, values);
  H5Sclose(space);
  H5Sclose(memory);
  return result;
}

static hetab_status read_checked(hetab_context *ctx, const hetab_h5_table *table,
                                 const hsize_t start[RANK], const hsize_t count[RANK], hid_t type,
                                 void *values) {
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result = read_block(table, start, count, type, values);
  hetab_h5_errors_end(&errors);
  HETAB_TRY(check_read(ctx, table));
  return result < 0 ? read_failed(ctx, table, "brdf", &errors) : HETAB_OK;
}

hetab_status hetab_h5_read(hetab_context *ctx, hetab_h5_table *table, size_t wavelength,
                           double *values) {
  const hsize_t start[RANK] = {wavelength, 0, 0, 0};
  const hsize_t count[RANK] = {1, table->dims[THETA_I], table->dims[THETA_R], table->dims[PHI]};
  if (wavelength >= table->dims[WAVELENGTH])
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "'%s' has no wavelength %zu, only %zu of them",
                      table->path, wavelength, (size_t)table->dims[WAVELENGTH]);
  return read_checked(ctx, table, start, count, H5T_NATIVE_DOUBLE, values);
}

size_t hetab_h5_row_step(const hetab_h5_table *table) {
  hsize_t chunk[RANK] = {1, 1, 1, 1};
  hid_t list = H5Dget_create_plist(table->brdf);
  if (H5Pget_layout(list) == H5D_CHUNKED)
    H5Pget_chunk(list, RANK, chunk);
  H5Pclose(list);
  return (size_t)(chunk[THETA_I] < table->dims[THETA_I] ? chunk[THETA_I] : table->dims[THETA_I]);
}

hetab_status hetab_h5_read_rows(hetab_context *ctx, hetab_h5_table *table, size_t first,
                                size_t count, float *values) {
  const hsize_t start[RANK] = {0, first, 0, 0};
  const hsize_t counts[RANK] = {table->dims[WAVELENGTH], count, table->dims[THETA_R],
                                table->dims[PHI]};
  return read_checked(ctx, table, start, counts, H5T_NATIVE_FLOAT, values);
}

/* A whole dataset of `rank` axes, whose size was checked on opening. */
static hetab_status read_whole(hetab_context *ctx, const hetab_h5_table *table, const char *name,
                               int rank, double *values) {
  hetab_h5_errors errors;
  hsize_t dims[RANK];
  hid_t dataset;
  hetab_h5_errors_begin(&errors);
  hetab_status status =
      hetab_h5_dataset_open(ctx, table->h5, table->path, name, rank, dims, &dataset);
  if (status == HETAB_OK &&
      H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    status = read_failed(ctx, table, name, &errors);
  H5Dclose(dataset);
  hetab_h5_errors_end(&errors);
  return table->descriptor.error ? check_read(ctx, table) : status;
}

hetab_status hetab_h5_read_specular(hetab_context *ctx, hetab_h5_table *table, double *values) {
  return read_whole(ctx, table, "specular_reflectance", 2, values);
}

hetab_status hetab_h5_bands(hetab_context *ctx, hetab_h5_table *table, hetab_band *bands) {
  size_t count = (size_t)table->dims[WAVELENGTH];
  HETAB_FREED double *values = hetab_alloc(ctx, 3 * count, sizeof *values);
  hetab_status status = values ? HETAB_OK : HETAB_ERR_MEMORY;
  static const char *const names[] = {"n", "k", "uniform_diffuse"};
  for (size_t i = 0; i < 3 && status == HETAB_OK; i++)
    status = read_whole(ctx, table, names[i], 1, values + i * count);
  for (size_t w = 0; w < count && status == HETAB_OK; w++)
    bands[w] =
        (hetab_band){table->lambda_um[w], values[w], values[count + w], values[2 * count + w]};
  return status;
}

/* One number, whatever its type in the file; negative if the attribute is something else. */
static herr_t read_number(hid_t root, const char *name, double *value) {
  hid_t attribute = H5Aopen(root, name, H5P_DEFAULT);
  if (attribute < 0)
    return -1;
  hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  H5T_class_t class = H5Tget_class(type);
  herr_t result = -1;
  if ((class == H5T_FLOAT || class == H5T_INTEGER) && H5Sget_simple_extent_npoints(space) == 1)
    result = H5Aread(attribute, H5T_NATIVE_DOUBLE, value);
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attribute);
  return result;
}

hetab_status hetab_h5_number(hetab_context *ctx, hetab_h5_table *table, const char *name,
                             double *value) {
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  htri_t found = H5Aexists(table->h5, name);
  herr_t result = found > 0 ? read_number(table->h5, name, value) : -1;
  hetab_h5_errors_end(&errors);
  if (result >= 0)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s': the attribute '%s' %s", table->path, name,
                    found > 0 ? "is not a number" : "is missing");
}
