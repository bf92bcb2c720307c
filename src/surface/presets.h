/* The built-in surfaces' parameters. */
#pragma once

#include <hetab/surface.h>

typedef struct hetab_preset {
  const char *name, *metal;
  double sigma0_um, tau_um;
  double non_uniformity; /* of sigma0; 0: not known */
  double diffuse_reflectance;
  const char *description;
} hetab_preset;

/* In any case ("bbqal2"); NULL if there is none. */
const hetab_preset *hetab_preset_find(const char *name);
