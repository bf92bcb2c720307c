/* Tables for renderers: open a file, evaluate it, sample it. Needs no OpenCL device.
 *
 * Directions are unit vectors away from the surface, in a frame whose z axis is the normal:
 * theta = acos(z), phi = azimuth(wo) - azimuth(wi). Values are BRDFs in 1/sr, without a cosine, one
 * for each channel of the table: dd + ud. The specular delta is apart: hetab_lookup_specular().
 *
 * Thread safety: once open, a table is read-only: every function that takes a const hetab_lookup *
 * may be called from any number of threads at once. None of them allocates or can fail. */
#ifndef HETAB_LOOKUP_H
#define HETAB_LOOKUP_H

#include <stddef.h>
#include <hetab/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hetab_lookup_rule {
  HETAB_LOOKUP_INTERPOLATE, /* smooth; thin lobes keep their height and place */
  HETAB_LOOKUP_NEAREST      /* the cell's or node's own number */
} hetab_lookup_rule;

typedef struct hetab_lookup hetab_lookup;

/* An HDF5 table of ours (.h5), a MERL table (.binary), or a .bsdf of ours; told apart by content.
 */
hetab_status hetab_lookup_open(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                               hetab_lookup **out);
void hetab_lookup_free(hetab_lookup *table); /* NULL is fine */

/* 3 for linear sRGB, else one for each wavelength. */
size_t hetab_lookup_channels(const hetab_lookup *table);
/* [channels], um, ascending; NULL for linear sRGB. */
const double *hetab_lookup_wavelengths_um(const hetab_lookup *table);

/* value[channels]; all 0 if either direction is not above the horizon. */
void hetab_lookup_eval(const hetab_lookup *table, const float wi[3], const float wo[3],
                       float *value);
/* value[count][channels] for wi[count], wo[count]. */
void hetab_lookup_eval_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                             const float (*wo)[3], float *value);

/* A direction wo for wi from u[2] in [0, 1): returns its density in 1/sr (0: no sample), and
 * weight[channels] = f cos(theta_o) / density. */
float hetab_lookup_sample(const hetab_lookup *table, const float wi[3], const float u[2],
                          float wo[3], float *weight);
void hetab_lookup_sample_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                               const float (*u)[2], float (*wo)[3], float *density, float *weight);
/* The density with which hetab_lookup_sample() returns wo, 1/sr. */
float hetab_lookup_pdf(const hetab_lookup *table, const float wi[3], const float wo[3]);

/* value[channels]: the directional-hemispherical reflectance of what eval returns. */
void hetab_lookup_albedo(const hetab_lookup *table, const float wi[3], float *value);
/* value[channels]: rho_s, the weight of the delta in the mirror direction; 0 where the file has
 * none. */
void hetab_lookup_specular(const hetab_lookup *table, const float wi[3], float *value);

#ifdef __cplusplus
}
#endif
#endif
