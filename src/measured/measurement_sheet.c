#include "measured/measurement_sheet.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measured/measurements_internal.h"

/* No gonioreflectometer measures outside: beyond lies a wavelength in the wrong unit. */
static const double shortest_um = 0.01, longest_um = 100;
static const size_t most_bytes = (size_t)1 << 31; /* of values */

const double hetab_rgb_um[3] = {0.61, 0.55, 0.46};

hetab_status hetab_sheet_fail(hetab_sheet *sheet, const char *format, ...) {
  char text[800];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  if (sheet->csv.text)
    return hetab_csv_fail(&sheet->csv, "%s", text);
  return hetab_fail(sheet->ctx, HETAB_ERR_PARSE, "%s: %s", sheet->path, text);
}

/* ---- wavelengths --------------------------------------------------------------------------- */

static hetab_status check_wavelength(hetab_sheet *sheet, double lambda_um) {
  if (lambda_um >= shortest_um && lambda_um <= longest_um)
    return HETAB_OK;
  return hetab_sheet_fail(sheet,
                          "a wavelength of %g um (%g nm) is outside 0.01 to 100 um: give it in the "
                          "unit that the format asks for",
                          lambda_um, 1000 * lambda_um);
}

/* Insertion: the place of every wavelength among those before it, which move up. */
static hetab_status place_wavelength(hetab_sheet *sheet, double lambda_um, size_t i) {
  size_t place = i;
  while (place > 0 && sheet->lambda_um[place - 1] > lambda_um)
    place--;
  if (place > 0 && sheet->lambda_um[place - 1] == lambda_um)
    return hetab_sheet_fail(sheet, "the wavelength %g nm is there twice: remove one",
                            1000 * lambda_um);
  memmove(sheet->lambda_um + place + 1, sheet->lambda_um + place,
          (i - place) * sizeof *sheet->lambda_um);
  for (size_t j = 0; j < i; j++)
    sheet->column[j] += sheet->column[j] >= place;
  sheet->lambda_um[place] = lambda_um;
  sheet->column[i] = place;
  return HETAB_OK;
}

