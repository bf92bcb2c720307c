/* Rows of a table of n and k in a file, in any order, on their way to curves. */
#pragma once

#include <stdbool.h>
#include "surface/index_parts.h"

typedef struct hetab_row {
  double lambda_um;
  double values[2]; /* in the order of the file's columns */
  size_t line;      /* in the file, from 1 */
} hetab_row;

/* Sort rows by wavelength; two that agree within 5 % become their mean. A wavelength with two
 * values is an error that names both lines. */
hetab_status hetab_rows_sort(hetab_context *ctx, const char *path, hetab_row *rows, size_t *count);

/* The sorted rows' values[column], n or k, as a curve. k from -0.001 on is 0: the noise of its
 * inversion. Other values that are no index stay, for whoever asks for them; not if all are such.
 */
hetab_status hetab_rows_to_curve(hetab_context *ctx, const char *path, const hetab_row *rows,
                                 size_t count, int column, bool is_k, hetab_curve *curve);
