/* The specular delta of a surface as the file beside a MERL or RGL table. */
#pragma once

#include <hetab/surface.h>

/* Of the table's channels, which are single wavelengths, band_um[channels]; 0: of the surface's
 * own. */
hetab_status hetab_surface_specular_save(hetab_context *ctx, const hetab_surface *surface,
                                         const double *band_um, size_t channels, const char *path,
                                         int overwrite);
