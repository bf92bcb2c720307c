/* Random pairs of directions with the source's values: what tables are judged by. */
#ifndef HETAB_RGL_RGL_TRIAL_H
#define HETAB_RGL_RGL_TRIAL_H

#include "rgl/rgl_build.h"

typedef struct hetab_rgl_trial {
  size_t incidences, directions, channels;
  float (*wi)[3]; /* [incidences] */
  float (*wo)[3]; /* [incidences][directions] */
  double *weight; /* [incidences][directions]: cos(theta_o) / density, 0 for none */
  double *values; /* [incidences][directions][channels] */
} hetab_rgl_trial;

/* Incidences from 0 to 80 degrees, both included, the others at random, one in each of equal
 * intervals; directions half by `sampler` and half evenly over the hemisphere. */
hetab_status hetab_rgl_trial_create(hetab_context *ctx, const hetab_rgl_source *source,
                                    const hetab_rgl *sampler, size_t incidences, size_t directions,
                                    unsigned seed, hetab_rgl_trial *trial);
void hetab_rgl_trial_clear(hetab_rgl_trial *trial);

/* The errors of a table, of the worst incidence. */
hetab_status hetab_rgl_trial_run(hetab_context *ctx, const hetab_rgl_trial *trial,
                                 const hetab_rgl *rgl, double *error_l1, double *bias);

#endif
