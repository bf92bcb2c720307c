/* Random pairs of directions with the source's values: what tables are judged by. */
#pragma once

#include <stdint.h>

#include "rgl/rgl_build.h"

enum { HETAB_RGL_DIRECTIONS = 1000 }; /* that an incidence is judged at */

typedef struct hetab_rgl_trial {
  size_t incidences, directions, channels;
  double *theta_i;  /* [incidences] */
  float (*wi)[3];   /* [incidences] */
  float (*wo)[3];   /* [incidences][directions] */
  double *weight;   /* [incidences][directions]: cos(theta_o) / density, 0 for none */
  double *values;   /* [incidences][directions][channels] */
  float *value;     /* [channels], for one reading */
  double *specular; /* [incidences]: what is reflected beside the table */
} hetab_rgl_trial;

/* At these incidences, radians, turned at random, so many directions each; directions half by
 * `sampler` and half widely, most towards the horizon ahead. */
hetab_status hetab_rgl_trial_at(hetab_context *ctx, const hetab_rgl_source *source,
                                const hetab_rgl *sampler, const double *theta_i, size_t count,
                                size_t directions, hetab_rgl_trial *trial);

/* At 0, at 80 degrees and at 30 random places between, one in each of equal intervals, and at 8
 * from 80 to 89 degrees. */
hetab_status hetab_rgl_trial_create(hetab_context *ctx, const hetab_rgl_source *source,
                                    const hetab_rgl *sampler, uint64_t seed,
                                    hetab_rgl_trial *trial);
void hetab_rgl_trial_clear(hetab_rgl_trial *trial);

/* Raises the report's error_l1, bias and error_grazing to those of a table at one incidence.
 * HETAB_ERR_CANCELLED where it is to stop. */
hetab_status hetab_rgl_trial_add(hetab_context *ctx, const hetab_rgl_trial *trial, size_t incidence,
                                 const hetab_rgl *rgl, hetab_rgl_report *report);

/* The errors of the worst incidence. */
hetab_status hetab_rgl_trial_run(hetab_context *ctx, const hetab_rgl_trial *trial,
                                 const hetab_rgl *rgl, hetab_rgl_report *report);
