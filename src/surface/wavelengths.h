/* Lists of wavelengths as text. */
#pragma once

#include <stdio.h>
#include <hetab/surface.h>
#include "core/context.h"

/* At least one, at most 100000, lengths, strictly ascending. */
hetab_status hetab_wavelengths_check(hetab_context *ctx, const double *lambda_um, size_t count);

/* "start:stop:step", stop included, or "a,b,c", in units of 1/per_um um (1000: nm); free() them. */
hetab_status hetab_wavelengths_parse(hetab_context *ctx, const char *text, double per_um,
                                     double **lambda_um, size_t *count);

/* A YAML line: wavelengths_nm as a range or a list, or wavelengths_um where no nm value gives back
 * exactly the same doubles. */
hetab_status hetab_wavelengths_write(hetab_context *ctx, FILE *out, const double *lambda_um,
                                     size_t count);

/* A YAML list of numbers that read back exactly, in brackets, with a newline at the end. */
void hetab_numbers_write(FILE *out, const double *values, size_t count);
