/* Levelling, and leaving outliers out. */
#pragma once

#include <hetab/roughness.h>
#include "core/context.h"

typedef struct hetab_levelled {
  double *z_um;          /* [rows][columns]; NaN: missing or outlier */
  unsigned char *marked; /* [rows][columns] 1: outlier */
} hetab_levelled;

hetab_status hetab_level_heights(hetab_context *ctx, const hetab_heights *heights,
                                 const hetab_roughness_options *options, hetab_levelled *out);
void hetab_levelled_free(hetab_levelled *levelled);
