/* A BRDF on rays about the mirror point, at some angles of one direction: what maps and the sphere
 * interpolate. In the plane of lateral direction cosines a lobe is centred at the mirror point and
 * nearly round whatever the angle, so that thin ones survive interpolation. */
#pragma once

#include "view/view_source.h"

/* Rays over half a turn, and nodes of a ray; 2 or more. */
typedef struct hetab_lobe_size {
  int rays, nodes;
} hetab_lobe_size;

/* log: of a luminance above 0; ratio: the colour over it. */
typedef struct hetab_lobe_node {
  float log, ratio[3];
} hetab_lobe_node;

typedef struct hetab_lobe_table {
  size_t count;
  hetab_lobe_size size;
  double *theta;          /* [count], radians, ascending */
  hetab_lobe_node *nodes; /* [count][size.rays][size.nodes] */
} hetab_lobe_table;

/* For theta[count]. fixed_is_wo: theta is the viewer's, else the light's. */
hetab_status hetab_lobe_table_create(hetab_context *ctx, const hetab_view_source *source,
                                     const double *theta, size_t count, hetab_lobe_size size,
                                     int fixed_is_wo, hetab_lobe_table *table);
void hetab_lobe_table_clear(hetab_lobe_table *table);

/* rgb for the fixed direction at theta and azimuth 0, and the other one at lateral cosines q. */
void hetab_lobe_table_eval(const hetab_lobe_table *table, double theta, const double q[2],
                           float rgb[3]);

/* The distance from the mirror point of theta to the horizon in the direction of cos_psi. */
double hetab_lobe_reach(double theta, double cos_psi);
/* Where node t in [0, 1] of a ray lies, over its length; and its derivative. */
double hetab_lobe_place(double t);
double hetab_lobe_place_slope(double t);
