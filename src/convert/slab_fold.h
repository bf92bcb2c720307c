/* The specular delta as a lobe in the slabs of a dense table.
 *
 * The lobe of model/fold.h, scaled at every theta_i of the grid such that the table, interpolated
 * linearly between its nodes, reflects rho_s with it: near the horizon a grid may hold little more
 * of a lobe than its ridge, phi = 180. */
#pragma once

#include <hetab/grid.h>
#include <hetab/surface.h>
#include <hetab/types.h>

#include "core/context.h"

typedef struct hetab_slab_fold hetab_slab_fold;

/* HETAB_ERR_RANGE for a cone below the spacing of theta_r, which is two of half vectors, and where
 * a theta_i has no node within the lobe. */
hetab_status hetab_slab_fold_create(hetab_context *ctx, const hetab_surface *surface,
                                    const hetab_grid *grid, double cone, hetab_precision precision,
                                    hetab_slab_fold **out);
void hetab_slab_fold_free(hetab_slab_fold *fold); /* NULL is fine */

/* The slab with the lobe in it; its values are the fold's, until the next call. */
hetab_status hetab_slab_fold_in(hetab_context *ctx, hetab_slab_fold *fold, const hetab_slab *slab,
                                hetab_slab *out);
