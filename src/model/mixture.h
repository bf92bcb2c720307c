/* The lobes of a sampler, and how much of each at each incidence. */
#pragma once

#include "core/context.h"
#include "model/model.h"
#include "model/lobe.h"

enum { HETAB_MIXTURE_LOBES = 24, HETAB_MIXTURE_ANGLES = 33 };

typedef struct hetab_mixture {
  size_t count;
  hetab_lobe lobes[HETAB_MIXTURE_LOBES];
  /* each row sums to 1; rows crowd towards grazing: hetab_mixture_at() */
  double weights[HETAB_MIXTURE_ANGLES][HETAB_MIXTURE_LOBES];
} hetab_mixture;

/* The lobes for one wave, with the weights of least variance. */
hetab_status hetab_mixture_build(hetab_context *ctx, const hetab_wave *wave, double tau_2sigma,
                                 hetab_mixture *mixture);

/* weights[count] at this incidence. */
void hetab_mixture_at(const hetab_mixture *mixture, double theta_i, double *weights);
