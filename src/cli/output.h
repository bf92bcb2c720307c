/* What the program writes: text files whole or not at all, JSON and aligned tables. */
#ifndef HETAB_CLI_OUTPUT_H
#define HETAB_CLI_OUTPUT_H

#include <stddef.h>
#include <stdio.h>
#include <jansson.h>
#include <hetab/tabulate.h>

/* Whether path may become an output file: its directory exists and can be written, path is no
 * directory, and does not exist unless overwrite. Returns 0 after printing why not. */
int cli_output_allowed(const char *path, int overwrite);
/* Two paths of one file, existing or not. */
int cli_same_file(const char *a, const char *b);

/* A text file in the making: nothing appears under its path before cli_file_publish. */
typedef struct cli_file {
  FILE *stream;
  char *path;
  char *temporary; /* name of the unpublished file; NULL: it has none (O_TMPFILE) */
} cli_file;

/* -1 to go on, else the exit status after printing why. */
int cli_file_create(cli_file *file, const char *path);
int cli_file_publish(cli_file *file, int overwrite);
void cli_file_abort(cli_file *file); /* fine after publish, and on a zeroed one */

/* "1.23 G", "45.0 k", "0": three digits and an SI prefix. */
void cli_si(double value, char *text, size_t size);
/* "1.2e-06", or "-" if nothing was compared. */
void cli_error_text(const hetab_error_stats *error, double value, char *text, size_t size);

/* A JSON string, whatever the bytes; control and non-UTF-8 bytes become '?'. */
json_t *cli_json_text(const char *text);
/* {samples, compared, max_rel, p99_rel, rms_rel, max_abs_below_floor, bad}; null without samples.
 */
json_t *cli_json_error(const hetab_error_stats *error);
/* Prints and frees; the exit status. */
int cli_json_print(json_t *json);

#endif
