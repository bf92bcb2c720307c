/* The making of RGL tables from anything that can be evaluated: the model, or a measured table. */
#pragma once

#include <hetab/rgl.h>

#include "core/context.h"

/* values[count][channels]: BRDFs in 1/sr without the cosine, finite and >= 0. */
typedef hetab_status (*hetab_rgl_values_fn)(hetab_context *ctx, void *user,
                                            const hetab_directions *pairs, size_t count,
                                            double *values);

typedef struct hetab_rgl_source {
  size_t channels;              /* 3 for linear sRGB, else one a wavelength */
  const double *wavelengths_um; /* [channels], ascending; NULL: linear sRGB */
  const char *description;      /* goes into the file; NULL: none */
  hetab_rgl_values_fn values;   /* isotropic: even in phi */
  /* What is reflected beside the table: the delta's reflectance, the sum over channels. NULL: 0. */
  double (*specular)(void *user, double theta_i);
  double specular_cone_deg; /* > 0: the delta is in the values, as a lobe that wide */
  void *user;
} hetab_rgl_source;

/* Of vndf over theta; of ndf; incidences that a table's are placed by, every 2 degrees. */
enum { HETAB_RGL_MOST_NODES = 256, HETAB_RGL_MOST_NDF = 1024, HETAB_RGL_PROBES = 46 };

/* The sizes of a table's arrays; all at least 2. */
typedef struct hetab_rgl_shape {
  size_t theta_i;              /* incidences, 0 and 90 degrees among them */
  size_t ndf;                  /* nodes of ndf and sigma over theta */
  size_t vndf_theta, vndf_phi; /* nodes of a vndf slice */
  size_t resolution;           /* nodes of luminance and spectra along either axis */
  double soft;                 /* how much of the density of half vectors is its root, 0 to 1 */
} hetab_rgl_shape;

/* The smallest candidate whose errors are below options->table_error, or, where none is, the
 * largest: report->error_l1 tells. HETAB_OK in both cases. */
hetab_status hetab_rgl_build(hetab_context *ctx, const hetab_rgl_source *source,
                             const hetab_rgl_options *options, hetab_rgl **out,
                             hetab_rgl_report *report);

/* What a table's shape needs, from small trials, which a table that is made of it needs no more. */
typedef struct hetab_rgl_forecast {
  double intervals, cells; /* incidences alone leave an error of (intervals / (theta_i - 1))^2,
                              nodes one of (cells / (resolution - 1))^2 */
  hetab_rgl_shape shape;   /* theta_i and resolution are whoever's who plans */
  unsigned char density[HETAB_RGL_PROBES]; /* of incidences, of the densest 255 */
} hetab_rgl_forecast;

hetab_status hetab_rgl_forecast_make(hetab_context *ctx, const hetab_rgl_source *source,
                                     hetab_rgl_forecast *out);
/* The shape whose error stays below table_error for nearly all surfaces, the error expected of it,
 * and the bytes of its file. */
hetab_status hetab_rgl_forecast_at(hetab_context *ctx, const hetab_rgl_forecast *forecast,
                                   const hetab_rgl_source *source, double table_error,
                                   hetab_rgl_report *out);

/* What the reader makes of any table, against the source (the same channels): fills the report's
 * errors. Directions are drawn half from the table's own sampler and half widely. */
hetab_status hetab_rgl_measure(hetab_context *ctx, const hetab_rgl_source *source,
                               const hetab_rgl *rgl, hetab_rgl_report *report);

/* The density D(theta_m) of half vectors that the source's lobe asks for, at the nodes of a table's
 * ndf: the mean, over several theta_d, of f cos(theta_i) cos(theta_r) as a function of the half
 * vector, each normalised. > 0 everywhere. */
hetab_status hetab_rgl_lobe_from_data(hetab_context *ctx, const hetab_rgl_source *source,
                                      size_t count, double *density);
