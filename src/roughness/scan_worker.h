/* Filter, statistics and memory for one scan after the other. */
#pragma once

#include "roughness/line_filter.h"
#include "roughness/scan_list.h"
#include "roughness/statistics.h"

typedef struct hetab_scan_worker {
  hetab_filter kind;
  hetab_line_filter filter;
  hetab_statistics statistics;
  size_t count; /* that these are made for */
  double spacing_um;
  double *z_um, *line_um; /* of the scan at hand */
  unsigned char *evaluated;
} hetab_scan_worker;

/* For scans of the list. Zeroed before the first. */
hetab_status hetab_scan_worker_create(hetab_context *ctx, const hetab_scan_list *list,
                                      hetab_scan_worker *worker);
void hetab_scan_worker_free(hetab_scan_worker *worker);

/* Takes scan i; max_cutoff_um 0: it is not going to be filtered. */
hetab_status hetab_scan_worker_take(hetab_context *ctx, const hetab_scan_list *list, size_t i,
                                    double max_cutoff_um, hetab_scan_worker *worker);
/* Its mean line and what is evaluated; cutoff_um 0: no line, and all that is not missing. Returns
 * the line, or NULL. */
const double *hetab_scan_worker_filter(hetab_scan_worker *worker, double cutoff_um);
