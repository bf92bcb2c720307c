/* Two Gaussian components behind the ISO 16610-21 filter, in closed form, and their fit to what was
 * measured at several cut-offs. */
#pragma once

#include "core/context.h"

/* c(r) = sum of sigma_i^2 exp(-(r / tau_i)^2) */
typedef struct hetab_two_scales {
  double sigma_um[2], tau_um[2];
} hetab_two_scales;

/* sigma and tau (1/e) of the process after the filter. */
void hetab_two_scales_filtered(const hetab_two_scales *scales, double cutoff_um, double *sigma_um,
                               double *tau_um);

/* From `scales` as a start: the least squares of ln sigma and ln tau at all cut-offs, weighted with
 * 1 / cutoff, as the squares of their errors grow. *misfit: weighted rms of the differences. */
hetab_status hetab_two_scales_fit(hetab_context *ctx, const double *cutoff_um,
                                  const double *sigma_um, const double *tau_um, size_t count,
                                  double longest_um, hetab_two_scales *scales, double *misfit);
