#include "roughness/scan_worker.h"

#include <stdlib.h>

hetab_status hetab_scan_worker_create(hetab_context *ctx, const hetab_scan_list *list,
                                      hetab_scan_worker *worker) {
  *worker = (hetab_scan_worker){.kind = list->filter};
  worker->z_um = hetab_alloc(ctx, list->longest, sizeof *worker->z_um);
  worker->line_um = hetab_alloc(ctx, list->longest, sizeof *worker->line_um);
  worker->evaluated = hetab_alloc(ctx, list->longest, 1);
  if (worker->z_um && worker->line_um && worker->evaluated)
    return HETAB_OK;
  hetab_scan_worker_free(worker);
  return HETAB_ERR_MEMORY;
}

void hetab_scan_worker_free(hetab_scan_worker *worker) {
  hetab_line_filter_free(&worker->filter);
  hetab_statistics_free(&worker->statistics);
  free(worker->z_um);
  free(worker->line_um);
  free(worker->evaluated);
  *worker = (hetab_scan_worker){0};
}

static hetab_status fit_scan(hetab_context *ctx, const hetab_listed_scan *scan,
                             double max_cutoff_um, hetab_scan_worker *worker) {
  if (worker->count == scan->count && worker->spacing_um == scan->spacing_um)
    return HETAB_OK;
  hetab_line_filter_free(&worker->filter);
  hetab_statistics_free(&worker->statistics);
  worker->count = 0;
  HETAB_TRY(hetab_statistics_create(ctx, scan->count, scan->spacing_um, &worker->statistics));
  if (max_cutoff_um > 0)
    HETAB_TRY(hetab_line_filter_create(ctx, worker->kind, scan->count, scan->spacing_um,
                                       max_cutoff_um, &worker->filter));
  worker->count = scan->count;
  worker->spacing_um = scan->spacing_um;
  return HETAB_OK;
}

hetab_status hetab_scan_worker_take(hetab_context *ctx, const hetab_scan_list *list, size_t i,
                                    double max_cutoff_um, hetab_scan_worker *worker) {
  HETAB_TRY(fit_scan(ctx, &list->scans[i], max_cutoff_um, worker));
  hetab_scan_list_get(list, i, worker->z_um);
  if (max_cutoff_um > 0)
    hetab_line_filter_load(&worker->filter, worker->z_um, worker->count);
  return HETAB_OK;
}

const double *hetab_scan_worker_filter(hetab_scan_worker *worker, double cutoff_um) {
  hetab_evaluated(worker->z_um, worker->count, worker->spacing_um, cutoff_um, worker->evaluated);
  if (!(cutoff_um > 0))
    return NULL;
  hetab_line_filter_line(&worker->filter, cutoff_um, worker->line_um);
  return worker->line_um;
}
