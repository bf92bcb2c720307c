#include "table/h5_layout.h"

#include <math.h>
#include <stdlib.h>
#include <hdf5_hl.h>

#include "core/angle.h"
#include "core/context.h"
#include "table/specular.h"

/* Bytes of a chunk: enough to be read at a disk's speed, few enough for one lookup's sake. */
enum { CHUNK_LEAST = 32 << 10, CHUNK_MOST = 1 << 20, COMPRESSING_CACHE = 8 << 20 };

/* --- attributes ----------------------------------------------------------------------------- */

static herr_t put_attribute(hid_t object, const char *name, hid_t file_type, hid_t memory_type,
                            const void *value) {
  hid_t space = H5Screate(H5S_SCALAR);
  hid_t attribute = H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
  herr_t result = H5Awrite(attribute, memory_type, value);
  H5Aclose(attribute);
  H5Sclose(space);
  return result;
}

herr_t hetab_h5_put_number(hid_t object, const char *name, double value) {
  return put_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

/* Of variable length, in UTF-8: what h5py gives back as str. */
herr_t hetab_h5_put_text(hid_t object, const char *name, const char *value) {
  hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  herr_t result = put_attribute(object, name, type, type, &value);
  H5Tclose(type);
  return result;
}

static herr_t put_words(hid_t object, const char *units, const char *long_name) {
  return hetab_h5_put_text(object, "units", units) < 0
             ? -1
             : hetab_h5_put_text(object, "long_name", long_name);
}

static herr_t put_head(hid_t root, const hetab_h5_head *head) {
  if ((head->name && hetab_h5_put_text(root, "name", head->name) < 0) ||
      (isfinite(head->sigma0_um) && hetab_h5_put_number(root, "sigma0_um", head->sigma0_um) < 0) ||
      (isfinite(head->tau_um) && hetab_h5_put_number(root, "tau_um", head->tau_um) < 0) ||
      (head->index_source && hetab_h5_put_text(root, "index_source", head->index_source) < 0) ||
      (head->source && hetab_h5_put_text(root, "source", head->source) < 0) ||
      (head->specular_cone > 0.0 &&
       hetab_h5_put_number(root, HETAB_H5_CONE, hetab_degrees(head->specular_cone)) < 0))
    return -1;
  return hetab_h5_put_text(root, "hetab_version", hetab_version());
}

/* --- datasets ------------------------------------------------------------------------------- */

/* No time stamps: the same table gives the same bytes. */
static hid_t creation_list(void) {
  hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(list, 0);
  return list;
}

/* A dataset of doubles, with its values unless those are NULL; negative on failure. */
static hid_t put_doubles(hid_t file, const char *name, int rank, const hsize_t *dims,
                         const double *values) {
  hid_t space = H5Screate_simple(rank, dims, NULL);
  hid_t list = creation_list();
  hid_t dataset = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, list, H5P_DEFAULT);
  H5Pclose(list);
  H5Sclose(space);
  if (dataset < 0 || !values)
    return dataset;
  if (H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0)
    return dataset;
  H5Dclose(dataset);
  return H5I_INVALID_HID;
}

static hid_t put_scale(hid_t file, const char *name, const char *units, const char *long_name,
                       hsize_t count, const double *values) {
  hid_t scale = put_doubles(file, name, 1, &count, values);
  if (scale >= 0 && put_words(scale, units, long_name) >= 0 && H5DSset_scale(scale, name) >= 0)
    return scale;
  H5Dclose(scale);
  return H5I_INVALID_HID;
}

/* Names the dataset's dimensions after their scales and attaches these. */
static herr_t attach(hid_t dataset, int rank, const hid_t *scales) {
  char label[16];
  for (int i = 0; i < rank; i++)
    if (H5DSget_scale_name(scales[i], label, sizeof label) < 0 ||
        H5DSset_label(dataset, (unsigned)i, label) < 0 ||
        H5DSattach_scale(dataset, scales[i], (unsigned)i) < 0)
      return -1;
  return 0;
}

/* As `put_doubles`, over the leading axes, with its scales and words. */
static hid_t put_quantity(hid_t file, const char *name, const char *units, const char *long_name,
                          int rank, const hsize_t *dims, const hid_t *scales,
                          const double *values) {
  hid_t dataset = put_doubles(file, name, rank, dims, values);
  if (dataset >= 0 && put_words(dataset, units, long_name) >= 0 &&
      attach(dataset, rank, scales) >= 0)
    return dataset;
  H5Dclose(dataset);
  return H5I_INVALID_HID;
}

