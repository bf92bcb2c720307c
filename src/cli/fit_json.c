/* Fits as JSON. */
#include "core/angle.h"
#include "fit_command.h"
#include "output.h"

static json_t *estimate_json(const hetab_fit_estimate *e) {
  return json_pack("{ss so sf so so so so sf ss sb}", "quantity",
                   hetab_fit_quantity_name(e->quantity), "wavelength_nm",
                   e->lambda_um > 0 ? json_real(1e3 * e->lambda_um) : json_null(), "value",
                   e->value, "low", cli_json_number(e->low), "high", cli_json_number(e->high),
                   "bootstrap_low", cli_json_number(e->bootstrap_low), "bootstrap_high",
                   cli_json_number(e->bootstrap_high), "unconstrained", e->wanted, "end",
                   hetab_fit_end_name(e->end), "determined", !e->undetermined);
}

static json_t *incidence_json(const hetab_fit_incidence *i) {
  const struct {
    const char *name;
    double value;
  } fields[] = {{"error", i->error},
                {"rms", i->rms},
                {"mean", i->mean},
                {"bias", i->bias},
                {"margin", i->margin},
                {"margin_wavelength_nm", 1e3 * i->margin_lambda_um},
                {"rho_dh", i->rho_dh},
                {"bound", i->bound},
                {"polished_margin", i->polished_margin},
                {"room", i->room},
                {"excess", i->excess}};
  json_t *incidence = json_pack("{sf sI}", "theta_i_deg", hetab_degrees(i->theta_i), "values",
                                (json_int_t)i->values);
  for (size_t f = 0; f < sizeof fields / sizeof *fields; f++)
    json_object_set_new(incidence, fields[f].name, cli_json_number(fields[f].value));
  return incidence;
}

static json_t *start_json(const hetab_fit_start *s) {
  json_t *start = json_object(), *end = json_object();
  for (int q = 0; q < HETAB_FIT_DIFFUSE; q++) {
    const char *name = hetab_fit_quantity_name((hetab_fit_quantity)q);
    if (s->start[q] > 0)
      json_object_set_new(start, name, json_real(s->start[q]));
    if (s->end[q] > 0)
      json_object_set_new(end, name, json_real(s->end[q]));
  }
  return json_pack("{so so so sb sb sb}", "start", start, "end", end, "error",
                   cli_json_number(s->error), "feasible", s->feasible, "best", s->best, "probe",
                   s->probe);
}

/* The unknowns' places in estimates, and the matrix. */
static json_t *correlation_json(const hetab_fit *fit) {
  json_t *places = json_array(), *rows = json_array();
  for (size_t a = 0; a < fit->free_count; a++) {
    json_t *row = json_array();
    for (size_t b = 0; b < fit->free_count; b++)
      json_array_append_new(row, json_real(fit->correlation[a * fit->free_count + b]));
    json_array_append_new(rows, row);
    json_array_append_new(places, json_integer((json_int_t)fit->free_estimates[a]));
  }
  return json_pack("{so so}", "estimates", places, "matrix", rows);
}

/* Those that a robust fit distrusts. */
static json_t *distrusted_json(const hetab_fit *fit, const hetab_measurements *m) {
  json_t *points = json_array();
  size_t wavelengths = hetab_measurements_wavelength_count(m);
  for (size_t i = 0; i < hetab_measurements_pair_count(m); i++)
    for (size_t b = 0; b < fit->bands; b++) {
      const hetab_directions *d = &hetab_measurements_pairs(m)[i];
      if (fit->distrusted[i * fit->bands + b])
        json_array_append_new(
            points,
            json_pack("{sf sf sf sf sf sf}", "wavelength_nm", 1e3 * fit->lambda_um[b],
                      "theta_i_deg", hetab_degrees(d->theta_i), "theta_r_deg",
                      hetab_degrees(d->theta_r), "phi_deg", hetab_degrees(d->phi), "measured",
                      hetab_measurements_values(m)[i * wavelengths + fit->band_of[b]], "model",
                      fit->model[i * fit->bands + b]));
    }
  return points;
}

static json_t *one_json(const hetab_fit *fit, const hetab_measurements *measurements) {
  json_t *estimates = CLI_JSON_LIST(fit->estimate_count, estimate_json(&fit->estimates[i]));
  json_t *incidences = CLI_JSON_LIST(fit->incidence_count, incidence_json(&fit->incidences[i]));
  json_t *starts = CLI_JSON_LIST(fit->start_count, start_json(&fit->starts[i]));
  json_t *notes = CLI_JSON_LIST(fit->note_count, cli_json_text(fit->notes[i]));
  return json_pack("{sf sf ss ss ss sb sb sf sI sI sI sI sI so so so so so so}", "error",
                   fit->error, "rms", fit->rms, "weights", hetab_fit_weights_name(fit->weights),
                   "constraint", hetab_fit_constraint_name(fit->constraint), "stop",
                   hetab_fit_stop_name(fit->stop), "on_constraint", fit->on_constraint, "ambiguous",
                   fit->ambiguous, "margin", fit->margin, "pairs", (json_int_t)fit->used_pairs,
                   "values", (json_int_t)fit->used_values, "missing", (json_int_t)fit->missing,
                   "thinned", (json_int_t)fit->thinned, "evaluations", (json_int_t)fit->evaluations,
                   "estimates", estimates, "correlation", correlation_json(fit), "incidences",
                   incidences, "starts", starts, "distrusted", distrusted_json(fit, measurements),
                   "notes", notes);
}

json_t *fit_json(const fit_report *report) {
  json_t *fits = CLI_JSON_LIST(report->count, one_json(report->fits[i], report->measurements));
  return json_pack("{so so ss ss so}", "measurements",
                   cli_json_text(hetab_measurements_name(report->measurements)), "device",
                   cli_json_text(report->device), "precision",
                   hetab_precision_name(report->precision), "version", hetab_version(), "fits",
                   fits);
}
