/* Tables for renderers: open a file, evaluate it, sample it. Needs no OpenCL device, nor its
 * library: a program that uses this header alone links with libhetab.a and -lhdf5 -lm -pthread. C
 * and C++.
 *
 * Directions are unit vectors away from the surface, in a frame whose z axis is the normal:
 * theta = acos(z), phi = azimuth(wo) - azimuth(wi). Values are BRDFs in 1/sr, without a cosine, one
 * for each channel of the table: dd + ud. The specular delta is apart: hetab_lookup_specular().
 *
 * Thread safety: once open, a table is read-only: every function that takes a const hetab_lookup *
 * may be called from any number of threads at once (`make tsan`). None of them allocates or can
 * fail; directions that are not directions (NaN, 0) get a number, or 0.
 *
 * Interpolation of HDF5 and MERL tables. On opening the table is put onto a lattice over half and
 * difference vectors, where a lobe stays in its place at every incidence, that ends at the horizon,
 * so that no cell has to be masked (src/lookup/lattice.h). On the way it is read by cubics of its
 * logarithm, HDF5 tables relative to the mirror direction. Look-ups are then linear in the
 * logarithm, over sin^2(theta_h): exact for a Gaussian lobe. Tables are taken as reciprocal and
 * symmetric to the plane of incidence, as the model is: where a file is not, the mean counts. MERL
 * cells are taken as samples of their centres, what `hetab tabulate` stores unless told otherwise.
 *
 * Relative L1 error against the model, %, over directions weighed with their cosine, worst of the
 * report's five surfaces; measured by tests/test_lookup.c, default grids (90 x 90 x 181 nodes,
 * MERL):
 *
 *   theta_i                      0     15    30    45    60    75    80    85 deg
 *   MERL, sRGB                   0.04  0.07  0.07  0.10  0.09  0.13  0.28  0.48
 *   HDF5                         0.05  0.07  0.07  0.10  0.13  0.24  0.27  0.48
 *
 * What else was tried, NGGAL (the narrowest lobe) at 0, 30, 60, 75, 85 degrees:
 *   the lattice, as it is        0.05  0.07  0.09  0.11  0.20  (MERL)
 *   linear in f in place of ln f 0.46  0.49  0.45  0.33  0.53
 *   ln f over sqrt(theta_h)      0.18  0.17  0.15  0.19  0.13
 *   MERL's cells, linear in f    0.44  0.51  0.45  0.45  0.72
 *   HDF5's nodes, linear in f    0.90  1.38  2.51  3.57  4.49
 *   HDF5's nodes, linear in ln f 0.48  1.48  2.95  3.67  4.63
 *
 * Limits: values below 2^-46 of the largest are 0. A lobe narrower than the file's own spacing is
 * not brought back: give HDF5 tables of such surfaces closer angles.
 *
 * Speed, one core of an AMD EPYC (Zen 5), random directions (tests/bench/lookup_speed.c, `make
 * bench`): 35 M evaluations/s with 3 channels, 15 M with 31; 5 M samples/s with 3 channels, 4 M
 * with 31. Memory: 3 MB with 3 channels, 14 MB with 31; while it is opened, an HDF5 file's size
 * more. Opening takes 0.2 to 2 s. */
#ifndef HETAB_LOOKUP_H
#define HETAB_LOOKUP_H

#include <stddef.h>
#include <hetab/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hetab_lookup_rule {
  HETAB_LOOKUP_INTERPOLATE, /* smooth; thin lobes keep their height and place */
  HETAB_LOOKUP_NEAREST      /* the cell's or node's own number, the whole file in memory */
} hetab_lookup_rule;

/* Threads: shared, as said above. */
typedef struct hetab_lookup hetab_lookup;

/* An HDF5 table of ours (.h5), a MERL table (.binary), or a .bsdf (see <hetab/rgl.h>: it is looked
 * up and sampled by its own rule, whatever `rule` says); told apart by content. HETAB_ERR_IO if it
 * cannot be read, HETAB_ERR_PARSE if it is none of these, damaged, or holds numbers that are no
 * BRDFs (NaN, negative), HETAB_ERR_RANGE if it would take more than 16 GiB. */
hetab_status hetab_lookup_open(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                               hetab_lookup **out);
void hetab_lookup_free(hetab_lookup *table); /* NULL is fine */

/* 3 for linear sRGB, else one for each wavelength. */
size_t hetab_lookup_channel_count(const hetab_lookup *table);
/* [channels], um, ascending; NULL for linear sRGB. */
const double *hetab_lookup_wavelengths_um(const hetab_lookup *table);
/* How many numbers of a .bsdf were a little below 0 and became 0 (see hetab_rgl_load()). */
size_t hetab_lookup_negative(const hetab_lookup *table);

/* value[channels]; all 0 if either direction is not above the horizon. */
void hetab_lookup_eval(const hetab_lookup *table, const float wi[3], const float wo[3],
                       float *value);
/* value[count][channels] for wi[count], wo[count]. */
void hetab_lookup_eval_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                             const float (*wo)[3], float *value);

/* A direction wo for wi from u[2] in [0, 1): returns its density in 1/sr (0: no sample), and
 * weight[channels] = f cos(theta_o) / density.
 * Of HDF5 and MERL tables: by half vectors, from a density tabulated over them at 48 incidences
 * when the table is opened; a tenth is drawn from the cosine, which bounds weights. Chi-square
 * tests pass at 10^6 samples on the report's five surfaces and a needle (sigma0 0.05 um, tau 60
 * um), 0 to 85 degrees; the mean weight is the albedo within 3 standard errors; the weights'
 * relative standard deviation is 0.13 to 0.35, 0.46 for the needle; at most 0.02 % of samples fail
 * (tests/test_lookup.c). */
float hetab_lookup_sample(const hetab_lookup *table, const float wi[3], const float u[2],
                          float wo[3], float *weight);
void hetab_lookup_sample_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                               const float (*u)[2], float (*wo)[3], float *density, float *weight);
/* The density with which hetab_lookup_sample() returns wo, 1/sr. */
float hetab_lookup_pdf(const hetab_lookup *table, const float wi[3], const float wo[3]);

/* value[channels]: the directional-hemispherical reflectance of what eval returns, interpolated
 * between 48 incidences: within 0.1 % on the report's five surfaces, 0.3 % on the needle as a MERL
 * table, 1 % on the needle in HDF5's default grid, which does not resolve it. */
void hetab_lookup_albedo(const hetab_lookup *table, const float wi[3], float *value);

/* value[channels]: rho_s, the weight of the delta in the mirror direction (-x, -y, z of wi). From
 * /specular_reflectance of an HDF5 table; from NAME.specular.csv beside NAME.binary or NAME.bsdf,
 * in linear sRGB where the table is; 0 where there is no such file. Between the file's angles ln
 * rho_s is linear in cos^2: within 0.6 % up to 87 degrees for whole degrees (tests/test_lookup.c).
 * A MERL table made with --specular-cone holds the delta as a lobe: do not add it again. */
void hetab_lookup_specular(const hetab_lookup *table, const float wi[3], float *value);

/* The same for wi[count], wo[count]: density[count], value[count][channels]. */
void hetab_lookup_pdf_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                            const float (*wo)[3], float *density);
void hetab_lookup_albedo_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                               float *value);
void hetab_lookup_specular_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                                 float *value);

#ifdef __cplusplus
}
#endif
#endif
