/* Source: H. Li and K. E. Torrance, Background Data for Validation of the He-Torrance Model, TR
 * PCG-05-02 (2005), surfaces on aluminium. Table 1: sigma0, tau and non-uniformity measured at the
 * small scale. Table 2: slope and diffuse term `a` fitted to measured BRDFs, here at Table 1's tau.
 *
 * `a` can be read in two ways: as pi * BRDF, which is what the model's authors' own program does
 * and what is here, or in 1/sr as Eq. 9 is printed: then it is `diffuse_brdf: a`, pi times as much.
 * With either, but for NGGAL, more light comes back than arrives. */
#include "surface/presets.h"

#include <strings.h>

#define REPORT " (Li & Torrance, TR PCG-05-02, 2005, Table "
static const char measured[] = "aluminium, measured small-scale roughness" REPORT "1)";
static const char fitted[] = "aluminium, slope and diffuse term fitted to the measured BRDF" REPORT
                             "2), tau of Table 1; a as pi * BRDF (as printed: diffuse_brdf)";

static const hetab_preset presets[] = {
    {"BBQAL1", "Al", 0.72, 5.6, 0.039, 0, measured},
    {"BBQAL2", "Al", 0.54, 6.5, 0.068, 0, measured},
    {"GGAL120", "Al", 0.86, 5.6, 0.045, 0, measured},
    {"GGAL240", "Al", 0.61, 4.7, 0.041, 0, measured},
    {"NGGAL", "Al", 0.13, 5.4, 0.053, 0, measured},
    {"BBQAL1-fit", "Al", 0.144 * 5.6, 5.6, 0, 0.70, fitted},
    {"BBQAL2-fit", "Al", 0.080 * 6.5, 6.5, 0, 0.37, fitted},
    {"GGAL120-fit", "Al", 0.166 * 5.6, 5.6, 0, 0.44, fitted},
    {"GGAL240-fit", "Al", 0.158 * 4.7, 4.7, 0, 0.44, fitted},
    {"NGGAL-fit", "Al", 0.020 * 5.4, 5.4, 0, 0, fitted},
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
