/* The model on the host as the library offers it. */
#include <hetab/host_model.h>

#include <math.h>

#include "core/context.h"
#include "model/hemisphere.h"
#include "model/limits.h"
#include "model/model.h"

int hetab_wants_double(const hetab_surface *surface) {
  static const double SHARP = 1e-2; /* 2 n k: beyond, float keeps its digits */
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++) {
    const hetab_band *band = &hetab_surface_bands(surface)[b];
    if (hetab_hemisphere_kink(band) > 0.0 && 2.0 * band->n * band->k < SHARP)
      return 1;
  }
  return 0;
}

hetab_status hetab_evaluate_literal(hetab_context *ctx, const hetab_point *points, size_t count,
                                    hetab_value *values) {
  HETAB_TRY(hetab_check_points(ctx, points, count));
  for (size_t i = 0; i < count; i++)
    values[i] = hetab_literal(&points[i]);
  return HETAB_OK;
}

void hetab_specular_of_bands(const hetab_surface *surface, const hetab_band *bands,
                             size_t band_count, const double *theta_i, size_t count, double *out) {
  double tau = hetab_surface_tau_um(surface), sigma0 = hetab_surface_sigma0_um(surface);
  for (size_t i = 0; i < count; i++) {
    hetab_direction d = hetab_direction_at(theta_i[i], tau / (2.0 * sigma0));
    for (size_t w = 0; w < band_count; w++) {
      hetab_wave wave = hetab_wave_of(sigma0, tau, &bands[w]);
      out[w * count + i] = hetab_specular(&d, &wave);
    }
  }
}

hetab_status hetab_specular_reflectance(hetab_context *ctx, const hetab_surface *surface,
                                        const double *theta_i, size_t count, double *out) {
  for (size_t i = 0; i < count; i++)
    if (!(theta_i[i] >= 0.0 && theta_i[i] <= M_PI_2))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "theta_i = %g radians is not in [0, pi/2]",
                        theta_i[i]);
  hetab_specular_of_bands(surface, hetab_surface_bands(surface), hetab_surface_band_count(surface),
                          theta_i, count, out);
  return HETAB_OK;
}

double hetab_specular_share(const hetab_surface *surface) {
  enum { STEPS = 90 };
  double tau_2sigma = hetab_tau_2sigma(surface), specular = 0.0, whole = 0.0;
  for (int i = 0; i < STEPS; i++) { /* 2 int rho mu dmu, midpoints in mu^2 */
    hetab_direction d = hetab_direction_at(acos(sqrt((i + 0.5) / STEPS)), tau_2sigma);
    for (size_t b = 0; b < hetab_surface_band_count(surface); b++) {
      const hetab_band *band = &hetab_surface_bands(surface)[b];
      hetab_wave wave =
          hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), band);
      specular += hetab_specular(&d, &wave);
      whole += hetab_fresnel_at(d.mu * d.mu, band->n, band->k) + M_PI * band->diffuse_brdf;
    }
  }
  return whole > 0.0 ? specular / whole : 0.0;
}
