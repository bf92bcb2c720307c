/* Scans, maps and lists of points as text. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/csv.h"
#include "roughness/heights.h"

enum { MOST_COLUMNS = 1 << 16, MOST_ROWS_OF_THREE = 30 };
enum { PLACE, ACROSS, HEIGHT, ROLES }; /* x, y and z, in the words of instruments */

static const hetab_csv_wanted wanted[ROLES] = {
    [PLACE] = {"x#|xposition|dist*|pos*|lateral*|scanposition|encoder1|abstand|strecke|weg",
               HETAB_LENGTH},
    [ACROSS] = {"y#|yposition|encoder2", HETAB_LENGTH},
    [HEIGHT] = {"z#|h#|height*|raw*|profil*|altitude*|hohe*|hauteur*|topograph*|elevation|depth",
                HETAB_LENGTH}};

typedef struct text_scan {
  hetab_csv csv;
  const hetab_heights_options *options;
  size_t *taken; /* [count] columns: x if has_x, y if has_y, then heights */
  double *unit;  /* [count] um */
  size_t count;
  bool has_x, has_y;
  double *values; /* [rows][count], um */
  size_t rows, room;
} text_scan;

/* ---- columns ------------------------------------------------------------------------------- */

static double given_unit(const text_scan *t) {
  return t->options->unit ? hetab_unit(HETAB_LENGTH, t->options->unit) : 0;
}

static hetab_status take(text_scan *t, size_t column, const char *name) {
  double unit = t->csv.column[column].unit;
  t->csv.line = t->csv.head_line;
  if (!(unit > 0) && !((unit = given_unit(t)) > 0))
    return hetab_csv_fail(&t->csv,
                          "no unit for %s: name it in the header, such as x_um,z_nm, or give "
                          "--unit",
                          name);
  t->csv.column[column].unit = 0; /* applied here */
  t->unit[t->count] = unit;
  t->taken[t->count++] = column;
  return HETAB_OK;
}

/* The columns of one role; at most one of places. */
static hetab_status take_role(text_scan *t, int role, bool *found) {
  for (size_t i = 0; i < t->csv.columns; i++) {
    if (t->csv.column[i].wanted != role)
      continue;
    if (*found && role != HEIGHT)
      return hetab_csv_fail(&t->csv, "two x columns: give one");
    *found = true;
    HETAB_TRY(take(t, i, t->csv.column[i].name));
  }
  return HETAB_OK;
}

/* y is a height where there is no other. */
static hetab_status take_named(text_scan *t) {
  bool heights = false;
  for (size_t i = 0; i < t->csv.columns; i++)
    heights |= t->csv.column[i].wanted == HEIGHT;
  for (size_t i = 0; !heights && i < t->csv.columns; i++)
    if (t->csv.column[i].wanted == ACROSS)
      t->csv.column[i].wanted = HEIGHT;
  heights = false;
  HETAB_TRY(take_role(t, PLACE, &t->has_x));
  if (t->has_x)
    HETAB_TRY(take_role(t, ACROSS, &t->has_y));
  HETAB_TRY(take_role(t, HEIGHT, &heights));
  if (heights)
    return HETAB_OK;
  t->csv.line = t->csv.head_line;
  return hetab_csv_fail(&t->csv, "no column of heights: the header has to name one, such as z_um");
}