hetab_status hetab_sheet_begin(hetab_sheet *sheet, const double *lambda_um, size_t wavelengths) {
  enum { MOST = 10000 };
  if (wavelengths == 0 || wavelengths > MOST)
    return hetab_sheet_fail(sheet, "%zu wavelengths: give 1 to %d", wavelengths, MOST);
  sheet->lambda_um = hetab_alloc(sheet->ctx, wavelengths, sizeof *sheet->lambda_um);
  sheet->column = hetab_alloc(sheet->ctx, wavelengths, sizeof *sheet->column);
  HETAB_NEED(sheet->lambda_um && sheet->column);
  sheet->wavelengths = wavelengths;
  for (size_t i = 0; i < wavelengths; i++) {
    HETAB_TRY(check_wavelength(sheet, lambda_um[i]));
    HETAB_TRY(place_wavelength(sheet, lambda_um[i], i));
  }
  return HETAB_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static hetab_status grow(hetab_sheet *sheet) {
  if (sheet->count < sheet->capacity)
    return HETAB_OK;
  size_t capacity = 2 * sheet->capacity + 256;
  size_t row = sheet->wavelengths * sizeof *sheet->values;
  if (capacity > most_bytes / row)
    return hetab_sheet_fail(sheet,
                            "more than %zu rows of %zu wavelengths: give fewer of either, or split "
                            "the file",
                            sheet->count, sheet->wavelengths);
  hetab_directions *pairs = realloc(sheet->pairs, capacity * sizeof *pairs);
  if (pairs)
    sheet->pairs = pairs;
  double *values = pairs ? realloc(sheet->values, capacity * row) : NULL;
  if (!values)
    return hetab_fail(sheet->ctx, HETAB_ERR_MEMORY, "%s: out of memory for %zu rows", sheet->path,
                      capacity);
  sheet->values = values;
  sheet->capacity = capacity;
  return HETAB_OK;
}

static hetab_status check_angles(hetab_sheet *sheet, const hetab_measured_angles *a) {
  const double round = 1e-3; /* pi as some program prints it */
  if (fabs(a->theta_i) <= M_PI + round && fabs(a->theta_r) <= M_PI + round &&
      fabs(a->phi_i) <= 4 * M_PI + round && fabs(a->phi_r) <= 4 * M_PI + round)
    return HETAB_OK;
  return hetab_sheet_fail(sheet,
                          "angles %g %g %g %g are too large for radians: convert them from degrees",
                          a->theta_i, a->phi_i, a->theta_r, a->phi_r);
}

/* Folded: the models here are symmetric in phi. */
static hetab_directions fold(const hetab_measured_angles *a) {
  double phi = a->phi_r - a->phi_i;
  if ((a->theta_i < 0) != (a->theta_r < 0))
    phi += M_PI;
  return (hetab_directions){fabs(a->theta_i), fabs(a->theta_r), fabs(remainder(phi, 2 * M_PI))};
}

static double counted(hetab_sheet *sheet, double value) {
  sheet->skipped.not_finite += isfinite(value) ? 0 : 1;
  sheet->skipped.negative += value < 0 && isfinite(value);
  return isfinite(value) ? value : (double)NAN;
}

hetab_status hetab_sheet_add(hetab_sheet *sheet, const hetab_measured_angles *angles,
                             const double *values) {
  HETAB_TRY(check_angles(sheet, angles));
  HETAB_TRY(grow(sheet));
  hetab_directions pair = fold(angles);
  if (pair.theta_i >= M_PI_2 || pair.theta_r >= M_PI_2) {
    sheet->skipped.below_horizon++;
    return HETAB_OK;
  }
  double *row = sheet->values + sheet->count * sheet->wavelengths;
  for (size_t i = 0; i < sheet->wavelengths; i++)
    if (isfinite(values[i]) && fabs(values[i]) > HETAB_MOST_BRDF)
      return hetab_sheet_fail(sheet, "a BRDF of %g / sr is no surface's: give at most %g / sr",
                              values[i], HETAB_MOST_BRDF);
  for (size_t i = 0; i < sheet->wavelengths; i++)
    row[sheet->column[i]] = counted(sheet, values[i]);
  sheet->pairs[sheet->count++] = pair;
  return HETAB_OK;
}

/* ---- the end ------------------------------------------------------------------------------- */

static bool has_value(const hetab_sheet *sheet) {
  for (size_t i = 0; i < sheet->count * sheet->wavelengths; i++)
    if (!isnan(sheet->values[i]))
      return true;
  return false;
}

/* "paint" of "folder/paint.brdf". */
static void name_of(const char *path, char *name, size_t size) {
  const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
  const char *dot = strrchr(base, '.');
  int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
  snprintf(name, size, "%.*s", length, base);
}

hetab_status hetab_sheet_finish(hetab_sheet *sheet, hetab_measurements **out) {
  const hetab_measurements_skipped *s = &sheet->skipped;
  if (!has_value(sheet))
    return hetab_sheet_fail(sheet,
                            "no usable value (%zu rows below the horizon, %zu values not finite): "
                            "give rows with measured values",
                            s->below_horizon, s->not_finite);
  char name[128];
  name_of(sheet->path, name, sizeof name);
  HETAB_TRY(hetab_measurements_new(sheet->ctx, name, sheet->wavelengths, sheet->count, out));
  memcpy((*out)->lambda_um, sheet->lambda_um, sheet->wavelengths * sizeof *sheet->lambda_um);
  memcpy((*out)->pairs, sheet->pairs, sheet->count * sizeof *sheet->pairs);
  memcpy((*out)->values, sheet->values, sheet->count * sheet->wavelengths * sizeof *sheet->values);
  (*out)->skipped = *s;
  return HETAB_OK;
}

void hetab_sheet_clear(hetab_sheet *sheet) {
  free(sheet->lambda_um);
  free(sheet->column);
  free(sheet->pairs);
  free(sheet->values);
}
