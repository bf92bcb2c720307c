/* The formats that a table is converted to; each file appears whole or not at all. */
#pragma once

#include "convert/convert_source.h"

hetab_status hetab_convert_to_h5(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                 const hetab_convert_options *options);
hetab_status hetab_convert_to_merl(hetab_context *ctx, hetab_convert_source *source,
                                   const char *path, const hetab_convert_options *options);
hetab_status hetab_convert_to_rgl(hetab_context *ctx, hetab_convert_source *source,
                                  const char *path, const hetab_convert_options *options);

/* The largest rho_s of the table; fails if NAME.specular.csv would have to be written beside the
 * output and could not be, or is there although the table has no delta. */
hetab_status hetab_convert_check_specular(hetab_context *ctx, const hetab_convert_source *source,
                                          hetab_format format, const char *path, int overwrite,
                                          double *largest);
/* Writes it: no conversion loses the delta. */
hetab_status hetab_convert_save_specular(hetab_context *ctx, const hetab_convert_source *source,
                                         hetab_format format, const char *path, int overwrite,
                                         hetab_convert_report *report);
