/* What exports of maps say above their rows. */
#include <stdlib.h>
#include <string.h>
#include "roughness/scan_text.h"

size_t scan_find_column(const hetab_csv *csv, const char *name, size_t length) {
  char wanted[64], plain[128], number[24];
  snprintf(wanted, sizeof wanted, "%.*s", (int)(length < 63 ? length : 63), name);
  hetab_plain_letters(wanted, plain, sizeof plain);
  for (size_t i = 0; i < csv->columns; i++) {
    char its[128];
    double unit;
    hetab_plain_letters(csv->column[i].name, its, sizeof its);
    snprintf(number, sizeof number, "%zu", i + 1);
    if (strcmp(its, plain) == 0 || strcmp(number, wanted) == 0 ||
        (*plain && hetab_names_quantity(its, plain, HETAB_LENGTH, &unit) == 2))
      return i;
  }
  return HETAB_CSV_ABSENT;
}

/* Of a text that may end in a quote. */
static double unit_in(char *text) {
  text[strcspn(text, "\"")] = '\0';
  return hetab_unit(HETAB_LENGTH, text);
}

/* "key: 100 um": the number, and its unit (um; 0: none that is known). */
static bool number_above(const text_scan *t, const char *keys, double *value, double *unit) {
  char text[96];
  hetab_csv either = {0}; /* of either decimal mark */
  if (!hetab_csv_above(&t->csv, keys, text, sizeof text))
    return false;
  char *end = text + strcspn(text, " \t\";");
  if (*end)
    *end++ = '\0';
  *unit = unit_in(end + strspn(end, ",;\"")); /* "500","nm" */
  return hetab_csv_parse(&either, text, value) && *value > 0;
}

static double unit_above(const text_scan *t, const char *keys) {
  char text[96];
  return hetab_csv_above(&t->csv, keys, text, sizeof text) ? unit_in(text) : 0;
}

/* "Pixel_size<tab>7<tab>4<tab>0.0005": the last word. */
static double wyko_number(const text_scan *t, const char *key) {
  char text[96];
  double value;
  if (!hetab_csv_above(&t->csv, key, text, sizeof text))
    return 0;
  const char *last = strrchr(text, '\t');
  return last && hetab_number_parse(last, &value) ? value : 0;
}

/* The second flag of "Wyko ASCII Data File Format 0<tab>0<tab>1": nm; else waves over Mult. */
static double wyko_height_unit(const text_scan *t) {
  char flags[32];
  if (!hetab_csv_above(&t->csv, "wyko ascii data file format", flags, sizeof flags))
    return 0;
  double wave = wyko_number(t, "wavelength"), mult = wyko_number(t, "mult");
  const char *second = strchr(flags, '\t');
  bool nm = second && second[1] == '1';
  return 1e-3 * (nm || !(wave > 0 && mult > 0) ? 1 : wave / mult);
}

double scan_height_unit(const text_scan *t) {
  static const struct {
    const char *key;
    double um;
  } factors[] = {{"height conversion factor (-> m)", 1e6}, {"bit2nm", 1e-3}};
  double unit = unit_above(t, "value units|werteinheit|einheiten|unites|unites de valeur|z-unit|"
                              "unit data|units|unit\"");
  for (size_t i = 0; !(unit > 0) && i < sizeof factors / sizeof *factors; i++) {
    double value, none;
    if (number_above(t, factors[i].key, &value, &none))
      unit = value * factors[i].um;
  }
  return unit > 0 ? unit : wyko_height_unit(t);
}

bool scan_map_pitch(const text_scan *t, double pitch_um[2]) {
  static const char *const extents[2] = {"width|breite|largeur|anchura|larghezza|x-length",
                                         "height|hohe|hauteur|altura|altezza|y-length"};
  static const char *const pitches[2] = {"pixel size|scale x|xy calibration",
                                         "pixel size|scale y|xy calibration"};
  static const char *const units[2] = {"x-unit|unit x", "y-unit|unit y|x-unit|unit x"};
  double found[2] = {0}, wyko = 1e3 * wyko_number(t, "pixel_size");
  const size_t counts[2] = {t->count, t->rows};
  for (int axis = 0; axis < 2; axis++) {
    double value, unit = 0;
    bool extent = number_above(t, extents[axis], &value, &unit);
    if (!extent && !number_above(t, pitches[axis], &value, &unit))
      continue;
    if (!(unit > 0) && !((unit = unit_above(t, units[axis])) > 0))
      unit = 1e-3; /* SPIP */
    found[axis] = value * unit / (extent ? (double)counts[axis] : 1);
  }
  if (wyko > 0) { /* a line is a place along x */
    double aspect = wyko_number(t, "aspect");
    found[0] = wyko;
    found[1] = wyko * (aspect > 0 ? aspect : 1);
  }
  if (!(found[0] > 0 && found[1] > 0))
    return false;
  memcpy(pitch_um, found, sizeof found);
  return true;
}
