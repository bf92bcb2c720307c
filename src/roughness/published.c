/* Tables of published per-scan values: do their summaries follow from their rows? */
#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <hetab/roughness.h>
#include "core/context.h"
#include "core/number.h"
#include "core/text.h"

enum { MOST_PUBLISHED_COLUMNS = 64 };

typedef struct published_reader {
  hetab_context *ctx;
  const char *path;
  size_t line;
  hetab_published *table;
  double *values[MOST_PUBLISHED_COLUMNS]; /* [rows] of each column */
} published_reader;

/* The next comma-separated field, blanks around it taken off; NULL at the end. */
static char *take_field(char **cursor) {
  char *field = *cursor;
  if (!field)
    return NULL;
  char *end = field + strcspn(field, ",");
  *cursor = *end ? end + 1 : NULL;
  *end = '\0';
  field += strspn(field, " \t");
  for (end = field + strlen(field); end > field && strchr(" \t\r", end[-1]); end--)
    end[-1] = '\0';
  return field;
}

static int decimals_of(const char *number) {
  const char *point = strchr(number, '.');
  return point ? (int)strspn(point + 1, "0123456789") : 0;
}

/* Which of the three summaries a row's name says it is; -1: a scan. */
static int summary_of(const char *name) {
  static const char *const starts[3][3] = {
      {"average", "mean", NULL}, {"dev", "standard dev", "std"}, {"non", NULL, NULL}};
  for (int kind = 0; kind < 3; kind++)
    for (int i = 0; i < 3 && starts[kind][i]; i++)
      if (strncasecmp(name, starts[kind][i], strlen(starts[kind][i])) == 0)
        return kind;
  return -1;
}

static hetab_status read_header(published_reader *r, char *line) {
  hetab_published *t = r->table;
  take_field(&line);
  for (char *field; (field = take_field(&line));) {
    if (t->count == MOST_PUBLISHED_COLUMNS)
      return hetab_fail(r->ctx, HETAB_ERR_PARSE, "%s:%zu: more than %d columns", r->path, r->line,
                        MOST_PUBLISHED_COLUMNS);
    hetab_published_column *c = &t->columns[t->count++];
    c->name = field;
    for (int i = 0; i < 3; i++)
      c->stated[i] = NAN;
  }
  if (!t->count)
    return hetab_fail(r->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: a header such as scan,sigma_um,tau_um has to come first", r->path,
                      r->line);
  return HETAB_OK;
}

static hetab_status add_value(published_reader *r, size_t column, int kind, const char *field) {
  hetab_published_column *c = &r->table->columns[column];
  double value = NAN;
  if (!*field && kind >= 0)
    return HETAB_OK;
  if (!hetab_number_parse(field, &value) || !isfinite(value))
    return hetab_fail(r->ctx, HETAB_ERR_PARSE, "%s:%zu: %s is '%.40s': it has to be a number",
                      r->path, r->line, c->name, field);
  int decimals = decimals_of(field);
  if (kind >= 0) {
    c->stated[kind] = value;
    c->stated_decimals[kind] = decimals;
    return HETAB_OK;
  }
  if (decimals > c->decimals)
    c->decimals = decimals;
  size_t rows = r->table->rows;
  double *larger = realloc(r->values[column], (rows + 1) * sizeof *larger);
  if (!larger)
    return hetab_fail(r->ctx, HETAB_ERR_MEMORY, "%s: out of memory", r->path);
  r->values[column] = larger;
  larger[rows] = value;
  return HETAB_OK;
}

static hetab_status read_row(published_reader *r, char *line) {
  char *name = take_field(&line);
  int kind = summary_of(name);
  size_t column = 0;
  for (char *field; (field = take_field(&line)); column++) {
    if (column == r->table->count)
      return hetab_fail(r->ctx, HETAB_ERR_PARSE, "%s:%zu: more fields than the header has", r->path,
                        r->line);
    HETAB_TRY(add_value(r, column, kind, field));
  }
  if (column < r->table->count && kind < 0)
    return hetab_fail(r->ctx, HETAB_ERR_PARSE, "%s:%zu: fewer fields than the header has", r->path,
                      r->line);
  r->table->rows += kind < 0;
  return HETAB_OK;
}

