/* From heights to the model's parameters. */
#include <hetab/roughness.h>

#include <math.h>
#include <stdlib.h>
#include "roughness/component.h"
#include "roughness/cutoff.h"
#include "roughness/notes.h"
#include "roughness/scan_worker.h"

#include "core/option_size.h"

static hetab_status check_options(hetab_context *ctx, const hetab_roughness_options *o) {
  if (!(o->cutoff_um >= 0 || o->cutoff_um == HETAB_CUTOFF_AUTO) || !isfinite(o->cutoff_um))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "a cut-off of %g um: give a length, 0 for no filter, or HETAB_CUTOFF_AUTO",
                      o->cutoff_um);
  if (o->filter && o->cutoff_um == HETAB_CUTOFF_AUTO)
    return hetab_fail(
        ctx, HETAB_ERR_ARGUMENT,
        "the cut-off of largest slope is found by what the Gaussian filter does to two "
        "scales: give one for the %s filter",
        hetab_filter_name(o->filter));
  if (isnan(o->outlier) || !(o->wavelength_um >= 0 && isfinite(o->wavelength_um)))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "outlier %g and wavelength %g um: both have to be numbers, the latter not "
                      "negative",
                      o->outlier, o->wavelength_um);
  return HETAB_OK;
}

static hetab_status list_sources(hetab_context *ctx, const hetab_scan_list *list,
                                 hetab_roughness *r) {
  r->scans = hetab_alloc(ctx, list->count, sizeof *r->scans);
  HETAB_NEED(r->scans);
  for (; r->count < list->count; r->count++)
    HETAB_TRY(hetab_scan_list_source(ctx, list, r->count, &r->scans[r->count]));
  return HETAB_OK;
}

static hetab_status none_left(hetab_context *ctx, const hetab_scan_list *list, double cutoff_um) {
  const hetab_listed_scan *scan = &list->scans[0];
  double length = (double)scan->count * scan->spacing_um;
  if (cutoff_um > 0)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "behind a cut-off of %g um nothing is left to evaluate: the first scan has "
                      "%zu heights %g um apart; give a cut-off from %g to %g um",
                      cutoff_um, scan->count, scan->spacing_um, 10 * scan->spacing_um, length / 2);
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "%s: no roughness to measure: all heights are equal, or fewer than %d of %zu "
                    "are valid; are the column and its unit the right ones?",
                    hetab_heights_name(list->heights[0]), HETAB_LEAST_POINTS, scan->count);
}

/* The scan that is shown in two. */
static hetab_status split_first(hetab_context *ctx, const hetab_scan_list *list,
                                hetab_roughness *r) {
  size_t first = r->small.scans[0].scan;
  hetab_scan_worker worker;
  HETAB_TRY(hetab_scan_worker_create(ctx, list, &worker));
  hetab_status status = hetab_scan_worker_take(ctx, list, first, r->cutoff_um, &worker);
  if (status == HETAB_OK) {
    hetab_scan_worker_filter(&worker, r->cutoff_um);
    r->split_count = worker.count;
    r->split_levelled_um = worker.z_um;
    r->split_line_um = worker.line_um;
    worker.z_um = worker.line_um = NULL;
  }
  hetab_scan_worker_free(&worker);
  return status;
}

static hetab_status measure_small(hetab_context *ctx, const hetab_scan_list *list,
                                  const hetab_roughness_options *o, hetab_roughness *r) {
  r->cutoff_um = o->cutoff_um;
  r->filter = o->filter;
  if (o->cutoff_um == HETAB_CUTOFF_AUTO)
    HETAB_TRY(hetab_find_cutoff(ctx, list, &r->raw, &r->cutoff_scan, &r->cutoff_um));
  if (r->cutoff_um == 0)
    return HETAB_OK; /* one scale: a filter would only take part of it */
  HETAB_TRY(hetab_component_measure(ctx, list, r->cutoff_um, &r->small));
  return r->small.count ? split_first(ctx, list, r) : none_left(ctx, list, r->cutoff_um);
}

static hetab_status measure(hetab_context *ctx, const hetab_scan_list *list,
                            const hetab_roughness_options *o, hetab_roughness *r) {
  HETAB_TRY(list_sources(ctx, list, r));
  HETAB_TRY(hetab_component_measure(ctx, list, 0, &r->raw));
  if (!r->raw.count)
    return none_left(ctx, list, 0);
  if (o->cutoff_um != 0)
    HETAB_TRY(measure_small(ctx, list, o, r));
  return hetab_roughness_notes(ctx, r, list->heights, list->inputs,
                               o->wavelength_um > 0 ? o->wavelength_um : 0.7);
}

hetab_status hetab_roughness_measure(hetab_context *ctx, const hetab_heights *const *heights,
                                     size_t count, const hetab_roughness_options *options,
                                     hetab_roughness **out) {
  hetab_scan_list list = {0};
  hetab_status status;
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_roughness_options, o, options);
  HETAB_TRY(check_options(ctx, &o));
  if (!count)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "no heights: give at least one scan");
  hetab_roughness *r = hetab_alloc(ctx, 1, sizeof *r);
  HETAB_NEED(r);
  HETAB_GOTO(hetab_scan_list_create(ctx, heights, count, &o, &list));
  HETAB_GOTO(measure(ctx, &list, &o, r));
  *out = r;
done:
  hetab_scan_list_free(&list);
  if (status != HETAB_OK)
    hetab_roughness_free(r);
  return status;
}

void hetab_roughness_free(hetab_roughness *r) {
  if (!r)
    return;
  for (size_t i = 0; i < r->count; i++)
    free((char *)r->scans[i].name);
  for (size_t i = 0; i < r->note_count; i++)
    free(r->notes[i]);
  free(r->scans);
  free(r->notes);
  free(r->raw.scans);
  free(r->small.scans);
  free(r->cutoff_scan.trials);
  free(r->split_levelled_um);
  free(r->split_line_um);
  free(r);
}
