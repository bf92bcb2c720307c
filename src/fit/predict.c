/* Curves in the incidence plane with the bounds of an interval of roughness, and how measured
 * points lie to them. */
#include <hetab/predict.h>

#include <math.h>
#include <stdlib.h>

#include "core/option_size.h"
#include "core/angle.h"
#include "core/context.h"
#include "engine/sample.h"

static const double SAME_THETA = 0.1 / 180.0 * M_PI, SAME_LAMBDA_UM = 1e-4,
                    IN_PLANE = 0.5 / 180.0 * M_PI;

typedef struct job {
  hetab_context *ctx;
  hetab_engine *engine;
  const hetab_surface *surface;
  const hetab_predict_options *options;
  const double *lambda_um;
  double *own_lambda_um; /* where the surface gives them */
  size_t lambda_count;
  hetab_band *bands; /* [lambda_count] */
  hetab_prediction *out;
} job;

/* ---- what was asked for -------------------------------------------------------------------- */

static hetab_status check_interval(job *j, hetab_interval *interval, double own, const char *what) {
  if (interval->low == 0 && interval->high == 0)
    *interval = (hetab_interval){own, own};
  if (own >= interval->low && own <= interval->high)
    return HETAB_OK;
  return hetab_fail(j->ctx, HETAB_ERR_ARGUMENT,
                    "the surface's %s, %g um, is not within %g to %g um: give bounds around it, or "
                    "a surface between them",
                    what, own, interval->low, interval->high);
}

static hetab_status check_options(job *j) {
  const hetab_predict_options *o = j->options;
  if (o->theta_i_count == 0)
    return hetab_fail(j->ctx, HETAB_ERR_ARGUMENT, "no incidence: give at least one theta_i");
  for (size_t i = 0; i < o->theta_i_count; i++)
    if (!(o->theta_i[i] >= 0.0 && o->theta_i[i] < M_PI_2))
      return hetab_fail(j->ctx, HETAB_ERR_ARGUMENT,
                        "theta_i: %g degrees is out of range: give angles from 0 to below 90",
                        hetab_degrees(o->theta_i[i]));
  if (!(o->step == 0.0 || (o->step >= hetab_radians(0.01) && o->step <= M_PI_2)))
    return hetab_fail(j->ctx, HETAB_ERR_ARGUMENT,
                      "a step of %g degrees is out of range: give 0.01 to 90",
                      hetab_degrees(o->step));
  if (!(o->accuracy >= 0 && o->accuracy < 1))
    return hetab_fail(j->ctx, HETAB_ERR_ARGUMENT,
                      "an accuracy of %g is out of range: give 0 to below 1", o->accuracy);
  HETAB_TRY(
      check_interval(j, &j->out->bounds.sigma0_um, hetab_surface_sigma0_um(j->surface), "sigma0"));
  return check_interval(j, &j->out->bounds.tau_um, hetab_surface_tau_um(j->surface), "tau");
}

static hetab_status find_wavelengths(job *j) {
  j->lambda_um = j->options->lambda_um;
  j->lambda_count = j->options->lambda_count;
  if (!j->lambda_um) {
    j->lambda_count = hetab_surface_band_count(j->surface);
    j->own_lambda_um = hetab_alloc(j->ctx, j->lambda_count, sizeof *j->own_lambda_um);
    HETAB_NEED(j->own_lambda_um);
    for (size_t b = 0; b < j->lambda_count; b++)
      j->own_lambda_um[b] = hetab_surface_bands(j->surface)[b].lambda_um;
    j->lambda_um = j->own_lambda_um;
  }
  j->bands = hetab_alloc(j->ctx, j->lambda_count, sizeof *j->bands);
  HETAB_NEED(j->bands);
  for (size_t b = 0; b < j->lambda_count; b++)
    HETAB_TRY(hetab_surface_at(j->ctx, j->surface, j->lambda_um[b], &j->bands[b]));
  return HETAB_OK;
}

