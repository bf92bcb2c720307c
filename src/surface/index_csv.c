/* CSV tables of wavelength, n and (optionally) k: columns in any order, found by name. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "surface/index_table.h"
#include "core/number.h"
#include "core/text.h"

enum { MAX_COLUMNS = 3 };

typedef enum { COLUMN_WAVELENGTH, COLUMN_N, COLUMN_K } column;
static const char *const column_names[] = {"wavelength", "n", "k"};

typedef struct csv_reader {
  hetab_context *ctx;
  const char *path;
  char *next;     /* the rest of the text, NULL at its end */
  size_t line;    /* number of the line that next_line returned */
  char separator; /* ',', ';' or tab, from the header */
  int columns;    /* how many */
  column order[MAX_COLUMNS];
  double per_um; /* file's wavelength units in a micrometre */
} csv_reader;

static char *trim(char *text) {
  text += strspn(text, " \t\r");
  size_t length = strlen(text);
  while (length && strchr(" \t\r", text[length - 1]))
    text[--length] = '\0';
  return text;
}

/* The next line with something left after its comment is cut off; NULL at the end. */
static char *next_line(csv_reader *csv) {
  while (csv->next) {
    char *line = csv->next, *end = strchr(line, '\n');
    csv->next = end ? end + 1 : NULL;
    csv->line++;
    if (end)
      *end = '\0';
    line[strcspn(line, "#")] = '\0';
    line = trim(line);
    if (*line)
      return line;
  }
  return NULL;
}

/* Cut the next field off *line; *line becomes NULL after the last. */
static char *next_field(char **line, char separator) {
  char *field = *line, *end = strchr(field, separator);
  *line = end ? end + 1 : NULL;
  if (end)
    *end = '\0';
  return trim(field);
}

/* Header words in one spelling: "Wavelength (um)" with any kind of mu -> "wavelengthum". */
static void normalise(const char *field, char *word, size_t size) {
  static const struct {
    const char *from, *to;
  } letters[] = {{"\xC2\xB5", "u"}, {"\xCE\xBC", "u"}, {"\xCE\xBB", "lambda"}};
  size_t used = 0;
  while (*field && used + 8 < size) {
    size_t i = 0;
    while (i < 3 && strncmp(field, letters[i].from, 2) != 0)
      i++;
    if (i < 3) {
      used += (size_t)snprintf(word + used, size - used, "%s", letters[i].to);
      field += 2;
      continue;
    }
    if (!strchr(" _-/()[]\"'.", *field))
      word[used++] = (char)tolower((unsigned char)*field);
    field++;
  }
  word[used] = '\0';
}

static bool is_one_of(const char *word, const char *const *words) {
  for (; *words; words++)
    if (strcmp(word, *words) == 0)
      return true;
  return false;
}

/* The file's units per micrometre; 0 for a word that is no wavelength, -1 for one without a unit
 * that is known. */
static double wavelength_unit(const char *word) {
  static const char *const stems[] = {"wavelength", "lambda", "wl", NULL};
  static const char *const nanometres[] = {"nm",         "innm",       "nanometer", "nanometre",
                                           "nanometers", "nanometres", NULL};
  static const char *const micrometres[] = {"um",          "inum",        "micron",
                                            "microns",     "micrometer",  "micrometre",
                                            "micrometers", "micrometres", NULL};
  for (const char *const *stem = stems; *stem; stem++) {
    size_t length = strlen(*stem);
    if (strncmp(word, *stem, length) != 0)
      continue;
    if (is_one_of(word + length, nanometres))
      return 1000;
    return is_one_of(word + length, micrometres) ? 1 : -1;
  }
  return 0;
}

static hetab_status read_header_field(csv_reader *csv, const char *field, column *found) {
  char word[64];
  normalise(field, word, sizeof word);
  double unit = wavelength_unit(word);
  if (unit < 0)
    return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: column '%.40s': unit not known: name it wavelength_nm or "
                      "wavelength_um",
                      csv->path, csv->line, field);
  if (unit > 0) {
    csv->per_um = unit;
    *found = COLUMN_WAVELENGTH;
    return HETAB_OK;
  }
  if (strcmp(word, "n") == 0 || strcmp(word, "k") == 0) {
    *found = *word == 'n' ? COLUMN_N : COLUMN_K;
    return HETAB_OK;
  }
  return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                    "%s:%zu: column '%.40s' not known: the header is wavelength_nm,n,k or "
                    "wavelength_um,n,k",
                    csv->path, csv->line, field);
}

