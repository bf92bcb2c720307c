/* Lines, fields, rows and numbers of delimited text. */
#include "core/csv.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "core/text.h"

enum { MOST_STREAM_LINE = 65535, MOST_NUMBER = 64 };

hetab_status hetab_csv_fail(const hetab_csv *csv, const char *format, ...) {
  char text[800];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  return hetab_fail(csv->ctx, HETAB_ERR_PARSE, "%s:%zu: %s", csv->path, csv->line ? csv->line : 1,
                    text);
}

/* ---- life ---------------------------------------------------------------------------------- */

void hetab_csv_of_text(hetab_context *ctx, const char *path, const char *text, hetab_csv *csv) {
  *csv = (hetab_csv){.ctx = ctx, .path = path, .text = text, .next = text, .body = text};
}

void hetab_csv_of_stream(hetab_context *ctx, const char *path, FILE *stream, hetab_csv *csv) {
  *csv = (hetab_csv){.ctx = ctx, .path = path, .stream = stream};
}

hetab_status hetab_csv_open(hetab_context *ctx, const char *path, size_t most_bytes,
                            hetab_csv *csv) {
  char *text;
  size_t length;
  *csv = (hetab_csv){0};
  HETAB_TRY(hetab_text_read_any(ctx, path, most_bytes, &text, &length));
  hetab_csv_of_text(ctx, path, text, csv);
  csv->owned = text;
  return HETAB_OK;
}

void hetab_csv_forget_header(hetab_csv *csv) {
  for (size_t i = 0; i < csv->columns; i++)
    free(csv->column[i].name);
  free(csv->column);
  csv->column = NULL;
  csv->columns = 0;
}

void hetab_csv_clear(hetab_csv *csv) {
  hetab_csv_forget_header(csv);
  free(csv->owned);
  free(csv->line_text);
  free(csv->work);
  free(csv->field);
  *csv = (hetab_csv){0};
}

/* ---- lines --------------------------------------------------------------------------------- */

/* To csv->line_text, without its end; *length is SIZE_MAX at the end of the stream. */
static hetab_status stream_line(hetab_csv *csv, size_t *length) {
  int c;
  *length = 0;
  bool nul = false;
  HETAB_TRY(hetab_grow(csv->ctx, &csv->line_text, 1, MOST_STREAM_LINE + 1, &csv->line_room));
  while ((c = getc_unlocked(csv->stream)) != EOF && c != '\n') {
    if (*length == MOST_STREAM_LINE)
      return hetab_csv_fail(csv, "the line is longer than %d bytes: shorten it", MOST_STREAM_LINE);
    nul |= c == 0;
    csv->line_text[(*length)++] = (char)c;
  }
  if (ferror(csv->stream))
    return hetab_fail(csv->ctx, HETAB_ERR_IO, "%s: %s", csv->path, strerror(errno));
  if (nul)
    return hetab_csv_fail(csv, "the line holds a NUL byte: not CSV text");
  if (c == EOF && *length == 0)
    *length = SIZE_MAX;
  else if (*length > 0 && csv->line_text[*length - 1] == '\r')
    --*length;
  return HETAB_OK;
}

static hetab_status text_line(hetab_csv *csv, size_t *length) {
  *length = *csv->next ? strcspn(csv->next, "\r\n") : SIZE_MAX;
  if (*length == SIZE_MAX)
    return HETAB_OK;
  HETAB_TRY(hetab_grow(csv->ctx, &csv->line_text, 1, *length + 1, &csv->line_room));
  memcpy(csv->line_text, csv->next, *length);
  csv->next += *length;
  csv->next += csv->next[0] == '\r' && csv->next[1] == '\n' ? 2 : *csv->next != '\0';
  return HETAB_OK;
}

/* '#' before a separator is the name of a column. */
static bool is_comment(const char *text) {
  return *text == '#' && !strchr(",;\t", text[1] ? text[1] : ' ');
}

hetab_status hetab_csv_line(hetab_csv *csv) {
  size_t length;
  do {
    csv->line++;
    csv->content = NULL;
    HETAB_TRY(hetab_go_on(csv->ctx, csv->line));
    HETAB_TRY(csv->stream ? stream_line(csv, &length) : text_line(csv, &length));
    if (length == SIZE_MAX) {
      csv->line -= csv->line > 1;
      return HETAB_OK;
    }
    csv->line_text[length] = '\0';
    csv->content = csv->line_text;
    if (csv->stream && csv->line == 1 && strncmp(csv->content, "\xEF\xBB\xBF", 3) == 0)
      csv->content += 3;
    csv->content += strspn(csv->content, " ");
  } while (!csv->content[strspn(csv->content, " \t")] || is_comment(csv->content));
  return HETAB_OK;
}

/* ---- fields -------------------------------------------------------------------------------- */

/* Unquotes the field at `from` in place; returns what follows its closing quote, NULL if none. */
static char *unquote(char *from) {
  char *to = from;
  for (from++; *from; from++) {
    if (*from == '"' && *++from != '"') {
      char *rest = from;
      *to = '\0';
      return rest;
    }
    *to++ = *from;
  }
  return NULL;
}

static void trim_end(char *field) {
  size_t length = strlen(field);
  while (length > 0 && strchr(" \t", field[length - 1]))
    field[--length] = '\0';
}

/* In the last column '#' starts a comment; before it (or where the columns are not known) only
 * between blanks, or where no separator follows. */
