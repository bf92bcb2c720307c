/* CSV, a value a row: columns in any order, found by name; the rows of one pair of directions are
 * brought together. A pair that was measured twice at a wavelength stays two. */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measured/measurement_sheet.h"
#include "measured/measurement_text.h"
#include "core/number.h"

enum { WAVELENGTH, THETA_I, THETA_R, PHI, PHI_I, PHI_R, VALUE, ROLES };

static const double degree = M_PI / 180;

/* Names of columns, lower case, and what a number there is worth in um, radians or 1/sr. */
static const struct {
  const char *name;
  int role;
  double unit;
} names[] = {
    {"wavelength_nm", WAVELENGTH, 1e-3},
    {"lambda_nm", WAVELENGTH, 1e-3},
    {"wavelength_um", WAVELENGTH, 1},
    {"lambda_um", WAVELENGTH, 1},
    {"theta_i_deg", THETA_I, M_PI / 180},
    {"theta_r_deg", THETA_R, M_PI / 180},
    {"theta_s_deg", THETA_R, M_PI / 180},
    {"phi_deg", PHI, M_PI / 180},
    {"phi_i_deg", PHI_I, M_PI / 180},
    {"phi_r_deg", PHI_R, M_PI / 180},
    {"phi_s_deg", PHI_R, M_PI / 180},
    {"theta_i_rad", THETA_I, 1},
    {"theta_r_rad", THETA_R, 1},
    {"theta_s_rad", THETA_R, 1},
    {"phi_rad", PHI, 1},
    {"phi_i_rad", PHI_I, 1},
    {"phi_r_rad", PHI_R, 1},
    {"phi_s_rad", PHI_R, 1},
    {"f", VALUE, 1},
    {"brdf", VALUE, 1},
    {"total", VALUE, 1}, /* what `hetab eval` writes */
};
enum { NAMES = sizeof names / sizeof *names };
static const char *const example = "wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f";

typedef struct row {
  double numbers[ROLES]; /* um, radians, 1/sr */
  size_t line, repeat;   /* how often the pair was measured before at this wavelength */
} row;

typedef struct csv {
  hetab_sheet *sheet;
  char separator;
  size_t fields;
  int *role; /* [fields], -1: passed over */
  double *unit;
  bool seen[ROLES], degrees;
  row *rows;
  size_t count, capacity;
} csv;

/* ---- the header ---------------------------------------------------------------------------- */

/* Whether the name begins as one that counts, but has no unit or a strange one. */
static bool lacks_unit(const char *name) {
  static const char *const stems[] = {"wavelength", "lambda", "theta_i", "theta_r",
                                      "theta_s",    "phi",    NULL};
  for (const char *const *stem = stems; *stem; stem++)
    if (strncmp(name, *stem, strlen(*stem)) == 0)
      return true;
  return false;
}

static void strip_quotes(char **field) {
  size_t length = strlen(*field);
  if (length >= 2 && **field == '"' && (*field)[length - 1] == '"') {
    (*field)[length - 1] = '\0';
    ++*field;
  }
}

static hetab_status read_name(csv *c, char *name, size_t field) {
  c->role[field] = -1;
  strip_quotes(&name);
  for (char *letter = name; *letter; letter++)
    *letter = (char)tolower((unsigned char)*letter);
  for (size_t i = 0; i < NAMES; i++) {
    if (strcmp(name, names[i].name) != 0)
      continue;
    if (c->seen[names[i].role])
      return hetab_sheet_fail(c->sheet, "column '%.40s': there is another for the same: remove one",
                              name);
    c->seen[names[i].role] = true;
    c->role[field] = names[i].role;
    c->unit[field] = names[i].unit;
    c->degrees |= names[i].unit == degree;
    return HETAB_OK;
  }
  if (lacks_unit(name))
    return hetab_sheet_fail(c->sheet,
                            "column '%.40s': unit not known: name it with its unit: wavelength_nm "
                            "or _um, theta_i_deg or _rad",
                            name);
  return HETAB_OK;
}

