/* Roughness as JSON. Keys are an interface: add, never rename. */

#include "output.h"
#include "roughness_command.h"

static json_t *scan_json(const hetab_scan_statistics *s) {
  json_t *json = json_pack("{sI sI sf}", "scan", (json_int_t)s->scan, "points",
                           (json_int_t)s->points, "length_um", s->length_um);
  for (int f = 0; f < ROUGHNESS_FIELDS; f++) {
    hetab_estimate e = roughness_estimate(s, f);
    json_object_set_new(
        json, roughness_fields[f].name,
        json_pack("{so so}", "value", cli_json_number(e.value), "error", cli_json_number(e.error)));
  }
  json_object_update_new(json,
                         json_pack("{so so so so}", "independent", cli_json_number(s->independent),
                                   "normal_distance", cli_json_number(s->normal_distance),
                                   "misfit_gaussian", cli_json_number(s->misfit_gaussian),
                                   "misfit_exponential", cli_json_number(s->misfit_exponential)));
  return json;
}

static json_t *component_json(const hetab_component *c) {
  if (!c->count)
    return json_null();
  json_t *json = json_object(), *scans = json_array();
  for (int f = 0; f < ROUGHNESS_FIELDS; f++) {
    hetab_average a = roughness_average(c, f);
    json_object_set_new(json, roughness_fields[f].name,
                        json_pack("{so so so s[oo]}", "average", cli_json_number(a.mean),
                                  "deviation", cli_json_number(a.deviation), "error",
                                  cli_json_number(a.error), "interval", cli_json_number(a.low),
                                  cli_json_number(a.high)));
  }
  for (size_t i = 0; i < c->count; i++)
    json_array_append_new(scans, scan_json(&c->scans[i]));
  json_object_update_new(
      json,
      json_pack("{so so so so so so so so}", "non_uniformity", cli_json_number(c->non_uniformity),
                "normal_distance", cli_json_number(c->normal_distance), "misfit_gaussian",
                cli_json_number(c->misfit_gaussian), "misfit_exponential",
                cli_json_number(c->misfit_exponential), "lag_step_um",
                cli_json_number(c->lag_step_um), "correlation",
                cli_json_numbers(c->correlation, HETAB_CORRELATION_LAGS, 1), "histogram",
                cli_json_numbers(c->histogram, HETAB_HISTOGRAM_BINS, 1), "scans", scans));
  return json;
}

static json_t *sources_json(const hetab_roughness *r) {
  json_t *list = json_array();
  for (size_t i = 0; i < r->count; i++) {
    const hetab_scan_source *s = &r->scans[i];
    json_array_append_new(list,
                          json_pack("{so sI sf sI sI}", "name", cli_json_text(s->name), "points",
                                    (json_int_t)s->points, "spacing_um", s->spacing_um, "missing",
                                    (json_int_t)s->missing, "outliers", (json_int_t)s->outliers));
  }
  return list;
}

static json_t *cutoffs_json(const hetab_cutoff_scan *s) {
  if (!s->count)
    return json_null();
  json_t *trials = json_array();
  for (size_t i = 0; i < s->count; i++) {
    const hetab_cutoff_trial *t = &s->trials[i];
    json_array_append_new(trials,
                          json_pack("{sf so so so so}", "cutoff_um", t->cutoff_um, "sigma_um",
                                    cli_json_number(t->sigma_um), "tau_um",
                                    cli_json_number(t->tau_um), "slope", cli_json_number(t->slope),
                                    "smooth", cli_json_number(t->smooth)));
  }
  return json_pack("{so so so so sb}", "trials", trials, "sigma_um",
                   cli_json_numbers(s->sigma_um, 2, 1), "tau_um", cli_json_numbers(s->tau_um, 2, 1),
                   "misfit", cli_json_number(s->misfit), "from_fit", s->from_fit);
}

/* The first scan in two. */
static json_t *split_json(const hetab_roughness *r) {
  return json_pack("{so so}", "levelled_um",
                   cli_json_numbers(r->split_levelled_um, r->split_count, 1), "line_um",
                   cli_json_numbers(r->split_line_um, r->split_count, 1));
}

json_t *roughness_json(const hetab_roughness *r) {
  json_t *notes = CLI_JSON_LIST(r->note_count, cli_json_text(r->notes[i]));
  return json_pack("{ss so so so so so so so so so}", "version", hetab_version(), "scans",
                   sources_json(r), "cutoff_um",
                   r->small.count ? json_real(r->cutoff_um) : json_null(), "filter",
                   r->small.count ? json_string(hetab_filter_name(r->filter)) : json_null(), "raw",
                   component_json(&r->raw), "small", component_json(&r->small), "cutoff_scan",
                   cutoffs_json(&r->cutoff_scan), "curvature_um", cli_json_number(r->curvature_um),
                   "notes", notes, "split", r->split_count ? split_json(r) : json_null());
}

static json_t *published_table_json(const hetab_published_table *t) {
  json_t *columns = CLI_JSON_LIST(
      t->count,
      json_pack("{so so so so}", "name", cli_json_text(t->columns[i].name), "average",
                cli_json_number(hetab_published_summary(t, i, HETAB_AVERAGE)), "deviation",
                cli_json_number(hetab_published_summary(t, i, HETAB_DEVIATION)), "non_uniformity",
                cli_json_number(hetab_published_summary(t, i, HETAB_NON_UNIFORMITY))));
  return json_pack("{so sI so}", "name", cli_json_text(t->name), "rows", (json_int_t)t->rows,
                   "columns", columns);
}

json_t *roughness_published_json(const hetab_published *p) {
  json_t *tables = CLI_JSON_LIST(p->count, published_table_json(&p->tables[i]));
  json_t *checks = json_array();
  for (size_t i = 0; i < p->check_count; i++) {
    const hetab_published_check *c = &p->checks[i];
    json_array_append_new(
        checks, json_pack("{sI sI so so sf so so so ss}", "table", (json_int_t)c->table, "against",
                          (json_int_t)c->against, "row", cli_json_text(c->row), "column",
                          cli_json_text(c->column), "stated", c->stated, "value",
                          cli_json_number(c->value), "low", cli_json_number(c->low), "high",
                          cli_json_number(c->high), "verdict", hetab_match_name(c->verdict)));
  }
  return json_pack("{ss so so}", "version", hetab_version(), "tables", tables, "checks", checks);
}
