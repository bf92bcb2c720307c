/* Tables of published per-scan values: do their summaries follow from their rows? */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <hetab/roughness.h>
#include "core/csv.h"

enum { MOST_PUBLISHED_COLUMNS = 64, MOST_BYTES = 16 << 20 };

typedef struct published_reader {
  hetab_csv csv;
  hetab_published *table;
  double *values[MOST_PUBLISHED_COLUMNS]; /* [rows] of each column */
  size_t room[MOST_PUBLISHED_COLUMNS];
} published_reader;

static int decimals_of(const char *number) {
  const char *point = strpbrk(number, ".,");
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

/* The names outlive the text they were read from. */
static hetab_status read_header(published_reader *r) {
  hetab_csv *csv = &r->csv;
  csv->ragged = true;
  HETAB_TRY(hetab_csv_header(csv, NULL, 0));
  if (csv->columns < 2)
    return hetab_csv_fail(csv, "a header such as scan,sigma_um,tau_um has to come first");
  if (csv->columns > MOST_PUBLISHED_COLUMNS)
    return hetab_csv_fail(csv, "more than %d columns", MOST_PUBLISHED_COLUMNS);
  for (size_t i = 1; i < csv->columns; i++) {
    hetab_published_column *c = &r->table->columns[r->table->count++];
    for (int kind = 0; kind < 3; kind++)
      c->stated[kind] = NAN;
    if (!(c->name = strdup(csv->column[i].name)))
      return hetab_fail(csv->ctx, HETAB_ERR_MEMORY, "%s: out of memory", csv->path);
  }
  return HETAB_OK;
}

static hetab_status add_value(published_reader *r, size_t column, int kind) {
  hetab_csv *csv = &r->csv;
  hetab_published_column *c = &r->table->columns[column];
  const char *field = csv->field[column + 1];
  double value;
  if (!*field && kind >= 0)
    return HETAB_OK;
  HETAB_TRY(hetab_csv_number(csv, column + 1, &hetab_rule_any, &value));
  int decimals = decimals_of(field);
  if (kind >= 0) {
    c->stated[kind] = value;
    c->stated_decimals[kind] = decimals;
    return HETAB_OK;
  }
  if (decimals > c->decimals)
    c->decimals = decimals;
  size_t rows = r->table->rows;
  HETAB_TRY(hetab_grow(csv->ctx, &r->values[column], sizeof(double), rows + 1, &r->room[column]));
  r->values[column][rows] = value;
  return HETAB_OK;
}

static hetab_status read_rows(published_reader *r) {
  hetab_csv *csv = &r->csv;
  for (;;) {
    HETAB_TRY(hetab_csv_row(csv));
    if (!csv->count)
      break;
    int kind = summary_of(csv->field[0]);
    for (size_t i = 0; i + 1 < csv->count; i++)
      HETAB_TRY(add_value(r, i, kind));
    if (csv->count < csv->columns && kind < 0)
      return hetab_csv_fail(csv, "fewer fields than the header has");
    r->table->rows += kind < 0;
  }
  if (r->table->rows < 2)
    return hetab_csv_fail(csv, "fewer than two scans have no summary");
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

static hetab_status read_table(published_reader *r) {
  HETAB_TRY(read_header(r));
  HETAB_TRY(read_rows(r));
  for (size_t i = 0; i < r->table->count; i++)
    summarise(&r->table->columns[i], r->values[i], r->table->rows);
  return HETAB_OK;
}

hetab_status hetab_published_load(hetab_context *ctx, const char *path, hetab_published **out) {
  published_reader r = {0};
  hetab_status status = HETAB_ERR_MEMORY;
  *out = NULL;
  HETAB_TRY(hetab_csv_open(ctx, path, MOST_BYTES, &r.csv));
  r.table = hetab_alloc(ctx, 1, sizeof *r.table);
  if (r.table)
    r.table->columns = hetab_alloc(ctx, MOST_PUBLISHED_COLUMNS, sizeof *r.table->columns);
  if (r.table && r.table->columns)
    status = read_table(&r);
  hetab_csv_clear(&r.csv);
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
