/* The cut-off with the largest small-scale slope. */
#pragma once

#include "roughness/scan_list.h"

/* Tries cut-offs from 10 spacings to a third of the shortest scan. `raw` are the unfiltered
 * statistics, a start for the fit. *cutoff_um 0: there is no large scale. free() scan->trials. */
hetab_status hetab_find_cutoff(hetab_context *ctx, const hetab_scan_list *list,
                               const hetab_component *raw, hetab_cutoff_scan *scan,
                               double *cutoff_um);
