#include "surface/wavelengths.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/number.h"

enum { MAX_WAVELENGTHS = 100000 };

static const char *const wanted = "start:stop:step or a list, as in 400:700:10 or 400,550,700";

/* ---- checking ---- */

hetab_status hetab_wavelengths_check(hetab_context *ctx, const double *lambda_um, size_t count) {
  if (count < 1 || count > MAX_WAVELENGTHS)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%zu wavelengths: give 1 to %d", count,
                      MAX_WAVELENGTHS);
  for (size_t i = 0; i < count; i++) {
    if (hetab_number_check(ctx, &hetab_rule_length, lambda_um[i]) != HETAB_OK)
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%g nm is no wavelength: give %s",
                        lambda_um[i] * 1e3, hetab_rule_length.wanted);
    if (i > 0 && lambda_um[i] <= lambda_um[i - 1])
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "wavelengths do not ascend: %g nm follows %g nm: sort them, each once",
                        lambda_um[i] * 1e3, lambda_um[i - 1] * 1e3);
  }
  return HETAB_OK;
}

/* ---- parsing ---- */

/* Split text at the separator into at most `room` numbers. */
static hetab_status split_numbers(hetab_context *ctx, const char *text, char separator,
                                  double *values, size_t room, size_t *count) {
  char word[HETAB_NUMBER_TEXT * 2];
  for (*count = 0; text; ++*count) {
    const char *end = strchr(text, separator);
    size_t length = end ? (size_t)(end - text) : strlen(text);
    snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word), text);
    double value;
    if (!hetab_number_parse(word, &value) || !isfinite(value))
      return hetab_fail(ctx, HETAB_ERR_PARSE, "'%.40s' is not a wavelength: give %s", word, wanted);
    if (*count == room)
      return hetab_fail(ctx, HETAB_ERR_PARSE, "too many numbers: give %s", wanted);
    values[*count] = value;
    text = end ? end + 1 : NULL;
  }
  return HETAB_OK;
}

/* The number of steps from start to stop, which has to be whole. */
static hetab_status count_steps(hetab_context *ctx, double start, double stop, double step,
                                size_t *steps) {
  if (!(step > 0) || !(stop >= start))
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "%g:%g:%g does not ascend: give start <= stop, step > 0", start, stop, step);
  double exact = (stop - start) / step;
  if (!(exact < MAX_WAVELENGTHS))
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%g:%g:%g has more than %d wavelengths: enlarge step",
                      start, stop, step, MAX_WAVELENGTHS);
  double whole = round(exact);
  if (fabs(exact - whole) > 1e-6)
    return hetab_fail(
        ctx, HETAB_ERR_PARSE,
        "%g:%g:%g does not end on its stop: set stop to %.10g or %.10g, or change step", start,
        stop, step, start + floor(exact) * step, start + ceil(exact) * step);
  *steps = (size_t)whole;
  return HETAB_OK;
}

static hetab_status parse_range(hetab_context *ctx, const char *text, double **values,
                                size_t *count) {
  double ends[3];
  size_t given = 0, steps = 0;
  HETAB_TRY(split_numbers(ctx, text, ':', ends, 3, &given));
  if (given != 3)
    return hetab_fail(ctx, HETAB_ERR_PARSE, "'%.40s' is no range: give %s", text, wanted);
  HETAB_TRY(count_steps(ctx, ends[0], ends[1], ends[2], &steps));
  *values = hetab_alloc(ctx, steps + 1, sizeof **values);
  HETAB_NEED(*values);
  *count = steps + 1;
  /* From both ends, so that decimal steps land on decimal values: 400.3, not 400 + 3 * 0.1. */
  for (size_t i = 0; i <= steps; i++)
    (*values)[i] = steps ? ends[0] + (ends[1] - ends[0]) * (double)i / (double)steps : ends[0];
  return HETAB_OK;
}

