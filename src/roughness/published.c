/* Tables of published per-scan values: does what they state follow from their rows, from one
 * another, and from what their rows may have been before they were rounded? */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <hetab/roughness.h>
#include "core/csv.h"

enum { MOST_PUBLISHED_COLUMNS = 64, MOST_BYTES = 16 << 20, FEWEST_SHARED = 2 };

static const char *const summaries[HETAB_SUMMARIES] = {"average", "deviation", "non-uniformity"};

const char *hetab_summary_name(int kind) {
  return summaries[kind];
}

const char *hetab_match_name(hetab_match verdict) {
  static const char *const names[] = {"agrees", "within rounding", "follows from its own row",
                                      "differs"};
  return names[verdict];
}

/* ---- reading ------------------------------------------------------------------------------- */

typedef struct reader {
  hetab_csv csv;
  hetab_published_table *table;
  size_t room[MOST_PUBLISHED_COLUMNS + 1]; /* of the columns' values, and of the rows' names */
} reader;

static int decimals_of(const char *number) {
  const char *point = strpbrk(number, ".,");
  return point ? (int)strspn(point + 1, "0123456789") : 0;
}

/* Which of the three summaries a row's name says it is; -1: a scan. */
static int summary_of(const char *name) {
  static const char *const starts[HETAB_SUMMARIES][3] = {
      {"average", "mean", NULL}, {"dev", "standard dev", "std"}, {"non", NULL, NULL}};
  for (int kind = 0; kind < HETAB_SUMMARIES; kind++)
    for (int i = 0; i < 3 && starts[kind][i]; i++)
      if (strncasecmp(name, starts[kind][i], strlen(starts[kind][i])) == 0)
        return kind;
  return -1;
}

static char *copy_name(const hetab_csv *csv, const char *name) {
  char *copy = hetab_alloc(csv->ctx, strlen(name) + 1, 1);
  return copy ? strcpy(copy, name) : NULL;
}

/* The names outlive the text they were read from. */
static hetab_status read_header(reader *r) {
  hetab_csv *csv = &r->csv;
  csv->ragged = true;
  HETAB_TRY(hetab_csv_header(csv, NULL, 0));
  if (csv->columns < 2)
    return hetab_csv_fail(csv, "a header such as scan,sigma_um,tau_um has to come first");
  if (csv->columns > MOST_PUBLISHED_COLUMNS)
    return hetab_csv_fail(csv, "more than %d columns", MOST_PUBLISHED_COLUMNS);
  r->table->columns = hetab_alloc(csv->ctx, csv->columns, sizeof *r->table->columns);
  HETAB_NEED(r->table->columns);
  for (size_t i = 1; i < csv->columns; i++) {
    hetab_published_column *c = &r->table->columns[r->table->count++];
    for (int kind = 0; kind < HETAB_SUMMARIES; kind++)
      c->stated[kind] = (double)NAN;
    if (!(c->name = copy_name(csv, csv->column[i].name)))
      return HETAB_ERR_MEMORY;
  }
  return HETAB_OK;
}

static hetab_status add_value(reader *r, size_t column, int kind) {
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
  c->decimals = decimals > c->decimals ? decimals : c->decimals;
  size_t rows = r->table->rows;
  HETAB_TRY(hetab_grow(csv->ctx, &c->values, sizeof(double), rows + 1, &r->room[column]));
  c->values[rows] = value;
  return HETAB_OK;
}

static hetab_status add_row(reader *r, int kind) {
  hetab_csv *csv = &r->csv;
  hetab_published_table *t = r->table;
  for (size_t i = 0; i + 1 < csv->count; i++)
    HETAB_TRY(add_value(r, i, kind));
  if (kind >= 0)
    return HETAB_OK;
  if (csv->count < csv->columns)
    return hetab_csv_fail(csv, "fewer fields than the header has");
  HETAB_TRY(hetab_grow(csv->ctx, &t->row_names, sizeof *t->row_names, t->rows + 1,
                       &r->room[MOST_PUBLISHED_COLUMNS]));
  if (!(t->row_names[t->rows] = copy_name(csv, csv->field[0])))
    return HETAB_ERR_MEMORY;
  t->rows++;
  return HETAB_OK;
}

