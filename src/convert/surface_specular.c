#include "convert/surface_specular.h"

#include <stdlib.h>

#include <hetab/host_model.h>

#include "core/angle.h"
#include "table/specular.h"

hetab_status hetab_surface_specular_save(hetab_context *ctx, const hetab_surface *surface,
                                         const double *band_um, size_t channels, const char *path,
                                         int overwrite) {
  double theta_i[HETAB_SPECULAR_ANGLES];
  size_t count = channels ? channels : hetab_surface_band_count(surface);
  HETAB_FREED hetab_band *bands = hetab_alloc(ctx, count, sizeof *bands);
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, count, sizeof *lambda_um);
  HETAB_FREED double *rho = hetab_alloc(ctx, count * HETAB_SPECULAR_ANGLES, sizeof *rho);
  HETAB_NEED(bands && lambda_um && rho);
  for (int i = 0; i < HETAB_SPECULAR_ANGLES; i++)
    theta_i[i] = hetab_radians(i);
  for (size_t i = 0; i < count; i++) {
    bands[i] = hetab_surface_bands(surface)[channels ? 0 : i];
    if (channels)
      HETAB_TRY(hetab_surface_at(ctx, surface, band_um[i], &bands[i]));
    lambda_um[i] = bands[i].lambda_um;
  }
  hetab_specular_of_bands(surface, bands, count, theta_i, HETAB_SPECULAR_ANGLES, rho);
  return hetab_specular_save(ctx, path, lambda_um, count, channels > 0, rho, overwrite);
}
