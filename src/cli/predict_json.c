/* Predictions as JSON. */
#include <math.h>

#include "core/angle.h"
#include "output.h"
#include "predict_command.h"

static json_t *bounds_json(double value, double low, double high) {
  return json_pack("{sf sf sf}", "value", value, "low", low, "high", high);
}

static json_t *curve_json(const hetab_prediction *p, const hetab_prediction_curve *c) {
  enum { STRIDE = sizeof(hetab_bounds) / sizeof(double) };
  return json_pack("{sf sf sf so so so so}", "wavelength_nm", 1000 * c->lambda_um, "theta_i_deg",
                   hetab_degrees(c->theta_i), "peak_theta_r_deg", hetab_degrees(c->peak), "f",
                   cli_json_numbers(&c->f->nominal, p->theta_r_count, STRIDE), "low",
                   cli_json_numbers(&c->f->low, p->theta_r_count, STRIDE), "high",
                   cli_json_numbers(&c->f->high, p->theta_r_count, STRIDE), "rho_s",
                   bounds_json(c->specular.nominal, c->specular.low, c->specular.high));
}

static json_t *count_json(const hetab_prediction_count *count) {
  double points = (double)count->points;
  return json_pack("{sI sI sI sI so so}", "points", (json_int_t)count->points, "within",
                   (json_int_t)count->within, "below", (json_int_t)count->below, "above",
                   (json_int_t)count->above, "fraction_within",
                   cli_json_number((double)count->within / points), "bias",
                   cli_json_number(points > 0.0 ? count->bias : (double)NAN));
}

static json_t *point_json(const hetab_prediction *p, const hetab_predicted_point *point) {
  const hetab_directions *d = &point->directions;
  return json_pack("{sf sf sf sf sf sf sf sf si}", "wavelength_nm",
                   1000 * p->curves[point->curve].lambda_um, "theta_i_deg",
                   hetab_degrees(d->theta_i), "theta_r_deg", hetab_degrees(d->theta_r), "phi_deg",
                   hetab_degrees(d->phi), "measured", point->measured, "f", point->f.nominal, "low",
                   point->f.low, "high", point->f.high, "side", point->side);
}

static json_t *measured_json(const predict_report *r) {
  if (!r->measurements)
    return json_null();
  const hetab_prediction *p = r->prediction;
  hetab_measurements_skipped s = hetab_measurements_skipped_of(r->measurements);
  json_t *points = CLI_JSON_LIST(p->point_count, point_json(p, &p->points[i]));
  return json_pack("{so sf so so s{sI sI sI} so}", "name",
                   cli_json_text(hetab_measurements_name(r->measurements)), "accuracy", r->accuracy,
                   "plane", count_json(&p->plane), "hemisphere", count_json(&p->hemisphere),
                   "skipped", "below_horizon", (json_int_t)s.below_horizon, "negative",
                   (json_int_t)s.negative, "not_finite", (json_int_t)s.not_finite, "points",
                   points);
}

static json_t *curves_json(const hetab_prediction *p) {
  return CLI_JSON_LIST(p->curve_count, curve_json(p, &p->curves[i]));
}

json_t *predict_json(const predict_report *r) {
  const hetab_prediction *p = r->prediction;
  hetab_roughness_bounds b = p->bounds;
  return json_pack(
      "{so ss so so sf so so so so}", "surface", cli_json_text(hetab_surface_name(r->surface)),
      "version", hetab_version(), "sigma0_um",
      bounds_json(hetab_surface_sigma0_um(r->surface), b.sigma0_um.low, b.sigma0_um.high), "tau_um",
      bounds_json(hetab_surface_tau_um(r->surface), b.tau_um.low, b.tau_um.high), "error", p->error,
      "theta_r_deg", CLI_JSON_LIST(p->theta_r_count, json_real(hetab_degrees(p->theta_r[i]))),
      "curves", curves_json(p), "measured", measured_json(r), "with_tau",
      r->with_tau ? curves_json(r->with_tau) : json_null());
}