static hetab_status read_rows(reader *r) {
  for (;;) {
    HETAB_TRY(hetab_csv_row(&r->csv));
    if (!r->csv.count)
      break;
    HETAB_TRY(add_row(r, summary_of(r->csv.field[0])));
  }
  if (r->table->rows < 2)
    return hetab_csv_fail(&r->csv, "fewer than two scans have no summary");
  return HETAB_OK;
}

static hetab_status read_table(hetab_context *ctx, const char *path, hetab_published_table *table) {
  reader r = {.table = table};
  HETAB_TRY(hetab_csv_open(ctx, path, MOST_BYTES, &r.csv));
  table->name = copy_name(&r.csv, path);
  hetab_status status = table->name ? read_header(&r) : HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = read_rows(&r);
  hetab_csv_clear(&r.csv);
  return status;
}

/* ---- summaries ----------------------------------------------------------------------------- */

/* Half of the last digit; a value half-way between two may be rounded either way. */
static double half_digit(int decimals, double value) {
  return 0.5 * pow(10, -decimals) * (1 + 1e-9) + 1e-12 * fabs(value);
}

/* The summaries of values that each lie as far outward from their mean as rounding hides (side 1),
 * or inward (-1), or as printed (0). */
static void summarise(const hetab_published_column *c, size_t rows, int side,
                      double out[HETAB_SUMMARIES]) {
  double mean = 0, shifted_mean = 0, squares = 0, half = half_digit(c->decimals, 0);
  for (size_t i = 0; i < rows; i++)
    mean += c->values[i] / (double)rows;
  for (int pass = 0; pass < 2; pass++)
    for (size_t i = 0; i < rows; i++) {
      double off = c->values[i] - mean;
      double value = mean + copysign(fmax(fabs(off) + side * half, 0), off);
      if (pass == 0)
        shifted_mean += value / (double)rows;
      else
        squares += (value - shifted_mean) * (value - shifted_mean);
    }
  out[HETAB_AVERAGE] = shifted_mean;
  out[HETAB_DEVIATION] = sqrt(squares / (double)(rows - 1));
  out[HETAB_NON_UNIFORMITY] = out[HETAB_DEVIATION] / shifted_mean;
}

/* What the column's rows give, and from where to where they may. */
static void bracket(const hetab_published_column *c, size_t rows, int kind, double out[3]) {
  double at[3][HETAB_SUMMARIES];
  for (int side = -1; side <= 1; side++)
    summarise(c, rows, side, at[side + 1]);
  out[0] = at[1][kind];
  out[1] = fmin(at[0][kind], at[2][kind]);
  out[2] = fmax(at[0][kind], at[2][kind]);
  if (kind == HETAB_AVERAGE) {
    out[1] = out[0] - half_digit(c->decimals, 0);
    out[2] = out[0] + half_digit(c->decimals, 0);
  }
}

/* ---- checks -------------------------------------------------------------------------------- */

typedef struct judge {
  hetab_context *ctx;
  hetab_published *all;
  size_t room;
} judge;

static hetab_match verdict_of(const hetab_published_check *c) {
  double half = half_digit(c->decimals, c->stated);
  if (fabs(c->value - c->stated) <= half)
    return HETAB_MATCH_EXACT;
  return c->low <= c->stated + half && c->high >= c->stated - half ? HETAB_MATCH_ROUNDING
                                                                   : HETAB_MATCH_NONE;
}

static hetab_status add_check(judge *j, hetab_published_check check, const double bracket[3],
                              double scale) {
  hetab_published *all = j->all;
  HETAB_TRY(hetab_grow(j->ctx, &all->checks, sizeof check, all->check_count + 1, &j->room));
  check.value = bracket[0] * scale;
  check.low = bracket[1] * scale;
  check.high = bracket[2] * scale;
  check.verdict = verdict_of(&check);
  all->checks[all->check_count++] = check;
  return HETAB_OK;
}

