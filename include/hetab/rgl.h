/* RGL tables (.bsdf): the tensor files that Mitsuba 3's `measured` plugin, pbrt-v4's measured
 * material and powitacq load (Dupuy & Jakob, An Adaptive Parameterization for Efficient Material
 * Acquisition and Rendering, 2018). */
#ifndef HETAB_RGL_H
#define HETAB_RGL_H

#include <stddef.h>
#include <hetab/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hetab_rgl_bands { HETAB_RGL_RGB, HETAB_RGL_SPECTRAL } hetab_rgl_bands;

typedef struct hetab_rgl hetab_rgl;

typedef struct hetab_rgl_options {
  hetab_rgl_bands bands;
  double table_error; /* relative L1 per incidence that the resolution is chosen for; 0: 0.01 */
} hetab_rgl_options;

/* What the reader of the table gets, against the model, at random directions. */
typedef struct hetab_rgl_report {
  double error_l1, bias; /* relative; the worst incidence up to 80 degrees */
  double target;         /* what was asked for of error_l1 */
  size_t theta_i_count, ndf_count, vndf_count, resolution;
  size_t bytes;   /* of the file */
  size_t clamped; /* negative values of linear sRGB set to 0 */
} hetab_rgl_report;

/* A table of the surface, at the smallest resolution whose error, read back by the functions below,
 * is below options->table_error. */
hetab_status hetab_rgl_tabulate(hetab_context *ctx, const hetab_surface *surface,
                                const hetab_rgl_options *options, hetab_rgl **out,
                                hetab_rgl_report *report);
/* Whole or not at all. */
hetab_status hetab_rgl_save(hetab_context *ctx, const hetab_rgl *rgl, const char *path,
                            int overwrite);
/* Isotropic tables, ours or others'. HETAB_ERR_PARSE naming file, field and what is wrong. */
hetab_status hetab_rgl_load(hetab_context *ctx, const char *path, hetab_rgl **out);
void hetab_rgl_free(hetab_rgl *rgl);

/* 3 for linear sRGB, else one for each wavelength. */
size_t hetab_rgl_channels(const hetab_rgl *rgl);
const double *hetab_rgl_wavelengths_um(const hetab_rgl *rgl); /* NULL: linear sRGB */

/* As the readers do it. Unit vectors as in <hetab/lookup.h>; thread-safe, no allocation.
 * value[channels]: the BRDF in 1/sr, WITHOUT the cosine that the files carry. */
void hetab_rgl_eval(const hetab_rgl *rgl, const float wi[3], const float wo[3], float *value);
/* A direction from u[2]: returns its density, 1/sr; 0: none. */
float hetab_rgl_sample(const hetab_rgl *rgl, const float wi[3], const float u[2], float wo[3]);
float hetab_rgl_pdf(const hetab_rgl *rgl, const float wi[3], const float wo[3]);

#ifdef __cplusplus
}
#endif
#endif
