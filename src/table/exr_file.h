/* OpenEXR files of scan-line parts, by OpenEXR's C API, on an atomic file.
 *
 * Calls in this order: create; add every part and its attributes; begin; write every part, in the
 * order of their numbers; patch; finish. A failure sticks: later calls do nothing, and those that
 * return a status report it. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

#include "core/atomic_file.h"

typedef struct hetab_exr_file hetab_exr_file;

enum { HETAB_EXR_NAME = 64 };

/* PREFIXvalueUNIT of values[i], ascending values[count]: of one width, so that sorting the names
 * sorts the values; two decimals, or as many as keep neighbours apart. prefix and unit have at most
 * 24 characters together. */
void hetab_exr_part_name(const char *prefix, const char *unit, const double *values, size_t count,
                         size_t i, char name[HETAB_EXR_NAME]);

typedef struct hetab_exr_part {
  const char *name;
  int width, height;
  const char *const *channels; /* [channel_count], in any order */
  int channel_count;
  int half;
} hetab_exr_part;

/* Into an empty file, which has to outlive it. */
hetab_status hetab_exr_file_create(hetab_context *ctx, hetab_atomic_file *atomic,
                                   hetab_exr_file **out);
/* Parts are numbered from 0. The display window, width x height, has to be one for all. */
void hetab_exr_file_part(hetab_exr_file *file, const hetab_exr_part *part, int display_width,
                         int display_height);
/* Attributes of the part added last. */
void hetab_exr_put_text(hetab_exr_file *file, const char *name, const char *value);
void hetab_exr_put_double(hetab_exr_file *file, const char *name, double value);
void hetab_exr_put_vector(hetab_exr_file *file, const char *name, const float *values,
                          size_t count);
/* Rec. 709 primaries and D65: what R, G, B stand for. */
void hetab_exr_put_chromaticities(hetab_exr_file *file);
/* The header. */
hetab_status hetab_exr_file_begin(hetab_context *ctx, hetab_exr_file *file);
/* Pixels of a part as it was added: planes[channel_count][height][width]. */
hetab_status hetab_exr_file_write(hetab_context *ctx, hetab_exr_file *file, int number,
                                  const hetab_exr_part *part, const float *const *planes);
/* Replaces the value of a double attribute in every part that has it: for what is known only when
 * the pixels are. Takes effect at the end. */
void hetab_exr_file_patch(hetab_exr_file *file, const char *name, double value);
/* Everything into the atomic file. */
hetab_status hetab_exr_file_finish(hetab_context *ctx, hetab_exr_file *file);
void hetab_exr_file_free(hetab_exr_file *file); /* NULL is fine */

/* Whether a file has so many parts, each with all its rows. Pixels are not decoded. */
hetab_status hetab_exr_file_check(hetab_context *ctx, const char *path, size_t part_count);