static hetab_status check_header(csv_reader *csv, const bool *seen) {
  for (column c = COLUMN_WAVELENGTH; c <= COLUMN_N; c++)
    if (!seen[c])
      return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                        "%s:%zu: column %s missing: the header is wavelength_nm,n,k or "
                        "wavelength_um,n,k",
                        csv->path, csv->line, column_names[c]);
  return HETAB_OK;
}

static hetab_status read_header(csv_reader *csv) {
  char *line = next_line(csv);
  if (!line)
    return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                      "%s:1: the file is empty: give the header wavelength_nm,n,k and rows",
                      csv->path);
  csv->separator = strchr(line, ',') ? ',' : strchr(line, ';') ? ';' : '\t';
  bool seen[MAX_COLUMNS] = {false};
  while (line) {
    const char *field = next_field(&line, csv->separator);
    column found = COLUMN_WAVELENGTH;
    HETAB_TRY(read_header_field(csv, field, &found));
    if (seen[found])
      return hetab_fail(csv->ctx, HETAB_ERR_PARSE, "%s:%zu: column %s twice: keep one", csv->path,
                        csv->line, column_names[found]);
    seen[found] = true;
    csv->order[csv->columns++] = found; /* no more than MAX_COLUMNS: each is seen once */
  }
  return check_header(csv, seen);
}

/* One number into the row; k stays 0 where there is no such column. */
static hetab_status read_field(csv_reader *csv, const char *field, column c, hetab_row *row) {
  /* The rule for lengths is in um: a wavelength is checked after its conversion. */
  const hetab_rule *const rules[] = {&hetab_rule_any, &hetab_rule_n, &hetab_rule_k};
  double value;
  hetab_status status = hetab_number_read(csv->ctx, field, rules[c], &value);
  if (status == HETAB_OK && c == COLUMN_WAVELENGTH) {
    row->lambda_um = value / csv->per_um;
    status = hetab_number_check(csv->ctx, &hetab_rule_length, row->lambda_um);
  } else if (status == HETAB_OK) {
    row->values[c - COLUMN_N] = value;
  }
  if (status == HETAB_OK)
    return HETAB_OK;
  char what[32];
  snprintf(what, sizeof what, "column %s", column_names[c]);
  return hetab_locate(csv->ctx, HETAB_ERR_PARSE, csv->path, csv->line, what);
}

static hetab_status read_row(csv_reader *csv, char *line, hetab_row *row) {
  *row = (hetab_row){.line = csv->line};
  int i = 0;
  for (; line && i < csv->columns; i++)
    HETAB_TRY(read_field(csv, next_field(&line, csv->separator), csv->order[i], row));
  if (!line && i == csv->columns)
    return HETAB_OK;
  return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                    "%s:%zu: %s values than the header's %d columns: give one per column",
                    csv->path, csv->line, line ? "more" : "fewer", csv->columns);
}

static hetab_status read_rows(csv_reader *csv, hetab_row *rows, size_t *count) {
  *count = 0;
  for (char *line; (line = next_line(csv)); ++*count)
    HETAB_TRY(read_row(csv, line, &rows[*count]));
  if (*count == 0)
    return hetab_fail(csv->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: no rows: give lines of numbers below the header", csv->path,
                      csv->line);
  return hetab_rows_sort(csv->ctx, csv->path, rows, *count);
}

static hetab_status read_text(hetab_context *ctx, const char *path, char *text, size_t lines,
                              hetab_index *index) {
  csv_reader csv = {.ctx = ctx, .path = path, .next = text};
  HETAB_TRY(read_header(&csv));
  hetab_row *rows = hetab_alloc(ctx, lines, sizeof *rows);
  if (!rows)
    return HETAB_ERR_MEMORY;
  size_t count;
  hetab_status status = read_rows(&csv, rows, &count);
  if (status == HETAB_OK)
    status = hetab_rows_to_curve(ctx, rows, count, 0, &index->n);
  if (status == HETAB_OK)
    status = hetab_rows_to_curve(ctx, rows, count, 1, &index->k);
  free(rows);
  return status;
}

hetab_status hetab_index_read_csv(hetab_context *ctx, const char *path, hetab_index *index) {
  char *text;
  size_t length;
  HETAB_TRY(hetab_text_read(ctx, path, &text, &length));
  hetab_status status = read_text(ctx, path, text, hetab_text_line(text, length), index);
  free(text);
  return status;
}
