/* Dense tables as readers see them that interpolate linearly between nodes. */
#pragma once

#include <hetab/tabulate_to.h>

#include "rgl/rgl_build.h"

/* value[channels] of what holds `values` at the nodes; corners has room for 8 * channels. */
hetab_status hetab_grid_read(hetab_context *ctx, const hetab_grid *grid, hetab_rgl_values_fn values,
                             void *user, size_t channels, const hetab_directions *pair,
                             double *corners, double *value);

/* What such a reader makes of a surface's table. */
hetab_status hetab_grid_try(hetab_context *ctx, const hetab_surface *surface,
                            const hetab_grid *grid, hetab_grid_report *report);
