#include "roughness/scan_list.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_map(const hetab_heights *heights) {
  return hetab_heights_kind_of(heights) == HETAB_HEIGHTS_MAP;
}

static void add_scans(hetab_scan_list *list, size_t input, bool columns) {
  const hetab_heights *h = list->heights[input];
  size_t scans = columns ? hetab_heights_column_count(h) : hetab_heights_row_count(h);
  size_t count = columns ? hetab_heights_row_count(h) : hetab_heights_column_count(h);
  double spacing = columns ? hetab_heights_spacing_y_um(h) : hetab_heights_spacing_um(h);
  for (size_t i = 0; i < scans; i++)
    list->scans[list->count++] = (hetab_listed_scan){input, i, columns, count, spacing};
  if (scans && count > list->longest)
    list->longest = count;
}

static hetab_status list_scans(hetab_context *ctx, hetab_scan_list *list) {
  size_t total = 0;
  for (size_t i = 0; i < list->inputs; i++)
    total += hetab_heights_row_count(list->heights[i]) +
             (is_map(list->heights[i]) ? hetab_heights_column_count(list->heights[i]) : 0);
  list->scans = hetab_alloc(ctx, total, sizeof *list->scans);
  HETAB_NEED(list->scans);
  for (size_t i = 0; i < list->inputs; i++) {
    add_scans(list, i, false);
    if (is_map(list->heights[i]))
      add_scans(list, i, true);
  }
  return HETAB_OK;
}

hetab_status hetab_scan_list_create(hetab_context *ctx, const hetab_heights *const *heights,
                                    size_t inputs, const hetab_roughness_options *options,
                                    hetab_scan_list *list) {
  *list = (hetab_scan_list){.heights = heights, .inputs = inputs, .filter = options->filter};
  hetab_status status = HETAB_ERR_MEMORY;
  list->levelled = hetab_alloc(ctx, inputs, sizeof *list->levelled);
  if (!list->levelled)
    goto done;
  for (size_t i = 0; i < inputs; i++)
    HETAB_GOTO(hetab_level_heights(ctx, heights[i], options, &list->levelled[i]));
  HETAB_GOTO(list_scans(ctx, list));
  return HETAB_OK;
done:
  hetab_scan_list_free(list);
  return status;
}

void hetab_scan_list_free(hetab_scan_list *list) {
  for (size_t i = 0; list->levelled && i < list->inputs; i++)
    hetab_levelled_free(&list->levelled[i]);
  free(list->levelled);
  free(list->scans);
  *list = (hetab_scan_list){0};
}

/* Where point k of the scan is in its input. */
static size_t place_of(const hetab_scan_list *list, const hetab_listed_scan *scan, size_t k) {
  size_t columns = hetab_heights_column_count(list->heights[scan->input]);
  return scan->is_column ? k * columns + scan->index : scan->index * columns + k;
}

void hetab_scan_list_get(const hetab_scan_list *list, size_t i, double *z_um) {
  const hetab_listed_scan *scan = &list->scans[i];
  for (size_t k = 0; k < scan->count; k++)
    z_um[k] = list->levelled[scan->input].z_um[place_of(list, scan, k)];
}

static char *name_of(const hetab_heights *h, const hetab_listed_scan *scan) {
  char *name = NULL;
  const char *what = is_map(h) ? scan->is_column ? "column" : "row" : "scan";
  if (hetab_heights_row_count(h) == 1)
    return strdup(hetab_heights_name(h));
  return asprintf(&name, "%s %s %zu", hetab_heights_name(h), what, scan->index + 1) < 0 ? NULL
                                                                                        : name;
}

hetab_status hetab_scan_list_source(hetab_context *ctx, const hetab_scan_list *list, size_t i,
                                    hetab_scan_source *source) {
  const hetab_listed_scan *scan = &list->scans[i];
  const hetab_heights *h = list->heights[scan->input];
  *source = (hetab_scan_source){.spacing_um = scan->spacing_um, .points = scan->count};
  for (size_t k = 0; k < scan->count; k++) {
    size_t place = place_of(list, scan, k);
    source->outliers += list->levelled[scan->input].marked[place];
    source->missing += isnan(hetab_heights_z_um(h)[place]) != 0;
  }
  source->name = name_of(h, scan);
  return source->name ? HETAB_OK : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for a name");
}