static hetab_point point_at(const job *j, const hetab_band *band, double theta_i, double theta_r,
                            double phi) {
  return (hetab_point){band->lambda_um,
                       theta_i,
                       theta_r,
                       phi,
                       hetab_surface_sigma0_um(j->surface),
                       hetab_surface_tau_um(j->surface),
                       band->n,
                       band->k,
                       band->diffuse_brdf};
}

/* Bounds equal to the surface's own value are none. */
static hetab_roughness_bounds proper_bounds(const hetab_prediction *p) {
  hetab_roughness_bounds bounds = p->bounds;
  if (bounds.sigma0_um.low == bounds.sigma0_um.high)
    bounds.sigma0_um = (hetab_interval){0, 0};
  if (bounds.tau_um.low == bounds.tau_um.high)
    bounds.tau_um = (hetab_interval){0, 0};
  return bounds;
}

static hetab_status bound(job *j, const hetab_point *points, size_t count, hetab_bounded quantity,
                          hetab_bounds *out) {
  hetab_roughness_bounds bounds = proper_bounds(j->out);
  return hetab_envelope(j->ctx, j->engine, points, count, &bounds, quantity, out);
}

/* ---- curves -------------------------------------------------------------------------------- */

static hetab_status make_room(job *j) {
  hetab_prediction *p = j->out;
  double step = j->options->step > 0.0 ? j->options->step : hetab_radians(0.5);
  size_t half = (size_t)lround(M_PI_2 / step);
  p->theta_r_count = 2 * half + 1;
  p->curve_count = j->lambda_count * j->options->theta_i_count;
  p->theta_r = hetab_alloc(j->ctx, p->theta_r_count, sizeof *p->theta_r);
  p->curves = hetab_alloc(j->ctx, p->curve_count, sizeof *p->curves);
  p->values = hetab_alloc(j->ctx, p->curve_count * p->theta_r_count, sizeof *p->values);
  HETAB_NEED(p->theta_r && p->curves && p->values);
  for (size_t i = 0; i < p->theta_r_count; i++)
    p->theta_r[i] = hetab_radians(90.0 * ((double)i - (double)half) / (double)half);
  return HETAB_OK;
}

static void describe_curve(hetab_prediction *p, hetab_prediction_curve *curve) {
  size_t peak = 0;
  for (size_t i = 0; i < p->theta_r_count; i++) {
    const hetab_bounds *f = &curve->f[i];
    peak = f->nominal > curve->f[peak].nominal ? i : peak;
    if (f->high >= HETAB_FLOOR_PER_SR)
      p->error = fmax(p->error, f->error / f->high);
  }
  curve->peak = p->theta_r[peak];
}

/* The points of a curve, and the values that they will have. */
static void lay_out_curve(job *j, size_t index, hetab_point *points) {
  hetab_prediction *p = j->out;
  const hetab_band *band = &j->bands[index / j->options->theta_i_count];
  double theta_i = j->options->theta_i[index % j->options->theta_i_count];
  p->curves[index] = (hetab_prediction_curve){
      .lambda_um = band->lambda_um, .theta_i = theta_i, .f = p->values + index * p->theta_r_count};
  for (size_t i = 0; i < p->theta_r_count; i++) {
    double theta_r = p->theta_r[i];
    points[i] = point_at(j, band, theta_i, fabs(theta_r), theta_r > 0.0 ? M_PI : 0.0);
  }
}

/* rho_s depends on the incidence alone: one point of each curve. */
static hetab_status bound_specular(job *j, hetab_point *points) {
  hetab_prediction *p = j->out;
  HETAB_FREED hetab_bounds *specular = hetab_alloc(j->ctx, p->curve_count, sizeof *specular);
  HETAB_NEED(specular);
  for (size_t i = 0; i < p->curve_count; i++)
    points[i] = points[i * p->theta_r_count];
  HETAB_TRY(bound(j, points, p->curve_count, HETAB_BOUNDED_SPECULAR, specular));
  for (size_t i = 0; i < p->curve_count; i++)
    p->curves[i].specular = specular[i];
  return HETAB_OK;
}

