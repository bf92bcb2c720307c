/* One wavelength of a dense table, [theta_i][theta_r][phi], as a renderer looks it up. */
#pragma once

#include <hetab/audit.h>
#include <hetab/grid.h>

#include "core/context.h"

typedef struct hetab_dense_table {
  const hetab_grid *grid;
  hetab_reading lookup; /* not HETAB_READ_DEFAULT */
  size_t count[HETAB_AXIS_COUNT];
  double *weights[HETAB_AXIS_COUNT]; /* of the integral over theta_r and phi; NULL for theta_i */
  double *values;                    /* of the wavelength at hand */
} hetab_dense_table;

hetab_status hetab_dense_table_create(hetab_context *ctx, const hetab_grid *grid,
                                      hetab_reading lookup, hetab_dense_table *table);
void hetab_dense_table_clear(hetab_dense_table *table);

/* 1/sr at any directions above the horizon; radians. What is no number is 0. */
double hetab_dense_table_read(const hetab_dense_table *table, double theta_i, double theta_r,
                              double phi);

/* Integral of the looked-up table times cos(theta_r) over the hemisphere, at a theta_i of the axis:
 * exact but for rounding, as what lies between entries is a polynomial. */
double hetab_dense_table_energy(const hetab_dense_table *table, size_t theta_i);

/* Entry (theta_i, theta_r, phi) with the two directions exchanged: the table's own where the axes
 * are the same, else looked up. */
int hetab_dense_table_same_axes(const hetab_dense_table *table);

static inline double *hetab_dense_table_at(const hetab_dense_table *table, size_t i, size_t r,
                                           size_t p) {
  return table->values + (i * table->count[HETAB_THETA_R] + r) * table->count[HETAB_PHI] + p;
}