/* A non-uniformity is a ratio, or per cent where it is stated above 1. */
static double percent_of(int kind, double stated) {
  return kind == HETAB_NON_UNIFORMITY && stated >= 1 ? 100 : 1;
}

static hetab_status check_summaries(judge *j, size_t table) {
  const hetab_published_table *t = &j->all->tables[table];
  double value[3];
  for (size_t i = 0; i < t->count; i++)
    for (int kind = 0; kind < HETAB_SUMMARIES; kind++) {
      const hetab_published_column *c = &t->columns[i];
      if (isnan(c->stated[kind]))
        continue;
      bracket(c, t->rows, kind, value);
      const hetab_published_check check = {.table = table,
                                           .against = table,
                                           .row = summaries[kind],
                                           .column = c->name,
                                           .stated = c->stated[kind],
                                           .decimals = c->stated_decimals[kind]};
      HETAB_TRY(add_check(j, check, value, percent_of(kind, c->stated[kind])));
    }
  return HETAB_OK;
}

/* The column whose name starts with prefix[length] and word; NULL: none. */
static const hetab_published_column *find(const hetab_published_table *t, const char *prefix,
                                          size_t length, const char *word) {
  for (size_t i = 0; i < t->count; i++)
    if (strncasecmp(t->columns[i].name, prefix, length) == 0 &&
        strncasecmp(t->columns[i].name + length, word, strlen(word)) == 0)
      return &t->columns[i];
  return NULL;
}

/* slope = sigma / tau in every row; also of raw_slope, raw_sigma_um and raw_tau_um. */
static hetab_status check_slopes(judge *j, size_t table) {
  const hetab_published_table *t = &j->all->tables[table];
  for (size_t i = 0; i < t->count; i++) {
    const hetab_published_column *slope = &t->columns[i];
    const char *word = strcasestr(slope->name, "slope");
    size_t length = word ? (size_t)(word - slope->name) : 0;
    const hetab_published_column *sigma = find(t, slope->name, length, "sigma");
    const hetab_published_column *tau = find(t, slope->name, length, "tau");
    for (size_t row = 0; word && sigma && tau && row < t->rows; row++) {
      double s = sigma->values[row], l = tau->values[row];
      double ds = half_digit(sigma->decimals, 0), dl = half_digit(tau->decimals, 0);
      const double value[3] = {s / l, (s - ds) / (l + dl), (s + ds) / (l - dl)};
      const hetab_published_check check = {.table = table,
                                           .against = table,
                                           .row = t->row_names[row],
                                           .column = slope->name,
                                           .stated = slope->values[row],
                                           .decimals = slope->decimals};
      HETAB_TRY(add_check(j, check, value, 1));
    }
  }
  return HETAB_OK;
}

/* ---- tables against each other ------------------------------------------------------------- */

/* What the table `against` has for a column of another: an average, or the non-uniformity of its
 * sigma; false: nothing. */
static int counterpart(const hetab_published_table *against, const hetab_published_column *c,
                       double stated, double value[3], double *scale) {
  int kind = summary_of(c->name) == HETAB_NON_UNIFORMITY ? HETAB_NON_UNIFORMITY : HETAB_AVERAGE;
  const hetab_published_column *other = kind == HETAB_AVERAGE
                                            ? find(against, c->name, strlen(c->name), "")
                                            : find(against, "sigma", strlen("sigma"), "");
  *scale = percent_of(kind, stated);
  if (other)
    bracket(other, against->rows, kind, value);
  return other != NULL;
}

/* How many averages of the table `against` are in the row. */
static size_t shared(const hetab_published_table *t, size_t row,
                     const hetab_published_table *against) {
  size_t count = 0;
  for (size_t i = 0; i < t->count; i++) {
    const hetab_published_column *c = &t->columns[i];
    double value[3], scale, stated = c->values[row], half = half_digit(c->decimals, stated);
    count += counterpart(against, c, stated, value, &scale) && scale * value[1] <= stated + half &&
             scale * value[2] >= stated - half;
  }
  return count;
}

