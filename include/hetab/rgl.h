/* RGL tables (.bsdf): the tensor files that Mitsuba 3's `measured` plugin, pbrt-v4's measured
 * material and powitacq load (Dupuy & Jakob, An Adaptive Parameterization for Efficient Material
 * Acquisition and Rendering, 2018).
 *
 * File: a little-endian container of named arrays (src/rgl/tensor.h), of which a table has
 *   description u8[n]; jacobian u8[1]; phi_i f32[1] = 0: isotropic;
 *   theta_i f32[T], radians, ascending, 0 first and pi/2 last;
 *   ndf, sigma f32[2, N], two identical rows; vndf f32[1, T, 32, W]; luminance f32[1, T, R, R];
 *   rgb f32[1, T, 3, R, R], linear; or wavelengths f32[L] in nm and spectra f32[1, T, L, R, R].
 * Last axis theta, the one before it phi: theta = pi/2 u^2, phi = (2 u - 1) pi, nodes at i / (N -
 * 1), bilinear between them.
 *
 * Value: with m the half vector, u_m its place with the azimuth relative to the light's, and s the
 * uniform point that the map of the vndf's density takes to u_m,
 *   f cos(theta_o) = spectra(s) ndf(u_m) / (4 sigma(u_wi)).
 *
 * The specular delta is not in the tables, as the format has no place for one, unless it was folded
 * in as a lobe: then a field of ours, specular_cone_deg f32[1], says so to our readers. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_rgl_bands {
  HETAB_RGL_RGB,     /* linear sRGB under D65 of the surface's wavelengths */
  HETAB_RGL_SPECTRAL /* the surface's wavelengths */
} hetab_rgl_bands;

/* Threads: once made, it does not change and may be shared. */
typedef struct hetab_rgl hetab_rgl;

typedef struct hetab_rgl_options {
  size_t size; /* of the struct; 0: of this header's */
  hetab_rgl_bands bands;
  double table_error; /* relative L1 per incidence that the shape is chosen for; 0: 0.01 */
  /* > 0: the specular delta becomes a lobe of half vectors within that angle of the normal
   * (radians), whose reflectance is rho_s at every incidence to 85 degrees: the whole within
   * 0.4 % for 2 degrees (tests/test_rgl.c). */
  double specular_cone;
  /* Of a plan (hetab/plan.h): its shape, or one of a few larger ones, in place of a search. */
  const struct hetab_rgl_forecast *forecast;
} hetab_rgl_options;

/* What the reader of the table gets, against the model, at random directions: the sums over
 * channels and directions of |f - f_ref| cos(theta_o) and of (f - f_ref) cos(theta_o), over that of
 * f_ref cos(theta_o), at the worst of 32 incidences from 0 to 80 degrees, 1000 directions each. */
typedef struct hetab_rgl_report {
  double error_l1, bias;
  /* As error_l1, the worst of 8 incidences from 81 to 89 degrees, but over all that is reflected
   * there, the delta included. */
  double error_grazing;
  double target;                                           /* what was asked for of error_l1 */
  size_t theta_i_count, ndf_count, vndf_count, resolution; /* T, N, W and R */
  size_t bytes;                                            /* of the file */
  size_t clamped; /* negative values of linear sRGB set to 0 */
} hetab_rgl_report;

/* A table of the surface, dd + ud: the smallest of some 40 candidates, from 4 incidences of 8 x 8
 * nodes to 96 of 128 x 128, whose error, read back by the functions below, is at most table_error
 * with a |bias| of at most a third of it at every incidence to 80 degrees, and 10 % beyond; with a
 * tenth to spare, so that other random directions find the same. A surface's candidates are the
 * same for every table_error: a larger one never gives a larger file. HETAB_OK also where no
 * candidate serves: the largest is made, and report->error_l1 above target tells. Linear sRGB needs
 * wavelengths from 400 to 700 nm in steps of at most 10 nm (HETAB_ERR_RANGE).
 *
 * Made on the host, on all cores; needs no device. Values are within 1e-4, relative L1, of the
 * series in double, compared for every surface (2e-5 for the presets). 0.2 to 0.3 s of one core's
 * time at 1 % (`make bench`).
 * Error: the presets at the default, against the literal equations at other directions: L1 <= 1 %,
 * bias <= 0.33 %, 0.3 to 0.7 MB (tests/test_rgl.c). A needle (sigma0 0.05, tau 60 um) and a
 * sub-wavelength surface (0.02, 0.2) reach 1 % too. options and report may be NULL. */
hetab_status hetab_tabulate_rgl(hetab_context *ctx, const hetab_surface *surface,
                                const hetab_rgl_options *options, hetab_rgl **out,
                                hetab_rgl_report *report);
/* Whole or not at all. HETAB_ERR_EXISTS if path exists and overwrite == 0. */
hetab_status hetab_rgl_save(hetab_context *ctx, const hetab_rgl *rgl, const char *path,
                            int overwrite);
/* Isotropic tables, ours or others', with either jacobian, any number of incidences, linear sRGB or
 * spectra of up to 4096 wavelengths. HETAB_ERR_PARSE naming file, field and what is wrong;
 * HETAB_ERR_UNSUPPORTED for anisotropic ones. A luminance slice of zeros samples evenly. Spectra
 * below 0 by less than 1e-3 of the largest, as fits of measurements have them, become 0 and are
 * counted; further below 0, or so large that values overflow: HETAB_ERR_PARSE. */
hetab_status hetab_rgl_load(hetab_context *ctx, const char *path, hetab_rgl **out);
void hetab_rgl_free(hetab_rgl *rgl); /* NULL is fine */

/* 0: the specular delta is not in the table; else the lobe's width, radians. */
double hetab_rgl_specular_cone(const hetab_rgl *rgl);

/* 3 for linear sRGB, else one for each wavelength. */
size_t hetab_rgl_channel_count(const hetab_rgl *rgl);
const double *hetab_rgl_wavelengths_um(const hetab_rgl *rgl); /* NULL: linear sRGB */
/* How many numbers of the file were below 0 and became 0. */
size_t hetab_rgl_negative(const hetab_rgl *rgl);

/* As the readers do it, in float: f cos(theta_o) and pdf are those of Mitsuba 3.9.1 to 2e-6, the
 * samples to 4e-5 and their densities to 2e-4 (tests/test_rgl.c). Unit vectors as in
 * <hetab/lookup.h>; no allocation.
 * value[channels]: the BRDF in 1/sr, WITHOUT the cosine that the files carry; 0 if a direction is
 * not above the horizon. */
void hetab_rgl_eval(const hetab_rgl *rgl, const float wi[3], const float wo[3], float *value);
/* A direction from u[2] in [0, 1): returns its density, 1/sr; 0: none. */
float hetab_rgl_sample(const hetab_rgl *rgl, const float wi[3], const float u[2], float wo[3]);
float hetab_rgl_pdf(const hetab_rgl *rgl, const float wi[3], const float wo[3]);

HETAB_END
