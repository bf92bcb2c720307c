/* A surface: roughness, refractive index, diffuse part and the wavelengths of interest.
 *
 * YAML form (unknown keys are errors; failures name the file, the line and the key):
 *
 *   name: BBQAL2
 *   sigma0_um: 0.54              # rms height, > 0; or slope: sigma0 / tau, with tau_um
 *   tau_um: 6.5                  # correlation length, > 0
 *   sigma0_bounds_um: [0.5, 0.58] # measured spread about the value, for `hetab predict`; optional
 *   tau_bounds_um: [6.1, 6.9]     # likewise
 *   slope_bounds: [0.077, 0.09]   # in place of sigma0_bounds_um: at this tau
 *   index: Al                    # built-in metal, or {file: Au.yml}, or {n: 0.958, k: 6.69}
 *   extrapolate_index: false     # true: allow wavelengths outside the index data
 *   diffuse_reflectance: 0.0     # pi * BRDF, or diffuse_brdf in 1/sr, never both:
 *                                # one number, or a list with one per wavelength; default 0
 *   wavelengths_nm: 400:700:10   # start:stop:step, or a list, ascending; default 400:700:10
 *                                # or wavelengths_um, the same in um
 *
 * A surface without a name takes the file's. A relative path in {file: ...} starts at the folder
 * of the surface's file.
 */
#pragma once

#include <stddef.h>
#include <hetab/index.h>
#include <hetab/types.h>

HETAB_BEGIN

/* Threads: shared where it is const; hetab_surface_set_*() by one thread, while no other reads. */
typedef struct hetab_surface hetab_surface;

/* A preset name, or a path: what contains a '/' or ends in .yml or .yaml is a path. */
hetab_status hetab_surface_open(hetab_context *ctx, const char *name_or_path, hetab_surface **out);
hetab_status hetab_surface_load(hetab_context *ctx, const char *path, hetab_surface **out);
hetab_status hetab_surface_preset(hetab_context *ctx, const char *name, hetab_surface **out);
/* From parameters, without a file: constant n and k, no diffuse part, the given wavelengths. */
hetab_status hetab_surface_create(hetab_context *ctx, double sigma0_um, double tau_um, double n,
                                  double k, const double *lambda_um, size_t count,
                                  hetab_surface **out);
/* One of its own, to change. */
hetab_status hetab_surface_copy(hetab_context *ctx, const hetab_surface *surface,
                                hetab_surface **out);
void hetab_surface_free(hetab_surface *surface);

/* Replace the wavelengths (um, ascending, > 0), sampling the index anew. A diffuse part given per
 * wavelength is interpolated linearly within the old wavelengths and held at the ends. */
hetab_status hetab_surface_set_wavelengths(hetab_context *ctx, hetab_surface *surface,
                                           const double *lambda_um, size_t count);

/* The surface at any wavelength, without changing it: as set_wavelengths would. */
hetab_status hetab_surface_at(hetab_context *ctx, const hetab_surface *surface, double lambda_um,
                              hetab_band *band);

const char *hetab_surface_name(const hetab_surface *surface);
/* The measured spread of the roughness, {low, high} about the surface's own value; {0, 0}: not
 * known. Tables and reflectances are of the value; predictions are of the spread. */
hetab_status hetab_surface_set_bounds(hetab_context *ctx, hetab_surface *surface,
                                      const double sigma0_um[2], const double tau_um[2]);
void hetab_surface_bounds(const hetab_surface *surface, double sigma0_um[2], double tau_um[2]);

double hetab_surface_sigma0_um(const hetab_surface *surface);
double hetab_surface_tau_um(const hetab_surface *surface);
const hetab_index *hetab_surface_index(const hetab_surface *surface);
size_t hetab_surface_band_count(const hetab_surface *surface);
const hetab_band *hetab_surface_bands(const hetab_surface *surface); /* [band_count] */

/* The surface as YAML that hetab_surface_load reads back; free() the text. */
hetab_status hetab_surface_yaml(hetab_context *ctx, const hetab_surface *surface, char **text);

/* "400:700:10" (start:stop:step, stop included) or "400,550,700", in nm, to micrometres,
 * ascending; free() *lambda_um. For --wavelengths options. */
hetab_status hetab_parse_wavelengths(hetab_context *ctx, const char *text, double **lambda_um,
                                     size_t *count);

/* The presets; i < hetab_preset_count(). */
size_t hetab_preset_count(void);
const char *hetab_preset_name(size_t i);
const char *hetab_preset_description(size_t i);

HETAB_END