static hetab_status check_columns(csv *c) {
  static const char *const wanted[] = {[WAVELENGTH] = "wavelength_nm",
                                       [THETA_I] = "theta_i_deg",
                                       [THETA_R] = "theta_r_deg",
                                       [PHI] = "phi_deg (or phi_i_deg and phi_r_deg)",
                                       [VALUE] = "f"};
  bool both = c->seen[PHI_I] && c->seen[PHI_R];
  if (c->seen[PHI] && (c->seen[PHI_I] || c->seen[PHI_R]))
    return hetab_sheet_fail(c->sheet, "phi and phi_i or phi_r: give phi, or the other two");
  for (int role = 0; role < ROLES; role++)
    if (wanted[role] && !c->seen[role] && !(role == PHI && both))
      return hetab_sheet_fail(c->sheet, "no column %s: the header is %s", wanted[role], example);
  return HETAB_OK;
}

static hetab_status read_header(csv *c, char **text) {
  char *line = hetab_cut_content(text, &c->sheet->line);
  if (!line)
    return hetab_sheet_fail(c->sheet, "no header: give %s and rows", example);
  c->separator = strchr(line, ',') ? ',' : strchr(line, ';') ? ';' : '\t';
  c->fields = hetab_count_fields(line, c->separator);
  c->role = hetab_alloc(c->sheet->ctx, c->fields, sizeof *c->role);
  c->unit = hetab_alloc(c->sheet->ctx, c->fields, sizeof *c->unit);
  if (!c->role || !c->unit)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < c->fields; i++)
    HETAB_TRY(read_name(c, hetab_cut_field(&line, c->separator), i));
  return check_columns(c);
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status read_field(csv *c, const char *field, size_t i, row *r) {
  int role = c->role[i];
  double value;
  bool good = role == VALUE ? hetab_measured_value(field, &value)
                            : hetab_number_parse(field, &value) && isfinite(value);
  if (!good)
    return hetab_sheet_fail(c->sheet, "'%.40s' is not a number: give %s", field,
                            role == VALUE        ? "a BRDF in 1/sr"
                            : role == WAVELENGTH ? "a wavelength"
                                                 : "an angle");
  r->numbers[role] = value * c->unit[i];
  return HETAB_OK;
}

static hetab_status check_row(csv *c, const row *r) {
  if (!(r->numbers[WAVELENGTH] > 0))
    return hetab_sheet_fail(c->sheet, "the wavelength is not positive: give one above 0");
  if (fabs(r->numbers[THETA_I]) <= M_PI && fabs(r->numbers[THETA_R]) <= M_PI)
    return HETAB_OK;
  return hetab_sheet_fail(c->sheet, "a polar angle of more than 180 degrees: check its unit");
}

static hetab_status read_row(csv *c, char *line, row *r) {
  *r = (row){.line = c->sheet->line};
  size_t count = hetab_count_fields(line, c->separator);
  if (count != c->fields)
    return hetab_sheet_fail(c->sheet, "%zu fields where the header names %zu: give one for each",
                            count, c->fields);
  for (size_t i = 0; i < count; i++) {
    char *field = hetab_cut_field(&line, c->separator);
    strip_quotes(&field);
    if (c->role[i] >= 0)
      HETAB_TRY(read_field(c, field, i, r));
  }
  return check_row(c, r);
}

static hetab_status read_rows(csv *c, char *text) {
  for (char *line; (line = hetab_cut_content(&text, &c->sheet->line));) {
    if (c->count == c->capacity) {
      c->capacity = 2 * c->capacity + 256;
      row *grown = realloc(c->rows, c->capacity * sizeof *grown);
      if (!grown)
        return hetab_fail(c->sheet->ctx, HETAB_ERR_MEMORY, "%s: out of memory", c->sheet->path);
      c->rows = grown;
    }
    HETAB_TRY(read_row(c, line, &c->rows[c->count]));
    c->count++;
  }
  if (c->count == 0)
    return hetab_sheet_fail(c->sheet, "no rows: give lines of numbers below the header");
  return HETAB_OK;
}

