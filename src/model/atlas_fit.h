/* Polynomials of ln h(g, x) over a range of g, for the kernels that read whole rows: the making of
 * what kernels/atlas.h describes and uses. */
#pragma once

#include <stddef.h>

#include "core/context.h"

typedef struct hetab_atlas {
  int degree_x, degree_g; /* numbers of coefficients in t and in u */
  int pad_x, pad_g;       /* the same, rounded up to the vector width */
  size_t panel_count, segment_count;
  double ln_h_end;      /* the tables end where ln h has fallen to this */
  int first_panel;      /* the number (kernels/tables.h) of panels[0] */
  double *panels;       /* [panel_count][HETAB_PANEL_REALS] */
  double *segments;     /* [segment_count][HETAB_SEGMENT_REALS] */
  double *coefficients; /* [segment_count][degree_g][pad_x] */
} hetab_atlas;

/* How many coefficients a relative error of h needs: build options of the kernels. */
void hetab_atlas_degrees(double tolerance, int vector_width, hetab_atlas *atlas);

/* Tables for g in [g_min, g_max] and all x with ln h > ln_h_end, relative error of h below
 * tolerance (tests/test_atlas.c). ln_h_end and the degrees are set before. */
hetab_status hetab_atlas_build(hetab_context *ctx, double g_min, double g_max, double tolerance,
                               hetab_atlas *atlas);
/* The coefficients as [segment_count][degree_x][pad_g], for rows of one x; free() *out. */
hetab_status hetab_atlas_transpose(hetab_context *ctx, const hetab_atlas *atlas, double **out);
void hetab_atlas_clear(hetab_atlas *atlas);
