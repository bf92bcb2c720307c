/* An RGL table in memory: the arrays of its file, and the running integrals of its densities. */
#pragma once

#include <hetab/rgl.h>

#include "rgl/warp.h"

/* Far more than any instrument has: what is done for every one of them takes its time. */
enum { HETAB_RGL_MOST_WAVELENGTHS = 4096 };

/* A bilinear function of (u_theta, u_phi): nodes[height][width]. */
typedef struct hetab_rgl_map {
  size_t width, height;
  float *nodes;
} hetab_rgl_map;

struct hetab_rgl {
  char *description;
  float specular_cone_deg; /* > 0: the delta is in the table, as a lobe that wide */
  int jacobian;            /* 0: spectra hold f cos(theta_o) itself */
  size_t phi_i_count, theta_i_count;
  float *phi_i, *theta_i; /* radians, ascending */
  hetab_rgl_map ndf, sigma;
  hetab_warp vndf, luminance; /* slices [phi_i][theta_i] */
  size_t channels, resolution;
  double *wavelengths_um; /* [channels]; NULL: linear sRGB */
  size_t negative;        /* spectra just below 0 that loading set to 0 */
  float *spectra;         /* [phi_i][theta_i][channels][resolution][resolution] */
};

/* The parameterisation: theta = pi/2 u^2, phi = (2 u - 1) pi. */
float hetab_rgl_theta_to_u(float theta);
double hetab_rgl_u_to_theta(double u);

/* theta of a unit vector without acos: exact about the normal. */
float hetab_rgl_elevation(const float w[3]);

/* The slices around an incidence. */
hetab_blend hetab_rgl_blend(const hetab_rgl *rgl, float theta_i, float phi_i);

/* Where a pair of directions is in the spectra; what their numbers there are multiplied by to give
 * f cos(theta_o). 0 if a direction is not above the horizon. */
float hetab_rgl_place(const hetab_rgl *rgl, const float wi[3], const float wo[3],
                      hetab_blend *blend, hetab_cell *cell);
