/* The Cornell gonioreflectometer's text: '#' comments; how many wavelengths; the wavelengths in nm;
 * then rows of theta_i phi_i theta_s phi_s in radians and a BRDF per wavelength. The numbers before
 * the rows may be spread over lines as one likes; a row has lines of its own. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measured/measurement_sheet.h"
#include "measured/measurement_text.h"
#include "core/number.h"

enum { ANGLES = 4 };

typedef struct words {
  hetab_sheet *sheet;
  char *text;    /* what follows the line at hand */
  char *rest;    /* of the line at hand; NULL or "": none */
  size_t length; /* of the whole text: no file has more numbers than half of it */
} words;

/* The next word, on the next line with content if this one has ended; NULL at the end of the text.
 */
static char *next_word(words *w) {
  while (!w->rest || !*w->rest) {
    w->rest = hetab_cut_content(&w->text, &w->sheet->line);
    if (!w->rest)
      return NULL;
  }
  char *word = w->rest;
  size_t span = strcspn(word, " \t,");
  w->rest = word + span;
  if (*w->rest) {
    *w->rest++ = '\0';
    w->rest += strspn(w->rest, " \t,");
  }
  return word;
}

static hetab_status next_number(words *w, const char *what, double *value) {
  const char *word = next_word(w);
  if (!word)
    return hetab_sheet_fail(w->sheet, "the file ends before the %s: get a complete copy", what);
  if (!hetab_number_parse(word, value) || !isfinite(*value))
    return hetab_sheet_fail(w->sheet, "'%.40s' is not a number: give the %s", word, what);
  return HETAB_OK;
}

static hetab_status read_wavelengths(words *w) {
  double count = 0;
  HETAB_TRY(next_number(w, "number of wavelengths", &count));
  if (!(count >= 1 && count == floor(count) && count <= (double)w->length / 2))
    return hetab_sheet_fail(w->sheet,
                            "%g wavelengths: the file begins with their number, then the "
                            "wavelengths in nm",
                            count);
  double *lambda_um = hetab_alloc(w->sheet->ctx, (size_t)count, sizeof *lambda_um);
  hetab_status status = lambda_um ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t i = 0; i < (size_t)count && status == HETAB_OK; i++) {
    status = next_number(w, "wavelengths in nm", &lambda_um[i]);
    lambda_um[i] /= 1000;
  }
  if (status == HETAB_OK)
    status = hetab_sheet_begin(w->sheet, lambda_um, (size_t)count);
  free(lambda_um);
  return status;
}

/* numbers[0] has been read from `first`; the others follow. */
static hetab_status read_row(words *w, const char *first, double *numbers) {
  size_t count = ANGLES + w->sheet->wavelengths, start = w->sheet->line;
  for (size_t i = 0; i < count; i++) {
    const char *word = i ? next_word(w) : first;
    if (!word)
      return hetab_sheet_fail(w->sheet, "the file ends %zu numbers short of a row: complete it",
                              count - i);
    bool good = i < ANGLES ? hetab_number_parse(word, &numbers[i]) && isfinite(numbers[i])
                           : hetab_measured_value(word, &numbers[i]);
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
  for (const char *first; (first = next_word(w));) {
    HETAB_TRY(read_row(w, first, numbers));
    hetab_measured_angles angles = {numbers[0], numbers[1], numbers[2], numbers[3]};
    HETAB_TRY(hetab_sheet_add(w->sheet, &angles, numbers + ANGLES));
  }
  return HETAB_OK;
}

hetab_status hetab_measurements_read_brdf(hetab_sheet *sheet, char *text) {
  words w = {.sheet = sheet, .text = text, .length = strlen(text)};
  HETAB_TRY(read_wavelengths(&w));
  double *numbers = hetab_alloc(sheet->ctx, ANGLES + sheet->wavelengths, sizeof *numbers);
  hetab_status status = numbers ? read_rows(&w, numbers) : HETAB_ERR_MEMORY;
  free(numbers);
  return status;
}