/* The extent, from most / 2 to most, whose chunks reach least beyond the axis: HDF5 stores the
 * chunks at its end whole. The largest of several. */
static hsize_t fitting_extent(hsize_t count, hsize_t most) {
  hsize_t best = most, least = count;
  if (most >= count)
    return count;
  for (hsize_t extent = most; extent >= (most + 1) / 2; extent--) {
    hsize_t waste = (extent - count % extent) % extent;
    if (waste < least) {
      best = extent;
      least = waste;
    }
  }
  return best;
}

/* All of phi and theta_r for one theta_i, so that slabs consist of whole chunks; more theta_i where
 * that is little, part of theta_r where it is much. */
static void choose_chunk(const hsize_t dims[RANK], size_t element, hsize_t chunk[RANK]) {
  hsize_t row = dims[PHI] * element, block = row * dims[THETA_R];
  chunk[WAVELENGTH] = chunk[THETA_I] = 1;
  chunk[THETA_R] = dims[THETA_R];
  chunk[PHI] = dims[PHI];
  if (block < CHUNK_LEAST)
    chunk[THETA_I] = fitting_extent(dims[THETA_I], CHUNK_LEAST / block);
  else if (block > CHUNK_MOST)
    chunk[THETA_R] = fitting_extent(dims[THETA_R], CHUNK_MOST / row);
}

/* Uncompressed tables are one run of bytes: slabs are written at the disk's speed, and any reader
 * can map the file. Their space is allocated at once, so that a full disk is found at once. */
static hid_t brdf_creation_list(const hsize_t dims[RANK], const hetab_h5_options *options) {
  hid_t list = creation_list();
  H5Pset_fill_time(list, H5D_FILL_TIME_NEVER);
  if (options->compression) {
    hsize_t chunk[RANK];
    choose_chunk(dims, options->element == HETAB_FLOAT ? 4 : 8, chunk);
    H5Pset_chunk(list, RANK, chunk);
    H5Pset_shuffle(list);
    H5Pset_deflate(list, (unsigned)options->compression);
  } else {
    H5Pset_layout(list, H5D_CONTIGUOUS);
    H5Pset_alloc_time(list, H5D_ALLOC_TIME_EARLY);
  }
  return list;
}

static hid_t create_brdf(hid_t file, const hsize_t dims[RANK], const hetab_h5_options *options) {
  hid_t creation = brdf_creation_list(dims, options);
  hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
  H5Pset_chunk_cache(access, 521, COMPRESSING_CACHE, 1);
  hid_t type = options->element == HETAB_FLOAT ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  hid_t space = H5Screate_simple(RANK, dims, NULL);
  hid_t dataset = H5Dcreate2(file, "brdf", type, space, H5P_DEFAULT, creation, access);
  H5Sclose(space);
  H5Pclose(access);
  H5Pclose(creation);
  return dataset;
}

static hid_t put_brdf(hid_t file, const hsize_t dims[RANK], const hid_t scales[RANK],
                      const hetab_h5_options *options) {
  hid_t brdf = create_brdf(file, dims, options);
  if (brdf >= 0 &&
      put_words(brdf, "1/sr",
                "BRDF, directional-diffuse plus uniform-diffuse; no cosine factor; the specular "
                "delta is apart, in specular_reflectance, unless " HETAB_H5_CONE
                " says how wide a lobe here it is") >= 0 &&
      attach(brdf, RANK, scales) >= 0)
    return brdf;
  H5Dclose(brdf);
  return H5I_INVALID_HID;
}

/* --- the layout ----------------------------------------------------------------------------- */

/* The leading axis, wavelengths or channels, and what is known for each. */
typedef struct columns {
  double *axis, *n, *k, *diffuse;
} columns;

/* 0.55 um is 550 nm, not 550 and a rounding error: wavelengths are decimal numbers of nm. */
static double nanometres(double um) {
  double nm = um * 1e3, decimal = round(nm * 1e6) / 1e6;
  return fabs(nm - decimal) <= 1e-15 * nm ? decimal : nm;
}

