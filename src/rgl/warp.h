/* Densities on the unit square, bilinear between nodes, with maps from uniform points to points of
 * that density and back: a marginal over rows, then a conditional along the row, both continuous.
 * A stack of slices belongs to parameter values; between them densities and running integrals are
 * blended. The arithmetic is float, as in the renderers that read these tables. */
#pragma once

#include <stddef.h>

#include "core/context.h"

/* The slices that parameters fall between, and their weights, which sum to 1. */
typedef struct hetab_blend {
  size_t count; /* 1 to 4 */
  size_t slice[4];
  float weight[4];
} hetab_blend;

typedef struct hetab_warp {
  size_t width, height, slices; /* nodes along x and y, at least 2 */
  float *data;                  /* [slices][height][width]; a slice's cells' means sum to 1 */
  float *conditional;           /* [slices][height][width]: running integral along a row */
  float *marginal;              /* [slices][height]: running integral of whole rows */
} hetab_warp;

/* From data[slices][height][width], finite and >= 0, which is copied. Slices that integrate to 0
 * are all 1 where `uniform`, else HETAB_ERR_RANGE with *bad_slice. */
hetab_status hetab_warp_create(hetab_context *ctx, const float *data, size_t width, size_t height,
                               size_t slices, int uniform, size_t *bad_slice, hetab_warp *out);
void hetab_warp_clear(hetab_warp *warp);

/* The density at u. */
float hetab_warp_density(const hetab_warp *warp, const hetab_blend *blend, const float u[2]);
/* The uniform point s of u, the inverse of hetab_warp_sample(); the density at u. */
float hetab_warp_invert(const hetab_warp *warp, const hetab_blend *blend, const float u[2],
                        float s[2]);
/* The point u of the uniform point s; the density there. */
float hetab_warp_sample(const hetab_warp *warp, const hetab_blend *blend, const float s[2],
                        float u[2]);

/* A place between nodes: the cell and where in it. */
typedef struct hetab_cell {
  size_t x, y;
  float tx, ty;
} hetab_cell;

/* u is clamped to the square. */
hetab_cell hetab_cell_at(size_t width, size_t height, const float u[2]);
/* Bilinear, of nodes[height][width]. */
float hetab_cell_value(const hetab_cell *cell, const float *nodes, size_t width);
