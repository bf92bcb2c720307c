/* Tables for renderers: open a file, evaluate it, sample it. Needs no OpenCL device, nor its
 * library: a program that uses this header alone links with libhetab.a and -lhdf5 -lm -pthread. C
 * and C++.
 *
 * Directions are unit vectors away from the surface, in a frame whose z axis is the normal:
 * theta = acos(z), phi = azimuth(wo) - azimuth(wi). Values are BRDFs in 1/sr, without a cosine, one
 * for each channel of the table, or at wavelengths of the caller's: dd + ud. The specular delta is
 * no value: hetab_lookup_sample() draws it, hetab_lookup_albedo() tells its weight.
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
 * report's five surfaces, and of slope 1 (sigma0 = tau = 2 um); measured by tests/test_lookup.c,
 * which fails above 0.25 to 75 degrees and 0.5 beyond, at slope 1 above 0.5 and 1.2; default grids
 * (90 x 90 x 181 nodes, MERL):
 *
 *   theta_i                      0     15    30    45    60    75    80    85 deg
 *   MERL, sRGB                   0.04  0.05  0.06  0.08  0.07  0.12  0.25  0.42
 *   HDF5                         0.04  0.05  0.06  0.08  0.12  0.23  0.24  0.41
 *   slope 1, MERL                0.13  0.10  0.05  0.17  0.16  0.44  0.72  0.90
 *   slope 1, HDF5                0.13  0.11  0.05  0.22  0.17  0.46  0.76  1.15
 *
 * Limits: values below 2^-46 of the largest are 0. A lobe narrower than the file's own spacing is
 * not brought back: give HDF5 tables of such surfaces closer angles.
 *
 * Speed, one core with AVX2, random directions (tests/bench/lookup_speed.c, `make bench`;
 * tests/bench/lookup.csv): 40 to 58 M evaluations/s with 3 channels in batches, 10 to 14 M with 31,
 * 13 to 19 M at 4 of the 31; 3.4 to 4.9 M samples/s with 3 channels, 2.6 to 3 M with 31. Memory: 3
 * MB with 3 channels, 14 MB with 31; while it is opened, half of an HDF5 file's size more. Opening
 * is shared by all cores: 1 s of their time for an HDF5 table of 182 MB, 0.3 for MERL, 0.05 for a
 * .bsdf of linear sRGB. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

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
/* 0: the delta is not in the values; else the width of the lobe that it is in them as (theta_h,
 * radians), as files made with --specular-cone say. */
double hetab_lookup_specular_cone(const hetab_lookup *table);
/* How many numbers of a .bsdf were a little below 0 and became 0 (see hetab_rgl_load()). */
size_t hetab_lookup_negative(const hetab_lookup *table);

/* What a call is about; NULL: every channel of the table, and all of the BSDF. */
typedef struct hetab_lookup_query {
  /* [count of the call][lambda_count], um: each path's own wavelengths, of which alone values are
   * formed, linear between the table's own and held beyond them. NULL: all channels, the only
   * choice with linear sRGB: a table without wavelengths answers 0. */
  const float *lambda_um;
  size_t lambda_count;
  int without_delta; /* nothing is drawn from it, and densities are of the rest */
} hetab_lookup_query;

/* Directions and results of a call are arrays of `count`: 1, or a batch. Rows of values hold
 * lambda_count numbers, or the table's channels. */

/* value[count][...]: the BRDF of wi[count][3], wo[count][3]; 0 if either is not above the horizon.
 * pdf[count]: the density with which hetab_lookup_sample() returns wo, 1/sr. NULL: not wanted. */
void hetab_lookup_eval(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                       const float *wi, const float *wo, float *value, float *pdf);

typedef enum hetab_lookup_lobe {
  HETAB_LOOKUP_NONE,     /* no sample: its weight is 0 */
  HETAB_LOOKUP_DIFFUSE,  /* of the table, drawn from the cosine */
  HETAB_LOOKUP_GLOSSY,   /* of the table, drawn from its lobe */
  HETAB_LOOKUP_SPECULAR, /* the delta: wo is the mirror direction, pdf a probability */
} hetab_lookup_lobe;

typedef struct hetab_lookup_drawn {
  float wo[3];
  float pdf; /* 1/sr, that of hetab_lookup_eval(): the choice of the lobe is in it */
  hetab_lookup_lobe lobe;
} hetab_lookup_drawn;

/* The whole BSDF: uc[count] in [0, 1) chooses the lobe, u[count][2] in [0, 1) the direction.
 * weight[count][...] = f cos(theta_o) / pdf, of the delta rho_s / pdf: its mean is all that is
 * reflected. The delta is drawn with its share of that, summed over the table's channels.
 * Of HDF5 and MERL tables: by half vectors, from a density tabulated over them at 48 incidences
 * when the table is opened; a tenth is drawn from the cosine, which bounds weights. Chi-square
 * tests pass at 10^6 samples on the report's five surfaces and a needle (sigma0 0.05 um, tau 60
 * um), 0 to 85 degrees; the mean weight is the albedo within 3 standard errors; the weights'
 * relative standard deviation is at most 0.36, 0.47 for the needle; at most 0.02 % of samples fail
 * (tests/test_lookup.c). */
void hetab_lookup_sample(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                         const float *wi, const float *uc, const float *u,
                         hetab_lookup_drawn *drawn, float *weight);

/* albedo[count][...]: the directional-hemispherical reflectance of what eval returns, interpolated
 * between 48 incidences: within 0.1 % on the report's five surfaces, 0.4 % on the needle as a MERL
 * table, 1 % on the needle in HDF5's default grid, which does not resolve it.
 * specular[count][...]: rho_s, the weight of the delta in the mirror direction (-x, -y, z of wi).
 * From /specular_reflectance of an HDF5 table; from NAME.specular.csv beside NAME.binary or
 * NAME.bsdf, in linear sRGB where the table is; 0 where there is no such file, or the delta is in
 * the table as a lobe. Between the file's angles ln rho_s is linear in cos^2: within 0.6 % up to 87
 * degrees for whole degrees (tests/test_lookup.c). Either may be NULL. */
void hetab_lookup_albedo(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                         const float *wi, float *albedo, float *specular);

HETAB_END
