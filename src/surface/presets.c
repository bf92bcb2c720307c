/* Source: Table 1 of H. Li and K. E. Torrance, Background Data for Validation of the He-Torrance
 * Model, TR PCG-05-02 (2005): roughness measured at the small scale, on aluminium.
 *
 * A variant is one more line. A fitted slope goes in as slope * tau, at Table 1's tau:
 *   {"BBQAL2-fitted", "Al", SLOPE * 6.5, 6.5, A, "..."},
 */
#include "surface/presets.h"

#include <strings.h>

static const char measured[] =
    "aluminium, measured small-scale roughness (Li & Torrance, TR PCG-05-02, 2005, Table 1)";

static const hetab_preset presets[] = {
    {"BBQAL1", "Al", 0.72, 5.6, 0, measured},  {"BBQAL2", "Al", 0.54, 6.5, 0, measured},
    {"GGAL120", "Al", 0.86, 5.6, 0, measured}, {"GGAL240", "Al", 0.61, 4.7, 0, measured},
    {"NGGAL", "Al", 0.13, 5.4, 0, measured},
};

size_t hetab_preset_count(void) {
  return sizeof presets / sizeof *presets;
}

const char *hetab_preset_name(size_t i) {
  return presets[i].name;
}

const char *hetab_preset_description(size_t i) {
  return presets[i].description;
}

const hetab_preset *hetab_preset_find(const char *name) {
  for (size_t i = 0; i < hetab_preset_count(); i++)
    if (strcasecmp(presets[i].name, name) == 0)
      return &presets[i];
  return NULL;
}
