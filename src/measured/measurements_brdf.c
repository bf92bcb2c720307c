/* The Cornell gonioreflectometer's text: '#' comments; how many wavelengths; the wavelengths in nm;
 * then rows of theta_i phi_i theta_s phi_s in radians and a BRDF per wavelength. The numbers before
 * the rows may be spread over lines as one likes; a row has lines of its own. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measured/measurement_sheet.h"

enum { ANGLES = 4 };

typedef struct words {
  hetab_sheet *sheet;
  char *rest; /* of the line at hand; NULL or "": none */
} words;

/* The next word, on the next line with content if this one has ended; NULL at the end of the text.
 */
static hetab_status next_word(words *w, char **word) {
  static const char blanks[] = " \t,";
  while (!w->rest || !*w->rest) {
    HETAB_TRY(hetab_csv_line(&w->sheet->csv));
    w->rest = *word = w->sheet->csv.content;
    if (!w->rest)
      return HETAB_OK;
    w->rest[strcspn(w->rest, "#")] = '\0';
    w->rest += strspn(w->rest, blanks);
  }
  *word = w->rest;
  w->rest += strcspn(w->rest, blanks);
  if (*w->rest) {
    *w->rest++ = '\0';
    w->rest += strspn(w->rest, blanks);
  }
  return HETAB_OK;
}

static hetab_status next_number(words *w, const char *what, double *value) {
  char *word;
  HETAB_TRY(next_word(w, &word));
  if (!word)
    return hetab_sheet_fail(w->sheet, "the file ends before the %s: get a complete copy", what);
  if (!hetab_number_parse(word, value) || !isfinite(*value))
    return hetab_sheet_fail(w->sheet, "'%.40s' is not a number: give the %s", word, what);
  return HETAB_OK;
}

static hetab_status read_wavelengths(words *w) {
  double count = 0;
  HETAB_TRY(next_number(w, "number of wavelengths", &count));
  if (!(count >= 1 && count == floor(count) && count <= (double)strlen(w->sheet->csv.text) / 2))
    return hetab_sheet_fail(w->sheet,
                            "%g wavelengths: the file begins with their number, then the "
                            "wavelengths in nm",
                            count);
  HETAB_FREED double *lambda_um = hetab_alloc(w->sheet->ctx, (size_t)count, sizeof *lambda_um);
  HETAB_NEED(lambda_um);
  for (size_t i = 0; i < (size_t)count; i++) {
    HETAB_TRY(next_number(w, "wavelengths in nm", &lambda_um[i]));
    lambda_um[i] /= 1000;
  }
  return hetab_sheet_begin(w->sheet, lambda_um, (size_t)count);
}

/* The file's next row; *end where there is none. */
static hetab_status read_row(words *w, double *numbers, bool *end) {
  size_t count = ANGLES + w->sheet->wavelengths, start = 0;
  *end = false;
  for (size_t i = 0; i < count; i++) {
    char *word;
    HETAB_TRY(next_word(w, &word));
    start = i ? start : w->sheet->csv.line;
    *end = !word && i == 0;
    if (*end)
      return HETAB_OK;
    if (!word)
      return hetab_sheet_fail(w->sheet, "the file ends %zu numbers short of a row: complete it",
                              count - i);
    bool good = i < ANGLES ? hetab_number_parse(word, &numbers[i]) && isfinite(numbers[i])
                           : hetab_number_or_missing(word, &numbers[i]);
    if (!good)
      return hetab_sheet_fail(w->sheet, "'%.40s' is not a number: give %s", word,
                              i < ANGLES ? "theta_i phi_i theta_s phi_s in radians"
                                         : "a BRDF in 1/sr");
  }
  if (w->rest && *w->rest)
    return hetab_sheet_fail(w->sheet,
                            "the row that starts at line %zu ends within this one: a row has 4 "
                            "angles and %zu values on lines of its own",
                            start, w->sheet->wavelengths);
  return HETAB_OK;
}

static hetab_status read_rows(words *w, double *numbers) {
  if (w->rest && *w->rest)
    return hetab_sheet_fail(w->sheet, "more than %zu wavelengths: begin the rows on a new line",
                            w->sheet->wavelengths);
  for (bool end;;) {
    HETAB_TRY(read_row(w, numbers, &end));
    if (end)
      return HETAB_OK;
    hetab_measured_angles angles = {numbers[0], numbers[1], numbers[2], numbers[3]};
    HETAB_TRY(hetab_sheet_add(w->sheet, &angles, numbers + ANGLES));
  }
}

hetab_status hetab_measurements_read_brdf(hetab_sheet *sheet) {
  words w = {.sheet = sheet};
  HETAB_TRY(read_wavelengths(&w));
  HETAB_FREED double *numbers =
      hetab_alloc(sheet->ctx, ANGLES + sheet->wavelengths, sizeof *numbers);
  HETAB_NEED(numbers);
  return read_rows(&w, numbers);
}