/* Its own row has the slope that the other table has not. */
static void excuse(hetab_published *all, hetab_published_check *check) {
  for (size_t i = 0; i < all->check_count; i++) {
    const hetab_published_check *own = &all->checks[i];
    if (check->verdict == HETAB_MATCH_NONE && own->table == check->table &&
        own->against == check->table && own->row == check->row && own->column == check->column &&
        own->verdict != HETAB_MATCH_NONE)
      check->verdict = HETAB_MATCH_OWN_ROW;
  }
}

static hetab_status compare_row(judge *j, size_t table, size_t row, size_t against) {
  const hetab_published_table *t = &j->all->tables[table];
  for (size_t i = 0; i < t->count; i++) {
    const hetab_published_column *c = &t->columns[i];
    double value[3], scale;
    if (!counterpart(&j->all->tables[against], c, c->values[row], value, &scale))
      continue;
    const hetab_published_check check = {.table = table,
                                         .against = against,
                                         .row = t->row_names[row],
                                         .column = c->name,
                                         .stated = c->values[row],
                                         .decimals = c->decimals};
    HETAB_TRY(add_check(j, check, value, scale));
    excuse(j->all, &j->all->checks[j->all->check_count - 1]);
  }
  return HETAB_OK;
}

/* A row that shares the most, and two at least, of another table's averages is about that table. */
static hetab_status compare(judge *j, size_t table, size_t against) {
  const hetab_published_table *t = &j->all->tables[table];
  size_t best = 0, most = 0, ties = 0;
  for (size_t row = 0; row < t->rows; row++) {
    size_t count = shared(t, row, &j->all->tables[against]);
    ties = count > most ? 1 : ties + (count == most);
    best = count > most ? row : best;
    most = count > most ? count : most;
  }
  return most >= FEWEST_SHARED && ties == 1 ? compare_row(j, table, best, against) : HETAB_OK;
}

/* ---- the whole ----------------------------------------------------------------------------- */

static hetab_status load_and_check(judge *j, const char *const *paths, size_t count) {
  j->all->count = count;
  for (size_t i = 0; i < count; i++)
    HETAB_TRY(read_table(j->ctx, paths[i], &j->all->tables[i]));
  for (size_t i = 0; i < count; i++) {
    HETAB_TRY(check_summaries(j, i));
    HETAB_TRY(check_slopes(j, i));
  }
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < count; k++)
      if (i != k)
        HETAB_TRY(compare(j, i, k));
  return HETAB_OK;
}

hetab_status hetab_published_load(hetab_context *ctx, const char *const *paths, size_t count,
                                  hetab_published **out) {
  hetab_status status = HETAB_ERR_MEMORY;
  *out = NULL;
  judge j = {.ctx = ctx, .all = hetab_alloc(ctx, 1, sizeof *j.all)};
  if (j.all)
    j.all->tables = hetab_alloc(ctx, count, sizeof *j.all->tables);
  if (j.all && j.all->tables)
    status = load_and_check(&j, paths, count);
  *out = j.all;
  HETAB_MADE(hetab_published, out, status);
}

double hetab_published_summary(const hetab_published_table *table, size_t column, int kind) {
  double at[HETAB_SUMMARIES];
  summarise(&table->columns[column], table->rows, 0, at);
  return at[kind];
}

static void free_table(hetab_published_table *t) {
  for (size_t i = 0; t->columns && i < t->count; i++) {
    free(t->columns[i].name);
    free(t->columns[i].values);
  }
  for (size_t i = 0; i < t->rows; i++)
    free(t->row_names[i]);
  free(t->columns);
  free(t->row_names);
  free(t->name);
}

void hetab_published_free(hetab_published *published) {
  if (!published)
    return;
  for (size_t i = 0; published->tables && i < published->count; i++)
    free_table(&published->tables[i]);
  free(published->tables);
  free(published->checks);
  free(published);
}
