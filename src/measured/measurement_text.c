#include "measured/measurement_text.h"

#include <string.h>

static const char blanks[] = " \t\r";

static char *trim(char *text) {
  text += strspn(text, blanks);
  size_t length = strlen(text);
  while (length && strchr(blanks, text[length - 1]))
    text[--length] = '\0';
  return text;
}

/* Up to the separator, which is overwritten; *rest is what follows, or NULL. */
static char *cut(char **rest, char separator) {
  char *start = *rest, *end = strchr(start, separator);
  *rest = end ? end + 1 : NULL;
  if (end)
    *end = '\0';
  return start;
}

char *hetab_cut_line(char **text, size_t *line) {
  if (!*text || !**text)
    return NULL;
  ++*line;
  return trim(cut(text, '\n'));
}

char *hetab_cut_content(char **text, size_t *line) {
  for (char *content; (content = hetab_cut_line(text, line));) {
    content[strcspn(content, "#")] = '\0';
    content = trim(content);
    if (*content)
      return content;
  }
  return NULL;
}

char *hetab_cut_field(char **line, char separator) {
  return trim(cut(line, separator));
}

size_t hetab_count_fields(const char *line, char separator) {
  size_t count = 1;
  for (; (line = strchr(line, separator)); line++)
    count++;
  return count;
}
