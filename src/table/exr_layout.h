/* How a dense table is laid out over the parts and channels of an OpenEXR image. */
#pragma once

#include <stdbool.h>
#include <hetab/exr.h>

#include "table/exr_file.h"

typedef struct hetab_exr_layout {
  hetab_exr_options options;
  size_t bands, count[HETAB_AXIS_COUNT];
  size_t part_count; /* without that of the specular reflectance; an atlas: of tiles */
  size_t tiles_across, tiles_down; /* 1, but of an atlas */
  size_t channel_count;
  char (*channel_names)[HETAB_EXR_NAME]; /* of that part, and of every part by theta_i */
  const char **channels;                 /* the same as pointers */
} hetab_exr_layout;

hetab_status hetab_exr_layout_make(hetab_context *ctx, const hetab_surface *surface,
                                   const hetab_grid *grid, const hetab_exr_options *options,
                                   hetab_exr_layout *out);
void hetab_exr_layout_clear(hetab_exr_layout *layout);

bool hetab_exr_by_wavelength(const hetab_exr_layout *layout);
bool hetab_exr_is_atlas(const hetab_exr_layout *layout);
/* Pixels of one channel of theta_i's part. */
size_t hetab_exr_block(const hetab_exr_layout *layout);
/* Numbers of a part: all of its channels. */
size_t hetab_exr_numbers(const hetab_exr_layout *layout);
/* Part i < part_count, named title; an atlas: the whole; and the last. */
hetab_exr_part hetab_exr_table_part(const hetab_exr_layout *layout, size_t i, const char *title);
hetab_exr_part hetab_exr_specular_part(const hetab_exr_layout *layout);

/* As floats, for OpenEXR has no vectors of doubles; free() it. */
float *hetab_exr_floats(hetab_context *ctx, const double *values, size_t count);
/* What is known before the pixels, but not yet written: hetab_exr_file_begin(). Errors are NaN
 * until they are patched. */
hetab_status hetab_exr_put_header(hetab_context *ctx, hetab_exr_file *file,
                                  const hetab_exr_layout *layout, const hetab_surface *surface,
                                  const hetab_grid *grid);
void hetab_exr_patch_errors(hetab_exr_file *file, const hetab_error_stats *error);
