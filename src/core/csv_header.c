/* Where the table begins, and what its columns are. */
#include "core/csv.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_LINES_ABOVE = 1000 };

typedef struct place {
  const char *next;
  size_t line;
} place;

/* Below a line that may be a header. */
typedef enum found_below { NOTHING, NUMBERS, NO_HEADER } found_below;

static place here(const hetab_csv *csv) {
  return (place){csv->next, csv->line};
}

static void go_to(hetab_csv *csv, place to) {
  csv->next = to.next;
  csv->line = to.line;
}

/* ---- names --------------------------------------------------------------------------------- */

static int find_wanted(const char *name, const hetab_csv_wanted *wanted, size_t count,
                       hetab_csv_column *c) {
  int best = 0, found = HETAB_CSV_OTHER;
  c->unit = 0;
  for (size_t i = 0; i < count && best < 2; i++) {
    double its_unit;
    int likeness = hetab_names_quantity(name, wanted[i].names, wanted[i].quantity, &its_unit);
    if (likeness <= best)
      continue;
    best = likeness;
    found = (int)i;
    c->unit = its_unit;
    c->strange = best == 1;
  }
  return found;
}

/* How many fields of the line at hand are wanted, were it separated so; names are no numbers. */
static size_t count_wanted(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count,
                           char separator) {
  size_t found = 0;
  hetab_csv_column column;
  if (hetab_csv_split(csv, separator) != HETAB_OK)
    return 0;
  for (size_t i = 0; i < csv->count; i++) {
    if (hetab_csv_is_number(csv, csv->field[i]) || strchr(csv->field[i], '\t'))
      return 0;
    found += find_wanted(csv->field[i], wanted, count, &column) >= 0;
  }
  return found;
}

/* Leaves the line split as it reads best; returns how many wanted columns that gives. */
static size_t split_header(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count) {
  static const char separators[] = ";\t, ";
  size_t most = 0, fields = 0;
  csv->separator = '\0';
  for (const char *s = separators; *s; s++) {
    if (*s == ',' && csv->decimal == ',')
      continue;
    size_t found = count_wanted(csv, wanted, count, *s);
    bool better = found > most || (found == most && csv->count > fields && *s != ' ');
    if (!better && csv->separator)
      continue;
    most = found;
    fields = csv->count;
    csv->separator = *s;
  }
  return hetab_csv_split(csv, csv->separator) == HETAB_OK ? most : 0;
}

static hetab_status name_columns(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count) {
  while (csv->count > 1 && !*csv->field[csv->count - 1])
    csv->count--;
  hetab_csv_forget_header(csv);
  csv->column = hetab_alloc(csv->ctx, csv->count, sizeof *csv->column);
  HETAB_NEED(csv->column);
  for (; csv->columns < csv->count; csv->columns++) {
    hetab_csv_column *c = &csv->column[csv->columns];
    char number[24];
    snprintf(number, sizeof number, "%zu", csv->columns + 1);
    c->name = strdup(csv->named ? csv->field[csv->columns] : number);
    if (!c->name)
      return hetab_fail(csv->ctx, HETAB_ERR_MEMORY, "%s: out of memory", csv->path);
    c->wanted = csv->named ? find_wanted(c->name, wanted, count, c) : HETAB_CSV_OTHER;
    c->quantity = c->wanted >= 0 ? wanted[c->wanted].quantity : HETAB_PLAIN;
  }
  csv->head_line = csv->line;
  return HETAB_OK;
}

/* ---- rows below ---------------------------------------------------------------------------- */

/* Whether the fields that count are numbers or missing, one of them a number. */
static bool holds_numbers(const hetab_csv *csv) {
  bool any = false;
  for (size_t i = 0; i < (csv->named ? csv->columns : csv->count); i++) {
    if (csv->named && csv->column[i].wanted == HETAB_CSV_OTHER)
      continue;
    bool number = i < csv->count && hetab_csv_is_number(csv, csv->field[i]);
    if (!number && (i >= csv->count || !hetab_number_missing(csv->field[i])))
      return false;
    any |= number;
  }
  return any;
}