static hetab_status split_columns(hetab_context *ctx, const hetab_h5_head *head, columns *columns) {
  size_t count = head->channels;
  double *memory = hetab_alloc(ctx, 4 * count, sizeof *memory);
  HETAB_NEED(memory);
  columns->axis = memory;
  columns->n = memory + count;
  columns->k = memory + 2 * count;
  columns->diffuse = memory + 3 * count;
  for (size_t i = 0; i < count; i++) {
    const hetab_band *band = head->bands ? &head->bands[i] : NULL;
    columns->axis[i] = head->lambda_um ? nanometres(head->lambda_um[i]) : (double)i;
    columns->n[i] = band ? band->n : (double)NAN;
    columns->k[i] = band ? band->k : (double)NAN;
    columns->diffuse[i] = band ? band->diffuse_brdf : (double)NAN;
  }
  return HETAB_OK;
}

static hid_t put_leading_scale(hid_t file, const hetab_h5_head *head, const columns *columns) {
  return head->lambda_um ? put_scale(file, "wavelength", "nm", "vacuum wavelength", head->channels,
                                     columns->axis)
                         : put_scale(file, "channel", "1", "linear sRGB: 0 red, 1 green, 2 blue",
                                     head->channels, columns->axis);
}

static herr_t put_scales(hid_t file, const hetab_h5_head *head, const columns *columns,
                         const hetab_grid *grid, const hsize_t dims[RANK], hid_t scales[RANK]) {
  scales[WAVELENGTH] = put_leading_scale(file, head, columns);
  scales[THETA_I] = put_scale(file, "theta_i", "degree", "angle of the light from the normal",
                              dims[THETA_I], hetab_grid_deg(grid, HETAB_THETA_I));
  scales[THETA_R] = put_scale(file, "theta_r", "degree", "angle of the viewer from the normal",
                              dims[THETA_R], hetab_grid_deg(grid, HETAB_THETA_R));
  scales[PHI] = put_scale(file, "phi", "degree",
                          "azimuth of the viewer less that of the light; 180 is the mirror side",
                          dims[PHI], hetab_grid_deg(grid, HETAB_PHI));
  return scales[WAVELENGTH] < 0 || scales[THETA_I] < 0 || scales[THETA_R] < 0 || scales[PHI] < 0
             ? -1
             : 0;
}

static herr_t put_spectra(hid_t file, const columns *columns, const hsize_t dims[RANK],
                          const hid_t scales[RANK]) {
  hid_t n = put_quantity(file, "n", "1", "refractive index n + ik, real part", 1, dims, scales,
                         columns->n);
  hid_t k = put_quantity(file, "k", "1", "refractive index n + ik, imaginary part", 1, dims, scales,
                         columns->k);
  hid_t ud =
      put_quantity(file, "uniform_diffuse", "1/sr", "uniform-diffuse BRDF, contained in brdf", 1,
                   dims, scales, columns->diffuse);
  H5Dclose(n);
  H5Dclose(k);
  H5Dclose(ud);
  return n < 0 || k < 0 || ud < 0 ? -1 : 0;
}

static herr_t put_table(hid_t file, const hetab_h5_head *head, const hetab_grid *grid,
                        const columns *columns, const hetab_h5_options *options,
                        hetab_h5_layout *out) {
  hid_t scales[RANK];
  hsize_t dims[RANK] = {head->channels, hetab_grid_count(grid, HETAB_THETA_I),
                        hetab_grid_count(grid, HETAB_THETA_R), hetab_grid_count(grid, HETAB_PHI)};
  if (put_head(file, head) < 0 || put_scales(file, head, columns, grid, dims, scales) < 0 ||
      put_spectra(file, columns, dims, scales) < 0)
    return -1;
  out->specular =
      put_quantity(file, "specular_reflectance", "1",
                   "reflectance of the specular delta, for unit irradiance", 2, dims, scales, NULL);
  out->brdf = put_brdf(file, dims, scales, options);
  for (int i = 0; i < RANK; i++)
    H5Dclose(scales[i]);
  return out->specular < 0 || out->brdf < 0 ? -1 : 0;
}

hetab_status hetab_h5_lay_out(hetab_context *ctx, hid_t file, const hetab_h5_head *head,
                              const hetab_grid *grid, const hetab_h5_options *options,
                              hetab_h5_layout *out, herr_t *result) {
  columns columns;
  HETAB_TRY(split_columns(ctx, head, &columns));
  *result = put_table(file, head, grid, &columns, options, out);
  free(columns.axis);
  return HETAB_OK;
}
