/* HDF5 tables for look-ups: (theta_i, theta_r, phi) with a node's channels side by side. */
#ifndef HETAB_LOOKUP_DENSE_SOURCE_H
#define HETAB_LOOKUP_DENSE_SOURCE_H

#include <hetab/table.h>

#include "lookup/lattice.h"

typedef struct hetab_dense_source {
  size_t channels, stride;         /* as the lattice's */
  size_t count[HETAB_AXIS_COUNT];  /* of nodes */
  double *nodes[HETAB_AXIS_COUNT]; /* radians */
  float *values;   /* [theta_i][theta_r][phi][stride]: BRDF, or its log2 once prepared */
  float low, high; /* of the logarithms */
} hetab_dense_source;

hetab_status hetab_dense_source_load(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                     hetab_dense_source *dense);
void hetab_dense_source_clear(hetab_dense_source *dense);

/* The BRDF of the nearest node. */
void hetab_dense_source_nearest(const hetab_dense_source *dense, const float wi[3],
                                const float wo[3], float *value);

/* Turns the BRDF into its logarithm, for hetab_dense_source_at(). */
void hetab_dense_source_prepare(hetab_dense_source *dense);
/* A hetab_lattice_source; user is a prepared hetab_dense_source. */
void hetab_dense_source_at(const void *user, const hetab_lattice_place *place, float *log2_values);

#endif
