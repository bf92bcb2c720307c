/* The specular delta beside the tables: rho_s over the incidence in a table's channels, at an
 * angle, and as the file NAME.specular.csv. */
#pragma once

#include <stdbool.h>
#include <hetab/table.h>

#include "core/context.h"
#include "table/band_places.h"

typedef struct hetab_specular_table {
  size_t channels, count; /* of incidences; 0: no specular part */
  float *cos2_i;          /* [count], cos^2(theta_i), descending */
  float *rho;             /* [count][channels] */
} hetab_specular_table;

/* Attribute of HDF5 tables that hold the delta as a lobe: its width in degrees. */
#define HETAB_H5_CONE "specular_cone_deg"
/* That, in radians; 0 where there is none. */
double hetab_specular_cone_of_h5(hetab_context *ctx, hetab_h5_table *table);
/* /specular_reflectance of a table of ours. */
hetab_status hetab_specular_of_h5(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                  hetab_specular_table *specular);
/* The file under a path, whole or not at all, unless the very same is there:
 * rho[wavelength][HETAB_SPECULAR_ANGLES]; what is below 1e-30 becomes 0. Wavelengths, one or three,
 * that are a table's channels rather than a spectrum are marked by a fourth column `channel`: mono,
 * or r, g, b. */
enum { HETAB_SPECULAR_ANGLES = 91 }; /* every degree */
hetab_status hetab_specular_save(hetab_context *ctx, const char *path, const double *lambda_um,
                                 size_t count, bool are_channels, const double *rho, int overwrite);

/* hetab_specular_path() of NAME.binary or NAME.bsdf, none where there is no such file: to linear
 * sRGB, or to the given wavelengths (um). */
hetab_status hetab_specular_beside(hetab_context *ctx, const char *path, size_t channels,
                                   const double *lambda_um, hetab_specular_table *specular);
void hetab_specular_clear(hetab_specular_table *specular);

/* Linear in cos^2(theta_i), of the logarithm: rho_s falls as exp(-g), g ~ cos^2. Held beyond the
 * ends. places: NULL: all channels. */
void hetab_specular_at(const hetab_specular_table *specular, float cos_i,
                       const hetab_band_places *places, float *value);
