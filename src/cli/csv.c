#include "csv.h"

#include <string.h>

static csv_status read_line(csv_reader *reader) {
  csv_status status = CSV_OK;
  size_t length = 0;
  int c;
  while ((c = getc_unlocked(reader->stream)) != EOF && c != '\n') {
    if (length == CSV_MAX_LINE - 1)
      return CSV_LONG;
    if (c == 0)
      status = CSV_BINARY;
    reader->text[length++] = (char)c;
  }
  if (ferror(reader->stream))
    return CSV_FAILED;
  if (c == EOF && length == 0)
    return CSV_END;
  if (length > 0 && reader->text[length - 1] == '\r')
    length--;
  reader->text[length] = 0;
  reader->length = length;
  return status;
}

static void drop_byte_order_mark(csv_reader *reader) {
  static const char mark[] = "\xEF\xBB\xBF";
  size_t size = sizeof mark - 1;
  if (reader->length < size || memcmp(reader->text, mark, size) != 0)
    return;
  reader->length -= size;
  memmove(reader->text, reader->text + size, reader->length + 1);
}

csv_status csv_read(csv_reader *reader) {
  csv_status status;
  do {
    reader->line++;
    status = read_line(reader);
    if (status == CSV_OK && reader->line == 1)
      drop_byte_order_mark(reader);
  } while (status == CSV_OK && reader->text[strspn(reader->text, " \t")] == 0);
  return status;
}

/* Unquotes the field at `from` in place; returns what follows its closing quote, NULL if none. */
static char *unquote(char *from) {
  char *to = from;
  for (from++; *from; from++) {
    if (*from == '"' && *++from != '"') {
      char *rest = from;
      *to = 0;
      return rest;
    }
    *to++ = *from;
  }
  return NULL;
}

static char *trim_end(char *field) {
  size_t length = strlen(field);
  while (length > 0 && strchr(" \t", field[length - 1]))
    length--;
  field[length] = 0;
  return field;
}

size_t csv_split(char *line, char **fields, size_t max) {
  for (size_t count = 0;; count++) {
    line += strspn(line, " \t");
    char *field = line;
    int quoted = *line == '"';
    if (quoted && !(line = unquote(line)))
      return 0;
    line += strcspn(line, ",");
    int last = *line == 0;
    *line = 0;
    if (count < max)
      fields[count] = quoted ? field : trim_end(field);
    if (last)
      return count + 1;
    line++;
  }
}