/* All curves at once: a device is slow to start and fast to go on. */
static hetab_status make_curves(job *j) {
  hetab_prediction *p = j->out;
  HETAB_TRY(make_room(j));
  size_t count = p->curve_count * p->theta_r_count;
  HETAB_FREED hetab_point *points = hetab_alloc(j->ctx, count, sizeof *points);
  HETAB_NEED(points);
  for (size_t i = 0; i < p->curve_count; i++)
    lay_out_curve(j, i, points + i * p->theta_r_count);
  HETAB_TRY(bound(j, points, count, HETAB_BOUNDED_TOTAL, p->values));
  HETAB_TRY(bound_specular(j, points));
  for (size_t i = 0; i < p->curve_count; i++)
    describe_curve(p, &p->curves[i]);
  return HETAB_OK;
}

/* ---- measured points ----------------------------------------------------------------------- */

/* The curve of the incidence and wavelength, or curve_count. */
static size_t find_curve(const hetab_prediction *p, double theta_i, double lambda_um) {
  size_t i = 0;
  while (i < p->curve_count && !(fabs(p->curves[i].theta_i - theta_i) <= SAME_THETA &&
                                 fabs(p->curves[i].lambda_um - lambda_um) <= SAME_LAMBDA_UM))
    i++;
  return i;
}

/* The angle between the view and the mirror direction. */
static double from_mirror(const hetab_directions *pair) {
  double cosine = cos(pair->theta_i) * cos(pair->theta_r) -
                  sin(pair->theta_i) * sin(pair->theta_r) * cos(pair->phi);
  return acos(fmax(-1.0, fmin(1.0, cosine)));
}

static hetab_predicted_point judged_point(size_t curve, const hetab_directions *pair,
                                          double measured) {
  double theta_r = pair->theta_r;
  int light_side = pair->phi <= IN_PLANE, mirror_side = pair->phi >= M_PI - IN_PLANE;
  return (hetab_predicted_point){.curve = curve,
                                 .directions = *pair,
                                 .in_plane = light_side || mirror_side || theta_r == 0.0,
                                 .plane_theta_r = mirror_side ? theta_r : -theta_r,
                                 .measured = measured};
}

static hetab_status fail_apart(const job *j, const hetab_measurements *m) {
  const hetab_directions *pairs = hetab_measurements_pairs(m);
  const double *lambda_um = hetab_measurements_lambda_um(m);
  double first = HUGE_VAL, last = 0;
  for (size_t i = 0; i < hetab_measurements_pair_count(m); i++) {
    first = fmin(first, hetab_degrees(pairs[i].theta_i));
    last = fmax(last, hetab_degrees(pairs[i].theta_i));
  }
  return hetab_fail(j->ctx, HETAB_ERR_RANGE,
                    "%s: no measurement at any of these incidences and wavelengths: choose some "
                    "that it has, theta_i from %.5g to %.5g degrees, %.6g to %.6g nm",
                    hetab_measurements_name(m), first, last, 1000 * lambda_um[0],
                    1000 * lambda_um[hetab_measurements_wavelength_count(m) - 1]);
}

static hetab_status choose_points(job *j) {
  const hetab_measurements *m = j->options->measurements;
  hetab_prediction *p = j->out;
  const hetab_directions *pairs = hetab_measurements_pairs(m);
  size_t bands = hetab_measurements_wavelength_count(m), count = hetab_measurements_pair_count(m);
  p->points = hetab_alloc(j->ctx, count * bands, sizeof *p->points);
  HETAB_NEED(p->points);
  for (size_t i = 0; i < count; i++)
    for (size_t b = 0; b < bands; b++) {
      double value = hetab_measurements_values(m)[i * bands + b];
      size_t curve = find_curve(p, pairs[i].theta_i, hetab_measurements_lambda_um(m)[b]);
      if (isnan(value) || curve == p->curve_count ||
          from_mirror(&pairs[i]) < j->options->exclude_mirror)
        continue;
      p->points[p->point_count++] = judged_point(curve, &pairs[i], value);
    }
  return p->point_count ? HETAB_OK : fail_apart(j, m);
}

