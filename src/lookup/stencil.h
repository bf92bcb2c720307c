/* Cubic interpolation along one axis of a table. */
#ifndef HETAB_LOOKUP_STENCIL_H
#define HETAB_LOOKUP_STENCIL_H

#include <stddef.h>

enum { HETAB_STENCIL = 4 };

/* The `count` nodes from `first` on, with Lagrange's weights. */
typedef struct hetab_stencil {
  size_t first;
  int count;
  double weight[HETAB_STENCIL];
} hetab_stencil;

/* Around x among ascending nodes: the four that surround it, or the last four towards an end, or as
 * many as there are. Beyond the ends x goes on for at most one interval. */
hetab_stencil hetab_stencil_at(const double *nodes, size_t count, double x);

/* log2 as hetab_lattice_source has it. */
float hetab_log2_or_zero(double value);

#endif
