/* Scans and maps as text. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "roughness/heights.h"
#include "core/number.h"
#include "core/text.h"

enum { MOST_COLUMNS = 1 << 16 };

typedef struct text_scan {
  hetab_context *ctx;
  const char *path;
  const hetab_heights_options *options;
  size_t line;
  double width_um, height_um, value_um; /* of "# Width:" and so on; 0: not there */
  char *header;                         /* that line, or NULL */
  size_t header_line;
  double *values; /* [rows][columns], in the file's units */
  size_t columns, rows, capacity;
} text_scan;

/* ---- lines --------------------------------------------------------------------------------- */

/* Cuts the next line off *text; NULL at the end. */
static char *next_line(char **text) {
  char *line = *text;
  if (!*line)
    return NULL;
  char *end = line + strcspn(line, "\n");
  *text = *end ? end + 1 : end;
  *end = '\0';
  size_t length = strlen(line);
  if (length && line[length - 1] == '\r')
    line[length - 1] = '\0';
  return line;
}

/* The field without the quotation marks about it. */
static char *unquoted(char *field, char *end) {
  if (end - field < 2 || *field != '"' || end[-1] != '"')
    return field;
  end[-1] = '\0';
  return field + 1;
}

/* Cuts the next field off *cursor; NULL at the end. Blanks separate where no other mark does. */
static char *next_field(char **cursor, char separator) {
  char *field = *cursor;
  if (!field)
    return NULL;
  field += strspn(field, separator == '\t' ? " " : " \t");
  if (separator == ' ' && !*field)
    return NULL;
  char *end = field + strcspn(field, separator == ' ' ? " \t" : (char[]){separator, '\0'});
  char *after = end;
  if (separator == ' ')
    after += strspn(after, " \t");
  *cursor = *after ? after + (separator != ' ') : NULL;
  while (end > field && strchr(" \t", end[-1]))
    end--;
  *end = '\0';
  return unquoted(field, end);
}

static char separator_of(const char *line) {
  return strchr(line, ';') ? ';' : strchr(line, ',') ? ',' : strchr(line, '\t') ? '\t' : ' ';
}

static size_t count_fields(const char *line, char separator) {
  char *copy = strdup(line), *cursor = copy;
  size_t count = 0;
  while (copy && next_field(&cursor, separator))
    count++;
  free(copy);
  return count;
}

/* ---- comments and headers ------------------------------------------------------------------ */

/* "# Width: 100 um" to *um; nothing if the comment says something else. */
static void read_extent(const char *comment, const char *key, double *um) {
  char number[64], unit[16];
  size_t length = strlen(key);
  comment += strspn(comment, "# \t");
  if (strncasecmp(comment, key, length) != 0)
    return;
  const char *cursor = comment + length;
  double value;
  if (hetab_next_word(&cursor, number, sizeof number) && hetab_number_parse(number, &value) &&
      hetab_next_word(&cursor, unit, sizeof unit))
    *um = value * hetab_length_unit(unit);
}

static void read_comment(text_scan *t, const char *comment) {
  static const char key[] = "value units:";
  char unit[16];
  read_extent(comment, "width:", &t->width_um);
  read_extent(comment, "height:", &t->height_um);
  comment += strspn(comment, "# \t");
  const char *cursor = comment + sizeof key - 1;
  if (strncasecmp(comment, key, sizeof key - 1) == 0 && hetab_next_word(&cursor, unit, sizeof unit))
    t->value_um = hetab_length_unit(unit);
}

static bool is_header(const char *line, char separator) {
  char *copy = strdup(line), *cursor = copy, *field;
  bool words = false;
  double value;
  while (copy && (field = next_field(&cursor, separator)))
    words |= !hetab_height_parse(field, &value) && !strchr("+-.0123456789", *field);
  free(copy);
  return words;
}

