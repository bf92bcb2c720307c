/* HDF5 tables for look-ups: (theta_i, theta_r, phi) with a node's channels side by side. */
#pragma once

#include <stdbool.h>
#include <hetab/table.h>

#include "lookup/lattice.h"
#include "lookup/stencil.h"

typedef struct hetab_dense_source {
  size_t channels, stride;         /* numbers of a node, and room for them */
  size_t count[HETAB_AXIS_COUNT];  /* of nodes */
  double *nodes[HETAB_AXIS_COUNT]; /* radians */
  float *values;                   /* [theta_i][theta_r][phi][stride]: BRDF; NULL: codes */
  uint16_t *codes;                 /* likewise: log2 = row_low[theta_i] + step * code */
  double *row_low;                 /* [theta_i] */
  float step, low, high;           /* of the logarithms in all */
  hetab_stencil_axis axes[HETAB_AXIS_COUNT];
} hetab_dense_source;

/* The BRDFs themselves, for hetab_dense_source_nearest(), or their logarithms, for
 * hetab_dense_source_at(). */
hetab_status hetab_dense_source_load(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                     bool logarithms, hetab_dense_source *dense);
void hetab_dense_source_clear(hetab_dense_source *dense);

/* The nearest node's BRDF, [channels]. */
const float *hetab_dense_source_nearest(const hetab_dense_source *dense, const float wi[3],
                                        const float wo[3]);

/* A hetab_lattice_source; user is a hetab_dense_source. */
void hetab_dense_source_at(const void *user, const hetab_lattice_place *place, float *log2_values);