static hetab_status parse_list(hetab_context *ctx, const char *text, double **values,
                               size_t *count) {
  size_t room = 1;
  for (const char *c = text; *c; c++)
    room += *c == ',';
  double *numbers = hetab_alloc(ctx, room, sizeof *numbers);
  HETAB_NEED(numbers);
  hetab_status status = split_numbers(ctx, text, ',', numbers, room, count);
  if (status != HETAB_OK) {
    free(numbers);
    return status;
  }
  *values = numbers;
  return HETAB_OK;
}

hetab_status hetab_wavelengths_parse(hetab_context *ctx, const char *text, double per_um,
                                     double **lambda_um, size_t *count) {
  double *values = NULL;
  size_t given = 0;
  HETAB_TRY(strchr(text, ':') ? parse_range(ctx, text, &values, &given)
                              : parse_list(ctx, text, &values, &given));
  for (size_t i = 0; i < given; i++)
    values[i] /= per_um;
  hetab_status status = hetab_wavelengths_check(ctx, values, given);
  if (status != HETAB_OK) {
    free(values);
    return status;
  }
  *lambda_um = values;
  *count = given;
  return HETAB_OK;
}

hetab_status hetab_parse_wavelengths(hetab_context *ctx, const char *text, double **lambda_um,
                                     size_t *count) {
  *lambda_um = NULL;
  return hetab_wavelengths_parse(ctx, text, 1000, lambda_um, count);
}

/* ---- writing ---- */

/* A value in nm that divides to exactly this double in um, the roundest first. For one um value in
 * fifty there is none: where nm have the wider spacing. */
static bool to_nm(double um, double *nm) {
  double near = um * 1000, round_near;
  char text[HETAB_NUMBER_TEXT];
  snprintf(text, sizeof text, "%.12g", near);
  if (!hetab_number_parse(text, &round_near))
    round_near = near;
  const double candidates[] = {round_near, near, nextafter(near, 0), nextafter(near, HUGE_VAL)};
  for (size_t i = 0; i < 4; i++) {
    *nm = candidates[i];
    if (*nm / 1000 == um)
      return true;
  }
  return false;
}

/* Try to say the values as start:stop:step in nm; false where that does not give them back. */
static bool format_range(hetab_context *ctx, const double *nm, const double *lambda_um,
                         size_t count, char *range, size_t size) {
  char start[HETAB_NUMBER_TEXT], stop[HETAB_NUMBER_TEXT], step[HETAB_NUMBER_TEXT];
  if (count < 3)
    return false;
  hetab_number_format(nm[0], start);
  hetab_number_format(nm[count - 1], stop);
  hetab_number_format((nm[count - 1] - nm[0]) / (double)(count - 1), step);
  snprintf(range, size, "%s:%s:%s", start, stop, step);
  HETAB_FREED double *back = NULL;
  size_t back_count;
  if (hetab_wavelengths_parse(ctx, range, 1000, &back, &back_count) != HETAB_OK)
    return false;
  bool same = back_count == count && memcmp(back, lambda_um, count * sizeof *back) == 0;
  return same;
}

void hetab_numbers_write(FILE *out, const double *values, size_t count) {
  for (size_t i = 0; i < count; i++) {
    char text[HETAB_NUMBER_TEXT];
    hetab_number_format(values[i], text);
    fprintf(out, "%s%s", i == 0 ? "[" : i % 8 ? ", " : ",\n  ", text);
  }
  fputs("]\n", out);
}

hetab_status hetab_wavelengths_write(hetab_context *ctx, FILE *out, const double *lambda_um,
                                     size_t count) {
  HETAB_FREED double *nm = hetab_alloc(ctx, count, sizeof *nm);
  HETAB_NEED(nm);
  bool exact = true;
  for (size_t i = 0; exact && i < count; i++)
    exact = to_nm(lambda_um[i], &nm[i]);
  char range[3 * HETAB_NUMBER_TEXT];
  if (exact && format_range(ctx, nm, lambda_um, count, range, sizeof range)) {
    fprintf(out, "wavelengths_nm: %s\n", range);
  } else {
    fputs(exact ? "wavelengths_nm: " : "wavelengths_um: ", out);
    hetab_numbers_write(out, exact ? nm : lambda_um, count);
  }
  return HETAB_OK;
}