/* Radians in columns of degrees: a scan that never leaves the normal's neighbourhood. */
static hetab_status check_unit(csv *c) {
  double largest = 0;
  for (size_t i = 0; i < c->count; i++)
    for (int role = THETA_I; role <= PHI_R; role++)
      largest = fmax(largest, fabs(c->rows[i].numbers[role]) / degree);
  if (!c->degrees || largest == 0 || largest > 2 * M_PI + 1e-3)
    return HETAB_OK;
  c->sheet->line = c->rows[0].line;
  return hetab_sheet_fail(c->sheet,
                          "no angle in the file exceeds %.3g degrees: if they are radians, name "
                          "the columns theta_i_rad and so on",
                          largest);
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
enum { DIRECTION_ROLES = 5 };

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

static void sort_rows(csv *c) {
  qsort(c->rows, c->count, sizeof *c->rows, by_direction);
  for (size_t i = 1; i < c->count; i++) {
    row *r = &c->rows[i];
    if (same_direction(r, r - 1) && r->numbers[WAVELENGTH] == r[-1].numbers[WAVELENGTH])
      r->repeat = r[-1].repeat + 1;
  }
  qsort(c->rows, c->count, sizeof *c->rows, by_repeat);
}

static hetab_status begin_sheet(csv *c) {
  size_t count = 0;
  double *lambda_um = hetab_alloc(c->sheet->ctx, c->count, sizeof *lambda_um);
  if (!lambda_um)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < c->count; i++)
    lambda_um[i] = c->rows[i].numbers[WAVELENGTH];
  qsort(lambda_um, c->count, sizeof *lambda_um, by_size);
  for (size_t i = 0; i < c->count; i++)
    if (i == 0 || lambda_um[i] != lambda_um[i - 1])
      lambda_um[count++] = lambda_um[i];
  hetab_status status = hetab_sheet_begin(c->sheet, lambda_um, count);
  free(lambda_um);
  return status;
}

/* The rows first..end of one pair, in one row of the sheet; what the file has no row for is missing
 * without being counted. */
static hetab_status add_pair(csv *c, size_t first, size_t end, double *values) {
  hetab_sheet *sheet = c->sheet;
  const double *n = c->rows[first].numbers;
  hetab_measured_angles angles = {n[THETA_I], n[PHI_I], n[THETA_R],
                                  c->seen[PHI] ? n[PHI] : n[PHI_R]};
  for (size_t i = 0; i < sheet->wavelengths; i++)
    values[i] = NAN;
  for (size_t i = first; i < end; i++) {
    const double *found = bsearch(&c->rows[i].numbers[WAVELENGTH], sheet->lambda_um,
                                  sheet->wavelengths, sizeof *found, by_size);
    values[found - sheet->lambda_um] = c->rows[i].numbers[VALUE];
  }
  sheet->line = c->rows[first].line;
  size_t absent = sheet->wavelengths - (end - first), counted = sheet->skipped.below_horizon;
  HETAB_TRY(hetab_sheet_add(sheet, &angles, values));
  if (sheet->skipped.below_horizon == counted)
    sheet->skipped.not_finite -= absent;
  return HETAB_OK;
}

static hetab_status fill_sheet(csv *c) {
  double *values = hetab_alloc(c->sheet->ctx, c->sheet->wavelengths, sizeof *values);
  hetab_status status = values ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t first = 0, end; first < c->count && status == HETAB_OK; first = end) {
    const row *r = &c->rows[first];
    for (end = first + 1;
         end < c->count && same_direction(r, r + (end - first)) && c->rows[end].repeat == r->repeat;
         end++)
      ;
    status = add_pair(c, first, end, values);
  }
  free(values);
  return status;
}

static hetab_status read_file(csv *c, char *text) {
  HETAB_TRY(read_header(c, &text));
  HETAB_TRY(read_rows(c, text));
  HETAB_TRY(check_unit(c));
  sort_rows(c);
  HETAB_TRY(begin_sheet(c));
  return fill_sheet(c);
}

hetab_status hetab_measurements_read_csv(hetab_sheet *sheet, char *text) {
  csv c = {.sheet = sheet};
  hetab_status status = read_file(&c, text);
  free(c.role);
  free(c.unit);
  free(c.rows);
  return status;
}
