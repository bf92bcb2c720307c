/* Exact importance sampling of the model, without a table.
 *
 * f_dd is a positive mixture, over the terms m >= 1 of the series, of Gaussians in the plane of
 * lateral direction cosines about the mirror point, of variance m lambda^2 / (2 pi^2 tau^2) per
 * axis, times factors that vary slowly. A sampler draws m, then the Gaussian, in closed form:
 *
 *   p(q) = (pi tau^2 / lambda^2) g / (1 - e^-g) h(g, x)    per unit of the plane; times mu_r per sr
 *
 * with g held at one value. In the model g depends on theta_r, the more so the rougher the surface
 * and the closer to grazing: a sampler holds a ladder of such lobes, lobes of visible slopes (what
 * the model tends to for large g) and the cosine, and mixes them by theta_i with the weights of
 * least variance, found when it is made. The densities it reports are those of that mixture: every
 * estimate is free of bias whatever the weights are.
 *
 * Directions are unit vectors away from the surface, the normal being z. f = dd + ud, 1/sr; the
 * specular delta is apart: hetab_model_sampler_specular(). Nothing here needs OpenCL.
 *
 * Samples that leave the hemisphere are lost (density 0, weight 0): the density integrates to the
 * probability that a sample is kept, not to 1.
 *
 * Error: densities are exact to 1e-7, relative, above e^-90 times the lobe's peak and 0 below
 * e^-100; values are the model's in double. Chi-square tests, mean weights against the reference
 * rho_dd, and what is kept: tests/test_sampler.c, which prints the efficiency of each surface and
 * incidence.
 *
 * Thread safety: once made, a sampler is read-only; functions that take a const hetab_model_sampler
 * * allocate nothing, cannot fail and may be called from any number of threads at once. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>

HETAB_BEGIN

/* Threads: shared, as said above. */
typedef struct hetab_model_sampler hetab_model_sampler;

/* Samples band number `hero` of the surface, with weights for all its bands, each at the cost of
 * one evaluation of the series (0.7 us, `make bench`). On smooth surfaces the lobe of a longer
 * wavelength is the wider one: over 400 to 700 nm choose a hero in the middle or above (550 nm: an
 * effective share of at least half of the samples for every band), or combine samplers of several
 * heroes by their densities. HETAB_ERR_ARGUMENT: no such band, or outside the model's limits. */
hetab_status hetab_model_sampler_create(hetab_context *ctx, const hetab_surface *surface,
                                        size_t hero, hetab_model_sampler **out);
void hetab_model_sampler_free(hetab_model_sampler *sampler); /* NULL is fine */
size_t hetab_model_sampler_band_count(const hetab_model_sampler *sampler);

/* A direction wo for wi from u[3] in [0, 1). Returns its density, 1/sr; 0: no sample. weight is
 * NULL, or weight[band_count] = f cos(theta_o) / density. */
double hetab_model_sampler_sample(const hetab_model_sampler *sampler, const double wi[3],
                                  const double u[3], double wo[3], double *weight);
/* The density with which hetab_model_sampler_sample() returns wo, 1/sr. */
double hetab_model_sampler_pdf(const hetab_model_sampler *sampler, const double wi[3],
                               const double wo[3]);
/* value[band_count]: f of the model, 1/sr, no cosine; 0 unless both are above the horizon. */
void hetab_model_sampler_eval(const hetab_model_sampler *sampler, const double wi[3],
                              const double wo[3], double *value);
/* value[band_count]: rho_s, the weight of the delta in the mirror direction. */
void hetab_model_sampler_specular(const hetab_model_sampler *sampler, const double wi[3],
                                  double *value);

HETAB_END
