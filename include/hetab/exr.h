/* OpenEXR tables (.exr): a dense table as a scan-line image of one or many parts, ZIP-compressed,
 * that a shader samples as a texture and a person looks at. Written whole or not at all.
 *
 *   parts by theta_i (default): one part for each theta_i, "theta_i_30_00deg"; row = index of
 *     theta_r, column = index of phi. Channels: R G B (linear sRGB under D65: the surface's
 *     spectrum, weighted; negative where the colour is outside the gamut), or one for each
 *     wavelength.
 *   parts by wavelength: one part for each wavelength, "wavelength_550_00nm"; row = index of
 *     theta_i * theta_r's count + index of theta_r, column = index of phi; one channel.
 *   last part of both, "specular_reflectance": one row, column = index of theta_i, the same
 *     channels (all wavelengths' where the parts are by wavelength): rho_s, the delta's weight.
 *   atlas: one part, for textures and readers that see the first alone (OpenCV); channels R G B:
 *     the parts by theta_i as tiles side by side, that of index i in column i mod tiles_across
 *     (double) and row i / tiles_across of tiles, from the top left; nearly a square, what is left
 *     over 0. rho_s by theta_i: specular_reflectance_R, _G, _B (floatvector).
 *     scripts/exr_atlas.glsl reads it.
 *
 * Spectral channels are named "T.550,000000nm", and the parts carry spectralLayoutVersion "1.0", as
 * in Fichet, Pacanowski & Wilkie, An OpenEXR Layout for Spectral Images, JCGT 10(3), 2021.
 * Pixels are dd + ud in 1/sr, no cosine, the specular delta not in them.
 *
 * Attributes of the first part: surface, index_source, hetab_version, method, precision, device,
 * quantity, units, specular_delta (string); sigma0_um, tau_um, tolerance, error_max_sampled,
 * error_share_above, error_p99_rel, error_rms_rel, error_max_abs_below_floor, error_samples,
 * error_compared (double; the errors are those of the spectral values, before colour and rounding,
 * NaN if none were measured); wavelength_nm, n, k, uniform_diffuse, theta_i_deg, theta_r_deg,
 * phi_deg (floatvector); chromaticities, where the channels are R G B. Of each part by theta_i
 * part_theta_i_deg, of one by wavelength part_wavelength_nm (double). Parts share one display
 * window, as the format wants.
 */
#pragma once

#include <stddef.h>
#include <hetab/grid.h>
#include <hetab/surface.h>
#include <hetab/table.h>
#include <hetab/types.h>

HETAB_BEGIN

typedef enum hetab_exr_bands { HETAB_EXR_RGB, HETAB_EXR_SPECTRAL } hetab_exr_bands;
typedef enum hetab_exr_parts {
  HETAB_EXR_BY_THETA_I,
  HETAB_EXR_BY_WAVELENGTH,
  HETAB_EXR_ATLAS
} hetab_exr_parts;

/* FLOAT: exactly the numbers of an HDF5 table in float (spectral), or their weighted sum rounded
 * once (RGB). HALF: 11 bits; below 6e-5 steps of 6e-8; above 65504 saturated, which is counted, in
 * an atlas HETAB_ERR_RANGE. */
typedef enum hetab_exr_element { HETAB_EXR_FLOAT, HETAB_EXR_HALF } hetab_exr_element;

typedef struct hetab_exr_options {
  size_t size;           /* of the struct; 0: of this header's */
  hetab_exr_bands bands; /* RGB needs wavelengths of 400-700 nm at 10 nm or finer */
  hetab_exr_parts parts; /* BY_WAVELENGTH only with SPECTRAL, ATLAS only with RGB */
  hetab_exr_element element;
  hetab_precision slabs; /* of the slabs that will be written: the engine's precision */
  hetab_method method;   /* how they are made, for the attributes */
  double tolerance;
  const char *device; /* NULL: "" */
  /* > 0: the slabs hold the delta as a lobe of half vectors within that angle of the normal
   * (radians): specular_cone_deg (double) says so. */
  double specular_cone;
  int overwrite; /* 0: an existing file is HETAB_ERR_EXISTS */
} hetab_exr_options;

/* As hetab_h5_create(). HETAB_ERR_RANGE where colour is asked of too few wavelengths, for more than
 * 4096 parts, for an atlas of more than 16384 pixels a side (textures' limit), and for tables that
 * would have to be held in more than 4 GiB of memory. What is held: parts or tiles by theta_i,
 * those whose wavelengths have not all come (with hetab_tabulate, 32 MiB or one theta_i row of each
 * wavelength; RGB takes 48 bytes a pixel); parts by wavelength and atlas, the whole as float. Slabs
 * with a NaN, or with what a float does not hold, are HETAB_ERR_ARGUMENT. */
hetab_status hetab_exr_create(hetab_context *ctx, const char *path, const hetab_surface *surface,
                              const hetab_grid *grid, const hetab_exr_options *options,
                              hetab_table_writer **out);

HETAB_END
