/* Tabulation: a surface over a whole grid, delivered slab by slab, or as a MERL table. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/grid.h>
#include <hetab/merl.h>
#include <hetab/surface.h>
#include <hetab/types.h>

HETAB_BEGIN

/* For `samples`: compare none. */
#define HETAB_NO_SAMPLES ((size_t)-1)

typedef struct hetab_tabulate_options {
  size_t size;    /* of the struct; 0: of this header's */
  size_t samples; /* entries compared with the literal reference in all; 0: 2000 */
  unsigned seed;  /* of the sample */
} hetab_tabulate_options;

/* Every entry of surface x grid. Memory: two slabs per device (four on a GPU), of at most 32 MiB or
 * one theta_i row (HETAB_ERR_RANGE if that is over 128 MiB), whatever the table's size.
 * Entries below 5e-15 / sr may be 0. options and report may be NULL. */
hetab_status hetab_tabulate(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                            const hetab_grid *grid, const hetab_tabulate_options *options,
                            hetab_slab_fn sink, void *user, hetab_report *report);

typedef enum hetab_merl_sampling {
  HETAB_MERL_CENTRE, /* cell centres: the best for readers, which truncate */
  HETAB_MERL_EDGE,   /* the cells' lower corners */
  HETAB_MERL_MEAN    /* mean of the valid ones of 3 x 3 x 3 sub-samples */
} hetab_merl_sampling;

typedef enum hetab_merl_colour {
  HETAB_MERL_SRGB, /* linear sRGB: D65-weighted CIE 1931 integration of the surface's wavelengths */
  HETAB_MERL_MONO, /* one band, the same in all three channels */
  HETAB_MERL_BANDS /* one band a channel */
} hetab_merl_colour;

typedef struct hetab_merl_options {
  size_t size; /* of the struct; 0: of this header's */
  hetab_merl_sampling sampling;
  hetab_merl_colour colour;
  double band_um[3];    /* MONO: the first; BANDS: R, G, B */
  double specular_cone; /* > 0: fold the specular delta in as a lobe that wide (theta_h); two rows
                           of cells, 0.044 degrees, or more */
  size_t samples;       /* cells compared with the literal reference; 0: 500 */
  unsigned seed;
} hetab_merl_options;

/* A MERL table of the surface. sRGB needs wavelengths that cover 400-700 nm at 10 nm or finer
 * (HETAB_ERR_RANGE). Out-of-gamut negatives become 0 and are counted. */
hetab_status hetab_tabulate_merl(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_surface *surface, const hetab_merl_options *options,
                                 hetab_merl **out, hetab_report *report);

/* What MERL's readers, who truncate, make of the delta that such a table holds as a lobe (with
 * specular_cone > 0): rho_s[count], and read[count] in its place, at theta_i[count], at 700 nm or
 * the first of band_um. On the host. */
hetab_status hetab_merl_cone_read(hetab_context *ctx, const hetab_surface *surface,
                                  const hetab_merl_options *options, const double *theta_i,
                                  size_t count, double *rho_s, double *read);

HETAB_END
