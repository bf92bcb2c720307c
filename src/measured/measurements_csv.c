/* Tables: columns in any order, found by name, a value a row or a column for each wavelength; ASTM
 * E1392 style files are such tables, whose names stand in the line VARS and whose angles are
 * radians. Rows of one pair of directions are brought together; a pair that was measured twice at a
 * wavelength stays two. */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "measured/measurement_sheet.h"

enum { THETA_I, THETA_R, PHI, PHI_I, PHI_R, WAVELENGTH, VALUE, VALUE_COS, FACTOR, ROLES };

static const hetab_csv_wanted wanted[ROLES] = {
    [THETA_I] = {"thetai", HETAB_ANGLE},
    [THETA_R] = {"thetar|thetas", HETAB_ANGLE},
    [PHI] = {"phi", HETAB_ANGLE},
    [PHI_I] = {"phii", HETAB_ANGLE},
    [PHI_R] = {"phir|phis", HETAB_ANGLE},
    [WAVELENGTH] = {"wavelength|lambda|wl", HETAB_LENGTH},
    [VALUE] = {"f|fr|brdf|total", HETAB_PLAIN}, /* total: what `hetab eval` writes */
    [VALUE_COS] = {"fcos|frcos|brdfcos|cosbrdf|ccbrdf|cosinecorrectedbrdf|brdfcostheta|brdfxcos",
                   HETAB_PLAIN},
    [FACTOR] = {"reflectancefactor|radiancefactor|rf|brf", HETAB_PLAIN}, /* pi times a BRDF */
};
static const char example[] = "wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f";
static const double degree = M_PI / 180;

typedef struct row {
  double numbers[ROLES]; /* um, radians, 1/sr */
  size_t line, repeat;   /* how often the pair was measured before at this wavelength */
} row;

typedef struct table {
  hetab_sheet *sheet;
  hetab_csv *csv; /* the sheet's */
  size_t at[ROLES];
  int value;    /* VALUE, VALUE_COS or FACTOR */
  size_t *wide; /* [wavelengths] columns named by their wavelength */
  double *lambda_um;
  size_t wavelengths; /* of those; 0: a value a row */
  bool degrees;
  double largest; /* angle, degrees */
  double *values; /* [wavelengths] of a row */
  row *rows;
  size_t count, room;
} table;

/* ---- columns ------------------------------------------------------------------------------- */

/* "550nm", "0.55 um", "f_550nm" in um; 0: none. */
static double wavelength_of(const char *name) {
  char number[32], *end;
  const char *digits = name + strcspn(name, "0123456789");
  size_t length = strspn(digits, "0123456789.");
  double value, unit = hetab_unit(HETAB_LENGTH, digits + length);
  if (digits > name && !strchr("_ -", digits[-1]))
    return 0;
  snprintf(number, sizeof number, "%.*s", (int)(length < 31 ? length : 31), digits);
  end = number;
  return unit > 0 && hetab_number_parse(end, &value) ? hetab_in_unit(value, unit) : 0;
}

/* Columns R, G, B, or values whose wavelengths were given. */
static void find_unnamed(table *t) {
  static const char *const sets[] = {"RGB", "XYZ"};
  hetab_csv *csv = t->csv;
  for (int set = 0; set < 2 && !t->wavelengths; set++) {
    size_t found = 0;
    for (size_t i = 0; i < csv->columns && found < 3; i++)
      if (toupper((unsigned char)csv->column[i].name[0]) == sets[set][found] &&
          !csv->column[i].name[1])
        t->wide[found++] = i;
    const double *um = t->sheet->given == 3 ? t->sheet->given_um : set == 0 ? hetab_rgb_um : NULL;
    for (t->wavelengths = found == 3 && um ? 3 : 0, found = 0; found < t->wavelengths; found++)
      t->lambda_um[found] = um[found];
  }
  if (t->wavelengths || t->at[VALUE] == HETAB_CSV_ABSENT || t->at[WAVELENGTH] != HETAB_CSV_ABSENT ||
      t->sheet->given != 1)
    return;
  t->wide[0] = t->at[VALUE];
  t->lambda_um[0] = t->sheet->given_um[0];
  t->wavelengths = 1;
}

