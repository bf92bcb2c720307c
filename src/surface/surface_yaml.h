/* Surfaces within other YAML files: scenes. */
#pragma once

#include <hetab/surface.h>

#include "surface/yaml.h"

/* From a mapping of the keys of include/hetab/surface.h; name: where it has none. */
hetab_status hetab_surface_of_mapping(hetab_yaml *file, const yaml_node_t *mapping,
                                      const char *name, hetab_surface **out);
/* One of many, of 400 to 700 nm in steps of 10. */
typedef struct hetab_surface_values {
  double sigma0_um, tau_um, diffuse_reflectance;
  const yaml_node_t *index; /* as under the key `index` */
} hetab_surface_values;

hetab_status hetab_surface_of_values(hetab_yaml *file, const char *name,
                                     const hetab_surface_values *values, hetab_surface **out);
