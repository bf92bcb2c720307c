/* The error of tables whose shape is no choice: MERL's cells, and the nodes of dense grids. */
#pragma once

#include <stdint.h>

#include <hetab/plan.h>

/* Relative L1 over directions that the model draws, of the worst of five incidences to 75 degrees
 * or the scene's largest: of a reader that truncates MERL cells, as the reference does, or is
 * linear between the nodes of HDF5 and OpenEXR tables. From the model alone, to a tenth of it. */
hetab_status hetab_fixed_error(hetab_context *ctx, const hetab_scene *scene,
                               const hetab_surface *surface, const hetab_plan_item *item,
                               uint64_t seed, double *error);
