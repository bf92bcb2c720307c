/* Polynomials of ln h(g, x) over a range of g, for the kernels that read whole rows: the making of
 * what kernels/atlas.h describes and uses. */
#ifndef HETAB_MODEL_ATLAS_H
#define HETAB_MODEL_ATLAS_H

#include <stddef.h>

#include "core/context.h"

typedef struct hetab_atlas {
  int degree_x, degree_g;        /* numbers of coefficients in t and in u */
  int pad;                       /* degree_x rounded up to the vector width */
  size_t panel_count, segment_count;
  double ln_h_end;               /* the tables end where ln h has fallen to this */
  double log2_g;                 /* of the first panel's start */
  double *panels;                /* [panel_count][HETAB_PANEL_REALS] */
  double *segments;              /* [segment_count][HETAB_SEGMENT_REALS] */
  double *coefficients;          /* [segment_count][degree_g][pad] */
} hetab_atlas;

/* How many coefficients a relative error of h needs: build options of the kernels. */
void hetab_atlas_degrees(double tolerance, int vector_width, hetab_atlas *atlas);

/* Tables for g in [g_min, g_max] and all x with ln h > ln_h_end, relative error of h below
 * tolerance (tests/test_atlas.c). ln_h_end and the degrees are set before. */
hetab_status hetab_atlas_build(hetab_context *ctx, double g_min, double g_max, double tolerance,
                               hetab_atlas *atlas);
void hetab_atlas_clear(hetab_atlas *atlas);

#endif
