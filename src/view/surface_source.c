#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/evaluate.h>

#include "core/context.h"
#include "model/colour.h"
#include "view/view_source.h"

enum { BATCH = 1 << 16 }; /* points */

static const double half_pi = 1.57079632679489661923;

void hetab_view_colour(const hetab_view_source *source, const double *channels, float rgb[3]) {
  for (int c = 0; c < 3; c++) {
    double sum = source->weights ? 0 : channels[c];
    for (size_t i = 0; source->weights && i < source->channels; i++)
      sum += source->weights[i][c] * channels[i];
    rgb[c] = (float)sum;
  }
}

/* Without the digits that an arc cosine loses near the normal. */
static double polar_angle(const float w[3]) {
  return fmin(atan2(hypot((double)w[0], (double)w[1]), (double)w[2]), half_pi);
}

static hetab_point point_of(const hetab_view_source *s, const hetab_band *band, const float wi[3],
                            const float wo[3]) {
  double phi = atan2((double)wo[1], (double)wo[0]) - atan2((double)wi[1], (double)wi[0]);
  return (hetab_point){.lambda_um = band->lambda_um,
                       .theta_i = polar_angle(wi),
                       .theta_r = polar_angle(wo),
                       .phi = phi,
                       .sigma0_um = s->sigma0_um,
                       .tau_um = s->tau_um,
                       .n = band->n,
                       .k = band->k,
                       .diffuse_brdf = band->diffuse_brdf};
}

/* points and values: [count * channels]; channels: [s->channels] */
static hetab_status eval_batch(hetab_context *ctx, const hetab_view_source *s, size_t count,
                               const float (*wi)[3], const float (*wo)[3], float (*rgb)[3],
                               hetab_point *points, hetab_value *values, double *channels) {
  for (size_t i = 0; i < count; i++)
    for (size_t b = 0; b < s->channels; b++)
      points[i * s->channels + b] = point_of(s, &s->bands[b], wi[i], wo[i]);
  HETAB_TRY(hetab_evaluate(ctx, s->engine, points, count * s->channels, values));
  for (size_t i = 0; i < count; i++) {
    for (size_t b = 0; b < s->channels; b++)
      channels[b] = values[i * s->channels + b].total;
    hetab_view_colour(s, channels, rgb[i]);
  }
  return HETAB_OK;
}

static hetab_status eval_surface(hetab_context *ctx, const hetab_view_source *s, size_t count,
                                 const float (*wi)[3], const float (*wo)[3], float (*rgb)[3]) {
  size_t batch = BATCH / s->channels + 1, size = batch * s->channels;
  hetab_status status = HETAB_ERR_MEMORY;
  HETAB_FREED hetab_point *points = hetab_alloc(ctx, size, sizeof *points);
  HETAB_FREED hetab_value *values = hetab_alloc(ctx, size, sizeof *values);
  HETAB_FREED double *channels = hetab_alloc(ctx, s->channels, sizeof *channels);
  if (points && values && channels)
    status = HETAB_OK;
  for (size_t i = 0; i < count && status == HETAB_OK; i += batch)
    status = eval_batch(ctx, s, count - i < batch ? count - i : batch, wi + i, wo + i, rgb + i,
                        points, values, channels);
  return status;
}

static hetab_status specular_surface(hetab_context *ctx, const hetab_view_source *s, double theta,
                                     float rgb[3]) {
  HETAB_FREED hetab_point *points = hetab_alloc(ctx, s->channels, sizeof *points);
  HETAB_FREED hetab_value *values = hetab_alloc(ctx, s->channels, sizeof *values);
  HETAB_FREED double *channels = hetab_alloc(ctx, s->channels, sizeof *channels);
  const float up[3] = {0, 0, 1};
  HETAB_NEED(points && values && channels);
  for (size_t b = 0; b < s->channels; b++) {
    points[b] = point_of(s, &s->bands[b], up, up);
    points[b].theta_i = points[b].theta_r = theta;
  }
  HETAB_TRY(hetab_evaluate(ctx, s->engine, points, s->channels, values));
  for (size_t b = 0; b < s->channels; b++)
    channels[b] = values[b].specular;
  hetab_view_colour(s, channels, rgb);
  return HETAB_OK;
}

/* One band, or all. */
static hetab_status take_bands(hetab_context *ctx, const hetab_surface *surface,
                               double wavelength_um, hetab_view_source *s) {
  s->channels = wavelength_um > 0 ? 1 : hetab_surface_band_count(surface);
  s->bands = hetab_alloc(ctx, s->channels, sizeof *s->bands);
  s->weights = hetab_alloc(ctx, s->channels, sizeof *s->weights);
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, s->channels, sizeof *lambda_um);
  hetab_status status = s->bands && s->weights && lambda_um ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK && wavelength_um > 0) {
    s->weights[0][0] = s->weights[0][1] = s->weights[0][2] = 1;
    status = hetab_surface_at(ctx, surface, wavelength_um, s->bands);
  } else if (status == HETAB_OK) {
    memcpy(s->bands, hetab_surface_bands(surface), s->channels * sizeof *s->bands);
    for (size_t b = 0; b < s->channels; b++)
      lambda_um[b] = s->bands[b].lambda_um;
    status = hetab_srgb_weights(ctx, lambda_um, s->channels, s->weights);
  }
  return status;
}

hetab_status hetab_view_source_surface(hetab_context *ctx, hetab_engine *engine,
                                       const hetab_surface *surface, double wavelength_um,
                                       hetab_view_source *s) {
  *s = (hetab_view_source){.eval = eval_surface, .specular = specular_surface, .engine = engine};
  s->sigma0_um = hetab_surface_sigma0_um(surface);
  s->tau_um = hetab_surface_tau_um(surface);
  snprintf(s->title, sizeof s->title, "%s", hetab_surface_name(surface));
  hetab_status status = take_bands(ctx, surface, wavelength_um, s);
  if (status != HETAB_OK) {
    hetab_view_source_clear(s);
    return status;
  }
  if (wavelength_um > 0)
    snprintf(s->subtitle, sizeof s->subtitle,
             "σ₀ %.4g µm,  τ %.4g µm,  n + ik = %.4g + %.4gi at %.5g nm", s->sigma0_um, s->tau_um,
             s->bands[0].n, s->bands[0].k, 1e3 * wavelength_um);
  else
    snprintf(s->subtitle, sizeof s->subtitle, "σ₀ %.4g µm,  τ %.4g µm,  %.4g to %.4g nm under D65",
             s->sigma0_um, s->tau_um, 1e3 * s->bands[0].lambda_um,
             1e3 * s->bands[s->channels - 1].lambda_um);
  return HETAB_OK;
}

void hetab_view_source_clear(hetab_view_source *s) {
  free(s->bands);
  free(s->weights);
  s->bands = NULL;
  s->weights = NULL;
}
