/* NAME.specular.csv, the specular delta beside tables that have no place for it. */
#ifndef HETAB_TABLE_SPECULAR_FILE_H
#define HETAB_TABLE_SPECULAR_FILE_H

#include <hetab/table.h>

#include "core/context.h"

enum { HETAB_SPECULAR_ANGLES = 91 }; /* every degree */

/* rho[wavelength][HETAB_SPECULAR_ANGLES], whole or not at all. */
hetab_status hetab_specular_save(hetab_context *ctx, const char *path, const double *lambda_um,
                                 size_t count, const double *rho, int overwrite);

#endif