/* A row of units: one for every wanted length and angle, and no numbers. */
static bool take_units(hetab_csv *csv) {
  bool any = false;
  for (size_t i = 0; i < csv->columns; i++) {
    const hetab_csv_column *c = &csv->column[i];
    bool has = i < csv->count && hetab_unit(c->quantity, csv->field[i]) > 0;
    if ((c->quantity != HETAB_PLAIN && !has) ||
        (i < csv->count && hetab_csv_is_number(csv, csv->field[i])))
      return false;
    any |= has;
  }
  for (size_t i = 0; any && i < csv->columns; i++)
    if (csv->column[i].quantity != HETAB_PLAIN)
      csv->column[i].unit = hetab_unit(csv->column[i].quantity, csv->field[i]);
  return any;
}

/* Some headers have two tabs between names where the rows have one. */
static void drop_empty_names(hetab_csv *csv) {
  size_t kept = 0;
  for (size_t i = 0; i < csv->columns; i++)
    kept += *csv->column[i].name != '\0';
  if (kept != csv->count)
    return;
  kept = 0;
  for (size_t i = 0; i < csv->columns; i++) {
    if (*csv->column[i].name)
      csv->column[kept++] = csv->column[i];
    else
      free(csv->column[i].name);
  }
  csv->columns = kept;
}

/* Leaves the line split as numbers, if it is nothing else. */
static bool split_numbers(hetab_csv *csv) {
  for (const char *s = ";\t, "; *s; s++) {
    if ((*s != ' ' && !strchr(csv->content, *s)) || (*s == ',' && csv->decimal == ','))
      continue;
    if (hetab_csv_split(csv, *s) == HETAB_OK && holds_numbers(csv)) {
      csv->separator = *s;
      return true;
    }
  }
  return false;
}

/* No header, the line at hand being below it: a word above rows of several numbers, or a line of a
 * list of keys and values. */
static bool is_no_header(hetab_csv *csv) {
  if (csv->columns == 2 && csv->count == 2 && csv->column[0].wanted == HETAB_CSV_OTHER)
    return !hetab_csv_is_number(csv, csv->field[0]) && !hetab_number_missing(csv->field[0]);
  if (csv->columns != 1)
    return false;
  char separator = csv->separator;
  csv->named = false;
  bool rows = split_numbers(csv) && csv->count > 1 && *csv->field[csv->count - 1];
  csv->named = true;
  csv->separator = separator;
  return rows;
}

/* Looks at the next line; stays before it, unless it is the units. */
static hetab_status look_below(hetab_csv *csv, found_below *below) {
  place before = here(csv);
  *below = NOTHING;
  for (int lines = 0; lines < 2; lines++) {
    HETAB_TRY(hetab_csv_line(csv));
    if (!csv->content || hetab_csv_split(csv, csv->separator) != HETAB_OK)
      break;
    if (lines == 0 && take_units(csv)) {
      before = here(csv);
      continue;
    }
    drop_empty_names(csv);
    *below = holds_numbers(csv) ? NUMBERS : NOTHING;
    if (is_no_header(csv))
      *below = NO_HEADER;
    break;
  }
  go_to(csv, before);
  csv->body = csv->next;
  return HETAB_OK;
}

/* A single number among the lines above, a count perhaps, is no table yet. */
static bool starts_rows(hetab_csv *csv) {
  csv->named = false;
  if (!split_numbers(csv))
    return false;
  if (csv->count > 1)
    return true;
  place before = here(csv);
  bool single =
      hetab_csv_line(csv) != HETAB_OK || !csv->content || (split_numbers(csv) && csv->count == 1);
  go_to(csv, before);
  return single;
}

/* ---- the header ---------------------------------------------------------------------------- */

static hetab_status take_header(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count,
                                found_below *below) {
  csv->named = true;
  HETAB_TRY(name_columns(csv, wanted, count));
  *below = NOTHING;
  return csv->stream ? HETAB_OK : look_below(csv, below);
}

hetab_status hetab_csv_names(hetab_csv *csv, char *names, const hetab_csv_wanted *wanted,
                             size_t count) {
  found_below below;
  csv->content = names;
  split_header(csv, wanted, count);
  return take_header(csv, wanted, count, &below);
}

/* Words in as many fields, right above: names that nobody asked for. */
static bool is_unknown_header(hetab_csv *csv, place above, size_t fields) {
  if (!above.next)
    return false;
  go_to(csv, above);
  if (fields < 2 || hetab_csv_line(csv) != HETAB_OK ||
      hetab_csv_split(csv, csv->separator) != HETAB_OK || csv->count != fields)
    return false;
  for (size_t i = 0; i < fields; i++)
    if (hetab_csv_is_number(csv, csv->field[i]) || hetab_number_missing(csv->field[i]))
      return false;
  return true;
}

