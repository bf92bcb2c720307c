/* Spectra of reflectances as colours. */
#include <hetab/reflectance.h>

#include <math.h>
#include <stdlib.h>

#include "core/context.h"
#include "model/colour.h"

typedef struct colour_weights {
  double (*xyz)[3];
  size_t band_count;
} colour_weights;

static hetab_status weights_of(hetab_context *ctx, const hetab_surface *surface,
                               colour_weights *weights) {
  size_t count = hetab_surface_band_count(surface);
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, count, sizeof *lambda_um);
  *weights = (colour_weights){hetab_alloc(ctx, count, sizeof *weights->xyz), count};
  HETAB_NEED(lambda_um && weights->xyz);
  for (size_t b = 0; b < count; b++)
    lambda_um[b] = hetab_surface_bands(surface)[b].lambda_um;
  return hetab_xyz_weights(ctx, lambda_um, count, weights->xyz);
}

/* Of the spectrum reflectances[band * stride]: of dh, or of the polished material. */
static hetab_reflectance_colour colour_of(const colour_weights *weights,
                                          const hetab_reflectance *reflectances, size_t stride,
                                          int polished) {
  double xyz[3] = {0}, error[4] = {0};
  hetab_reflectance_colour colour;
  for (size_t b = 0; b < weights->band_count; b++) {
    const hetab_reflectance *r = &reflectances[b * stride];
    const double *w = weights->xyz[b];
    double rgb[3], band_error = polished ? 0.0 : r->dd.error;
    hetab_xyz_to_srgb(w, rgb);
    for (int c = 0; c < 3; c++) {
      xyz[c] += w[c] * (polished ? r->fresnel : r->dh);
      error[c] += fabs(rgb[c]) * band_error;
    }
    error[3] += fabs(w[1]) * band_error;
  }
  hetab_xyz_to_srgb(xyz, colour.rgb);
  colour.luminance = xyz[1];
  colour.error = fmax(fmax(error[0], error[1]), fmax(error[2], error[3]));
  return colour;
}

hetab_status hetab_reflectance_rgb(hetab_context *ctx, const hetab_surface *surface,
                                   const hetab_reflectance *reflectances, size_t count,
                                   hetab_reflectance_colour *dh,
                                   hetab_reflectance_colour *fresnel) {
  colour_weights weights = {0};
  hetab_status status = weights_of(ctx, surface, &weights);
  for (size_t i = 0; status == HETAB_OK && i < count; i++) {
    if (dh)
      dh[i] = colour_of(&weights, &reflectances[i], count, 0);
    if (fresnel)
      fresnel[i] = colour_of(&weights, &reflectances[i], count, 1);
  }
  free(weights.xyz);
  return status;
}
