#include "surface/surface_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/number.h"
#include "surface/index_parts.h"
#include "surface/presets.h"
#include "core/text.h"
#include "surface/wavelengths.h"

static const double pi = 3.14159265358979323846;

/* ---- life ---- */

hetab_status hetab_surface_new(hetab_context *ctx, const char *name, hetab_surface **out) {
  hetab_surface *surface = hetab_alloc(ctx, 1, sizeof *surface);
  char *copy = hetab_alloc(ctx, strlen(name) + 1, 1);
  double *diffuse = hetab_alloc(ctx, 1, sizeof *diffuse);
  if (!surface || !copy || !diffuse) {
    free(surface);
    free(copy);
    free(diffuse);
    return HETAB_ERR_MEMORY;
  }
  strcpy(copy, name);
  *surface = (hetab_surface){.name = copy, .diffuse = diffuse, .diffuse_count = 1};
  *out = surface;
  return HETAB_OK;
}

void hetab_surface_free(hetab_surface *surface) {
  if (!surface)
    return;
  hetab_index_free(surface->index);
  free(surface->name);
  free(surface->diffuse);
  free(surface->bands);
  free(surface);
}

hetab_status hetab_surface_copy(hetab_context *ctx, const hetab_surface *surface,
                                hetab_surface **out) {
  hetab_surface *copy;
  *out = NULL;
  HETAB_TRY(hetab_surface_new(ctx, surface->name, &copy));
  double *diffuse = hetab_alloc(ctx, surface->diffuse_count, sizeof *diffuse);
  hetab_band *bands = hetab_alloc(ctx, surface->count, sizeof *bands);
  hetab_status status = diffuse && bands ? HETAB_OK : HETAB_ERR_MEMORY;
  hetab_surface owned = *surface;
  free(copy->diffuse);
  owned.name = copy->name;
  owned.diffuse = diffuse;
  owned.bands = bands;
  owned.index = NULL;
  *copy = owned;
  if (status == HETAB_OK)
    status = hetab_index_copy(ctx, surface->index, &copy->index);
  if (status != HETAB_OK) {
    hetab_surface_free(copy);
    return status;
  }
  memcpy(diffuse, surface->diffuse, surface->diffuse_count * sizeof *diffuse);
  memcpy(bands, surface->bands, surface->count * sizeof *bands);
  *out = copy;
  return HETAB_OK;
}

/* ---- wavelengths ---- */

hetab_status hetab_surface_sample(hetab_context *ctx, hetab_surface *surface,
                                  const double *lambda_um, size_t count) {
  hetab_band *bands = hetab_alloc(ctx, count, sizeof *bands);
  HETAB_NEED(bands);
  for (size_t i = 0; i < count; i++) {
    double diffuse = surface->diffuse[surface->diffuse_count == 1 ? 0 : i];
    bands[i].lambda_um = lambda_um[i];
    bands[i].diffuse_brdf = surface->diffuse_is_brdf ? diffuse : diffuse / pi;
    hetab_status status = hetab_index_at(ctx, surface->index, lambda_um[i], surface->extrapolate,
                                         &bands[i].n, &bands[i].k);
    if (status != HETAB_OK) {
      free(bands);
      return status;
    }
  }
  free(surface->bands);
  surface->bands = bands;
  surface->count = count;
  return HETAB_OK;
}

/* The diffuse part as given, at any wavelength: linear between the bands, held at the ends. */
static double diffuse_at(const hetab_surface *surface, double lambda_um) {
  const hetab_band *bands = surface->bands;
  const double *diffuse = surface->diffuse;
  size_t above = 0; /* the first band that is not below */
  if (surface->diffuse_count == 1)
    return diffuse[0];
  while (above < surface->count && bands[above].lambda_um < lambda_um)
    above++;
  if (above == 0 || above == surface->count)
    return diffuse[above ? above - 1 : 0];
  double part =
      (bands[above].lambda_um - lambda_um) / (bands[above].lambda_um - bands[above - 1].lambda_um);
  return diffuse[above] + part * (diffuse[above - 1] - diffuse[above]);
}

hetab_status hetab_surface_at(hetab_context *ctx, const hetab_surface *surface, double lambda_um,
                              hetab_band *band) {
  double diffuse = diffuse_at(surface, lambda_um);
  band->lambda_um = lambda_um;
  band->diffuse_brdf = surface->diffuse_is_brdf ? diffuse : diffuse / pi;
  return hetab_index_at(ctx, surface->index, lambda_um, surface->extrapolate, &band->n, &band->k);
}

hetab_status hetab_surface_set_wavelengths(hetab_context *ctx, hetab_surface *surface,
                                           const double *lambda_um, size_t count) {
  HETAB_TRY(hetab_wavelengths_check(ctx, lambda_um, count));
  if (surface->diffuse_count == 1)
    return hetab_surface_sample(ctx, surface, lambda_um, count);
  double *old = surface->diffuse;
  size_t old_count = surface->diffuse_count;
  double *resampled = hetab_alloc(ctx, count, sizeof *resampled);
  HETAB_NEED(resampled);
  for (size_t i = 0; i < count; i++)
    resampled[i] = diffuse_at(surface, lambda_um[i]);
  surface->diffuse = resampled;
  surface->diffuse_count = count;
  hetab_status status = hetab_surface_sample(ctx, surface, lambda_um, count);
  if (status != HETAB_OK) {
    surface->diffuse = old;
    surface->diffuse_count = old_count;
    old = resampled;
  }
  free(old);
  return status;
}

