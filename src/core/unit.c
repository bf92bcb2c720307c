#include "core/unit.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/angle.h"

enum { WORD = 96 };

/* ---- letters ------------------------------------------------------------------------------- */

void hetab_plain_letters(const char *text, char *plain, size_t size) {
  static const struct {
    const char *from, *to;
  } letters[] = {
      {"\u00b5", "u"},   {"\u03bc", "u"},   {"\u03bb", "lambda"},   {"\u03b8", "theta"},
      {"\u03c6", "phi"}, {"\u03d5", "phi"}, {"\u00c5", "angstrom"}, {"\u212b", "angstrom"},
      {"\u00e5", "a"},   {"\u00b0", "deg"}, {"\u00f6", "o"},        {"\u00d6", "o"},
      {"\u00fc", "u"},   {"\u00e4", "a"},   {"\u00e9", "e"},        {"\u00e8", "e"}};
  size_t used = 0, i;
  while (*text && used + 10 < size) {
    for (i = 0; i < sizeof letters / sizeof *letters; i++)
      if (strncmp(text, letters[i].from, strlen(letters[i].from)) == 0)
        break;
    if (i < sizeof letters / sizeof *letters) {
      used += (size_t)snprintf(plain + used, size - used, "%s", letters[i].to);
      text += strlen(letters[i].from);
    } else
      plain[used++] = (char)tolower((unsigned char)*text++);
  }
  plain[used] = '\0';
}

/* Letters and digits alone. */
static void squash(const char *text, size_t length, char *word) {
  size_t used = 0;
  for (size_t i = 0; i < length; i++)
    if (isalnum((unsigned char)text[i]))
      word[used++] = text[i];
  word[used] = '\0';
}

/* ---- units --------------------------------------------------------------------------------- */

static bool is_one_of(const char *word, const char *words) {
  size_t length = strlen(word);
  for (const char *at = words; length && (at = strstr(at, word)); at++)
    if ((at == words || at[-1] == '|') && (at[length] == '|' || !at[length]))
      return true;
  return false;
}

double hetab_unit(hetab_quantity quantity, const char *text) {
  static const struct {
    hetab_quantity quantity;
    const char *words;
    double size;
  } units[] = {
      {HETAB_LENGTH, "pm|picometer|picometre|picometers|picometres", 1e-6},
      {HETAB_LENGTH, "a|ang|angstrom|angstroms|angstroem|angstrom s", 1e-4},
      {HETAB_LENGTH, "nm|nanometer|nanometre|nanometers|nanometres", 1e-3},
      {HETAB_LENGTH, "um|mum|micron|microns|micrometer|micrometre|micrometers|micrometres", 1},
      {HETAB_LENGTH, "mm|millimeter|millimetre|millimeters|millimetres", 1e3},
      {HETAB_LENGTH, "cm|centimeter|centimetre|centimeters|centimetres", 1e4},
      {HETAB_LENGTH, "m|meter|metre|meters|metres", 1e6},
      {HETAB_ANGLE, "deg|degree|degrees|grad dezimal", M_PI / 180},
      {HETAB_ANGLE, "rad|radian|radians", 1}};
  char plain[WORD], word[WORD];
  hetab_plain_letters(text, plain, sizeof plain);
  squash(plain, strlen(plain), word);
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (units[i].quantity == quantity && is_one_of(word, units[i].words))
      return units[i].size;
  return 0;
}

double hetab_in_unit(double value, double unit) {
  if (unit == M_PI / 180)
    return hetab_radians(value);
  double per = round(1 / unit);
  return unit < 1e-2 && 1 / per == unit ? value / per : value * unit;
}

/* ---- names --------------------------------------------------------------------------------- */

/* "z#" is z, z1, z12; "pos*" whatever begins so. What follows the name is *rest. */
static bool begins_with(const char *word, const char *name, size_t length, const char **rest) {
  char last = name[length - 1];
  size_t stem = length - (last == '#' || last == '*');
  if (strncmp(word, name, stem) != 0)
    return false;
  *rest = word + stem;
  if (last == '#')
    *rest += strspn(*rest, "0123456789");
  if (last == '*')
    *rest += strlen(*rest);
  return true;
}

/* Whether the word is a name, or with a unit at its end that was `glued` to it. */
static bool is_name(const char *word, const char *names, hetab_quantity quantity, double *glued) {
  for (size_t length; *names; names += length + (names[length] == '|')) {
    const char *rest;
    length = strcspn(names, "|");
    if (!begins_with(word, names, length, &rest))
      continue;
    if (!*rest)
      return true;
    if (glued && length > 2 && (*glued = hetab_unit(quantity, rest)) > 0)
      return true;
  }
  return false;
}

/* Where the unit in "x [um]", "x (um)", "x/um", "x_um", "x um", "x in um" begins, and where the
 * name before it ends. */
static const char *unit_part(char *plain, size_t *name) {
  char *mark = strpbrk(plain, "[(/");
  size_t end = strlen(plain);
  while (!mark && end > 0 && !isalnum((unsigned char)plain[end - 1]))
    end--;
  while (!mark && end > 0 && isalnum((unsigned char)plain[end - 1]))
    end--;
  *name = mark ? (size_t)(mark - plain) : end;
  char *unit = mark ? mark + 1 : plain + end;
  unit[strcspn(unit, "])")] = '\0';
  while (*name > 0 && !isalnum((unsigned char)plain[*name - 1]))
    --*name;
  if (*name > 3 && strncmp(plain + *name - 3, " in", 3) == 0)
    *name -= 3;
  return unit;
}

int hetab_names_quantity(const char *name, const char *names, hetab_quantity quantity,
                         double *unit) {
  char plain[WORD], word[WORD];
  size_t length;
  hetab_plain_letters(name, plain, sizeof plain);
  squash(plain, strlen(plain), word);
  double glued = 0;
  bool whole = is_name(word, names, quantity, &glued);
  const char *tail = unit_part(plain, &length);
  squash(plain, length, word);
  bool head = is_name(word, names, quantity, NULL);
  *unit = head ? hetab_unit(quantity, tail) : glued;
  return whole || *unit > 0 ? 2 : head;
}
