/* Audits as JSON. Keys are an interface: add, never rename. */
#include "core/angle.h"
#include "audit_command.h"
#include "output.h"

static json_t *checks_json(const hetab_audit *a) {
  json_t *list = json_array();
  for (size_t i = 0; i < a->check_count; i++) {
    const hetab_check *c = &a->checks[i];
    json_array_append_new(
        list,
        json_pack("{ss ss so so so so}", "name", c->name, "verdict", hetab_verdict_name(c->verdict),
                  "value", cli_json_number(c->value), "error", cli_json_number(c->error),
                  "threshold", cli_json_number(c->threshold), "detail", cli_json_text(c->detail)));
  }
  return list;
}

/* rho_dh and its parts, each [theta_i]. */
static void add_energy(json_t *object, const hetab_audit *a, size_t channel) {
  json_t *lists[7];
  static const char *const names[7] = {"rho_dh", "error",   "rho_dd", "rho_s",
                                       "rho_ud", "fresnel", "model"};
  for (int i = 0; i < 7; i++)
    json_object_set_new(object, names[i], lists[i] = json_array());
  for (size_t t = 0; t < a->theta_count; t++) {
    const hetab_energy *e = &a->energy[channel * a->theta_count + t];
    const double values[7] = {e->dh, e->error, e->dd, e->specular, e->ud, e->fresnel, e->model};
    for (int i = 0; i < 7; i++)
      json_array_append_new(lists[i], cli_json_number(values[i]));
  }
}

static void add_band(json_t *object, const hetab_band_audit *b) {
  json_object_update_new(object,
                         json_pack("{sf ss sf sf sf sf sf so so sf sf}", "a", b->a, "a_unit",
                                   b->a_is_brdf ? "1/sr" : "reflectance", "max_a_brdf",
                                   b->max_a_brdf, "max_a_reflectance", b->max_a_reflectance,
                                   "max_a_fresnel", b->max_a_fresnel, "rho_dh_if_brdf",
                                   b->dh_if_brdf, "rho_dh_if_reflectance", b->dh_if_reflectance,
                                   "min", cli_json_number(b->min), "max", cli_json_number(b->max),
                                   "specular_share", b->specular_share, "grazing", b->grazing));
}

static json_t *channels_json(const hetab_audit *a) {
  static const char *const colours[] = {"red", "green", "blue"};
  json_t *list = json_array();
  for (size_t c = 0; c < a->channel_count; c++) {
    json_t *object = json_object();
    if (a->lambda_um)
      json_object_set_new(object, "wavelength_nm", json_real(1000 * a->lambda_um[c]));
    else
      json_object_set_new(object, "channel", json_string(colours[c]));
    if (a->bands)
      add_band(object, &a->bands[c]);
    add_energy(object, a, c);
    json_array_append_new(list, object);
  }
  return list;
}

static json_t *symmetry_json(const hetab_symmetry *s) {
  if (!s->compared)
    return json_null();
  return json_pack("{sI sf sf sf sf sf}", "compared", (json_int_t)s->compared, "mean_abs",
                   s->mean_abs, "max_abs", s->max_abs, "mean_rel", s->mean_rel, "max_rel",
                   s->max_rel, "norm", s->norm);
}

static json_t *cells_json(const hetab_cells *c) {
  return json_pack("{sI sI sI sI sI sI so so}", "total", (json_int_t)c->total, "nan",
                   (json_int_t)c->nan, "infinite", (json_int_t)c->infinite, "negative",
                   (json_int_t)c->negative, "invalid_above_horizon", (json_int_t)c->invalid_above,
                   "valid_below_horizon", (json_int_t)c->valid_below, "min",
                   cli_json_number(c->min), "max", cli_json_number(c->max));
}

