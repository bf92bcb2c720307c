/* Writing a surface as YAML that reads back to the same doubles. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "surface/index_parts.h"
#include "core/number.h"
#include "surface/surface_parts.h"
#include "surface/wavelengths.h"

/* Letters, digits, '_' and '-' after a letter: what YAML takes for text without quotes, but for the
 * words of YAML 1.1 that other readers take for truth values or nothing. */
static bool is_plain(const char *text) {
  static const char *const words[] = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (strcasecmp(text, words[i]) == 0)
      return false;
  if (!isalpha((unsigned char)*text))
    return false;
  for (; *text; text++)
    if (!isalnum((unsigned char)*text) && *text != '_' && *text != '-')
      return false;
  return true;
}

static void write_text(FILE *out, const char *text) {
  if (is_plain(text)) {
    fputs(text, out);
    return;
  }
  fputc('"', out);
  for (; *text; text++) {
    unsigned char c = (unsigned char)*text;
    if (c < ' ' || c == 0x7f)
      fprintf(out, "\\x%02X", c);
    else
      fprintf(out, c == '"' || c == '\\' ? "\\%c" : "%c", c);
  }
  fputc('"', out);
}

static void write_number(FILE *out, const char *key, double value) {
  char text[HETAB_NUMBER_TEXT];
  hetab_number_format(value, text);
  fprintf(out, "%s: %s\n", key, text);
}

static void write_bounds(FILE *out, const char *key, const double bounds[2]) {
  if (bounds[1] == 0)
    return;
  fprintf(out, "%s: ", key);
  hetab_numbers_write(out, bounds, 2);
}

static void write_index(FILE *out, const hetab_index *index) {
  char n[HETAB_NUMBER_TEXT], k[HETAB_NUMBER_TEXT];
  switch (index->origin) {
  case HETAB_INDEX_METAL:
    fprintf(out, "index: %s # %s\n", index->symbol, index->source);
    break;
  case HETAB_INDEX_FILE:
    fputs("index: {file: ", out);
    write_text(out, index->source);
    fputs("}\n", out);
    break;
  case HETAB_INDEX_CONSTANT:
    hetab_number_format(index->n.values[0], n);
    hetab_number_format(index->k.values[0], k);
    fprintf(out, "index: {n: %s, k: %s}\n", n, k);
    break;
  }
}

static void write_diffuse(FILE *out, const hetab_surface *surface) {
  const char *key = surface->diffuse_is_brdf ? "diffuse_brdf" : "diffuse_reflectance";
  if (surface->diffuse_count == 1) {
    write_number(out, key, surface->diffuse[0]);
    return;
  }
  fprintf(out, "%s: ", key);
  hetab_numbers_write(out, surface->diffuse, surface->diffuse_count);
}

static hetab_status write_surface(hetab_context *ctx, const hetab_surface *surface,
                                  const double *lambda_um, FILE *out) {
  fputs("name: ", out);
  write_text(out, surface->name);
  fputc('\n', out);
  write_number(out, "sigma0_um", surface->sigma0_um);
  write_number(out, "tau_um", surface->tau_um);
  write_bounds(out, "sigma0_bounds_um", surface->sigma0_bounds_um);
  write_bounds(out, "tau_bounds_um", surface->tau_bounds_um);
  write_index(out, surface->index);
  if (surface->extrapolate)
    fputs("extrapolate_index: true\n", out);
  write_diffuse(out, surface);
  return hetab_wavelengths_write(ctx, out, lambda_um, surface->count);
}

static hetab_status write_to_memory(hetab_context *ctx, const hetab_surface *surface,
                                    const double *lambda_um, char **text) {
  char *buffer = NULL;
  size_t length;
  FILE *out = open_memstream(&buffer, &length);
  if (!out)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the text of a surface");
  hetab_status status = write_surface(ctx, surface, lambda_um, out);
  bool failed = ferror(out);
  failed |= fclose(out) != 0;
  if (failed && status == HETAB_OK)
    status = hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the text of a surface");
  if (status != HETAB_OK) {
    free(buffer);
    return status;
  }
  *text = buffer;
  return HETAB_OK;
}

hetab_status hetab_surface_yaml(hetab_context *ctx, const hetab_surface *surface, char **text) {
  *text = NULL;
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, surface->count, sizeof *lambda_um);
  HETAB_NEED(lambda_um);
  for (size_t i = 0; i < surface->count; i++)
    lambda_um[i] = surface->bands[i].lambda_um;
  return write_to_memory(ctx, surface, lambda_um, text);
}
