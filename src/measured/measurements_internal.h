/* What measurements are made of, for their readers. */
#pragma once

#include <hetab/measurements.h>

#include "core/context.h"

struct hetab_measurements {
  char *name;
  size_t wavelengths, count;
  double *lambda_um;       /* [wavelengths] */
  hetab_directions *pairs; /* [count] */
  double *values;          /* [count][wavelengths] */
  hetab_measurements_skipped skipped;
};

/* 1/sr. Beyond it is no surface, and the sums of squares of a fit come to an end. */
#define HETAB_MOST_BRDF 1e12

/* Room for count pairs at these many wavelengths, all zero; HETAB_ERR_MEMORY if it does not fit. */
hetab_status hetab_measurements_new(hetab_context *ctx, const char *name, size_t wavelengths,
                                    size_t count, hetab_measurements **out);