static json_t *error_json(const hetab_table_error *e) {
  return json_pack("{sI sf sf sf sf sf sf}", "pairs", (json_int_t)e->pairs, "relative_l1",
                   e->relative_l1, "bias", e->bias, "p50", e->p50, "p95", e->p95, "p99", e->p99,
                   "max", e->max);
}

static json_t *against_json(const hetab_against *against) {
  if (!against)
    return json_null();
  json_t *bins = json_array();
  for (int i = 0; i < HETAB_ERROR_BINS; i++) {
    json_t *bin = error_json(&against->theta_i[i]);
    json_object_set_new(bin, "theta_i_from_deg", json_integer(i * 90 / HETAB_ERROR_BINS));
    json_object_set_new(bin, "theta_i_to_deg", json_integer((i + 1) * 90 / HETAB_ERROR_BINS));
    json_array_append_new(bins, bin);
  }
  return json_pack("{so so so so s{sf sf sb}}", "all", error_json(&against->all), "on_lobe",
                   error_json(&against->on_lobe), "off_lobe", error_json(&against->off_lobe),
                   "by_theta_i", bins, "specular", "white_sky", against->specular_hh,
                   "share_in_table", against->specular_in_table, "beside_table",
                   against->specular_apart);
}

static json_t *dims_json(const hetab_audit *a) {
  json_t *list = json_array();
  for (int i = 0; i < 4 && a->dims[i]; i++)
    json_array_append_new(list, json_integer((json_int_t)a->dims[i]));
  return list;
}

static json_t *result_json(const audit_result *result) {
  const hetab_audit *a = result->audit;
  json_t *object =
      json_pack("{so ss ss so so so so so so so so}", "input", cli_json_text(result->input), "kind",
                hetab_audit_kind_name(a->kind), "verdict",
                hetab_verdict_name(hetab_audit_verdict(a)), "checks", checks_json(a), "theta_i_deg",
                CLI_JSON_LIST(a->theta_count, json_real(hetab_degrees(a->theta_i[i]))), "channels",
                channels_json(a), "cells", cells_json(&a->cells), "reciprocity",
                symmetry_json(&a->reciprocity), "isotropy", symmetry_json(&a->isotropy),
                "bilateral", symmetry_json(&a->bilateral), "against", against_json(a->against));
  if (a->kind == HETAB_AUDIT_H5)
    json_object_set_new(object, "separability", cli_json_number(a->separability));
  if (a->kind != HETAB_AUDIT_SURFACE) {
    json_object_set_new(object, "lookup", json_string(hetab_reading_name(a->lookup)));
    json_object_set_new(object, "bytes", json_integer((json_int_t)a->bytes));
    json_object_set_new(object, "dimensions", dims_json(a));
  }
  return object;
}

static json_t *repair_json(const audit_report *report) {
  const hetab_repair_report *r = &report->repair;
  if (!report->repaired)
    return json_null();
  return json_pack("{so sI sI sI sI sf sf sI sf}", "output", cli_json_text(report->repaired),
                   "entries", (json_int_t)r->entries, "replaced", (json_int_t)r->replaced,
                   "clamped", (json_int_t)r->clamped, "symmetrised", (json_int_t)r->symmetrised,
                   "max_change_abs", r->max_change_abs, "max_change_rel", r->max_change_rel,
                   "scaled_incidences", (json_int_t)r->scaled_incidences, "smallest_scale",
                   r->smallest_scale);
}

json_t *audit_json(const audit_report *report) {
  size_t counts[3];
  hetab_verdict worst = audit_worst(report, counts);
  json_t *results = CLI_JSON_LIST(report->count, result_json(&report->results[i]));
  return json_pack("{ss ss s{sI sI sI} so so}", "version", hetab_version(), "verdict",
                   hetab_verdict_name(worst), "summary", "pass", (json_int_t)counts[HETAB_PASS],
                   "warn", (json_int_t)counts[HETAB_WARN], "fail", (json_int_t)counts[HETAB_FAIL],
                   "repair", repair_json(report), "results", results);
}
