/* The structure of our HDF5 tables: groups of attributes, axes, datasets. Functions that return a
 * herr_t are negative on failure. */
#pragma once

#include "table/h5_common.h"
#include "table/h5_head.h"

/* Axes of /brdf, in its order. */
enum { WAVELENGTH, THETA_I, THETA_R, PHI, RANK };

herr_t hetab_h5_put_number(hid_t object, const char *name, double value);
herr_t hetab_h5_put_text(hid_t object, const char *name, const char *value);

/* The datasets that are filled later; the file owns them. */
typedef struct hetab_h5_layout {
  hid_t brdf, specular;
} hetab_h5_layout;

/* Everything of a new file but the values of /brdf and /specular_reflectance. *result: of HDF5. */
hetab_status hetab_h5_lay_out(hetab_context *ctx, hid_t file, const hetab_h5_head *head,
                              const hetab_grid *grid, const hetab_h5_options *options,
                              hetab_h5_layout *out, herr_t *result);