/* One column is z, two are x and z, more are a map, whose heights may have their unit above. */
static hetab_status take_unnamed(text_scan *t) {
  char word[32];
  double unit = 0;
  size_t columns = t->csv.columns;
  if (hetab_csv_above(&t->csv, "value units|werteinheit|einheit der werte|unites", word,
                      sizeof word))
    unit = hetab_unit(HETAB_LENGTH, word);
  t->has_x = columns == 2;
  for (size_t i = 0; i < columns; i++) {
    t->csv.column[i].unit = unit;
    HETAB_TRY(take(t, i, columns == 1 ? "z" : columns == 2 ? "x and z" : "the heights"));
  }
  return HETAB_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status read_row(text_scan *t) {
  double *row = t->values + t->rows * t->count;
  for (size_t i = 0; i < t->count; i++) {
    HETAB_TRY(hetab_csv_value(&t->csv, t->taken[i], &row[i]));
    row[i] = hetab_in_unit(row[i], t->unit[i]);
    if (isnan(row[i]) && i < (size_t)t->has_x + t->has_y)
      return hetab_csv_fail(&t->csv, "the point has no x: leave it out");
  }
  t->rows++;
  return HETAB_OK;
}

static hetab_status read_rows(text_scan *t) {
  for (;;) {
    HETAB_TRY(hetab_csv_row(&t->csv));
    if (!t->csv.count)
      break;
    if (t->rows * t->count > HETAB_MOST_HEIGHTS)
      return hetab_csv_fail(&t->csv, "too many heights: at most 2^27");
    HETAB_TRY(
        hetab_grow(t->csv.ctx, &t->values, sizeof *t->values, (t->rows + 1) * t->count, &t->room));
    HETAB_TRY(read_row(t));
  }
  if (t->rows == 0)
    return hetab_csv_fail(&t->csv, "no heights: is the file empty or cut off?");
  if (t->rows < 2 && t->count <= 2)
    return hetab_csv_fail(&t->csv, "one point is no scan: is the file cut off?");
  return HETAB_OK;
}

/* ---- heights ------------------------------------------------------------------------------- */

static hetab_status need_spacing(const text_scan *t) {
  if (t->options->spacing_um > 0)
    return HETAB_OK;
  return hetab_fail(t->csv.ctx, HETAB_ERR_PARSE,
                    "%s: how far the heights lie apart is not in the file: give --spacing",
                    t->csv.path);
}

/* Columns from `first` on as rows of heights. */
static void transpose(const text_scan *t, size_t first, size_t count, double *out) {
  for (size_t i = 0; i < t->rows; i++)
    for (size_t k = 0; k < count; k++)
      out[k * t->rows + i] = t->values[i * t->count + first + k];
}

static hetab_status from_columns(const text_scan *t, hetab_heights **out) {
  size_t scans = t->count - t->has_x;
  if (!t->has_x) {
    HETAB_TRY(need_spacing(t));
    HETAB_TRY(hetab_heights_new(t->csv.ctx, t->csv.path, t->rows, scans, out));
    (*out)->spacing_um = t->options->spacing_um;
    transpose(t, 0, scans, (*out)->z_um);
    return HETAB_OK;
  }
  double *columns = hetab_alloc(t->csv.ctx, t->rows * t->count, sizeof *columns);
  if (!columns)
    return HETAB_ERR_MEMORY;
  transpose(t, 0, t->count, columns);
  hetab_status status =
      hetab_heights_from_places(t->csv.ctx, t->csv.path, columns, columns + t->rows, t->rows, scans,
                                t->options->resample_um, out);
  free(columns);
  return status;
}

/* "# Width: 100 um"; 0: not there. */
static double extent_um(const text_scan *t, const char *keys) {
  char text[64], number[32], *end;
  double value;
  if (!hetab_csv_above(&t->csv, keys, text, sizeof text))
    return 0;
  size_t length = strcspn(text, " \t");
  snprintf(number, sizeof number, "%.*s", (int)(length < 31 ? length : 31), text);
  hetab_csv copy = {0}; /* of either decimal mark */
  end = text + length;
  return hetab_csv_parse(&copy, number, &value) ? value * hetab_unit(HETAB_LENGTH, end) : 0;
}

static hetab_status from_map(const text_scan *t, hetab_heights **out) {
  double width = extent_um(t, "width|breite|largeur"), height = extent_um(t, "height|hohe|hauteur");
  bool extents = width > 0 && height > 0;
  if (!extents)
    HETAB_TRY(need_spacing(t));
  HETAB_TRY(hetab_heights_new(t->csv.ctx, t->csv.path, t->count, t->rows, out));
  hetab_heights *h = *out;
  h->kind = HETAB_HEIGHTS_MAP;
  h->spacing_um = extents ? width / (double)t->count : t->options->spacing_um;
  h->spacing_y_um = extents ? height / (double)t->rows : t->options->spacing_um;
  memcpy(h->z_um, t->values, t->rows * t->count * sizeof *h->z_um);
  return HETAB_OK;
}

static hetab_status read_scan(text_scan *t, hetab_heights **out) {
  HETAB_TRY(hetab_csv_header(&t->csv, wanted, ROLES));
  size_t columns = t->csv.columns;
  if (!columns || columns > MOST_COLUMNS)
    return columns ? hetab_csv_fail(&t->csv, "%zu columns: at most %d", columns, MOST_COLUMNS)
                   : hetab_csv_fail(&t->csv, "no heights: is the file empty or cut off?");
  t->taken = hetab_alloc(t->csv.ctx, columns, sizeof *t->taken);
  t->unit = hetab_alloc(t->csv.ctx, columns, sizeof *t->unit);
  if (!t->taken || !t->unit)
    return HETAB_ERR_MEMORY;
  size_t above = t->csv.line;
  HETAB_TRY(t->csv.named ? take_named(t) : take_unnamed(t));
  t->csv.line = above;
  HETAB_TRY(read_rows(t));
  return !t->csv.named && columns > 2 ? from_map(t, out) : from_columns(t, out);
}

hetab_status hetab_scan_text(hetab_context *ctx, const char *path, const char *text,
                             const hetab_heights_options *options, hetab_heights **out) {
  text_scan t = {.options = options};
  if (options->unit && !(hetab_unit(HETAB_LENGTH, options->unit) > 0))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "'%.20s' is no unit of length: give nm, um, mm or m",
                      options->unit);
  hetab_csv_of_text(ctx, path, text, &t.csv);
  hetab_status status = read_scan(&t, out);
  hetab_csv_clear(&t.csv);
  free(t.taken);
  free(t.unit);
  free(t.values);
  return status;
}
