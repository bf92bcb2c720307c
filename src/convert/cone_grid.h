/* Grids of dense tables that hold a folded delta. */
#ifndef HETAB_CONVERT_CONE_GRID_H
#define HETAB_CONVERT_CONE_GRID_H

#include <hetab/grid.h>

/* The axes given (specs, or NULL), else hetab_grid_create()'s or, where cone > 0 (radians), such
 * that a lobe of half vectors within it keeps its energy for readers that interpolate linearly:
 * thetas are a quarter of the cone apart, at most a degree; phi begins at the mirror direction with
 * a 48th of it, since seen at grazing incidence the lobe is 2 cone / tan(theta_i) wide, and goes on
 * in steps of a fifth of the way. HETAB_ERR_RANGE for a given axis whose nodes are too far apart;
 * `path` is for the message. */
hetab_status hetab_cone_grid(hetab_context *ctx, const char *const axes[HETAB_AXIS_COUNT],
                             double cone, const char *path, hetab_grid **out);

#endif
