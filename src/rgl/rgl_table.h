/* The making of one RGL table of a given shape. */
#pragma once

#include "rgl/rgl_build.h"
#include "rgl/rgl_internal.h"

/* One number for a source's values, channel c at values[c * stride]: their luminance, or, for
 * spectra, their mean. */
double hetab_rgl_luminance(const hetab_rgl_source *source, const double *values, size_t stride);

/* A table with everything but spectra and luminance: ndf, from lobe[shape->ndf], sigma, and vndf
 * for incidences theta_i[shape->theta_i], ascending, 0 to pi/2. */
hetab_status hetab_rgl_new(hetab_context *ctx, const hetab_rgl_source *source,
                           const hetab_rgl_shape *shape, const double *lobe, const double *theta_i,
                           hetab_rgl **out);

/* The spectra that a reader at theta_i should find at the nodes of a table: out[channels][n][n], n
 * = rgl->resolution, where `blend` is how it finds its way from nodes to half vectors. */
hetab_status hetab_rgl_spectra_at(hetab_context *ctx, const hetab_rgl_source *source,
                                  const hetab_rgl *rgl, const hetab_blend *blend, double theta_i,
                                  double *out);

/* Fills spectra and luminance. */
hetab_status hetab_rgl_fill(hetab_context *ctx, const hetab_rgl_source *source, hetab_rgl *rgl);
/* Of the spectra, those that are read at this incidence, alone. */
hetab_status hetab_rgl_fill_about(hetab_context *ctx, const hetab_rgl_source *source,
                                  hetab_rgl *rgl, double theta_i);

/* The incidence that slice k is made at. 90 degrees itself reflects nothing: its slice stands for
 * the last quarter of the interval. */
double hetab_rgl_slice_theta(const hetab_rgl *rgl, size_t k);

/* Where column x of n stands. The last one leads to theta_m = 90 degrees, where nothing is: it
 * stands for what is before. */
float hetab_rgl_column_place(size_t x, size_t n);