static void count_point(hetab_prediction_count *count, const hetab_predicted_point *point) {
  count->points++;
  count->below += point->side < 0;
  count->within += point->side == 0;
  count->above += point->side > 0;
}

/* Of the sums: where the model has next to nothing, ratios of single values mean nothing. */
static void find_bias(const hetab_prediction *p, int plane, hetab_prediction_count *count) {
  double measured = 0, predicted = 0;
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_predicted_point *point = &p->points[i];
    measured += !plane || point->in_plane ? point->measured : 0;
    predicted += !plane || point->in_plane ? point->f.nominal : 0;
  }
  count->bias = predicted > 0 ? measured / predicted - 1 : 0;
}

static void judge_points(const job *j) {
  hetab_prediction *p = j->out;
  double accuracy = j->options->accuracy;
  for (size_t i = 0; i < p->point_count; i++) {
    hetab_predicted_point *point = &p->points[i];
    double most = point->measured * (1 + accuracy) + HETAB_FLOOR_PER_SR;
    double least = point->measured * (1 - accuracy) - HETAB_FLOOR_PER_SR;
    point->side = most < point->f.low ? -1 : least > point->f.high ? 1 : 0;
    count_point(&p->hemisphere, point);
    if (point->in_plane)
      count_point(&p->plane, point);
  }
  find_bias(p, 0, &p->hemisphere);
  find_bias(p, 1, &p->plane);
}

static hetab_status bound_points(job *j) {
  hetab_prediction *p = j->out;
  HETAB_FREED hetab_point *points = hetab_alloc(j->ctx, p->point_count, sizeof *points);
  HETAB_FREED hetab_bounds *bounds = hetab_alloc(j->ctx, p->point_count, sizeof *bounds);
  HETAB_NEED(points && bounds);
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_directions *d = &p->points[i].directions;
    const hetab_band *band = &j->bands[p->points[i].curve / j->options->theta_i_count];
    points[i] = point_at(j, band, d->theta_i, d->theta_r, d->phi);
  }
  HETAB_TRY(bound(j, points, p->point_count, HETAB_BOUNDED_TOTAL, bounds));
  for (size_t i = 0; i < p->point_count; i++)
    p->points[i].f = bounds[i];
  return HETAB_OK;
}

static hetab_status judge_measurements(job *j) {
  if (!j->options->measurements)
    return HETAB_OK;
  HETAB_TRY(choose_points(j));
  HETAB_TRY(bound_points(j));
  judge_points(j);
  return HETAB_OK;
}

/* ---- the whole ----------------------------------------------------------------------------- */

static hetab_status run(job *j) {
  HETAB_TRY(check_options(j));
  HETAB_TRY(find_wavelengths(j));
  HETAB_TRY(make_curves(j));
  return judge_measurements(j);
}

hetab_status hetab_predict(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                           const hetab_predict_options *options, hetab_prediction **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_predict_options, own, options);
  job j = {.ctx = ctx, .engine = engine, .surface = surface, .options = &own};
  j.out = hetab_alloc(ctx, 1, sizeof *j.out);
  HETAB_NEED(j.out);
  j.out->bounds = own.bounds;
  hetab_status status = run(&j);
  free(j.bands);
  free(j.own_lambda_um);
  if (status == HETAB_OK)
    *out = j.out;
  else
    hetab_prediction_free(j.out);
  return status;
}

void hetab_prediction_free(hetab_prediction *prediction) {
  if (!prediction)
    return;
  free(prediction->theta_r);
  free(prediction->curves);
  free(prediction->points);
  free(prediction->values);
  free(prediction);
}
