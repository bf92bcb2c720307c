/* What a surface is made of, for what makes, changes or writes one. */
#pragma once

#include <stdbool.h>
#include <hetab/surface.h>
#include "core/context.h"

struct hetab_surface {
  char *name;
  double sigma0_um, tau_um;
  double sigma0_bounds_um[2], tau_bounds_um[2]; /* low, high; 0, 0: not known */
  hetab_index *index;
  bool extrapolate; /* allow wavelengths outside the index data */

  /* The diffuse part in the unit that it was given in, so that it is written back unchanged. */
  bool diffuse_is_brdf; /* else pi * BRDF */
  double *diffuse;      /* [diffuse_count] one for all wavelengths, or one each */
  size_t diffuse_count;

  hetab_band *bands; /* [count] */
  size_t count;
};

/* A surface without an index and without bands; the diffuse part is 0. */
hetab_status hetab_surface_new(hetab_context *ctx, const char *name, hetab_surface **out);

/* Make the bands of these wavelengths from the index and the diffuse part, which has one value or
 * `count`. The surface is unchanged on failure. */
hetab_status hetab_surface_sample(hetab_context *ctx, hetab_surface *surface,
                                  const double *lambda_um, size_t count);
