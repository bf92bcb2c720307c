/* Cubic interpolation along one axis of a table. */
#pragma once

#include <stddef.h>

#include "core/context.h"

enum { HETAB_STENCIL = 4 };

/* Ascending nodes; fewer than four are interpolated as far as they go. */
typedef struct hetab_stencil_axis {
  size_t count;
  int size;            /* of a stencil */
  const double *nodes; /* not owned */
  double per_node;     /* nodes a unit, of even spacing */
  double *scale;       /* [count - size + 1][size]: weights but for their products of distances */
} hetab_stencil_axis;

typedef struct hetab_stencil {
  size_t first;
  int count;
  double weight[HETAB_STENCIL];
} hetab_stencil;

hetab_status hetab_stencil_axis_create(hetab_context *ctx, const double *nodes, size_t count,
                                       hetab_stencil_axis *axis);
void hetab_stencil_axis_clear(hetab_stencil_axis *axis);

/* Beyond the ends extrapolated by at most one interval. */
hetab_stencil hetab_stencil_at(const hetab_stencil_axis *axis, double x);

/* HETAB_LATTICE_ZERO for what is faint enough to be 0 in every table. */
float hetab_log2_or_zero(double value);
