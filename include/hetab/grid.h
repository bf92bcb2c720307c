/* The angular grid of a dense table: theta_i, theta_r, phi, in degrees (the axes of the files;
 * degrees so that 0, 90 and 180 are exact). Both thetas in [0, 90], phi in [0, 180]: the viewer's
 * azimuth minus the light's, 180 being the mirror side. The model is symmetric in phi. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

typedef enum hetab_axis { HETAB_THETA_I, HETAB_THETA_R, HETAB_PHI, HETAB_AXIS_COUNT } hetab_axis;

/* Threads: shared where it is const; hetab_grid_set_*() by one thread, while no other reads. */
typedef struct hetab_grid hetab_grid;

/* 90 x 90 x 181: theta 0:90:90, phi 0:180:181, both ends included. */
hetab_status hetab_grid_create(hetab_context *ctx, hetab_grid **out);
void hetab_grid_free(hetab_grid *grid);

/* "start:stop:count" (both ends included, count >= 2), "cells:N" (centres of N equal cells of the
 * whole range), or a list "0,10,20.5". Strictly ascending and within the axis's range. */
hetab_status hetab_grid_set_axis(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                                 const char *spec);
hetab_status hetab_grid_set_values(hetab_context *ctx, hetab_grid *grid, hetab_axis axis,
                                   const double *deg, size_t count);

size_t hetab_grid_count(const hetab_grid *grid, hetab_axis axis);
const double *hetab_grid_deg(const hetab_grid *grid, hetab_axis axis);     /* [count] */
const double *hetab_grid_radians(const hetab_grid *grid, hetab_axis axis); /* [count], the same */
const char *hetab_axis_name(hetab_axis axis);                              /* "theta_i" */

HETAB_END
