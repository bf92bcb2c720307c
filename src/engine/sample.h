/* Measured error: a random sample of what was computed, compared with the literal reference. */
#pragma once

#include <stdint.h>

#include <hetab/tabulate.h>

#include "core/context.h"

/* Relative errors are taken where the reference is at least this, 1/sr; absolute ones below. */
#define HETAB_FLOOR_PER_SR 1e-9

typedef struct hetab_sample {
  size_t count;
  uint64_t *positions; /* ascending flat positions in the table */
  double *relative;    /* of the compared ones so far */
  hetab_error_stats stats;
} hetab_sample;

/* count distinct-enough random positions below total, by a fixed generator. */
hetab_status hetab_sample_create(hetab_context *ctx, size_t count, uint64_t total, unsigned seed,
                                 hetab_sample *sample);
void hetab_sample_clear(hetab_sample *sample);
/* The number of the first position that is not below `position`. */
size_t hetab_sample_from(const hetab_sample *sample, uint64_t position);
/* Take one comparison. */
void hetab_sample_add(hetab_sample *sample, double value, double reference);
/* Fills in p99 and RMS. */
hetab_error_stats hetab_sample_finish(hetab_sample *sample);
