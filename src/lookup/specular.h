/* rho_s over the incidence, in a table's channels. */
#ifndef HETAB_LOOKUP_SPECULAR_H
#define HETAB_LOOKUP_SPECULAR_H

#include <hetab/table.h>

#include "core/context.h"

typedef struct hetab_specular_table {
  size_t channels, count; /* of incidences; 0: no specular part */
  double *theta;          /* [count], radians, ascending */
  float *rho;             /* [count][channels] */
} hetab_specular_table;

/* /specular_reflectance of a table of ours. */
hetab_status hetab_specular_of_h5(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                  hetab_specular_table *specular);
/* hetab_specular_path() of NAME.binary or NAME.bsdf, none where there is no such file: to linear
 * sRGB, or to the given wavelengths (um). */
hetab_status hetab_specular_beside(hetab_context *ctx, const char *path, size_t channels,
                                   const double *lambda_um, hetab_specular_table *specular);
void hetab_specular_clear(hetab_specular_table *specular);

/* Linear in cos^2(theta_i), of the logarithm: rho_s falls as exp(-g), g ~ cos^2. Held beyond the
 * ends. */
void hetab_specular_at(const hetab_specular_table *specular, float cos_i, float *value);

#endif
