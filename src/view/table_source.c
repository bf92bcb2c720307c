#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/context.h"
#include "model/colour.h"
#include "view/view_source.h"

static hetab_status check_colour(hetab_context *ctx, const hetab_view_source *s,
                                 const float rgb[3]) {
  if (!isfinite(rgb[0]) || !isfinite(rgb[1]) || !isfinite(rgb[2]))
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' holds numbers that are not finite; 'hetab audit' says where", s->title);
  return HETAB_OK;
}

/* Channels of one pair to R, G, B. */
static hetab_status mix(hetab_context *ctx, const hetab_view_source *s, const float *channels,
                        double *doubles, float rgb[3]) {
  for (size_t c = 0; c < s->channels; c++)
    doubles[c] = (double)channels[c];
  hetab_view_colour(s, doubles, rgb);
  return check_colour(ctx, s, rgb);
}

static hetab_status eval_table(hetab_context *ctx, const hetab_view_source *s, size_t count,
                               const float (*wi)[3], const float (*wo)[3], float (*rgb)[3]) {
  hetab_status status = HETAB_ERR_MEMORY;
  HETAB_FREED float *values = hetab_alloc(ctx, s->channels, sizeof *values);
  HETAB_FREED double *doubles = hetab_alloc(ctx, s->channels, sizeof *doubles);
  if (values && doubles)
    status = HETAB_OK;
  for (size_t i = 0; i < count && status == HETAB_OK; i++) {
    hetab_lookup_eval(s->table, NULL, 1, wi[i], wo[i], values, NULL);
    status = mix(ctx, s, values, doubles, rgb[i]);
  }
  return status;
}

static hetab_status specular_table(hetab_context *ctx, const hetab_view_source *s, double theta,
                                   float rgb[3]) {
  hetab_status status = HETAB_ERR_MEMORY;
  const float wi[3] = {(float)sin(theta), 0, (float)cos(theta)};
  HETAB_FREED float *values = hetab_alloc(ctx, s->channels, sizeof *values);
  HETAB_FREED double *doubles = hetab_alloc(ctx, s->channels, sizeof *doubles);
  if (values && doubles) {
    hetab_lookup_albedo(s->table, NULL, 1, wi, NULL, values);
    status = mix(ctx, s, values, doubles, rgb);
  }
  return status;
}

/* The wavelength between two of the table's: linear. */
static hetab_status pick_wavelength(hetab_context *ctx, hetab_view_source *s,
                                    const double *lambda_um, double wavelength_um) {
  size_t last = s->channels - 1, i = 0;
  const double slack_um = 1e-9;
  if (wavelength_um < lambda_um[0] - slack_um || wavelength_um > lambda_um[last] + slack_um)
    return hetab_fail(ctx, HETAB_ERR_RANGE, "'%s' holds %g to %g nm; %g nm is not among them",
                      s->title, 1e3 * lambda_um[0], 1e3 * lambda_um[last], 1e3 * wavelength_um);
  while (i + 1 < last && lambda_um[i + 1] <= wavelength_um)
    i++;
  size_t next = i < last ? i + 1 : i;
  double span = lambda_um[next] - lambda_um[i];
  double t = span > 0 ? fmin(fmax((wavelength_um - lambda_um[i]) / span, 0), 1) : 0;
  for (int c = 0; c < 3; c++) {
    s->weights[i][c] += 1 - t;
    s->weights[next][c] += t;
  }
  return HETAB_OK;
}

static hetab_status weigh(hetab_context *ctx, hetab_view_source *s, double wavelength_um) {
  const double *lambda_um = hetab_lookup_wavelengths_um(s->table);
  if (!lambda_um && wavelength_um > 0)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "'%s' holds linear sRGB, no wavelengths; view it in colour, or view a "
                      "spectral table",
                      s->title);
  if (!lambda_um)
    return HETAB_OK;
  if (!(s->weights = hetab_alloc(ctx, s->channels, sizeof *s->weights)))
    return HETAB_ERR_MEMORY;
  if (wavelength_um > 0)
    return pick_wavelength(ctx, s, lambda_um, wavelength_um);
  return hetab_srgb_weights(ctx, lambda_um, s->channels, s->weights);
}

hetab_status hetab_view_source_table(hetab_context *ctx, const hetab_lookup *table,
                                     const char *title, double wavelength_um,
                                     hetab_view_source *s) {
  *s = (hetab_view_source){.eval = eval_table, .specular = specular_table, .table = table};
  const double *lambda_um = hetab_lookup_wavelengths_um(table);
  s->channels = hetab_lookup_channel_count(table);
  snprintf(s->title, sizeof s->title, "%s", title);
  if (wavelength_um > 0)
    snprintf(s->subtitle, sizeof s->subtitle, "table of %zu wavelengths, at %.5g nm", s->channels,
             1e3 * wavelength_um);
  else if (lambda_um)
    snprintf(s->subtitle, sizeof s->subtitle, "table of %zu wavelengths, under D65", s->channels);
  else
    snprintf(s->subtitle, sizeof s->subtitle, "table of linear sRGB");
  hetab_status status = weigh(ctx, s, wavelength_um);
  if (status != HETAB_OK)
    hetab_view_source_clear(s);
  return status;
}