/* The rows start at the line at hand, which is split. */
static hetab_status take_numbers(hetab_csv *csv, place above, place before) {
  csv->body = csv->next;
  csv->named = is_unknown_header(csv, above, csv->count);
  go_to(csv, csv->named ? above : before);
  HETAB_TRY(hetab_csv_line(csv));
  HETAB_TRY(hetab_csv_split(csv, csv->separator));
  HETAB_TRY(name_columns(csv, NULL, 0));
  go_to(csv, before);
  return HETAB_OK;
}

/* The best line that is no header for sure: it has no numbers below it. */
typedef struct candidate {
  place at;
  size_t wanted;
} candidate;

/* *settled: a header with numbers below it, or rows without a header. */
static hetab_status search(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count,
                           candidate *best, bool *settled) {
  place above = {0}, before = {0};
  for (int lines = 0; lines < MOST_LINES_ABOVE; lines++) {
    above = before;
    before = here(csv);
    hetab_csv_forget_header(csv);
    HETAB_TRY(hetab_csv_line(csv));
    if (!csv->content)
      return HETAB_OK;
    size_t score = split_header(csv, wanted, count);
    if (score > 0) {
      bool sure = (score >= 2 || score == csv->count) && !strpbrk(csv->content, "=:");
      found_below below;
      HETAB_TRY(take_header(csv, wanted, count, &below));
      *settled = below == NUMBERS;
      if (*settled)
        return HETAB_OK;
      if (sure && below != NO_HEADER && score > best->wanted)
        *best = (candidate){before, score};
      hetab_csv_forget_header(csv);
      go_to(csv, before);
      HETAB_TRY(hetab_csv_line(csv));
    }
    if (starts_rows(csv)) {
      *settled = !best->wanted;
      return *settled ? take_numbers(csv, above, before) : HETAB_OK;
    }
  }
  return HETAB_OK;
}

static hetab_status first_line(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count) {
  HETAB_TRY(hetab_csv_line(csv));
  return csv->content ? hetab_csv_names(csv, csv->content, wanted, count) : HETAB_OK;
}

hetab_status hetab_csv_header(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count) {
  candidate best = {{0}, 0};
  bool settled = false;
  if (csv->stream || !count)
    return first_line(csv, wanted, count);
  HETAB_TRY(search(csv, wanted, count, &best, &settled));
  if (settled)
    return HETAB_OK;
  hetab_csv_forget_header(csv);
  csv->named = false;
  if (!best.wanted)
    return HETAB_OK;
  go_to(csv, best.at);
  return first_line(csv, wanted, count);
}

hetab_status hetab_csv_find(hetab_csv *csv, int which, const char *example, size_t *column) {
  size_t line = csv->line;
  *column = HETAB_CSV_ABSENT;
  csv->line = csv->head_line; /* for messages */
  for (size_t i = 0; i < csv->columns; i++) {
    const hetab_csv_column *c = &csv->column[i];
    if (c->wanted != which)
      continue;
    if (*column != HETAB_CSV_ABSENT)
      return hetab_csv_fail(csv, "column '%.40s' is there twice ('%.40s'): remove one",
                            csv->column[*column].name, c->name);
    if (c->quantity != HETAB_PLAIN && !(c->unit > 0))
      return hetab_csv_fail(csv, "column '%.40s': unit not known: name it with its unit: %s",
                            c->name, example);
    *column = i;
  }
  csv->line = line;
  return HETAB_OK;
}

/* ---- what stands above --------------------------------------------------------------------- */

bool hetab_csv_above(const hetab_csv *csv, const char *keys, char *value, size_t size) {
  char line[256], plain[512];
  for (const char *at = csv->text; at && at < csv->body; at += strcspn(at, "\r\n") + 1) {
    snprintf(line, sizeof line, "%.*s", (int)(strcspn(at, "\r\n") % sizeof line), at);
    hetab_plain_letters(line + strspn(line, "# \t\""), plain, sizeof plain);
    for (const char *key = keys; *key; key += strspn(key, "|")) {
      size_t length = strcspn(key, "|");
      const char *rest = plain + length;
      if (strncmp(plain, key, length) == 0 && strchr(":=,;\t \"", *rest)) {
        snprintf(value, size, "%s", rest + strspn(rest, ":=,;\t \""));
        return true;
      }
      key += length;
    }
  }
  return false;
}
