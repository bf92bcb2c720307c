/* MERL tables for look-ups. */
#pragma once

#include <hetab/merl.h>

#include "lookup/lattice.h"
#include "lookup/stencil.h"
#include "table/merl_frame.h"

enum { HETAB_MERL_HALF = HETAB_MERL_PHI_D / 2 };

/* log2 of the cells, the two halves of phi_d (that reciprocity and the plane of incidence's
 * symmetry make equal) averaged, cells below the horizon continued from those above. */
typedef struct hetab_merl_source {
  float (*logs)[HETAB_MERL_CHANNELS]; /* [theta_h][theta_d][phi_d < 90] */
  double sin2_h[HETAB_MERL_THETA_H], theta_d[HETAB_MERL_THETA_D];
  hetab_stencil_axis h, d;
  float low, high;
} hetab_merl_source;

hetab_status hetab_merl_prepare(hetab_context *ctx, const hetab_merl *merl,
                                hetab_merl_source *source);
void hetab_merl_source_clear(hetab_merl_source *source);
/* A hetab_lattice_source; user is a hetab_merl_source. */
void hetab_merl_at(const void *user, const hetab_lattice_place *place, float *log2_values);

/* The cell's own number; 0 where it is below the horizon. */
void hetab_merl_nearest(const hetab_merl *merl, const float wi[3], const float wo[3], float *value);