static hetab_status read_lines(published_reader *r, char *text) {
  bool header = false;
  while (text) {
    char *line = text, *end = strchr(text, '\n');
    text = end ? end + 1 : NULL;
    if (end)
      *end = '\0';
    r->line++;
    if (*line == '#' || !line[strspn(line, " \t\r")])
      continue;
    HETAB_TRY(header ? read_row(r, line) : read_header(r, line));
    header = true;
  }
  if (!header || r->table->rows < 2)
    return hetab_fail(r->ctx, HETAB_ERR_PARSE, "%s: fewer than two scans have no summary", r->path);
  return HETAB_OK;
}

/* ---- summaries ----------------------------------------------------------------------------- */

/* Rounded as the table has it; a value half-way between two may be rounded either way. */
static int rounds_to(double value, double stated, int decimals) {
  return fabs(value - stated) <= 0.5 * pow(10, -decimals) * (1 + 1e-9) + 1e-12 * fabs(stated);
}

/* A non-uniformity is a ratio, or per cent where it is stated above 1. */
static void summarise(hetab_published_column *c, const double *values, size_t rows) {
  double squares = 0;
  for (size_t i = 0; i < rows; i++)
    c->average += values[i] / (double)rows;
  for (size_t i = 0; i < rows; i++)
    squares += (values[i] - c->average) * (values[i] - c->average);
  c->deviation = sqrt(squares / (double)(rows - 1));
  c->non_uniformity = c->deviation / c->average;
  const double found[3] = {c->average, c->deviation,
                           c->non_uniformity * (c->stated[2] >= 1 ? 100 : 1)};
  for (int i = 0; i < 3; i++)
    c->agrees[i] = !isnan(c->stated[i]) && rounds_to(found[i], c->stated[i], c->stated_decimals[i]);
}

/* The names outlive the text they were read from. */
static hetab_status keep_names(published_reader *r) {
  hetab_status status = HETAB_OK;
  for (size_t i = 0; i < r->table->count; i++) {
    char *name = strdup(r->table->columns[i].name);
    r->table->columns[i].name = name;
    if (!name)
      status = hetab_fail(r->ctx, HETAB_ERR_MEMORY, "%s: out of memory", r->path);
  }
  return status;
}

static hetab_status read_table(published_reader *r, char *text) {
  hetab_status status = read_lines(r, text);
  hetab_status named = keep_names(r);
  HETAB_TRY(status);
  HETAB_TRY(named);
  for (size_t i = 0; i < r->table->count; i++)
    summarise(&r->table->columns[i], r->values[i], r->table->rows);
  return HETAB_OK;
}

hetab_status hetab_published_load(hetab_context *ctx, const char *path, hetab_published **out) {
  published_reader r = {.ctx = ctx, .path = path};
  char *text;
  size_t length;
  hetab_status status = HETAB_ERR_MEMORY;
  *out = NULL;
  HETAB_TRY(hetab_text_read(ctx, path, &text, &length));
  r.table = hetab_alloc(ctx, 1, sizeof *r.table);
  if (r.table)
    r.table->columns = hetab_alloc(ctx, MOST_PUBLISHED_COLUMNS, sizeof *r.table->columns);
  if (r.table && r.table->columns)
    status = read_table(&r, text);
  free(text);
  for (size_t i = 0; i < MOST_PUBLISHED_COLUMNS; i++)
    free(r.values[i]);
  if (status == HETAB_OK)
    *out = r.table;
  else
    hetab_published_free(r.table);
  return status;
}

void hetab_published_free(hetab_published *published) {
  if (!published)
    return;
  for (size_t i = 0; published->columns && i < published->count; i++)
    free((char *)published->columns[i].name);
  free(published->columns);
  free(published);
}
