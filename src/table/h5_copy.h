/* A copy of an HDF5 table with other values of /brdf; all else is taken over byte by byte. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

typedef struct hetab_h5_copy hetab_h5_copy;

/* Nothing appears under `path` before hetab_h5_copy_commit. */
hetab_status hetab_h5_copy_create(hetab_context *ctx, const char *source, const char *path,
                                  int overwrite, hetab_h5_copy **out);
/* values[theta_i][theta_r][phi] of one wavelength. */
hetab_status hetab_h5_copy_write(hetab_context *ctx, hetab_h5_copy *copy, size_t wavelength,
                                 const double *values);
/* Publishes; frees the copy, whatever the outcome. */
hetab_status hetab_h5_copy_commit(hetab_context *ctx, hetab_h5_copy *copy);
/* Drops it; NULL is fine. */
void hetab_h5_copy_abort(hetab_h5_copy *copy);
