/* HDF5 tables (.h5): written slab by slab, whole or not at all; and read back.
 *
 *   /brdf                  float32 or float64 [wavelength][theta_i][theta_r][phi], 1/sr, dd + ud,
 *                          no cosine, the specular delta not in it; one run of
 *                          bytes, or chunks where it is compressed
 *   /specular_reflectance  float64 [wavelength][theta_i]: rho_s, the weight of the delta
 *   /uniform_diffuse       float64 [wavelength], 1/sr
 *   /n, /k                 float64 [wavelength]
 *   /wavelength (nm), /theta_i, /theta_r, /phi (deg)   float64 dimension scales, attribute `units`
 *   attributes of /: name, sigma0_um, tau_um, index_source, hetab_version, method, precision,
 *                    device, tolerance, error_max_sampled, error_share_above, error_p99_rel,
 *                    error_rms_rel, error_max_abs_below_floor, error_samples, error_compared
 *                    (hetab_error_stats; until version 1.0 the first was called error_max_rel);
 *                    specular_cone_deg of converted tables, where the delta is in /brdf as a lobe
 */
#pragma once

#include <stddef.h>
#include <hetab/grid.h>
#include <hetab/surface.h>
#include <hetab/output_file.h>
#include <hetab/types.h>

HETAB_BEGIN

typedef struct hetab_h5_options {
  size_t size;             /* of the struct; 0: of this header's */
  hetab_precision element; /* of /brdf in the file */
  hetab_precision slabs;   /* of the slabs that will be written: the engine's precision */
  int compression;         /* 0 none, 1-9 shuffle + deflate level */
  int overwrite;           /* 0: an existing file is HETAB_ERR_EXISTS */
} hetab_h5_options;

/* A dense table in the making, HDF5 or OpenEXR (<hetab/exr.h>): create, write every slab once and
 * the specular reflectance, commit. Threads: one at a time. */
typedef struct hetab_table_writer hetab_table_writer;

/* Nothing appears under path before hetab_table_commit: a kill at any moment leaves the old file,
 * or none, and no litter (where the file system has O_TMPFILE). */
hetab_status hetab_h5_create(hetab_context *ctx, const char *path, const hetab_surface *surface,
                             const hetab_grid *grid, const hetab_h5_options *options,
                             hetab_table_writer **out);
/* A hetab_slab_fn; user is the writer. Each slab once; HETAB_ERR_ARGUMENT for one that is outside
 * the table or repeated. */
hetab_status hetab_table_write_slab(hetab_context *ctx, void *writer, const hetab_slab *slab);
/* rho_s[wavelength][theta_i], as hetab_specular_reflectance() gives it over the grid's theta_i. */
hetab_status hetab_table_write_specular(hetab_context *ctx, hetab_table_writer *writer,
                                        const double *rho_s);
/* Stores how the table was made, and its error, as attributes. HDF5: method, precision, tolerance,
 * device and hetab_h5_error(); OpenEXR: the error. */
hetab_status hetab_table_write_report(hetab_context *ctx, hetab_table_writer *writer,
                                      const hetab_report *report);
/* Numbers so far that were too large for the file, stored as its largest (OpenEXR, HALF). */
size_t hetab_table_saturated_count(const hetab_table_writer *writer);
/* fsync and publish under the path; frees the writer, whatever the outcome. HETAB_ERR_ARGUMENT if
 * a slab or the specular reflectance has not been written: tables have no holes. */
hetab_status hetab_table_commit(hetab_context *ctx, hetab_table_writer *writer);
/* Drop everything written; NULL is fine. */
void hetab_table_abort(hetab_table_writer *writer);

/* The error of the file's numbers, at most, where `error` is that of the slabs: doubles rounded to
 * float are off by up to 6e-8 more. */
hetab_error_stats hetab_h5_error(const hetab_h5_options *options, const hetab_error_stats *error);

/* A table open for reading. Nothing but metadata is held in memory. Threads: one at a time. */
typedef struct hetab_h5_table hetab_h5_table;

/* HETAB_ERR_PARSE, naming the file and what is missing, if it is not such a table. */
hetab_status hetab_h5_open(hetab_context *ctx, const char *path, hetab_h5_table **out);
/* The same, and tables converted from linear sRGB (<hetab/convert.h>), which hetab_h5_open()
 * refuses: three channels in place of wavelengths, hetab_h5_wavelengths_um() being NULL. */
hetab_status hetab_h5_open_any(hetab_context *ctx, const char *path, hetab_h5_table **out);
void hetab_h5_free(hetab_h5_table *table);
size_t hetab_h5_wavelength_count(const hetab_h5_table *table);
const double *hetab_h5_wavelengths_um(const hetab_h5_table *table);
const hetab_grid *hetab_h5_grid(const hetab_h5_table *table);
/* values[theta_i][theta_r][phi] of one wavelength, converted to double. */
hetab_status hetab_h5_read(hetab_context *ctx, hetab_h5_table *table, size_t wavelength,
                           double *values);
/* rho_s[wavelength][theta_i]. */
hetab_status hetab_h5_read_specular(hetab_context *ctx, hetab_h5_table *table, double *values);
/* bands[wavelength]: wavelength, n, k and the uniform-diffuse BRDF as the file has them. */
hetab_status hetab_h5_bands(hetab_context *ctx, hetab_h5_table *table, hetab_band *bands);
/* The root attributes: a number (HETAB_ERR_PARSE if absent or not a number). */
hetab_status hetab_h5_number(hetab_context *ctx, hetab_h5_table *table, const char *name,
                             double *value);

const char *hetab_format_name(hetab_format format); /* "HDF5", "MERL", "RGL", "OpenEXR" */
const char *hetab_format_word(hetab_format format); /* "hdf5", "merl", "rgl", "exr": in JSON */
/* The format that an output's name asks for by its ending, .h5, .hdf5, .exr, .binary or .bsdf. 0 if
 * it has none of these. */
int hetab_format_by_ending(const char *path, hetab_format *format);
/* NAME.binary -> NAME.specular.csv: where the specular reflectance of MERL and RGL tables is;
 * free() it. NULL without memory. */
char *hetab_specular_path(hetab_context *ctx, const char *path);

HETAB_END
