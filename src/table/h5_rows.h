/* Rows of theta_i of a table, of all wavelengths at once. */
#pragma once

#include <hetab/table.h>

/* How many theta_i are best read together: those of a chunk. */
size_t hetab_h5_row_step(const hetab_h5_table *table);
/* values[wavelength][count][theta_r][phi], from theta_i `first` on. */
hetab_status hetab_h5_read_rows(hetab_context *ctx, hetab_h5_table *table, size_t first,
                                size_t count, float *values);
