#include "shader/shader_parts.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"

static const char *find_template(const char *name, size_t length) {
  for (const hetab_shader_template *t = hetab_shader_templates; t->name; t++)
    if (strlen(t->name) == length && strncmp(t->name, name, length) == 0)
      return t->text;
  return NULL;
}

/* The length of the mark @NAME@ or @file.name@ at `text`, 0 if there is none. */
static size_t mark_length(const char *text) {
  size_t i = 1;
  while (isalnum((unsigned char)text[i]) || text[i] == '_' || text[i] == '.')
    i++;
  return i > 1 && text[i] == '@' ? i + 1 : 0;
}

static hetab_status expand(const hetab_shader_input *input, const char *text, FILE *out) {
  for (; *text; text++) {
    size_t length = *text == '@' ? mark_length(text) : 0;
    hetab_shader_part_fn part = length ? hetab_shader_part(text + 1, length - 2) : NULL;
    const char *inner = length ? find_template(text + 1, length - 2) : NULL;
    if (part)
      HETAB_TRY(part(input, out));
    else if (inner)
      HETAB_TRY(expand(input, inner, out));
    else
      fputc(*text, out);
    if (part || inner)
      text += length - 1;
  }
  return HETAB_OK;
}

hetab_status hetab_shader_text(hetab_context *ctx, const hetab_surface *surface,
                               hetab_shader_language language, char **text) {
  static const char *const names[] = {[HETAB_SHADER_C] = "he_torrance.c99",
                                      [HETAB_SHADER_GLSL] = "he_torrance.glsl",
                                      [HETAB_SHADER_PYTHON] = "he_torrance.py",
                                      [HETAB_SHADER_MITSUBA] = "mitsuba.py",
                                      [HETAB_SHADER_HTML] = "explorer.html"};
  const hetab_shader_input input = {ctx, surface};
  size_t size;
  *text = NULL;
  if ((unsigned)language >= sizeof names / sizeof *names)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "there is no language number %d", (int)language);
  FILE *out = open_memstream(text, &size);
  if (!out)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  hetab_status status =
      expand(&input, find_template(names[language], strlen(names[language])), out);
  bool failed = ferror(out) != 0;
  if ((fclose(out) != 0 || failed) && status == HETAB_OK)
    status = hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  if (status == HETAB_OK)
    return HETAB_OK;
  free(*text);
  *text = NULL;
  return status;
}
