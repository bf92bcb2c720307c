/* Directions drawn from a table: a density over half vectors, tabulated over the incidence.
 *
 * At each of HETAB_SAMPLER_INCIDENCES incidences the half vectors' plane is cut into cells, in
 * v = sin^2(theta_h) as the lattice's and in the azimuth against the incident direction, and the
 * density is constant in each: the cell's mean of f cos(theta_o) d(wo)/d(h), over all channels.
 * Between two incidences their densities are mixed, and a share is drawn from the cosine, which
 * bounds what a cell may have missed. */
#pragma once

#include <stddef.h>

#include <hetab/lookup.h>

#include "core/context.h"
#include "table/band_places.h"

enum { HETAB_SAMPLER_INCIDENCES = 48, HETAB_SAMPLER_RINGS = 96, HETAB_SAMPLER_SECTORS = 32 };

typedef struct hetab_incidence {
  float ring_cdf[HETAB_SAMPLER_RINGS + 1];
  float sector_cdf[HETAB_SAMPLER_RINGS][HETAB_SAMPLER_SECTORS + 1];
  float density[HETAB_SAMPLER_RINGS][HETAB_SAMPLER_SECTORS]; /* of h over v and azimuth */
} hetab_incidence;

/* value[count][channels] of wi[count][3], wo[count][3]. */
typedef void (*hetab_eval_fn)(const void *user, size_t count, const float *wi, const float *wo,
                              float *value);
/* weight[channels] of the sample of u, f cos(theta_o) over its density. */
typedef void (*hetab_weigh_fn)(const void *user, const float wi[3], const float u[2],
                               float *weight);

typedef struct hetab_half_sampler {
  size_t channels;
  hetab_incidence *incidences; /* [HETAB_SAMPLER_INCIDENCES] */
  float *albedo;               /* [HETAB_SAMPLER_INCIDENCES][channels] */
} hetab_half_sampler;

/* Of what eval returns. */
hetab_status hetab_sampler_create(hetab_context *ctx, size_t channels, hetab_eval_fn eval,
                                  const void *user, hetab_half_sampler *sampler);
/* The albedo alone, of what has a sampler of its own. */
hetab_status hetab_sampler_create_albedo(hetab_context *ctx, size_t channels, hetab_weigh_fn weigh,
                                         const void *user, hetab_half_sampler *sampler);
void hetab_sampler_clear(hetab_half_sampler *sampler);

/* Return the density of wo in 1/sr, 0 at and below the horizon. The lobe is chosen by uc. */
float hetab_sampler_draw(const hetab_half_sampler *sampler, const float wi[3], float uc,
                         const float u[2], float wo[3], hetab_lookup_lobe *lobe);
float hetab_sampler_pdf(const hetab_half_sampler *sampler, const float wi[3], const float wo[3]);

/* cos(theta_i) of an incidence; what is between two, of rows[HETAB_SAMPLER_INCIDENCES][channels].
 */
double hetab_sampler_cos_i(size_t incidence);
void hetab_sampler_between(const float *rows, size_t channels, float cos_i,
                           const hetab_band_places *places, float *value);
