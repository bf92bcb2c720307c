/* Heights behind the public handle, and the readers of their formats. */
#pragma once

#include <stdbool.h>
#include <hetab/roughness.h>
#include "core/context.h"

#define HETAB_MOST_HEIGHTS ((size_t)1 << 27)

struct hetab_heights {
  char *name;
  hetab_heights_kind kind;
  size_t columns, rows;
  double spacing_um, spacing_y_um;
  double *z_um; /* [rows][columns] */
  char *note;   /* a sentence about how they were read, or NULL */
};

/* Without values; all of z_um is 0. `name` is for messages too. */
hetab_status hetab_heights_new(hetab_context *ctx, const char *name, size_t columns, size_t rows,
                               hetab_heights **out);

/* Frees what was read, *out then being NULL, if status or a check of the heights says so. */
hetab_status hetab_heights_keep(hetab_context *ctx, hetab_status status, hetab_heights **out);

/* Puts heights z_um[rows][count], whose places are x_um[count], on an even grid: a step of several
 * usual ones becomes missing heights, and x that a printer rounded is even. Fails for other steps
 * that are no multiple of the usual, unless resample_um says how far apart to interpolate. */
hetab_status hetab_heights_from_places(hetab_context *ctx, const char *name, const double *x_um,
                                       const double *z_um, size_t count, size_t rows,
                                       double resample_um, hetab_heights **out);

/* Keeps a copy of the sentence. */
hetab_status hetab_heights_note(hetab_context *ctx, hetab_heights *heights, const char *note);

/* Heights at x_um[count], y_um[count] in any order, on the grid that they lie on: a map, or a scan
 * if all have the same x or y. */
hetab_status hetab_heights_from_points(hetab_context *ctx, const char *name, const double *x_um,
                                       const double *y_um, const double *z_um, size_t count,
                                       double resample_um, hetab_heights **out);
/* Whether the first two of xyz[count][3] are places on such a grid. */
bool hetab_are_points(const double *xyz, size_t count);

/* Readers; the text is NUL-terminated. */
hetab_status hetab_scan_text(hetab_context *ctx, const char *path, const char *text,
                             const hetab_heights_options *options, hetab_heights **out);
hetab_status hetab_scan_sdf(hetab_context *ctx, const char *path, const char *text,
                            hetab_heights **out);
hetab_status hetab_scan_zygo(hetab_context *ctx, const char *path, const char *text,
                             hetab_heights **out);
/* Binary SDF, and Digital Surf's .sur. */
hetab_status hetab_scan_binary(hetab_context *ctx, const char *path, hetab_heights **out);
hetab_status hetab_scan_x3p(hetab_context *ctx, const char *path,
                            const hetab_heights_options *options, hetab_heights **out);
