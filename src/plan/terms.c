#include "plan/terms.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include <hetab/host_model.h>
#include <hetab/sampler.h>
#include <hetab/stand_in.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/random.h"
#include "model/model.h"
#include "plan/scene.h"

enum { SHARE_ANGLES = 18 };

/* ---- the delta ----------------------------------------------------------------------------- */

/* The delta's part of what is reflected: rho_s / F = e^-g S^2, the largest over wavelengths and
 * incidences in use; *least: the smallest of the wavelengths at normal incidence. */
static hetab_status delta_share(hetab_context *ctx, const hetab_scene *scene,
                                const hetab_surface *surface, double *largest, double *least) {
  size_t count = hetab_surface_band_count(surface);
  const hetab_band *bands = hetab_surface_bands(surface);
  double theta[SHARE_ANGLES], *rho = hetab_alloc(ctx, count * SHARE_ANGLES, sizeof *rho);
  HETAB_NEED(rho);
  for (int i = 0; i < SHARE_ANGLES; i++)
    theta[i] = fmin(scene->max_theta_i, hetab_radians(89.0)) * i / (SHARE_ANGLES - 1);
  hetab_status status = hetab_specular_reflectance(ctx, surface, theta, SHARE_ANGLES, rho);
  *largest = 0.0;
  *least = 1.0;
  for (size_t b = 0; b < count && status == HETAB_OK; b++)
    for (int i = 0; i < SHARE_ANGLES; i++) {
      double share = rho[b * SHARE_ANGLES + (size_t)i] /
                     hetab_fresnel_at(pow(cos(theta[i]), 2), bands[b].n, bands[b].k);
      *largest = fmax(*largest, share);
      if (i == 0)
        *least = fmin(*least, share);
    }
  free(rho);
  return status;
}

static hetab_delta carrier(const hetab_scene *scene, double share) {
  if (share <= scene->energy_error)
    return HETAB_DELTA_LEFT_OUT;
  if (scene->specular_cone > 0.0 &&
      (hetab_wants_rgl(scene) || scene->consumer == HETAB_CONSUMER_MERL))
    return HETAB_DELTA_FOLDED;
  return scene->consumer <= HETAB_MITSUBA_SPECTRAL ? HETAB_DELTA_MATERIAL : HETAB_DELTA_BESIDE;
}

/* ---- materials of the renderer ------------------------------------------------------------- */

/* Of the first, the middle and the last wavelength, at normal incidence, half the largest incidence
 * in use, and that; a table is judged to 80 degrees too. Where one of them is too much already, the
 * rest is not asked for. */
static hetab_status plain_errors(hetab_context *ctx, const hetab_scene *scene,
                                 const hetab_surface *surface, hetab_plan_item *item) {
  size_t count = hetab_surface_band_count(surface);
  double most = fmin(scene->max_theta_i, hetab_radians(80.0));
  item->plain_error = 0.0;
  for (int t = 0; t < HETAB_PLAIN_ANGLES && item->plain_error <= scene->table_error; t++) {
    item->plain_theta_i[t] = most * t / (HETAB_PLAIN_ANGLES - 1);
    for (size_t b = 0; b < 3; b++) {
      hetab_stand_in at;
      HETAB_TRY(hetab_stand_in_compare(ctx, surface, HETAB_BECKMANN,
                                       hetab_surface_bands(surface)[b * (count - 1) / 2].lambda_um,
                                       &item->plain_theta_i[t], 1, &at));
      item->plain_errors[t] = fmax(item->plain_errors[t], at.error);
    }
    item->plain_error = fmax(item->plain_error, item->plain_errors[t]);
  }
  return HETAB_OK;
}

static bool has_diffuse(const hetab_surface *surface) {
  bool found = false;
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++)
    found |= hetab_surface_bands(surface)[b].diffuse_brdf > 0.0;
  return found;
}

hetab_status hetab_plan_terms(hetab_context *ctx, const hetab_scene *scene,
                              const hetab_surface *surface, hetab_plan_item *item) {
  double least;
  HETAB_TRY(delta_share(ctx, scene, surface, &item->delta_share, &least));
  item->delta = carrier(scene, item->delta_share);
  item->diffuse = has_diffuse(surface);
  item->energy_left_out = item->delta ? 0.0 : item->delta_share;
  if (item->diffuse || !hetab_has_materials(scene))
    return HETAB_OK;
  if (1.0 - least <= scene->energy_error) {
    item->kind = HETAB_PLAN_MIRROR;
    item->energy_left_out = 1.0 - least;
    return HETAB_OK;
  }
  if (item->delta || scene->consumer == HETAB_PBRT) /* whose rough conductor has GGX facets alone */
    return HETAB_OK;
  HETAB_TRY(plain_errors(ctx, scene, surface, item));
  if (item->plain_error <= scene->table_error)
    item->kind = HETAB_PLAN_PLAIN;
  return HETAB_OK;
}

