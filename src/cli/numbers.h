/* Numbers on the command line and in the tables that the program prints. */
#pragma once

#include <stddef.h>
#include <hetab/types.h>

/* A finite decimal number that is the whole text (spaces around it allowed). Returns 0 if not. */
int cli_number(const char *text, double *value);

/* Likewise, or with a percent sign: "3.9%" is 0.039. */
int cli_share(const char *text, double *value);

/* "LOW:HIGH", the lower one first. Returns 0 if not. */
int cli_interval(const char *text, double *low, double *high);

/* "n=1.5", "n=1.5,k=0.1" or "1.5,0.1": 1; another text: 0; malformed: -1. */
int cli_constant_index(const char *text, double *n, double *k);

/* "550" or "600,550,450" (nm) to um: the count, or 0 if malformed, not positive or more than max.
 */
size_t cli_wavelength_list(const char *text, double *lambda_um, size_t max);

enum { CLI_SHORT = 16 }; /* room for a short number */

/* "1.23 G", "45.0 k", "0": three digits and an SI prefix. */
void cli_si(double value, char *text, size_t size);

/* "1.2e-06" each, or "-" if nothing was compared. */
typedef struct cli_errors {
  char max[CLI_SHORT], p99[CLI_SHORT], rms[CLI_SHORT];
} cli_errors;
cli_errors cli_error_texts(const hetab_error_stats *error);
