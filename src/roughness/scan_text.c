/* Scans, maps and lists of points as text. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/csv.h"
#include "roughness/heights.h"
#include "roughness/scan_text.h"

enum { MOST_COLUMNS = 1 << 16, MOST_ROWS_OF_THREE = 30 };

/* x, y and z, in the words of instruments. */
static const hetab_csv_wanted wanted[SCAN_ROLES] = {
    [SCAN_X] = {"x#|xposition|dist*|pos*|lateral*|scanposition|encoder1|abstand|strecke|weg",
                HETAB_LENGTH},
    [SCAN_Y] = {"y#|yposition|encoder2", HETAB_LENGTH},
    [SCAN_Z] = {"z#|h#|height*|raw*|profil*|altitude*|hohe*|hauteur*|topograph*|elevation|depth",
                HETAB_LENGTH}};

/* ---- units --------------------------------------------------------------------------------- */

/* "um", or "mm,um" of places and heights. */
static hetab_status read_units(text_scan *t) {
  const char *text = t->options->unit, *comma = text ? strchr(text, ',') : NULL;
  char first[24];
  if (!text)
    return HETAB_OK;
  snprintf(first, sizeof first, "%.*s", comma ? (int)(comma - text) : 23, text);
  t->place_unit = hetab_unit(HETAB_LENGTH, first);
  t->height_unit = comma ? hetab_unit(HETAB_LENGTH, comma + 1) : t->place_unit;
  if (t->place_unit > 0 && t->height_unit > 0)
    return HETAB_OK;
  return hetab_fail(t->csv.ctx, HETAB_ERR_ARGUMENT,
                    "'%.20s' is no unit of length: give nm, um, mm or m, or two of places and "
                    "heights, such as mm,um",
                    text);
}

/* The unit of a column: its own, what is above the rows, or the one given. */
static hetab_status find_unit(text_scan *t, size_t k) {
  const hetab_csv_column *c = &t->csv.column[t->taken[k].column];
  bool height = t->taken[k].role == SCAN_Z;
  double *unit = &t->taken[k].unit;
  *unit = c->unit;
  if (!(*unit > 0) && height)
    *unit = scan_height_unit(t);
  if (!(*unit > 0))
    *unit = height ? t->height_unit : t->place_unit;
  if (!(*unit > 0) && height && t->has_x && t->csv.named && !c->strange &&
      (*unit = t->taken[0].unit) > 0)
    snprintf(t->note, sizeof t->note,
             "%.80s: column '%.40s' names no unit: it was read in that of '%.40s'; --unit sets it.",
             t->csv.path, c->name, t->csv.column[t->taken[0].column].name);
  if (*unit > 0)
    return HETAB_OK;
  t->csv.line = t->csv.head_line;
  return hetab_csv_fail(&t->csv,
                        "no unit for %s: name it in the header, such as x_um,z_nm, or give --unit",
                        t->csv.named                                 ? c->name
                        : t->csv.columns == 2 || t->has_y            ? "x and z"
                        : t->csv.columns > 2 && !t->options->columns ? "the heights"
                                                                     : "z");
}

/* ---- columns ------------------------------------------------------------------------------- */

static void take(text_scan *t, size_t column, int role) {
  t->has_x |= role == SCAN_X;
  t->has_y |= role == SCAN_Y;
  t->taken[t->count++] = (scan_column){column, role, 0};
}

/* The columns of one role; at most one of places. */
static hetab_status take_role(text_scan *t, int role) {
  size_t first = t->count;
  for (size_t i = 0; i < t->csv.columns; i++)
    if (t->csv.column[i].wanted == role)
      take(t, i, role);
  if (role == SCAN_Z || t->count <= first + 1)
    return HETAB_OK;
  t->csv.line = t->csv.head_line;
  return hetab_csv_fail(&t->csv, "two %c columns: give one, or choose by --columns", "xy"[role]);
}