static hetab_status find_wide(table *t) {
  hetab_csv *csv = t->csv;
  t->wide = hetab_alloc(csv->ctx, csv->columns, sizeof *t->wide);
  t->lambda_um = hetab_alloc(csv->ctx, csv->columns, sizeof *t->lambda_um);
  t->values = hetab_alloc(csv->ctx, csv->columns, sizeof *t->values);
  HETAB_NEED(t->wide && t->lambda_um && t->values);
  for (size_t i = 0; i < csv->columns; i++) {
    const hetab_csv_column *c = &csv->column[i];
    bool candidate = c->wanted == HETAB_CSV_OTHER || (c->wanted == VALUE && c->strange);
    double lambda_um = candidate ? wavelength_of(c->name) : 0;
    if (lambda_um > 0) {
      t->wide[t->wavelengths] = i;
      t->lambda_um[t->wavelengths++] = lambda_um;
    }
  }
  if (!t->wavelengths)
    find_unnamed(t);
  return HETAB_OK;
}

static hetab_status need(const table *t, int role, const char *name) {
  return t->at[role] != HETAB_CSV_ABSENT
             ? HETAB_OK
             : hetab_csv_fail(t->csv, "no column %s: the header is %s", name, example);
}

static hetab_status find_columns(table *t) {
  for (int role = 0; role < ROLES; role++) {
    HETAB_TRY(
        hetab_csv_find(t->csv, role, "wavelength_nm or _um, theta_i_deg or _rad", &t->at[role]));
    t->degrees |= role <= PHI_R && t->at[role] != HETAB_CSV_ABSENT &&
                  t->csv->column[t->at[role]].unit == degree;
  }
  bool phi = t->at[PHI] != HETAB_CSV_ABSENT, phi_i = t->at[PHI_I] != HETAB_CSV_ABSENT;
  bool phi_r = t->at[PHI_R] != HETAB_CSV_ABSENT;
  if (phi && (phi_i || phi_r))
    return hetab_csv_fail(t->csv, "phi and phi_i or phi_r: give phi, or the other two");
  HETAB_TRY(need(t, THETA_I, "theta_i_deg"));
  HETAB_TRY(need(t, THETA_R, "theta_r_deg (or theta_s)"));
  if (phi_i || phi_r)
    HETAB_TRY(phi_i ? need(t, PHI_R, "phi_s_deg (or phi_r)") : need(t, PHI_I, "phi_i_deg"));
  else
    HETAB_TRY(need(t, PHI, "phi_deg (or phi_i_deg and phi_r_deg)"));
  HETAB_TRY(find_wide(t));
  if (t->wavelengths)
    return hetab_sheet_begin(t->sheet, t->lambda_um, t->wavelengths);
  if (t->at[WAVELENGTH] == HETAB_CSV_ABSENT)
    return hetab_csv_fail(t->csv,
                          "no wavelength: name a column wavelength_nm, or columns of values "
                          "by it, such as 550nm, or give --wavelengths; the header is %s",
                          example);
  for (int role = VALUE; role <= FACTOR; role++)
    if (t->at[role] != HETAB_CSV_ABSENT) {
      t->value = role;
      return HETAB_OK;
    }
  return need(t, VALUE, "f");
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status read_angles(table *t, double numbers[ROLES]) {
  static const hetab_rule polar = {-M_PI - 1e-3, M_PI + 1e-3,
                                   "a polar angle within 180 degrees, or pi if it is in radians"},
                          azimuth = {-1e9, 1e9, "an angle"};
  for (int role = THETA_I; role <= PHI_R; role++) {
    numbers[role] = 0;
    if (t->at[role] == HETAB_CSV_ABSENT)
      continue;
    HETAB_TRY(
        hetab_csv_number(t->csv, t->at[role], role <= THETA_R ? &polar : &azimuth, &numbers[role]));
    t->largest = fmax(t->largest, fabs(numbers[role]) / degree);
  }
  return HETAB_OK;
}

static hetab_measured_angles angles_of(const table *t, const double numbers[ROLES]) {
  return (hetab_measured_angles){numbers[THETA_I], numbers[PHI_I], numbers[THETA_R],
                                 t->at[PHI] != HETAB_CSV_ABSENT ? numbers[PHI] : numbers[PHI_R]};
}

static hetab_status read_wide_row(table *t) {
  double numbers[ROLES];
  HETAB_TRY(read_angles(t, numbers));
  for (size_t i = 0; i < t->wavelengths; i++)
    HETAB_TRY(hetab_csv_value(t->csv, t->wide[i], &t->values[i]));
  hetab_measured_angles angles = angles_of(t, numbers);
  return hetab_sheet_add(t->sheet, &angles, t->values);
}

static hetab_status read_row(table *t) {
  static const hetab_rule wavelength = {1e-9, 1e6, "a wavelength above 0"};
  if (t->count++ == 0)
    t->sheet->first_line = t->csv->line;
  if (t->wavelengths)
    return read_wide_row(t);
  HETAB_TRY(hetab_grow(t->csv->ctx, &t->rows, sizeof *t->rows, t->count, &t->room));
  row *r = &t->rows[t->count - 1];
  *r = (row){.line = t->csv->line};
  HETAB_TRY(read_angles(t, r->numbers));
  HETAB_TRY(hetab_csv_number(t->csv, t->at[WAVELENGTH], &wavelength, &r->numbers[WAVELENGTH]));
  HETAB_TRY(hetab_csv_value(t->csv, t->at[t->value], &r->numbers[VALUE]));
  if (t->value == VALUE_COS)
    r->numbers[VALUE] /= cos(r->numbers[THETA_R]);
  if (t->value == FACTOR)
    r->numbers[VALUE] /= M_PI;
  return HETAB_OK;
}

/* Radians in columns of degrees: a scan that never leaves the normal's neighbourhood. */
static hetab_status check_unit(table *t) {
  if (!t->degrees || t->largest == 0 || t->largest > 2 * M_PI + 1e-3)
    return HETAB_OK;
  t->csv->line = t->sheet->first_line;
  return hetab_csv_fail(t->csv,
                        "no angle in the file exceeds %.3g degrees: if they are radians, name the "
                        "columns theta_i_rad and so on",
                        t->largest);
}

/* ---- from rows to pairs -------------------------------------------------------------------- */

static int compare_numbers(const row *a, const row *b, const int *roles, int count) {
  for (int i = 0; i < count; i++) {
    double x = a->numbers[roles[i]], y = b->numbers[roles[i]];
    if (x != y)
      return x < y ? -1 : 1;
  }
  return 0;
}

static const int direction_roles[] = {THETA_I, PHI_I, THETA_R, PHI_R, PHI};
enum { DIRECTION_ROLES = PHI_R + 1 };

static int same_direction(const row *a, const row *b) {
  return compare_numbers(a, b, direction_roles, DIRECTION_ROLES) == 0;
}

static int compare_lines(const row *a, const row *b) {
  return (a->line > b->line) - (a->line < b->line);
}

static int by_direction(const void *left, const void *right) {
  static const int wavelength = WAVELENGTH;
  const row *a = left, *b = right;
  int order = compare_numbers(a, b, direction_roles, DIRECTION_ROLES);
  if (!order)
    order = compare_numbers(a, b, &wavelength, 1);
  return order ? order : compare_lines(a, b);
}

static int by_repeat(const void *left, const void *right) {
  const row *a = left, *b = right;
  int order = compare_numbers(a, b, direction_roles, DIRECTION_ROLES);
  if (!order)
    order = (a->repeat > b->repeat) - (a->repeat < b->repeat);
  return order ? order : compare_lines(a, b);
}

static int by_size(const void *left, const void *right) {
  double a = *(const double *)left, b = *(const double *)right;
  return (a > b) - (a < b);
}

static void sort_rows(table *t) {
  qsort(t->rows, t->count, sizeof *t->rows, by_direction);
  for (size_t i = 1; i < t->count; i++) {
    row *r = &t->rows[i];
    if (same_direction(r, r - 1) && r->numbers[WAVELENGTH] == r[-1].numbers[WAVELENGTH])
      r->repeat = r[-1].repeat + 1;
  }
  qsort(t->rows, t->count, sizeof *t->rows, by_repeat);
}

static hetab_status begin_sheet(table *t) {
  size_t count = 0;
  HETAB_FREED double *lambda_um = hetab_alloc(t->sheet->ctx, t->count, sizeof *lambda_um);
  HETAB_NEED(lambda_um);
  for (size_t i = 0; i < t->count; i++)
    lambda_um[i] = t->rows[i].numbers[WAVELENGTH];
  qsort(lambda_um, t->count, sizeof *lambda_um, by_size);
  for (size_t i = 0; i < t->count; i++)
    if (i == 0 || lambda_um[i] != lambda_um[i - 1])
      lambda_um[count++] = lambda_um[i];
  return hetab_sheet_begin(t->sheet, lambda_um, count);
}

/* The rows first..end of one pair, in one row of the sheet; what the file has no row for is missing
 * without being counted. */
static hetab_status add_pair(table *t, size_t first, size_t end, double *values) {
  hetab_sheet *sheet = t->sheet;
  hetab_measured_angles angles = angles_of(t, t->rows[first].numbers);
  for (size_t i = 0; i < sheet->wavelengths; i++)
    values[i] = (double)NAN;
  for (size_t i = first; i < end; i++) {
    const double *found = bsearch(&t->rows[i].numbers[WAVELENGTH], sheet->lambda_um,
                                  sheet->wavelengths, sizeof *found, by_size);
    values[found - sheet->lambda_um] = t->rows[i].numbers[VALUE];
  }
  sheet->csv.line = t->rows[first].line;
  size_t absent = sheet->wavelengths - (end - first), counted = sheet->skipped.below_horizon;
  HETAB_TRY(hetab_sheet_add(sheet, &angles, values));
  if (sheet->skipped.below_horizon == counted)
    sheet->skipped.not_finite -= absent;
  return HETAB_OK;
}

static hetab_status fill_sheet(table *t) {
  HETAB_FREED double *values = hetab_alloc(t->sheet->ctx, t->sheet->wavelengths, sizeof *values);
  HETAB_NEED(values);
  for (size_t first = 0, end; first < t->count; first = end) {
    const row *r = &t->rows[first];
    for (end = first + 1;
         end < t->count && same_direction(r, r + (end - first)) && t->rows[end].repeat == r->repeat;
         end++)
      ;
    HETAB_TRY(add_pair(t, first, end, values));
  }
  return HETAB_OK;
}

static hetab_status finish(table *t) {
  if (t->count == 0)
    return hetab_csv_fail(t->csv, "no rows: give lines of numbers below the header");
  HETAB_TRY(check_unit(t));
  if (t->wavelengths)
    return HETAB_OK;
  sort_rows(t);
  HETAB_TRY(begin_sheet(t));
  return fill_sheet(t);
}

static hetab_status read_csv(table *t) {
  HETAB_TRY(hetab_csv_header(t->csv, wanted, ROLES));
  if (!t->csv->named)
    return hetab_csv_fail(t->csv, "no header: the header is %s", example);
  HETAB_TRY(find_columns(t));
  for (;;) {
    HETAB_TRY(hetab_csv_row(t->csv));
    if (!t->csv->count)
      return finish(t);
    HETAB_TRY(read_row(t));
  }
}

/* ---- ASTM E1392 style ---------------------------------------------------------------------- */

/* What follows the key in the line at hand, or NULL if the line has another. */
static char *value_of(const hetab_csv *csv, const char *key) {
  size_t length = strlen(key);
  char *line = csv->content;
  if (strncasecmp(line, key, length) != 0 || !line[length] || !strchr(" \t", line[length]))
    return NULL;
  return line + length + strspn(line + length, " \t");
}

static hetab_status read_points(hetab_csv *csv, const char *text, double *points) {
  if (hetab_number_parse(text, points) && *points >= 0)
    return HETAB_OK;
  return hetab_csv_fail(csv, "NUM_POINTS: '%.40s' is no count: give the number of rows", text);
}

static hetab_status read_vars(table *t, char *names) {
  HETAB_TRY(hetab_csv_names(t->csv, names, wanted, ROLES));
  for (size_t i = 0; i < t->csv->columns; i++)
    if (t->csv->column[i].quantity == HETAB_ANGLE && !(t->csv->column[i].unit > 0))
      t->csv->column[i].unit = 1;
  return find_columns(t);
}

static hetab_status read_astm(table *t) {
  hetab_csv *csv = t->csv;
  double points = -1;
  for (char *value;;) {
    HETAB_TRY(hetab_csv_line(csv));
    if (!csv->content)
      break;
    if ((value = value_of(csv, "NUM_POINTS")))
      HETAB_TRY(read_points(csv, value, &points));
    else if (!csv->columns && (value = value_of(csv, "VARS")))
      HETAB_TRY(read_vars(t, value));
    else if (csv->columns) {
      HETAB_TRY(hetab_csv_fields(csv));
      HETAB_TRY(read_row(t));
    }
  }
  if (!csv->columns)
    return hetab_csv_fail(csv,
                          "no VARS line: name the columns, VARS theta_i,phi_i,theta_s,phi_s,550nm");
  if (points >= 0 && (double)t->count != points)
    return hetab_csv_fail(csv, "%zu rows where NUM_POINTS says %.0f: get a complete copy", t->count,
                          points);
  return finish(t);
}

static hetab_status read_with(hetab_sheet *sheet, hetab_status (*read)(table *t)) {
  table t = {.sheet = sheet, .csv = &sheet->csv};
  hetab_status status = read(&t);
  free(t.wide);
  free(t.lambda_um);
  free(t.values);
  free(t.rows);
  return status;
}

hetab_status hetab_measurements_read_csv(hetab_sheet *sheet) {
  return read_with(sheet, read_csv);
}

hetab_status hetab_measurements_read_astm(hetab_sheet *sheet) {
  return read_with(sheet, read_astm);
}
