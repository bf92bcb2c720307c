/* What the program writes: text files, JSON and aligned tables. */
#pragma once

#include <stddef.h>
#include <stdio.h>
#include <jansson.h>
#include <hetab/hetab.h>

/* Whether path may become an output file. Returns 0 after printing why not. */
int cli_output_allowed(hetab_context *ctx, const char *path, int overwrite);

/* A text file in the making, in memory. */
typedef struct cli_text {
  FILE *stream;
  char *text;
  size_t size;
} cli_text;

/* -1 to go on, else the exit status after printing why. */
int cli_text_begin(cli_text *text);
int cli_text_save(cli_text *text, hetab_context *ctx, const char *path, int overwrite);
void cli_text_free(cli_text *text); /* fine after save, and on a zeroed one */

/* Who reads such a file: what tests/test_cli_rgl.sh and tests/renderers check, and no more. */
const char *cli_readers(hetab_format format, int is_spectral);

/* Before the first JSON: where memory runs out for any of it, none is printed. */
void cli_json_begin(void);
/* A JSON string, whatever the bytes; control and non-UTF-8 bytes become '?'. */
json_t *cli_json_text(const char *text);
/* JSON has no NaN: null for what is not finite. */
json_t *cli_json_number(double value);
/* The list of `item`, which may use i, for i = 0 ... count - 1. */
#define CLI_JSON_LIST(count, item)                                                                 \
  ({                                                                                               \
    json_t *list_ = json_array();                                                                  \
    for (size_t i = 0; i < (size_t)(count); i++)                                                   \
      json_array_append_new(list_, item);                                                          \
    list_;                                                                                         \
  })
/* The list of values[i * stride]. */
json_t *cli_json_numbers(const double *values, size_t count, size_t stride);
/* {samples, compared, max_sampled, share_above, p99_rel, rms_rel, max_abs_below_floor, bad}; null
 * without samples.
 */
json_t *cli_json_error(const hetab_error_stats *error);
/* Prints and frees; the exit status. */
int cli_json_print(json_t *json);