/* y is a height where there is no other. */
static hetab_status take_named(text_scan *t) {
  bool heights = false;
  for (size_t i = 0; i < t->csv.columns; i++)
    heights |= t->csv.column[i].wanted == SCAN_Z;
  for (size_t i = 0; !heights && i < t->csv.columns; i++)
    if (t->csv.column[i].wanted == SCAN_Y)
      t->csv.column[i].wanted = SCAN_Z;
  HETAB_TRY(take_role(t, SCAN_X));
  if (t->has_x)
    HETAB_TRY(take_role(t, SCAN_Y));
  size_t places = t->count;
  HETAB_TRY(take_role(t, SCAN_Z));
  if (t->count > places)
    return HETAB_OK;
  t->csv.line = t->csv.head_line;
  return hetab_csv_fail(&t->csv, "no column of heights: name one, such as z_um, in the header, or "
                                 "choose by --columns x,z");
}

/* One column is z, two are x and z, more are a map or, if they are three, perhaps x, y and z. */
static void take_unnamed(text_scan *t) {
  for (size_t i = 0; i < t->csv.columns; i++)
    take(t, i, t->csv.columns == 2 && i == 0 ? SCAN_X : SCAN_Z);
}

/* --columns: names or numbers of z, of x and z, or of x, y and z. */
static hetab_status take_chosen(text_scan *t) {
  static const int roles[3][3] = {{SCAN_Z}, {SCAN_X, SCAN_Z}, {SCAN_X, SCAN_Y, SCAN_Z}};
  const char *names[3], *text = t->options->columns;
  size_t lengths[3], count = 0;
  for (bool more = true; more && count < 3; count++) {
    names[count] = text + strspn(text, " ");
    lengths[count] = strcspn(names[count], ",");
    text = names[count] + lengths[count];
    more = *text++ == ',';
    if (more && count == 2)
      return hetab_fail(t->csv.ctx, HETAB_ERR_ARGUMENT,
                        "--columns: at most three: x, y and z of a list of points");
  }
  for (size_t i = 0; i < count; i++) {
    size_t found = scan_find_column(&t->csv, names[i], lengths[i]);
    if (found == HETAB_CSV_ABSENT)
      return hetab_csv_fail(&t->csv,
                            "no column '%.*s': give a name of the header, or a number from 1 "
                            "to %zu",
                            (int)lengths[i], names[i], t->csv.columns);
    take(t, found, roles[count - 1][i]);
  }
  return HETAB_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status read_row(text_scan *t) {
  double *row = t->values + t->rows * t->count;
  for (size_t k = 0; k < t->count; k++) {
    if (!hetab_csv_parse(&t->csv, t->csv.field[t->taken[k].column], &row[k]))
      return hetab_csv_value(&t->csv, t->taken[k].column, &row[k]);
    if (isnan(row[k]) && t->taken[k].role != SCAN_Z)
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

/* Into um, when it is known what the columns are. */
static hetab_status convert(text_scan *t) {
  for (size_t k = 0; k < t->count; k++)
    HETAB_TRY(find_unit(t, k));
  for (size_t i = 0; i < t->rows; i++)
    for (size_t k = 0; k < t->count; k++) {
      double *value = &t->values[i * t->count + k];
      *value = hetab_in_unit(*value, t->taken[k].unit);
    }
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

static void transpose(const text_scan *t, double *out) {
  for (size_t i = 0; i < t->rows; i++)
    for (size_t k = 0; k < t->count; k++)
      out[k * t->rows + i] = t->values[i * t->count + k];
}

static hetab_status from_columns(const text_scan *t, hetab_heights **out) {
  if (!t->has_x) {
    HETAB_TRY(need_spacing(t));
    HETAB_TRY(hetab_heights_new(t->csv.ctx, t->csv.path, t->rows, t->count, out));
    (*out)->spacing_um = t->options->spacing_um;
    transpose(t, (*out)->z_um);
    return HETAB_OK;
  }
  HETAB_FREED double *columns = hetab_alloc(t->csv.ctx, t->rows * t->count, sizeof *columns);
  HETAB_NEED(columns);
  transpose(t, columns);
  const double *x_um = columns, *y_um = columns + t->rows, *z_um = y_um + t->has_y * t->rows;
  return t->has_y ? hetab_heights_from_points(t->csv.ctx, t->csv.path, x_um, y_um, z_um, t->rows,
                                              t->options->resample_um, out)
                  : hetab_heights_from_places(t->csv.ctx, t->csv.path, x_um, z_um, t->rows,
                                              t->count - 1, t->options->resample_um, out);
}

static hetab_status from_map(const text_scan *t, hetab_heights **out) {
  double pitch[2] = {t->options->spacing_um, t->options->spacing_um};
  if (!scan_map_pitch(t, pitch))
    HETAB_TRY(need_spacing(t));
  HETAB_TRY(hetab_heights_new(t->csv.ctx, t->csv.path, t->count, t->rows, out));
  hetab_heights *h = *out;
  h->kind = HETAB_HEIGHTS_MAP;
  h->spacing_um = pitch[0];
  h->spacing_y_um = pitch[1];
  memcpy(h->z_um, t->values, t->rows * t->count * sizeof *h->z_um);
  return HETAB_OK;
}

/* Three columns without names are points if their places lie on a grid, and a map if they are few;
 * else one cannot tell. */
static hetab_status tell_points(text_scan *t) {
  if (hetab_are_points(t->values, t->rows)) {
    t->taken[0].role = SCAN_X;
    t->taken[1].role = SCAN_Y;
    t->has_x = t->has_y = true;
    return HETAB_OK;
  }
  if (t->rows <= MOST_ROWS_OF_THREE)
    return HETAB_OK;
  t->csv.line = t->csv.head_line;
  return hetab_csv_fail(&t->csv, "three columns: a list of points whose places lie on no grid, or "
                                 "three scans? choose by --columns, such as 1,3");
}

static hetab_status take_columns(text_scan *t) {
  size_t columns = t->csv.columns;
  if (!columns || columns > MOST_COLUMNS)
    return columns ? hetab_csv_fail(&t->csv, "%zu columns: at most %d", columns, MOST_COLUMNS)
                   : hetab_csv_fail(&t->csv, "no heights: is the file empty or cut off?");
  t->taken = hetab_alloc(t->csv.ctx, columns > 3 ? columns : 3, sizeof *t->taken);
  HETAB_NEED(t->taken);
  if (t->options->columns)
    return take_chosen(t);
  if (t->csv.named)
    return take_named(t);
  take_unnamed(t);
  return HETAB_OK;
}

static hetab_status read_scan(text_scan *t, hetab_heights **out) {
  HETAB_TRY(read_units(t));
  HETAB_TRY(hetab_csv_header(&t->csv, wanted, SCAN_ROLES));
  size_t above = t->csv.line;
  HETAB_TRY(take_columns(t));
  t->csv.line = above;
  HETAB_TRY(read_rows(t));
  bool map = !t->csv.named && !t->options->columns && t->count > 2;
  if (map && t->count == 3)
    HETAB_TRY(tell_points(t));
  HETAB_TRY(convert(t));
  HETAB_TRY(map && !t->has_y ? from_map(t, out) : from_columns(t, out));
  return t->note[0] ? hetab_heights_note(t->csv.ctx, *out, t->note) : HETAB_OK;
}

hetab_status hetab_scan_text(hetab_context *ctx, const char *path, const char *text,
                             const hetab_heights_options *options, hetab_heights **out) {
  text_scan t = {.options = options};
  hetab_csv_of_text(ctx, path, text, &t.csv);
  t.csv.decimal = options->decimal;
  hetab_status status = read_scan(&t, out);
  hetab_csv_clear(&t.csv);
  free(t.taken);
  free(t.values);
  return status;
}