static void cut_comment(const hetab_csv *csv, char *field, size_t index, const char *separator) {
  bool last = csv->columns && index + 1 >= csv->columns;
  for (char *mark = field; (mark = strchr(mark, '#')); mark++) {
    bool apart = mark > field && strchr(" \t", mark[-1]);
    bool ends = apart && (strchr(" \t", mark[1]) || !strpbrk(mark, separator));
    if (last || (!csv->columns && ends)) {
      *mark = '\0';
      return;
    }
  }
}

hetab_status hetab_csv_split(hetab_csv *csv, char separator) {
  const char *blanks = separator == '\t' ? " " : " \t";
  const char marks[] = {separator, separator == ' ' ? '\t' : '\0', '\0'};
  size_t size = strlen(csv->content) + 1;
  HETAB_TRY(hetab_grow(csv->ctx, &csv->work, 1, size, &csv->work_room));
  memcpy(csv->work, csv->content, size);
  csv->count = 0;
  for (char *line = csv->work;;) {
    line += strspn(line, blanks);
    if (separator == ' ' && !*line)
      return HETAB_OK;
    char *field = line;
    bool quoted = *line == '"';
    if (quoted && !(line = unquote(line)))
      return hetab_csv_fail(csv, "a double quote is not closed: close or remove it");
    cut_comment(csv, line, csv->count, marks);
    line += strcspn(line, marks);
    bool last = !*line;
    *line = '\0';
    if (!quoted)
      trim_end(field);
    HETAB_TRY(
        hetab_grow(csv->ctx, &csv->field, sizeof *csv->field, csv->count + 1, &csv->field_room));
    csv->field[csv->count++] = field;
    if (last)
      return HETAB_OK;
    line++;
  }
}

/* ---- rows ---------------------------------------------------------------------------------- */

hetab_status hetab_csv_row(hetab_csv *csv) {
  csv->count = 0;
  HETAB_TRY(hetab_csv_line(csv));
  return csv->content ? hetab_csv_fields(csv) : HETAB_OK;
}

hetab_status hetab_csv_fields(hetab_csv *csv) {
  HETAB_TRY(hetab_csv_split(csv, csv->separator));
  while (csv->count > csv->columns && !*csv->field[csv->count - 1])
    csv->count--;
  if (csv->count == csv->columns || (csv->ragged && csv->count < csv->columns))
    return HETAB_OK;
  return hetab_csv_fail(csv, "%zu field%s where the header names %zu: %s", csv->count,
                        csv->count == 1 ? "" : "s", csv->columns,
                        csv->count < csv->columns
                            ? "add the missing value or remove the column; is the line cut off?"
                            : "remove the value or name its column");
}

/* ---- numbers ------------------------------------------------------------------------------- */

/* A decimal comma becomes a point, unless the file has points. Sets *mark to what was met. */
static bool parse_number(const hetab_csv *csv, const char *text, double *value, char *mark) {
  char number[MOST_NUMBER];
  size_t length = strlen(text);
  const char *comma = strchr(text, ',');
  *mark = comma ? ',' : strchr(text, '.') ? '.' : '\0';
  if (*mark && csv->decimal && csv->decimal != *mark)
    return false;
  if (!comma)
    return hetab_number_parse(text, value);
  if (length >= sizeof number || strchr(text, '.'))
    return false;
  memcpy(number, text, length + 1);
  number[comma - text] = '.';
  return hetab_number_parse(number, value);
}

bool hetab_csv_is_number(const hetab_csv *csv, const char *text) {
  double value;
  char mark;
  return parse_number(csv, text, &value, &mark);
}

bool hetab_csv_parse(hetab_csv *csv, const char *text, double *value) {
  char mark;
  if (!parse_number(csv, text, value, &mark))
    return !strpbrk(text, "0123456789") && hetab_number_or_missing(text, value);
  if (mark)
    csv->decimal = mark;
  if (!isfinite(*value)) /* more than a double holds */
    *value = (double)NAN;
  return true;
}

static const char *name_of(const hetab_csv *csv, size_t column) {
  return csv->column ? csv->column[column].name : "?";
}

hetab_status hetab_csv_number(hetab_csv *csv, size_t column, const hetab_rule *rule,
                              double *value) {
  const char *text = csv->field[column];
  char mark;
  if (!parse_number(csv, text, value, &mark))
    return hetab_csv_fail(csv, "column '%.40s': '%.40s' is not a number: give %s%s",
                          name_of(csv, column), text, rule->wanted,
                          strchr(text, ',') ? ", with '.' before the decimals" : "");
  if (mark)
    csv->decimal = mark;
  double unit = csv->column ? csv->column[column].unit : 0;
  if (unit > 0)
    *value = hetab_in_unit(*value, unit);
  if (!(*value >= rule->min && *value <= rule->max))
    return hetab_csv_fail(csv, "column '%.40s': %.40s is out of range: give %s",
                          name_of(csv, column), text, rule->wanted);
  return HETAB_OK;
}

hetab_status hetab_csv_value(hetab_csv *csv, size_t column, double *value) {
  if (!hetab_csv_parse(csv, csv->field[column], value))
    return hetab_csv_fail(csv,
                          "column '%.40s': '%.40s' is not a number: give numbers%s, or nan for a "
                          "value that is missing",
                          name_of(csv, column), csv->field[column],
                          strchr(csv->field[column], ',') ? " with a decimal point" : "");
  double unit = csv->column ? csv->column[column].unit : 0;
  if (unit > 0)
    *value = hetab_in_unit(*value, unit);
  return HETAB_OK;
}
