/* The atlas: h(g, x), one universal function of two numbers, as polynomials made by the host in
 * double (src/model/atlas.c) from the very series of series.h.
 *
 * Panels split g at 2^e and 1.5 2^e (a real's exponent and first bit are its panel), segments split
 * x within a panel; on a segment
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
  int panel_count, first_panel;      /* the number of panels[0] */
} hetab_atlas;

/* The panel of g, -1 below the atlas. */
static inline int hetab_atlas_panel(const hetab_atlas *atlas, real g) {
  return max(-1, min(hetab_panel_number(g) - atlas->first_panel, atlas->panel_count - 1));
}

static inline real hetab_panel_start(const hetab_atlas *atlas, int panel) {
  return atlas->panels[panel * HETAB_PANEL_REALS + HETAB_PANEL_START];
}

/* A row's segments are its work-item's own, or shared by the group along it. */
#if HETAB_ROW_ITEMS > 1
#define HETAB_SEGMENT_SPACE __local
#else
#define HETAB_SEGMENT_SPACE __private
#endif

/* The polynomial of one segment for one row. */
typedef struct hetab_segment {
  real start;         /* x where it begins */
  real offset, slope; /* t = offset + slope (1 + cos phi) */
  real h_centre;      /* kept out of the exponent, which stays small */
  real c[HETAB_ATLAS_X_PAD];
} hetab_segment;
#define HETAB_SEGMENT_VECTORS (HETAB_ATLAS_X_PAD / HETAB_VW) /* of c */

/* One row's x = wave_x (d2 + p (1 + cos phi)), factors apart so that t does not cancel. */
typedef struct hetab_row_x {
  hetab_two wave_x, d2;
  real p;
} hetab_row_x;

static inline real hetab_segment_start(const hetab_atlas *atlas, int segment) {
  return atlas->segments[segment * HETAB_SEGMENT_REALS + HETAB_SEGMENT_START];
}

/* All but the coefficients. */
static inline void hetab_atlas_head(const hetab_atlas *atlas, int segment, const hetab_row_x *x,
                                    HETAB_SEGMENT_SPACE hetab_segment *s) {
  __global const real *head = atlas->segments + segment * HETAB_SEGMENT_REALS;
  s->start = head[HETAB_SEGMENT_START];
  s->h_centre = head[HETAB_SEGMENT_H];
  s->offset =
      hetab_product_less(x->wave_x, x->d2, head[HETAB_SEGMENT_CENTRE]) * head[HETAB_SEGMENT_SCALE];
  s->slope = x->wave_x.hi * x->p * head[HETAB_SEGMENT_SCALE];
}

/* Vector i of the coefficients. */
static inline void hetab_atlas_coefficients(const hetab_atlas *atlas, int segment, int i, real u,
                                            HETAB_SEGMENT_SPACE hetab_segment *s) {
  __global const real *table = atlas->coefficients + segment * (HETAB_ATLAS_G * HETAB_ATLAS_X_PAD);
  vreal c = V_LOAD((HETAB_ATLAS_G - 1) * HETAB_SEGMENT_VECTORS + i, table);
#pragma unroll
  for (int k = HETAB_ATLAS_G - 2; k >= 0; k--)
    c = fma(c, (vreal)u, V_LOAD(k * HETAB_SEGMENT_VECTORS + i, table));
  V_STORE(c, i, s->c);
}

/* h at 1 + cos phi; held to the segment's ends outside. */
static inline vreal hetab_atlas_h(const HETAB_SEGMENT_SPACE hetab_segment *s, vreal one_plus_cos) {
  vreal t =
      clamp(fma(one_plus_cos, (vreal)s->slope, (vreal)s->offset), (vreal)RC(-1.0), (vreal)RC(1.0));
  /* even and odd powers apart: two chains that overlap */
  vreal t2 = t * t;
  vreal even = (vreal)s->c[HETAB_ATLAS_X - 2], odd = (vreal)s->c[HETAB_ATLAS_X - 1];
#pragma unroll
  for (int j = HETAB_ATLAS_X - 4; j >= 0; j -= 2) {
    even = fma(even, t2, (vreal)s->c[j]);
    odd = fma(odd, t2, (vreal)s->c[j + 1]);
  }
  return s->h_centre * hetab_exp(fma(odd, t, even));
}

/* The polynomial in u of one panel at one x. */
typedef struct hetab_column {
  real centre, scale; /* u = (g - centre) scale */
  real h_centre;      /* 0 beyond the end of the atlas */
  real c[HETAB_ATLAS_G_PAD];
} hetab_column;

static inline void hetab_atlas_load_column(const hetab_atlas *atlas, int panel, hetab_two wave_x,
                                           hetab_two lateral2, hetab_column *column) {
  __global const real *panel_head = atlas->panels + panel * HETAB_PANEL_REALS;
  real x = wave_x.hi * lateral2.hi;
  int first = (int)panel_head[HETAB_PANEL_FIRST],
      segment = first + (int)panel_head[HETAB_PANEL_COUNT] - 1;
  column->centre = panel_head[HETAB_PANEL_CENTRE];
  column->scale = panel_head[HETAB_PANEL_SCALE];
  column->h_centre = RC(0.0);
  if (x >= panel_head[HETAB_PANEL_X_END])
    return;
  while (segment > first && x < hetab_segment_start(atlas, segment))
    segment--;
  __global const real *head = atlas->segments + segment * HETAB_SEGMENT_REALS;
  __global const real *table = atlas->coefficients + segment * (HETAB_ATLAS_X * HETAB_ATLAS_G_PAD);
  vreal t = (vreal)clamp(hetab_product_less(wave_x, lateral2, head[HETAB_SEGMENT_CENTRE]) *
                             head[HETAB_SEGMENT_SCALE],
                         RC(-1.0), RC(1.0));
#pragma unroll
  for (int i = 0; i < HETAB_ATLAS_G_PAD / HETAB_VW; i++) {
    vreal c = V_LOAD((HETAB_ATLAS_X - 1) * (HETAB_ATLAS_G_PAD / HETAB_VW) + i, table);
#pragma unroll
    for (int j = HETAB_ATLAS_X - 2; j >= 0; j--)
      c = fma(c, t, V_LOAD(j * (HETAB_ATLAS_G_PAD / HETAB_VW) + i, table));
    V_STORE(c, i, column->c);
  }
  column->h_centre = head[HETAB_SEGMENT_H];
}

/* h at g, which should lie in the panel. */
static inline vreal hetab_atlas_column_h(const hetab_column *column, vreal g) {
  vreal u = clamp((g - column->centre) * column->scale, (vreal)RC(-1.0), (vreal)RC(1.0));
  vreal p = (vreal)column->c[HETAB_ATLAS_G - 1];
#pragma unroll
  for (int k = HETAB_ATLAS_G - 2; k >= 0; k--)
    p = fma(p, u, (vreal)column->c[k]);
  return column->h_centre * hetab_exp(p);
}

#endif
