/* The table that is converted, in the channels of what it is converted to. */
#pragma once

#include <hetab/convert.h>
#include <hetab/lookup.h>

#include "core/context.h"
#include "rgl/rgl_build.h"
#include "rgl/rgl_smooth.h"

typedef struct hetab_convert_source {
  const char *path;
  hetab_format format;
  hetab_lookup *table;
  hetab_rgl *rgl; /* RGL tables: the same, read as a BRDF rather than f cos */
  hetab_rgl_smooth smooth;
  size_t channels_in, channels;
  const double *lambda_um; /* [channels]; NULL: linear sRGB */
  double (*weights)[3];    /* [channels_in], to XYZ; NULL: the channels are kept */
  size_t filled, clamped;
  double specular_cone; /* > 0: the delta is in the table, as a lobe that wide */
} hetab_convert_source;

/* srgb: the output is to have linear sRGB. */
hetab_status hetab_convert_open(hetab_context *ctx, const char *path, int srgb,
                                hetab_convert_source *source);
void hetab_convert_close(hetab_convert_source *source);

/* A hetab_rgl_values_fn; user is the source. */
hetab_status hetab_convert_values(hetab_context *ctx, void *user, const hetab_directions *pairs,
                                  size_t count, double *values);
/* rho_s in the output's channels, value[channels]. */
hetab_status hetab_convert_specular(hetab_context *ctx, const hetab_convert_source *source,
                                    double theta_i, double *value);
/* channels_in values to channels; returns how many were below 0. */
size_t hetab_convert_channels(const hetab_convert_source *source, const float *in, double *out);
