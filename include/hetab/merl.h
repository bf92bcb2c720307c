/* MERL tables (.binary): 90 x 90 x 180 cells of (theta_h, theta_d, phi_d), three channels.
 *
 * File: int32 dims[3] = {90, 90, 180}, then three planes of doubles, red first, each
 * [theta_h][theta_d][phi_d], phi_d fastest, little-endian. Stored = value / scale with scale
 * 1/1500, 1.15/1500, 1.66/1500. theta_h = (i/90)^2 90 deg, theta_d = j deg, phi_d = k deg at the
 * cells' lower corners. Cells below the horizon hold -1 in all three channels, and no others; but
 * of a table that holds the specular delta as a lobe, the last cell's blue number, below the
 * horizon too, is -1 less the lobe's width in degrees. */
#pragma once

#include <stddef.h>
#include <hetab/types.h>

HETAB_BEGIN

enum {
  HETAB_MERL_THETA_H = 90,
  HETAB_MERL_THETA_D = 90,
  HETAB_MERL_PHI_D = 180,
  HETAB_MERL_CELLS = HETAB_MERL_THETA_H * HETAB_MERL_THETA_D * HETAB_MERL_PHI_D
};

/* Threads: shared where it is const; through hetab_merl_channel() by one thread, while no other
 * reads. */
typedef struct hetab_merl hetab_merl;

/* All cells -1 (below the horizon). */
hetab_status hetab_merl_create(hetab_context *ctx, hetab_merl **out);
void hetab_merl_free(hetab_merl *merl);

/* BRDF in 1/sr, unscaled: [HETAB_MERL_CELLS] of channel 0 (red), 1, 2; -1 below the horizon. */
double *hetab_merl_channel(hetab_merl *merl, int channel);
const double *hetab_merl_channel_const(const hetab_merl *merl, int channel);

/* 0: the specular delta is not in the cells; else the width of the lobe (theta_h, radians) that it
 * is in them as. */
double hetab_merl_specular_cone(const hetab_merl *merl);
void hetab_merl_set_specular_cone(hetab_merl *merl, double cone);

/* Write whole or not at all. HETAB_ERR_EXISTS if path exists and overwrite == 0. */
hetab_status hetab_merl_save(hetab_context *ctx, const hetab_merl *merl, const char *path,
                             int overwrite);
/* Any MERL file; HETAB_ERR_PARSE for wrong dimensions or a wrong length, naming both. */
hetab_status hetab_merl_load(hetab_context *ctx, const char *path, hetab_merl **out);

/* The same for audits: NaN, infinite and negative numbers stay as they are (scaled), but for cells
 * whose three stored numbers are -1, the mark of the horizon: they hold -1. */
hetab_status hetab_merl_load_raw(hetab_context *ctx, const char *path, hetab_merl **out);

/* The cell that the reference reader uses: truncating square-root theta_h, truncating theta_d and
 * phi_d, phi_d folded by reciprocity. */
size_t hetab_merl_cell(hetab_directions at);
/* The reference reader's BRDF, 1/sr; negative if the cell is below the horizon. */
void hetab_merl_lookup(const hetab_merl *merl, hetab_directions at, double rgb[3]);

HETAB_END