/* "z_um", "z [um]", "Height (um)", "x/mm": the name, and the unit's length; 0: none. */
static double split_unit(char *field) {
  char *mark = strpbrk(field, "[(/");
  if (!mark)
    mark = strrchr(field, '_');
  if (!mark)
    return 0;
  char *unit = mark + 1 + strspn(mark + 1, " ");
  unit[strcspn(unit, "])\" ")] = '\0';
  double um = hetab_length_unit(unit);
  if (um > 0)
    *mark = '\0';
  return um;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status fail_at(const text_scan *t, const char *what, const char *field) {
  return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s:%zu: '%.40s' %s", t->path, t->line, field, what);
}

static hetab_status grow(text_scan *t) {
  if (t->rows * t->columns + t->columns <= t->capacity)
    return HETAB_OK;
  size_t capacity = t->capacity ? 2 * t->capacity : 4096;
  while (capacity < t->columns)
    capacity *= 2;
  double *larger =
      capacity > 2 * HETAB_MOST_HEIGHTS ? NULL : realloc(t->values, capacity * sizeof *larger);
  if (!larger)
    return hetab_fail(t->ctx, HETAB_ERR_MEMORY, "%s:%zu: too many heights: at most 2^27", t->path,
                      t->line);
  t->values = larger;
  t->capacity = capacity;
  return HETAB_OK;
}

static hetab_status read_row(text_scan *t, char *line, char separator) {
  HETAB_TRY(grow(t));
  double *row = t->values + t->rows * t->columns;
  size_t count = 0;
  char *field;
  while ((field = next_field(&line, separator))) {
    if (count == t->columns && !line && !*field)
      break; /* a separator at the end of the line */
    if (count == t->columns)
      return fail_at(t, "is a field more than the lines before have", field);
    if (!hetab_height_parse(field, &row[count++]))
      return fail_at(
          t, "is not a number: give numbers with a decimal point, or nan for a missing height",
          field);
  }
  if (count != t->columns)
    return hetab_fail(t->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: %zu fields, where the lines before have %zu: is the line cut off?",
                      t->path, t->line, count, t->columns);
  t->rows++;
  return HETAB_OK;
}

static hetab_status read_rows(text_scan *t, char *text) {
  char separator = ' ', *line;
  while ((line = next_line(&text))) {
    t->line++;
    if (line[strspn(line, " \t")] == '\0')
      continue;
    if (*line == '#') {
      read_comment(t, line);
      continue;
    }
    if (!t->columns) {
      separator = separator_of(line);
      t->columns = count_fields(line, separator);
      if (!t->columns || t->columns > MOST_COLUMNS)
        return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s:%zu: %zu columns: at most %d", t->path,
                          t->line, t->columns, MOST_COLUMNS);
      if (is_header(line, separator)) {
        t->header = line;
        t->header_line = t->line;
        continue;
      }
    }
    HETAB_TRY(read_row(t, line, separator));
  }
  if (t->rows * t->columns < 2)
    return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s: no heights: is the file empty or cut off?",
                      t->path);
  return HETAB_OK;
}

/* ---- columns ------------------------------------------------------------------------------- */

typedef struct text_columns {
  size_t x; /* SIZE_MAX: none */
  double x_um;
  size_t *z; /* [count] */
  double *z_um;
  size_t count;
} text_columns;

static hetab_status missing_unit(const text_scan *t, const char *column) {
  return hetab_fail(t->ctx, HETAB_ERR_PARSE,
                    "%s:%zu: no unit for %s: name it in the header, such as x_um,z_nm, or give "
                    "--unit",
                    t->path, t->header ? t->header_line : 1, column);
}

static double given_unit(const text_scan *t) {
  return t->options->unit ? hetab_length_unit(t->options->unit) : 0;
}

static bool begins(const char *name, const char *letters) {
  return strncasecmp(name, letters, strlen(letters)) == 0;
}

static hetab_status add_column(const text_scan *t, text_columns *c, size_t index, char *name) {
  double um = split_unit(name);
  bool is_x = (begins(name, "x") || begins(name, "dist") || begins(name, "pos"));
  if (!is_x && !begins(name, "z") && !begins(name, "h"))
    return HETAB_OK; /* an index, a quality, whatever else */
  if (!(um > 0) && !((um = given_unit(t)) > 0))
    return missing_unit(t, name);
  if (is_x && c->x != SIZE_MAX)
    return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s:%zu: two x columns: give one", t->path,
                      t->header_line);
  if (is_x) {
    c->x = index;
    c->x_um = um;
  } else {
    c->z[c->count] = index;
    c->z_um[c->count++] = um;
  }
  return HETAB_OK;
}

static hetab_status read_header(const text_scan *t, text_columns *c) {
  char separator = separator_of(t->header), *cursor = t->header, *field;
  for (size_t i = 0; i < t->columns && (field = next_field(&cursor, separator)); i++)
    HETAB_TRY(add_column(t, c, i, field));
  if (!c->count)
    return hetab_fail(t->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: no column of heights: the header has to name one, such as z_um",
                      t->path, t->header_line);
  return HETAB_OK;
}

