#include "audit/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/colour.h"
#include "surface/surface_parts.h"

HETAB_HANDLE(hetab_surface)

static hetab_status allocate(hetab_context *ctx, size_t bands, size_t channels,
                             hetab_model *model) {
  model->band_count = bands;
  model->channel_count = channels;
  model->bands = hetab_alloc(ctx, bands, sizeof *model->bands);
  model->weights = hetab_alloc(ctx, bands * channels, sizeof *model->weights);
  return model->bands && model->weights ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_model_clear(hetab_model *model) {
  free(model->bands);
  free(model->weights);
  *model = (hetab_model){0};
}

/* What a file claims may be anything. */
static hetab_status check_band(hetab_context *ctx, const hetab_band *band) {
  if (band->n > 0 && band->n < 1e3 && band->k >= 0 && band->k < 1e3 && band->diffuse_brdf >= 0 &&
      band->diffuse_brdf < 1e3)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "the file's parameters at %g nm make no sense: n %g, k %g, uniform_diffuse %g",
                    1000 * band->lambda_um, band->n, band->k, band->diffuse_brdf);
}

hetab_status hetab_model_of_bands(hetab_context *ctx, const hetab_surface *against,
                                  double sigma0_um, double tau_um, const hetab_band *bands,
                                  size_t count, hetab_model *model) {
  *model = (hetab_model){.sigma0_um = sigma0_um, .tau_um = tau_um};
  HETAB_TRY(allocate(ctx, count, count, model));
  if (against) {
    model->sigma0_um = hetab_surface_sigma0_um(against);
    model->tau_um = hetab_surface_tau_um(against);
  }
  for (size_t b = 0; b < count; b++) {
    model->weights[b * count + b] = 1;
    model->bands[b] = bands[b];
    if (!against)
      HETAB_TRY(check_band(ctx, &bands[b]));
    else
      HETAB_TRY(hetab_surface_at(ctx, against, bands[b].lambda_um, &model->bands[b]));
  }
  return HETAB_OK;
}

/* XYZ weights turned into linear sRGB ones. */
static hetab_status colour_weights(hetab_context *ctx, hetab_model *model) {
  size_t count = model->band_count;
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, count, sizeof *lambda_um);
  HETAB_FREED double(*xyz)[3] = hetab_alloc(ctx, count, sizeof *xyz);
  HETAB_NEED(lambda_um && xyz);
  for (size_t b = 0; b < count; b++)
    lambda_um[b] = model->bands[b].lambda_um;
  HETAB_TRY(hetab_xyz_weights(ctx, lambda_um, count, xyz));
  for (size_t b = 0; b < count; b++) {
    double rgb[3];
    hetab_xyz_to_srgb(xyz[b], rgb);
    for (size_t c = 0; c < 3; c++)
      model->weights[c * count + b] = rgb[c];
  }
  return HETAB_OK;
}

hetab_status hetab_model_of_colour(hetab_context *ctx, const hetab_audit_options *o,
                                   hetab_model *model) {
  const hetab_surface *surface = o->against;
  size_t count = o->colour == HETAB_MERL_SRGB   ? hetab_surface_band_count(surface)
                 : o->colour == HETAB_MERL_MONO ? 1
                                                : 3;
  *model = (hetab_model){.sigma0_um = hetab_surface_sigma0_um(surface),
                         .tau_um = hetab_surface_tau_um(surface)};
  HETAB_TRY(allocate(ctx, count, 3, model));
  for (size_t b = 0; b < count; b++) {
    if (o->colour == HETAB_MERL_SRGB)
      model->bands[b] = hetab_surface_bands(surface)[b];
    else
      HETAB_TRY(hetab_surface_at(ctx, surface, o->band_um[b], &model->bands[b]));
  }
  if (o->colour == HETAB_MERL_SRGB)
    return colour_weights(ctx, model);
  for (size_t c = 0; c < 3; c++)
    model->weights[c * count + (count == 1 ? 0 : c)] = 1;
  return HETAB_OK;
}

hetab_status hetab_model_surface(hetab_context *ctx, const hetab_model *model, size_t first,
                                 size_t count, hetab_surface **out) {
  const hetab_band *bands = model->bands + first;
  double placeholder = bands[0].lambda_um;
  HETAB_TRY(hetab_surface_create(ctx, model->sigma0_um, model->tau_um, bands[0].n, bands[0].k,
                                 &placeholder, 1, out));
  hetab_band *own = hetab_alloc(ctx, count, sizeof *own);
  if (!own) {
    hetab_surface_free(*out);
    *out = NULL;
    return HETAB_ERR_MEMORY;
  }
  memcpy(own, bands, count * sizeof *own);
  free((*out)->bands);
  (*out)->bands = own;
  (*out)->count = count;
  return HETAB_OK;
}

/* ---- energy -------------------------------------------------------------------------------- */

/* Of one channel at one incidence, from every band's reflectances; its specular part. */
static double mix(const hetab_model *model, size_t channel, const hetab_reflectance *rho,
                  size_t stride, hetab_energy *out) {
  double fresnel = 0, diffuse = 0, specular = 0;
  for (size_t b = 0; b < model->band_count; b++) {
    double weight = model->weights[channel * model->band_count + b];
    fresnel += weight * rho[b * stride].fresnel;
    diffuse += weight * (rho[b * stride].dd.value + rho[b * stride].ud);
    specular += weight * rho[b * stride].specular;
  }
  out->fresnel = fresnel;
  out->model = diffuse;
  return specular;
}

/* What an incidence stands for in the white-sky integral: half way to its neighbours. */
static double white_sky_weight(const hetab_audit *audit, size_t theta) {
  const double *theta_i = audit->theta_i;
  size_t last = audit->theta_count - 1;
  double low = theta ? (theta_i[theta - 1] + theta_i[theta]) / 2.0 : 0.0;
  double high = theta < last ? (theta_i[theta] + theta_i[theta + 1]) / 2.0 : M_PI_2;
  double a = sin(low), b = sin(high);
  return b * b - a * a;
}

static void mix_all(const hetab_model *model, const hetab_reflectance *rho, hetab_audit *audit,
                    double *specular) {
  for (size_t c = 0; c < model->channel_count; c++) {
    specular[c] = 0;
    for (size_t t = 0; t < audit->theta_count; t++)
      specular[c] += white_sky_weight(audit, t) *
                     mix(model, c, rho + t, audit->theta_count, hetab_audit_energy(audit, c, t));
  }
}

hetab_status hetab_model_energy(hetab_context *ctx, hetab_engine *engine, const hetab_model *model,
                                hetab_audit *audit, double *specular) {
  HETAB_ENDS(hetab_surface_end) hetab_surface *surface = NULL;
  HETAB_FREED hetab_reflectance *rho =
      hetab_alloc(ctx, model->band_count * audit->theta_count, sizeof *rho);
  HETAB_NEED(rho);
  HETAB_TRY(hetab_model_surface(ctx, model, 0, model->band_count, &surface));
  HETAB_TRY(hetab_reflectance_dh(ctx, engine, surface, audit->theta_i, audit->theta_count, 0, rho));
  mix_all(model, rho, audit, specular);
  return HETAB_OK;
}
