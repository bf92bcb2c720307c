/* The atlas: h(g, x), one universal function of two numbers, as polynomials made by the host in
 * double (src/model/atlas.c) from the very series of series.h.
 *
 * Panels split g (two per octave), segments split x within a panel; on a segment
 *   ln(h / h_centre) = sum_j c_j(u) t^j,  c_j(u) = sum_k C[k][j] u^k,  u and t in [-1, 1].
 * A table row has one g: its c_j cost HETAB_ATLAS_G vector multiply-adds a segment, and then every
 * entry costs one polynomial and one exponential, whatever the roughness.
 *
 * Rows of the half/difference frame have one x and many g: for them the same table stands
 * transposed, C[j][k], and the polynomial in u is what is left.
 *
 * Build options: HETAB_ATLAS_X coefficients in t, HETAB_ATLAS_G in u, padded to multiples of
 * HETAB_VW as HETAB_ATLAS_X_PAD and HETAB_ATLAS_G_PAD; the host chooses them with the tolerance. */
#ifndef HETAB_ATLAS_H
#define HETAB_ATLAS_H

#include "hetab_lang.h"
#include "tables.h"
#include "vexp.h"

typedef struct hetab_atlas {
  __global const real *panels, *segments;
  __global const real *coefficients; /* [segment][k][j], or [segment][j][k] for rows of one x */
  int panel_count;
  real log2_g; /* of the first panel's start */
} hetab_atlas;

/* The panel of g, -1 below the atlas. */
static inline int hetab_atlas_panel(const hetab_atlas *atlas, real g) {
  real p = floor(RC(2.0) * (log2(fmax(g, RC(1e-30))) - atlas->log2_g));
  return p < RC(0.0) ? -1 : min((int)p, atlas->panel_count - 1);
}

/* Where a panel starts. */
static inline real hetab_atlas_edge(const hetab_atlas *atlas, int panel) {
  return exp2(atlas->log2_g + RC(0.5) * panel);
}

/* The polynomial of one segment for one row. */
typedef struct hetab_segment {
  real start;         /* x where it begins */
  real offset, slope; /* t = offset + slope (1 + cos phi) */
  real peak;          /* exp(c_0): kept out of the exponent, which stays small */
  real c[HETAB_ATLAS_X_PAD];
} hetab_segment;

/* One row's x = wave_x (d2 + p (1 + cos phi)), factors apart so that t does not cancel. */
typedef struct hetab_row_x {
  hetab_two wave_x, d2;
  real p;
} hetab_row_x;

static inline void hetab_atlas_load(const hetab_atlas *atlas, int segment, real u,
                                    const hetab_row_x *x, hetab_segment *s) {
  __global const real *head = atlas->segments + segment * HETAB_SEGMENT_REALS;
  __global const real *table = atlas->coefficients + segment * (HETAB_ATLAS_G * HETAB_ATLAS_X_PAD);
  s->start = head[0];
  s->offset = hetab_product_less(x->wave_x, x->d2, head[1]) * head[2];
  s->slope = x->wave_x.hi * x->p * head[2];
  for (int i = 0; i < HETAB_ATLAS_X_PAD / HETAB_VW; i++) {
    vreal c = V_LOAD((HETAB_ATLAS_G - 1) * (HETAB_ATLAS_X_PAD / HETAB_VW) + i, table);
    for (int k = HETAB_ATLAS_G - 2; k >= 0; k--)
      c = fma(c, (vreal)u, V_LOAD(k * (HETAB_ATLAS_X_PAD / HETAB_VW) + i, table));
    V_STORE(c, i, s->c);
  }
  s->peak = head[3] * exp(s->c[0]);
}

/* h at 1 + cos phi; held to the segment's ends outside. */
static inline vreal hetab_atlas_h(const hetab_segment *s, vreal one_plus_cos) {
  vreal t =
      clamp(fma(one_plus_cos, (vreal)s->slope, (vreal)s->offset), (vreal)RC(-1.0), (vreal)RC(1.0));
  vreal p = (vreal)s->c[HETAB_ATLAS_X - 1];
  for (int j = HETAB_ATLAS_X - 2; j >= 1; j--)
    p = fma(p, t, (vreal)s->c[j]);
  return s->peak * hetab_exp(p * t);
}

/* The polynomial in u of one panel at one x. */
typedef struct hetab_column {
  real centre, scale; /* u = (g - centre) scale */
  real peak;
  real c[HETAB_ATLAS_G_PAD];
} hetab_column;

/* peak is 0 beyond the end of the atlas. */
static inline void hetab_atlas_load_column(const hetab_atlas *atlas, int panel, hetab_two wave_x,
                                           hetab_two lateral2, hetab_column *column) {
  __global const real *panel_head = atlas->panels + panel * HETAB_PANEL_REALS;
  real x = wave_x.hi * lateral2.hi;
  int first = (int)panel_head[0], segment = first + (int)panel_head[1] - 1;
  column->centre = panel_head[2];
  column->scale = panel_head[3];
  column->peak = RC(0.0);
  if (x >= panel_head[4])
    return;
  while (segment > first && x < atlas->segments[segment * HETAB_SEGMENT_REALS])
    segment--;
  __global const real *head = atlas->segments + segment * HETAB_SEGMENT_REALS;
  __global const real *table = atlas->coefficients + segment * (HETAB_ATLAS_X * HETAB_ATLAS_G_PAD);
  vreal t =
      (vreal)clamp(hetab_product_less(wave_x, lateral2, head[1]) * head[2], RC(-1.0), RC(1.0));
  for (int i = 0; i < HETAB_ATLAS_G_PAD / HETAB_VW; i++) {
    vreal c = V_LOAD((HETAB_ATLAS_X - 1) * (HETAB_ATLAS_G_PAD / HETAB_VW) + i, table);
    for (int j = HETAB_ATLAS_X - 2; j >= 0; j--)
      c = fma(c, t, V_LOAD(j * (HETAB_ATLAS_G_PAD / HETAB_VW) + i, table));
    V_STORE(c, i, column->c);
  }
  column->peak = head[3] * exp(column->c[0]);
}

/* h at g, which should lie in the panel. */
static inline vreal hetab_atlas_column_h(const hetab_column *column, vreal g) {
  vreal u = clamp((g - column->centre) * column->scale, (vreal)RC(-1.0), (vreal)RC(1.0));
  vreal p = (vreal)column->c[HETAB_ATLAS_G - 1];
  for (int k = HETAB_ATLAS_G - 2; k >= 1; k--)
    p = fma(p, u, (vreal)column->c[k]);
  return column->peak * hetab_exp(p * u);
}

#endif
