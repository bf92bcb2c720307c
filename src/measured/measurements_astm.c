/* ASTM E1392 style: header lines of a key and a text, of which VARS names the columns and
 * NUM_POINTS counts the rows; then comma-separated rows. Columns in any order: theta_i, phi_i,
 * theta_s, phi_s in radians and a BRDF for each wavelength ("550nm"); others are passed over. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "measured/measurement_sheet.h"
#include "measured/measurement_text.h"
#include "core/number.h"

enum { THETA_I, PHI_I, THETA_S, PHI_S, ANGLES };
static const char *const angle_names[ANGLES] = {"theta_i", "phi_i", "theta_s", "phi_s"};

/* What the fields of a row are. */
typedef enum { PASSED_OVER, ANGLE, VALUE } role;
typedef struct column {
  role role;
  size_t place; /* which angle, or which wavelength */
} column;

typedef struct astm {
  hetab_sheet *sheet;
  column *columns; /* [count] */
  size_t count, wavelengths;
  double *lambda_um;
  double points; /* NUM_POINTS; negative: not given */
  double angles[ANGLES];
  double *values; /* [wavelengths] of a row */
} astm;

/* ---- the header ---------------------------------------------------------------------------- */

/* "550nm" or "0.55um"; false if it is none. */
static bool read_wavelength(const char *word, double *lambda_um) {
  char number[64];
  size_t length = strlen(word);
  if (length < 3 || length >= sizeof number || strcasecmp(word + length - 1, "m") != 0)
    return false;
  double per_um = strcasecmp(word + length - 2, "nm") == 0   ? 1000
                  : strcasecmp(word + length - 2, "um") == 0 ? 1
                                                             : 0;
  snprintf(number, sizeof number, "%.*s", (int)length - 2, word);
  if (per_um == 0 || !hetab_number_parse(number, lambda_um))
    return false;
  *lambda_um /= per_um;
  return true;
}

static int find_angle(const char *word) {
  for (int i = 0; i < ANGLES; i++)
    if (strcasecmp(word, angle_names[i]) == 0)
      return i;
  return strcasecmp(word, "theta_r") == 0 ? THETA_S : strcasecmp(word, "phi_r") == 0 ? PHI_S : -1;
}

static hetab_status read_column(astm *a, const char *word, bool seen[ANGLES], column *c) {
  int angle = find_angle(word);
  if (angle >= 0) {
    if (seen[angle])
      return hetab_sheet_fail(a->sheet, "VARS: column %s twice: keep one", word);
    seen[angle] = true;
    *c = (column){ANGLE, (size_t)angle};
  } else if (read_wavelength(word, &a->lambda_um[a->wavelengths])) {
    *c = (column){VALUE, a->wavelengths++};
  }
  return HETAB_OK;
}

static hetab_status read_columns(astm *a, char *names) {
  bool seen[ANGLES] = {false};
  a->count = hetab_count_fields(names, ',');
  a->columns = hetab_alloc(a->sheet->ctx, a->count, sizeof *a->columns);
  a->lambda_um = hetab_alloc(a->sheet->ctx, a->count, sizeof *a->lambda_um);
  if (!a->columns || !a->lambda_um)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < a->count; i++)
    HETAB_TRY(read_column(a, hetab_cut_field(&names, ','), seen, &a->columns[i]));
  for (int i = 0; i < ANGLES; i++)
    if (!seen[i])
      return hetab_sheet_fail(a->sheet, "VARS: no column %s: name it", angle_names[i]);
  if (a->wavelengths == 0)
    return hetab_sheet_fail(a->sheet, "VARS: no wavelength: name the columns of values by it, with "
                                      "its unit: 550nm or 0.55um");
  a->values = hetab_alloc(a->sheet->ctx, a->wavelengths, sizeof *a->values);
  return a->values ? hetab_sheet_begin(a->sheet, a->lambda_um, a->wavelengths) : HETAB_ERR_MEMORY;
}

/* What follows the key, or NULL if the line has another. */
static char *value_of(char *line, const char *key) {
  size_t length = strlen(key);
  if (strncasecmp(line, key, length) != 0 || !line[length] || !strchr(" \t", line[length]))
    return NULL;
  return line + length + strspn(line + length, " \t");
}

static hetab_status read_points(astm *a, const char *text) {
  if (hetab_number_parse(text, &a->points) && a->points >= 0)
    return HETAB_OK;
  return hetab_sheet_fail(a->sheet, "NUM_POINTS: '%.40s' is no count: give the number of rows",
                          text);
}

/* VARS ends the header but for NUM_POINTS, which may follow it. */
static hetab_status read_header(astm *a, char **text) {
  for (char *line, *value; (line = hetab_cut_line(text, &a->sheet->line));) {
    if ((value = value_of(line, "NUM_POINTS")))
      HETAB_TRY(read_points(a, value));
    else if ((value = value_of(line, "VARS")))
      return read_columns(a, value);
  }
  return hetab_sheet_fail(a->sheet,
                          "no VARS line: name the columns, VARS theta_i,phi_i,theta_s,phi_s,550nm");
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status read_field(astm *a, const char *field, const column *c) {
  if (c->role == ANGLE &&
      !(hetab_number_parse(field, &a->angles[c->place]) && isfinite(a->angles[c->place])))
    return hetab_sheet_fail(a->sheet, "%s: '%.40s' is not a number: give radians",
                            angle_names[c->place], field);
  if (c->role == VALUE && !hetab_measured_value(field, &a->values[c->place]))
    return hetab_sheet_fail(a->sheet, "'%.40s' is not a number: give a BRDF in 1/sr", field);
  return HETAB_OK;
}

static hetab_status read_row(astm *a, char *line) {
  size_t count = hetab_count_fields(line, ',');
  if (count != a->count)
    return hetab_sheet_fail(a->sheet, "%zu fields where VARS names %zu: give one for each", count,
                            a->count);
  for (size_t i = 0; i < count; i++)
    HETAB_TRY(read_field(a, hetab_cut_field(&line, ','), &a->columns[i]));
  hetab_measured_angles angles = {a->angles[THETA_I], a->angles[PHI_I], a->angles[THETA_S],
                                  a->angles[PHI_S]};
  return hetab_sheet_add(a->sheet, &angles, a->values);
}

static hetab_status read_file(astm *a, char *text) {
  double rows = 0;
  HETAB_TRY(read_header(a, &text));
  for (char *line; (line = hetab_cut_content(&text, &a->sheet->line));) {
    char *points = value_of(line, "NUM_POINTS");
    HETAB_TRY(points ? read_points(a, points) : read_row(a, line));
    rows += !points;
  }
  if (a->points >= 0 && rows != a->points)
    return hetab_sheet_fail(a->sheet, "%.0f rows where NUM_POINTS says %.0f: get a complete copy",
                            rows, a->points);
  return HETAB_OK;
}

hetab_status hetab_measurements_read_astm(hetab_sheet *sheet, char *text) {
  astm a = {.sheet = sheet, .points = -1};
  hetab_status status = read_file(&a, text);
  free(a.columns);
  free(a.lambda_um);
  free(a.values);
  return status;
}