/* One column is z, two are x and z. */
static hetab_status default_columns(const text_scan *t, text_columns *c) {
  double um = given_unit(t);
  if (!(um > 0))
    return missing_unit(t, t->columns == 2 ? "x and z" : "z");
  c->x = t->columns == 2 ? 0 : SIZE_MAX;
  c->x_um = um;
  c->z[0] = t->columns - 1;
  c->z_um[0] = um;
  c->count = 1;
  return HETAB_OK;
}

static hetab_status need_spacing(const text_scan *t) {
  if (t->options->spacing_um > 0)
    return HETAB_OK;
  return hetab_fail(t->ctx, HETAB_ERR_PARSE,
                    "%s: how far the heights lie apart is not in the file: give --spacing",
                    t->path);
}

/* The chosen columns as rows of heights. */
static hetab_status make_scans(const text_scan *t, const text_columns *c, double *x_um,
                               double *z_um, hetab_heights **out) {
  for (size_t i = 0; i < t->rows; i++) {
    const double *row = t->values + i * t->columns;
    x_um[i] = c->x == SIZE_MAX ? 0 : row[c->x] * c->x_um;
    if (isnan(x_um[i]))
      return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s: point %zu has no x: leave it out", t->path,
                        i + 1);
    for (size_t k = 0; k < c->count; k++)
      z_um[k * t->rows + i] = row[c->z[k]] * c->z_um[k];
  }
  if (t->rows < 2)
    return hetab_fail(t->ctx, HETAB_ERR_PARSE, "%s: one point is no scan: is the file cut off?",
                      t->path);
  if (c->x != SIZE_MAX)
    return hetab_heights_from_places(t->ctx, t->path, x_um, z_um, t->rows, c->count,
                                     t->options->resample_um, out);
  HETAB_TRY(need_spacing(t));
  HETAB_TRY(hetab_heights_new(t->ctx, t->path, t->rows, c->count, out));
  (*out)->spacing_um = t->options->spacing_um;
  memcpy((*out)->z_um, z_um, t->rows * c->count * sizeof *z_um);
  return HETAB_OK;
}

static hetab_status from_columns(const text_scan *t, hetab_heights **out) {
  text_columns c = {.x = SIZE_MAX};
  hetab_status status = HETAB_ERR_MEMORY;
  double *x_um = NULL, *z_um = NULL;
  c.z = hetab_alloc(t->ctx, t->columns, sizeof *c.z);
  c.z_um = hetab_alloc(t->ctx, t->columns, sizeof *c.z_um);
  if (!c.z || !c.z_um)
    goto done;
  HETAB_GOTO(t->header ? read_header(t, &c) : default_columns(t, &c));
  status = HETAB_ERR_MEMORY;
  x_um = hetab_alloc(t->ctx, t->rows, sizeof *x_um);
  z_um = hetab_alloc(t->ctx, t->rows * c.count, sizeof *z_um);
  if (x_um && z_um)
    status = make_scans(t, &c, x_um, z_um, out);
done:
  free(c.z);
  free(c.z_um);
  free(x_um);
  free(z_um);
  return status;
}

/* ---- maps ---------------------------------------------------------------------------------- */

static hetab_status from_map(const text_scan *t, hetab_heights **out) {
  double unit = t->value_um > 0 ? t->value_um : given_unit(t);
  bool extents = t->width_um > 0 && t->height_um > 0;
  if (!(unit > 0))
    return missing_unit(t, "the heights");
  if (!extents)
    HETAB_TRY(need_spacing(t));
  HETAB_TRY(hetab_heights_new(t->ctx, t->path, t->columns, t->rows, out));
  hetab_heights *h = *out;
  h->kind = HETAB_HEIGHTS_MAP;
  h->spacing_um = extents ? t->width_um / (double)t->columns : t->options->spacing_um;
  h->spacing_y_um = extents ? t->height_um / (double)t->rows : t->options->spacing_um;
  for (size_t i = 0; i < t->rows * t->columns; i++)
    h->z_um[i] = t->values[i] * unit;
  return HETAB_OK;
}

hetab_status hetab_scan_text(hetab_context *ctx, const char *path, char *text,
                             const hetab_heights_options *options, hetab_heights **out) {
  text_scan t = {.ctx = ctx, .path = path, .options = options};
  if (options->unit && !(hetab_length_unit(options->unit) > 0))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "'%.20s' is no unit of length: give nm, um, mm or m",
                      options->unit);
  hetab_status status = read_rows(&t, text);
  if (status == HETAB_OK)
    status = !t.header && t.columns > 2 ? from_map(&t, out) : from_columns(&t, out);
  free(t.values);
  return status;
}
