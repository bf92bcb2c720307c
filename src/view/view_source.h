/* Where a view's numbers come from: the model, or a table. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/lookup.h>
#include <hetab/surface.h>

typedef struct hetab_view_source hetab_view_source;

struct hetab_view_source {
  /* rgb[count] of the BRDF for unit vectors wi[count], wo[count], both above the horizon. */
  hetab_status (*eval)(hetab_context *ctx, const hetab_view_source *source, size_t count,
                       const float (*wi)[3], const float (*wo)[3], float (*rgb)[3]);
  /* rgb of the delta's reflectance at theta, radians. */
  hetab_status (*specular)(hetab_context *ctx, const hetab_view_source *source, double theta,
                           float rgb[3]);
  /* The surface: its bands, and what each adds to R, G and B. */
  hetab_engine *engine;
  double sigma0_um, tau_um;
  hetab_band *bands;
  /* The table. */
  const hetab_lookup *table;
  /* Either. */
  double (*weights)[3]; /* [channels]; NULL: the three channels are R, G and B */
  size_t channels;
  char title[96], subtitle[160];
};

/* wavelength_um 0: linear sRGB. */
hetab_status hetab_view_source_surface(hetab_context *ctx, hetab_engine *engine,
                                       const hetab_surface *surface, double wavelength_um,
                                       hetab_view_source *source);
hetab_status hetab_view_source_table(hetab_context *ctx, const hetab_lookup *table,
                                     const char *title, double wavelength_um,
                                     hetab_view_source *source);
void hetab_view_source_clear(hetab_view_source *source);

/* The sum of weights of channels[channels], or they themselves. */
void hetab_view_colour(const hetab_view_source *source, const double *channels, float rgb[3]);
