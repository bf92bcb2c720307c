/* HDF5 tables of any source, a surface or another table. */
#pragma once

#include <hetab/table.h>

/* What a file says of its table; what is unknown is NAN or NULL, and then missing from the file
 * (attributes) or NaN in it (n, k, uniform_diffuse). */
typedef struct hetab_h5_head {
  const char *name;
  double sigma0_um, tau_um;
  const char *index_source;
  const char *source;      /* where the table came from, in words */
  size_t channels;         /* the leading axis */
  const double *lambda_um; /* [channels]; NULL: three channels of linear sRGB, the axis `channel` */
  const hetab_band *bands; /* [channels] */
  double specular_cone;    /* > 0: the delta is in the table, as a lobe that wide (radians) */
} hetab_h5_head;

/* As hetab_h5_create(). */
hetab_status hetab_h5_create_from(hetab_context *ctx, const char *path, const hetab_h5_head *head,
                                  const hetab_grid *grid, const hetab_h5_options *options,
                                  hetab_table_writer **out);
