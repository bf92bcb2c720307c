/* Pictures of a surface or of a table: lobes, hemisphere maps, and a lit sphere, on one page (PNG)
 * or as linear data (OpenEXR).
 *
 * Lobes: the BRDF in the plane of incidence, theta_r from -89.5 (the light's side) to 89.5
 * degrees.
 * Maps: the BRDF over the hemisphere of viewers, one for each theta_i; equal-area discs, the normal
 * in the centre, the light's azimuth to the left, the mirror direction to the right.
 * Sphere: orthographic, of radius 0.46 of its image, under two distant lights and a dome, each
 * white: discs of 12 and 9 degrees radius that give an irradiance of 2.0 and 1.0 from (-0.5, 0.62,
 * 0.6) and (0.82, 0.25, -0.51), and radiance 0.32 + 0.22 y from direction y (x right, y up, z to
 * the viewer). A white Lambertian surface that faces the first is about 1. The delta reflects
 * all three.
 *
 * Error (tests/test_view.c): lobes are the model's, in float to 5e-5, or the table's own values.
 * Maps and sphere interpolate the logarithm on rays about the mirror point: maps, median 0.9 % at
 * most, 99th percentile 25 % (beyond 80 degrees, where values fall by decades in a few degrees), of
 * pixels within four decades of the largest; a Lambertian sphere, 1.4 % of its closed form; a
 * needle of a lobe under the dome, 0.4 %. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/lookup.h>
#include <hetab/surface.h>

HETAB_BEGIN

enum { HETAB_VIEW_MOST_THETA_I = 4 };

typedef enum hetab_view_what {
  HETAB_VIEW_ALL,
  HETAB_VIEW_LOBES,
  HETAB_VIEW_MAPS,
  HETAB_VIEW_SPHERE
} hetab_view_what;

typedef struct hetab_view_options {
  size_t size; /* of the struct; 0: of this header's */
  hetab_view_what what;
  const double *theta_i; /* [theta_i_count], ascending, in [0, pi/2); NULL: 0, 30, 60, 80 degrees */
  size_t theta_i_count;  /* at most HETAB_VIEW_MOST_THETA_I */
  double wavelength_um;  /* one wavelength, the same in R, G and B; 0: linear sRGB */
  size_t width;          /* of the page in pixels, 640 to 8192; 0: 1280 */
  double exposure;       /* of the sphere on the page, in stops */
} hetab_view_options;

/* Threads: once made, it does not change and may be shared. */
typedef struct hetab_view hetab_view;

/* HETAB_ERR_RANGE for colour from too few wavelengths, or a wavelength that is not there. */
hetab_status hetab_view_surface(hetab_context *ctx, hetab_engine *engine,
                                const hetab_surface *surface, const hetab_view_options *options,
                                hetab_view **out);
/* title: what the page calls the table. HETAB_ERR_RANGE also for a wavelength of a table of linear
 * sRGB, HETAB_ERR_PARSE for a table that holds NaN or infinity where it was looked up. */
hetab_status hetab_view_table(hetab_context *ctx, const hetab_lookup *table, const char *title,
                              const hetab_view_options *options, hetab_view **out);
void hetab_view_free(hetab_view *view); /* NULL is fine */

/* rgb[side][side][3], top row first: radiance; 0 outside the sphere. NULL without a sphere. */
const float *hetab_view_sphere(const hetab_view *view, size_t *side);
/* rgb[side][side][3], top row first: BRDF in 1/sr, of theta_i number i; 0 outside the disc. */
const float *hetab_view_map(const hetab_view *view, size_t i, size_t *side);
/* rgb[count][3], BRDF in 1/sr, of theta_i number i; NULL without lobes. */
const float *hetab_view_lobe(const hetab_view *view, size_t i, size_t *count);
/* Where: theta_r[count], ascending, negative on the light's side. */
void hetab_view_lobe_theta_r(const hetab_view *view, size_t i, float *theta_r);

/* The page, 8-bit sRGB. Whole or not at all. */
hetab_status hetab_view_save_png(hetab_context *ctx, const hetab_view *view, const char *path,
                                 int overwrite);
/* The data, linear, float: parts sphere, map_theta_i_30_00deg, ..., and lobe_theta_i_30_00deg, ...
 * (one row; channels R G B and theta_r_deg); with more decimals where angles are closer than 0.01
 * degrees. */
hetab_status hetab_view_save_exr(hetab_context *ctx, const hetab_view *view, const char *path,
                                 int overwrite);

HETAB_END
