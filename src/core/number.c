#include "core/number.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* As the model's limits (model/limits.c). */
const hetab_rule hetab_rule_length = {1e-9, 1e6, "a length from 1e-9 to 1e6 um"};
const hetab_rule hetab_rule_slope = {1e-9, 1e9, "a slope sigma0/tau from 1e-9 to 1e9"};
const hetab_rule hetab_rule_n = {1e-6, 1e3, "an index n > 0, from 1e-6 to 1000"};
const hetab_rule hetab_rule_k = {0, 1e3, "an index k >= 0, at most 1000 (absorption is positive)"};
const hetab_rule hetab_rule_wavelength_data = {1e-9, 1e12, "a length above 0"};
const hetab_rule hetab_rule_n_data = {-1e9, 1e9, "an index n > 0"};
const hetab_rule hetab_rule_k_data = {-1e9, 1e9, "an index k >= 0 (absorption is positive)"};
const hetab_rule hetab_rule_reflectance = {0, 1, "a reflectance from 0 to 1"};
const hetab_rule hetab_rule_brdf = {0, 1e3, "a BRDF from 0 to 1000 1/sr"};
const hetab_rule hetab_rule_any = {-DBL_MAX, DBL_MAX, "a finite number"};

static locale_t c_locale;

static void make_c_locale(void) {
  c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

/* Made once and kept: the "C" locale of glibc takes no memory. */
static locale_t get_c_locale(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, make_c_locale);
  return c_locale;
}

bool hetab_number_parse(const char *text, double *value) {
  const char *blanks = " \t\r\n";
  text += strspn(text, blanks);
  size_t length = strspn(text, "+-.0123456789eE"); /* keeps 0x1p3, nan and inf out */
  if (length == 0 || text[length + strspn(text + length, blanks)] != '\0')
    return false;
  char *end;
  *value = strtod_l(text, &end, get_c_locale());
  return end == text + length;
}

bool hetab_number_missing(const char *text) {
  static const char *const words[] = {"nan", "inf", "infinity", "bad", "null", "na", "n/a", "none"};
  if (!text[strspn(text, "-*")]) /* "", "-", "---", "****" */
    return true;
  text += *text == '-' || *text == '+';
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (strcasecmp(text, words[i]) == 0)
      return true;
  return false;
}

bool hetab_number_or_missing(const char *text, double *value) {
  if (hetab_number_parse(text, value)) {
    if (!isfinite(*value)) /* more than a double holds */
      *value = (double)NAN;
    return true;
  }
  *value = (double)NAN;
  return hetab_number_missing(text);
}

/* What is wrong with "0,5" and with "20 MB". */
static const char *number_advice(const char *text) {
  size_t length = strlen(text);
  if (strchr(text, ','))
    return ", with '.' before the decimals";
  bool unit = length && text[0] >= '0' && text[0] <= '9' &&
              (text[length - 1] == '%' || text[length - 1] >= 'A');
  return unit ? ", without a unit" : "";
}

hetab_status hetab_number_read(hetab_context *ctx, const char *text, const hetab_rule *rule,
                               double *value) {
  double parsed;
  if (!hetab_number_parse(text, &parsed))
    return hetab_fail(ctx, HETAB_ERR_PARSE, "'%.40s' is not a number: give %s%s", text,
                      rule->wanted, number_advice(text));
  if (!(parsed >= rule->min && parsed <= rule->max))
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%.40s is out of range: give %s", text, rule->wanted);
  *value = parsed;
  return HETAB_OK;
}

hetab_status hetab_number_check(hetab_context *ctx, const hetab_rule *rule, double value) {
  if (value >= rule->min && value <= rule->max)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%g is out of range: give %s", value, rule->wanted);
}

void hetab_number_format(double value, char text[HETAB_NUMBER_TEXT]) {
  locale_t callers = uselocale(get_c_locale());
  double size = fabs(value), back = (double)NAN;
  bool plain = size >= 1e-4 && size < 1e15; /* 400, though 4e+02 is shorter to %g */
  for (int digits = 1; digits <= 17; digits++) {
    snprintf(text, HETAB_NUMBER_TEXT, "%.*g", digits, value);
    if (hetab_number_parse(text, &back) && back == value && !(plain && strchr(text, 'e')))
      break;
  }
  uselocale(callers);
}

hetab_digits hetab_two_digits(double value) {
  hetab_digits digits;
  bool whole = fabs(value) >= 99.5 && fabs(value) < 1e9;
  snprintf(digits.text, sizeof digits.text, whole ? "%.0f" : "%.2g", value);
  return digits;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

void hetab_sort(double *values, size_t count) {
  qsort(values, count, sizeof *values, ascending);
}
