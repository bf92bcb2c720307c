#include "output.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

/* ---- files --------------------------------------------------------------------------------- */

int cli_output_allowed(hetab_context *ctx, const char *path, int overwrite) {
  hetab_status status = hetab_output_check(ctx, path, overwrite);
  if (status == HETAB_ERR_EXISTS)
    cli_fail("%s exists: use --force to overwrite it", path);
  else if (status != HETAB_OK)
    cli_fail_context(ctx);
  return status == HETAB_OK;
}

int cli_text_begin(cli_text *text) {
  *text = (cli_text){0};
  text->stream = open_memstream(&text->text, &text->size);
  return text->stream ? -1 : cli_fail("out of memory");
}

int cli_text_save(cli_text *text, hetab_context *ctx, const char *path, int overwrite) {
  int status = -1, failed = ferror(text->stream);
  failed |= fclose(text->stream); /* which brings text and size up to date */
  text->stream = NULL;
  if (failed)
    status = cli_fail("%s: out of memory", path);
  else if (hetab_text_save(ctx, path, text->text, text->size, overwrite) != HETAB_OK)
    status = cli_fail_context(ctx);
  cli_text_free(text);
  return status;
}

void cli_text_free(cli_text *text) {
  if (text->stream)
    fclose(text->stream);
  free(text->text);
  *text = (cli_text){0};
}

/* ---- JSON ---------------------------------------------------------------------------------- */

/* Lists and objects are silent about what they were too short of memory to hold. */
static bool json_lacks;

static void *json_memory(size_t size) {
  void *memory = malloc(size);
  json_lacks |= !memory;
  return memory;
}

void cli_json_begin(void) {
  json_set_alloc_funcs(json_memory, free);
}

json_t *cli_json_text(const char *text) {
  json_t *json = json_string(text);
  char *copy = json ? NULL : strdup(text);
  if (!copy)
    return json;
  for (char *c = copy; *c; c++)
    if (*c < ' ' || *c > '~')
      *c = '?';
  json = json_string(copy);
  free(copy);
  return json;
}

json_t *cli_json_number(double value) {
  return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_numbers(const double *values, size_t count, size_t stride) {
  return CLI_JSON_LIST(count, cli_json_number(values[i * stride]));
}

json_t *cli_json_error(const hetab_error_stats *error) {
  if (!error->samples)
    return json_null();
  return json_pack("{sI sI sf sf sf sf sf sI}", "samples", (json_int_t)error->samples, "compared",
                   (json_int_t)error->compared, "max_sampled", error->max_rel, "share_above",
                   hetab_error_share_above(error), "p99_rel", error->p99_rel, "rms_rel",
                   error->rms_rel, "max_abs_below_floor", error->max_abs_below, "bad",
                   (json_int_t)error->bad);
}

int cli_json_print(json_t *json) {
  bool whole = json && !json_lacks &&
               json_dumpf(json, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(12)) == 0;
  if (whole)
    putchar('\n');
  json_decref(json);
  return whole || ferror(stdout) ? CLI_OK : cli_fail("out of memory for JSON");
}

const char *cli_readers(hetab_format format, int is_spectral) {
  static const char *const readers[] = {
      [HETAB_FORMAT_H5] = "hetab and whatever reads HDF5",
      [HETAB_FORMAT_MERL] = "readers of the MERL database",
      [HETAB_FORMAT_RGL] = "Mitsuba 3's rgb variants and powitacq_rgb",
      [HETAB_FORMAT_EXR] = "OpenEXR readers that know several parts"};
  return format == HETAB_FORMAT_RGL && is_spectral
             ? "pbrt-v4, powitacq and Mitsuba 3's spectral variants"
             : readers[format];
}
