#include "numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/number.h"

/* ---- read ---------------------------------------------------------------------------------- */

int cli_number(const char *text, double *value) {
  double number;
  if (!hetab_number_parse(text, &number) || !isfinite(number))
    return 0;
  *value = number;
  return 1;
}

int cli_share(const char *text, double *value) {
  char number[64];
  size_t length = strcspn(text, "%");
  if (!text[length])
    return cli_number(text, value);
  snprintf(number, sizeof number, "%.*s", (int)length, text);
  if (length >= sizeof number || text[length + 1] || !cli_number(number, value))
    return 0;
  *value /= 100;
  return 1;
}

int cli_interval(const char *text, double *low, double *high) {
  char first[64];
  int length = (int)strcspn(text, ":");
  snprintf(first, sizeof first, "%.*s", length, text);
  return text[length] && cli_number(first, low) && cli_number(text + length + 1, high) &&
         *low <= *high;
}

int cli_constant_index(const char *text, double *n, double *k) {
  const char *comma = strchr(text, ',');
  int named = strncmp(text, "n=", 2) == 0;
  char first[64];
  if (!named && (!comma || strchr(text, '/')))
    return cli_number(text, n) ? -1 : 0;
  const char *start = named ? text + 2 : text;
  int length = comma ? (int)(comma - start) : (int)strlen(start);
  snprintf(first, sizeof first, "%.*s", length < 0 ? 0 : length, start);
  *k = 0;
  if (!cli_number(first, n))
    return -1;
  if (!comma)
    return 1;
  comma += named && strncmp(comma + 1, "k=", 2) == 0 ? 3 : 1;
  return cli_number(comma, k) ? 1 : -1;
}

size_t cli_wavelength_list(const char *text, double *lambda_um, size_t max) {
  char field[64];
  for (size_t count = 0; count < max; count++) {
    size_t length = strcspn(text, ",");
    snprintf(field, sizeof field, "%.*s", (int)(length < sizeof field ? length : 0), text);
    if (!cli_number(field, &lambda_um[count]) || lambda_um[count] <= 0)
      return 0;
    lambda_um[count] /= 1000;
    if (!text[length])
      return count + 1;
    text += length + 1;
  }
  return 0;
}

/* ---- printed ------------------------------------------------------------------------------- */

void cli_si(double value, char *text, size_t size) {
  static const char *const prefixes[] = {"", " k", " M", " G", " T", " P"};
  int power = 0;
  while (fabs(value) >= 999.5 && power < 5) {
    value /= 1000;
    power++;
  }
  int decimals = power == 0 && value == floor(value) ? 0 : value < 9.995 ? 2 : value < 99.95;
  snprintf(text, size, "%.*f%s", decimals, value, prefixes[power]);
}

static void error_text(const hetab_error_stats *error, double value, char text[CLI_SHORT]) {
  if (error->compared)
    snprintf(text, CLI_SHORT, "%.1e", value);
  else
    snprintf(text, CLI_SHORT, "-");
}

cli_errors cli_error_texts(const hetab_error_stats *error) {
  cli_errors text;
  error_text(error, error->max_rel, text.max);
  error_text(error, error->p99_rel, text.p99);
  error_text(error, error->rms_rel, text.rms);
  return text;
}
