/* All scans of all inputs, one after the other: rows, and of maps columns too. */
#pragma once

#include <stdbool.h>
#include "roughness/level.h"

typedef struct hetab_listed_scan {
  size_t input, index; /* of the row or column */
  bool is_column;
  size_t count;
  double spacing_um;
} hetab_listed_scan;

typedef struct hetab_scan_list {
  const hetab_heights *const *heights;
  hetab_levelled *levelled; /* [inputs] */
  size_t inputs;
  hetab_listed_scan *scans; /* [count] */
  size_t count, longest;
  hetab_filter filter; /* as asked for */
} hetab_scan_list;

/* Levels all. */
hetab_status hetab_scan_list_create(hetab_context *ctx, const hetab_heights *const *heights,
                                    size_t inputs, const hetab_roughness_options *options,
                                    hetab_scan_list *list);
void hetab_scan_list_free(hetab_scan_list *list);

/* The levelled heights of scan i, to z_um[scans[i].count]. */
void hetab_scan_list_get(const hetab_scan_list *list, size_t i, double *z_um);

/* Name, points, missing and outliers of scan i; the caller frees the name. */
hetab_status hetab_scan_list_source(hetab_context *ctx, const hetab_scan_list *list, size_t i,
                                    hetab_scan_source *source);
