/* The statistics of all scans, raw or behind the filter, and their averages. */
#pragma once

#include "roughness/scan_list.h"

/* cutoff_um 0: raw. Scans that have too little left are not in the component; a component may come
 * out with none. */
hetab_status hetab_component_measure(hetab_context *ctx, const hetab_scan_list *list,
                                     double cutoff_um, hetab_component *component);
