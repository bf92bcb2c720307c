/* A table against the model at random direction pairs. */
#pragma once

#include <stdint.h>

#include "audit/audit_internal.h"
#include "audit/reference.h"

/* The table's channels from `first` on, as many as are compared together, at a direction pair;
 * radians. */
typedef void (*hetab_pair_fn)(const void *user, size_t first, double theta_i, double theta_r,
                              double phi, double *channels);

enum { HETAB_ERROR_LEVELS = 1200 };

/* The errors of some of the pairs, as they come in. */
typedef struct hetab_error_sum {
  size_t pairs, judged;
  double absolute, bias, reference, max;
  uint32_t histogram[HETAB_ERROR_LEVELS]; /* of |error| / model, by its logarithm */
} hetab_error_sum;

typedef struct hetab_pairs {
  hetab_error_sum on_lobe, off_lobe, theta_i[HETAB_ERROR_BINS];
  double map[HETAB_ERROR_MAP][HETAB_ERROR_MAP][2]; /* absolute, reference */
  uint64_t random;
  /* of the whole job: before these pairs, what they add, in all */
  double progress, progress_step, progress_total;
} hetab_pairs;

/* Draws about `count` pairs: theta_i stratified under uniform light; theta_r and phi half of the
 * time so too, half of the time about the lobe. The model is evaluated as tables are, on a grid of
 * theta_r and phi for every theta_i. Channels from `first` on; each is of a band of
 * its own, or of all of the model's. */
hetab_status hetab_pairs_add(hetab_context *ctx, hetab_engine *engine, const hetab_model *model,
                             size_t first, size_t channels, size_t count, hetab_pair_fn table,
                             const void *user, hetab_pairs *pairs);
void hetab_pairs_finish(const hetab_pairs *pairs, hetab_against *against);