/* ---- making ---- */

static hetab_status check_length(hetab_context *ctx, const char *name, double value) {
  if (hetab_number_check(ctx, &hetab_rule_length, value) == HETAB_OK)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s: %g is out of range: give %s", name, value,
                    hetab_rule_length.wanted);
}

hetab_status hetab_surface_create(hetab_context *ctx, double sigma0_um, double tau_um, double n,
                                  double k, const double *lambda_um, size_t count,
                                  hetab_surface **out) {
  *out = NULL;
  HETAB_TRY(check_length(ctx, "sigma0_um", sigma0_um));
  HETAB_TRY(check_length(ctx, "tau_um", tau_um));
  HETAB_TRY(hetab_wavelengths_check(ctx, lambda_um, count));
  hetab_surface *surface;
  HETAB_TRY(hetab_surface_new(ctx, "surface", &surface));
  surface->sigma0_um = sigma0_um;
  surface->tau_um = tau_um;
  hetab_status status = hetab_index_constant(ctx, n, k, &surface->index);
  if (status == HETAB_OK)
    status = hetab_surface_sample(ctx, surface, lambda_um, count);
  *out = surface;
  HETAB_MADE(hetab_surface, out, status);
}

static hetab_status fail_unknown_preset(hetab_context *ctx, const char *name) {
  char all[256] = "";
  for (size_t i = 0; i < hetab_preset_count(); i++)
    hetab_append_word(all, sizeof all, hetab_preset_name(i));
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "no preset '%.40s': choose %s, or give the path of a file ending in .yml or "
                    ".yaml",
                    name, all);
}

static hetab_status fill_preset(hetab_context *ctx, const hetab_preset *preset,
                                hetab_surface *surface) {
  surface->sigma0_um = preset->sigma0_um;
  surface->tau_um = preset->tau_um;
  surface->diffuse[0] = preset->diffuse_reflectance;
  for (int i = 0; i < 2 && preset->non_uniformity > 0; i++)
    surface->sigma0_bounds_um[i] =
        round(1e6 * preset->sigma0_um * (1 + (2 * i - 1) * preset->non_uniformity)) / 1e6;
  HETAB_TRY(hetab_index_metal(ctx, preset->metal, &surface->index));
  HETAB_FREED double *lambda_um = NULL;
  size_t count;
  HETAB_TRY(hetab_parse_wavelengths(ctx, "400:700:10", &lambda_um, &count));
  return hetab_surface_sample(ctx, surface, lambda_um, count);
}

hetab_status hetab_surface_preset(hetab_context *ctx, const char *name, hetab_surface **out) {
  *out = NULL;
  const hetab_preset *preset = hetab_preset_find(name);
  if (!preset)
    return fail_unknown_preset(ctx, name);
  hetab_surface *surface;
  HETAB_TRY(hetab_surface_new(ctx, preset->name, &surface));
  *out = surface;
  HETAB_MADE(hetab_surface, out, fill_preset(ctx, preset, surface));
}

/* ---- reading it ---- */

const char *hetab_surface_name(const hetab_surface *surface) {
  return surface->name;
}

double hetab_surface_sigma0_um(const hetab_surface *surface) {
  return surface->sigma0_um;
}

double hetab_surface_tau_um(const hetab_surface *surface) {
  return surface->tau_um;
}

static bool are_bounds(const double bounds[2], double value) {
  bool none = bounds[0] == 0 && bounds[1] == 0;
  return none || (bounds[0] > 0 && bounds[0] <= value && value <= bounds[1] && isfinite(bounds[1]));
}

hetab_status hetab_surface_set_bounds(hetab_context *ctx, hetab_surface *surface,
                                      const double sigma0_um[2], const double tau_um[2]) {
  if (!are_bounds(sigma0_um, surface->sigma0_um) || !are_bounds(tau_um, surface->tau_um))
    return hetab_fail(
        ctx, HETAB_ERR_ARGUMENT,
        "bounds %g to %g of sigma0 %g um, %g to %g of tau %g um: give a low one above "
        "0 and a high one with the value between them",
        sigma0_um[0], sigma0_um[1], surface->sigma0_um, tau_um[0], tau_um[1], surface->tau_um);
  memcpy(surface->sigma0_bounds_um, sigma0_um, sizeof surface->sigma0_bounds_um);
  memcpy(surface->tau_bounds_um, tau_um, sizeof surface->tau_bounds_um);
  return HETAB_OK;
}

void hetab_surface_bounds(const hetab_surface *surface, double sigma0_um[2], double tau_um[2]) {
  memcpy(sigma0_um, surface->sigma0_bounds_um, sizeof surface->sigma0_bounds_um);
  memcpy(tau_um, surface->tau_bounds_um, sizeof surface->tau_bounds_um);
}

const hetab_index *hetab_surface_index(const hetab_surface *surface) {
  return surface->index;
}

size_t hetab_surface_band_count(const hetab_surface *surface) {
  return surface->count;
}

const hetab_band *hetab_surface_bands(const hetab_surface *surface) {
  return surface->bands;
}