/* ---- wavelengths --------------------------------------------------------------------------- */

/* Adds |linear between every step-th - value| and value. */
static void add_thinned(const hetab_band *bands, const double *value, size_t count, size_t step,
                        double weight, double sums[2]) {
  for (size_t b = 0; b < count; b++) {
    size_t low = b / step * step, high = low + step < count ? low + step : low;
    double part = high > low ? (bands[b].lambda_um - bands[low].lambda_um) /
                                   (bands[high].lambda_um - bands[low].lambda_um)
                             : 0.0;
    sums[0] += weight * fabs(value[low] + part * (value[high] - value[low]) - value[b]);
    sums[1] += weight * value[b];
  }
}

/* The error of every choice at one incidence, of directions that the model draws. */
static void add_incidence(const hetab_model_sampler *sampler, const hetab_surface *surface,
                          double theta_i, double *value, hetab_plan_counts *out) {
  enum { DIRECTIONS = 48 };
  size_t count = hetab_surface_band_count(surface);
  const hetab_band *bands = hetab_surface_bands(surface);
  const double wi[3] = {sin(theta_i), 0.0, cos(theta_i)};
  double sums[HETAB_PLAN_COUNTS][2] = {{0.0}};
  uint64_t state = 1;
  for (int d = 0; d <= DIRECTIONS; d++) {
    double u[3] = {hetab_random_unit(&state), hetab_random_unit(&state), hetab_random_unit(&state)};
    double wo[3], part = 1.0;
    if (d == DIRECTIONS)
      hetab_model_sampler_specular(sampler, wi, value);
    else if (hetab_model_sampler_sample(sampler, wi, u, wo, value) > 0.0)
      part = 1.0 / DIRECTIONS;
    else
      continue;
    for (size_t c = 0; c < out->choices; c++)
      add_thinned(bands, value, count, count > 1 ? (count - 1) / (out->count[c] - 1) : 1, part,
                  sums[c]);
  }
  for (size_t c = 0; c < out->choices; c++)
    out->error[c] = fmax(out->error[c], sums[c][1] > 0.0 ? sums[c][0] / sums[c][1] : 0.0);
}

hetab_status hetab_plan_count_errors(hetab_context *ctx, const hetab_scene *scene,
                                     const hetab_surface *surface, hetab_plan_counts *out) {
  size_t count = hetab_surface_band_count(surface);
  hetab_model_sampler *sampler;
  *out = (hetab_plan_counts){0};
  for (size_t step = count - 1; step > 0; step--)
    if ((count - 1) % step == 0 && (out->choices + 1 < HETAB_PLAN_COUNTS || step == 1))
      out->count[out->choices++] = (count - 1) / step + 1;
  if (count == 1)
    out->count[out->choices++] = 1;
  HETAB_FREED double *value = hetab_alloc(ctx, count, sizeof *value);
  HETAB_NEED(value);
  HETAB_TRY(hetab_model_sampler_create(ctx, surface, count / 2, &sampler));
  for (int t = 0; t < 3; t++)
    add_incidence(sampler, surface, fmin(scene->max_theta_i, hetab_radians(80.0)) * t / 2, value,
                  out);
  hetab_model_sampler_free(sampler);
  return HETAB_OK;
}

hetab_status hetab_plan_thinned(hetab_context *ctx, const hetab_surface *surface, size_t count,
                                hetab_surface **out) {
  size_t all = hetab_surface_band_count(surface);
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, count, sizeof *lambda_um);
  hetab_status status = lambda_um ? hetab_surface_copy(ctx, surface, out) : HETAB_ERR_MEMORY;
  for (size_t i = 0; status == HETAB_OK && i < count; i++)
    lambda_um[i] =
        hetab_surface_bands(surface)[count > 1 ? i * (all - 1) / (count - 1) : 0].lambda_um;
  if (status == HETAB_OK && count < all) {
    status = hetab_surface_set_wavelengths(ctx, *out, lambda_um, count);
    if (status != HETAB_OK)
      hetab_surface_free(*out);
  }
  return status;
}
