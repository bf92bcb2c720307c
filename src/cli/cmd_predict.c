/* hetab predict: the BRDF in the incidence plane with bounds, beside measured points. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "core/held_files.h"
#include "output.h"
#include "predict_command.h"

static const double preferred_um = 0.55;

typedef struct request {
  const char *surface, *theta_i, *wavelengths, *sigma0, *tau, *measurements;
  const char *csv, *html, *device;
  double non_uniformity, accuracy, exclude_mirror_deg, step_deg;
  int precision, literal, json, force, quiet;
} request;

typedef struct job {
  const request *request;
  hetab_context *ctx;
  hetab_engine *engine;
  hetab_surface *surface;
  hetab_measurements *measurements;
  hetab_grid *grid; /* of the incidences, where an option names them */
  double *theta_i;  /* else those of the measurements */
  double *lambda_um;
  hetab_predict_options options;
  hetab_prediction *prediction;
} job;

/* ---- bounds -------------------------------------------------------------------------------- */

/* "LO:HI"; a usage error names the option. */
static int parse_interval(const cli_command *self, const char *option, const char *text,
                          hetab_interval *out) {
  if (text && !(cli_interval(text, &out->low, &out->high) && out->low > 0))
    return cli_usage(self, "--%s: '%s' is no interval LO:HI of lengths in um", option, text);
  return -1;
}

static int check_bounds(const cli_command *self, const request *r, hetab_roughness_bounds *bounds) {
  int status = parse_interval(self, "sigma0", r->sigma0, &bounds->sigma0_um);
  if (status < 0)
    status = parse_interval(self, "tau", r->tau, &bounds->tau_um);
  if (status < 0 && r->sigma0 && r->non_uniformity >= 0)
    status = cli_usage(self, "--sigma0 and --non-uniformity are both bounds of sigma0: keep one");
  return status;
}

/* What no option says, the surface's file may. */
static void fill_bounds(job *j) {
  hetab_roughness_bounds *bounds = &j->options.bounds;
  double sigma0_um[2], tau_um[2], own = hetab_surface_sigma0_um(j->surface);
  hetab_surface_bounds(j->surface, sigma0_um, tau_um);
  if (j->request->non_uniformity >= 0)
    bounds->sigma0_um = (hetab_interval){own * (1 - j->request->non_uniformity),
                                         own * (1 + j->request->non_uniformity)};
  else if (!j->request->sigma0)
    bounds->sigma0_um = (hetab_interval){sigma0_um[0], sigma0_um[1]};
  if (!j->request->tau)
    bounds->tau_um = (hetab_interval){tau_um[0], tau_um[1]};
}

/* ---- incidences and wavelengths ------------------------------------------------------------ */

static int by_size(const void *left, const void *right) {
  double a = *(const double *)left, b = *(const double *)right;
  return (a > b) - (a < b);
}

/* The measured incidences, each once. */
static hetab_status measured_incidences(job *j) {
  size_t count = hetab_measurements_pair_count(j->measurements), kept = 0;
  const hetab_directions *pairs = hetab_measurements_pairs(j->measurements);
  double *theta_i = j->theta_i = calloc(count + 1, sizeof *theta_i);
  if (!theta_i)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < count; i++)
    theta_i[i] = pairs[i].theta_i;
  qsort(theta_i, count, sizeof *theta_i, by_size);
  for (size_t i = 0; i < count; i++)
    if (kept == 0 || theta_i[i] > theta_i[kept - 1] + hetab_radians(0.1)) /* 50.00002 degrees is */
      theta_i[kept++] =
          hetab_radians(round(1000.0 * hetab_degrees(theta_i[i])) / 1000.0); /* 0.872665 */
  j->options.theta_i = theta_i;
  j->options.theta_i_count = kept;
  return HETAB_OK;
}

static hetab_status find_incidences(job *j) {
  const char *spec = j->request->theta_i;
  if (!spec && j->measurements)
    return measured_incidences(j);
  hetab_status status = hetab_grid_create(j->ctx, &j->grid);
  if (status == HETAB_OK)
    status = hetab_grid_set_axis(j->ctx, j->grid, HETAB_THETA_I, spec ? spec : "15,30,45,60,75");
  if (status != HETAB_OK)
    return status;
  j->options.theta_i = hetab_grid_radians(j->grid, HETAB_THETA_I);
  j->options.theta_i_count = hetab_grid_count(j->grid, HETAB_THETA_I);
  return HETAB_OK;
}

/* Without the option, the one next to the middle of the visible: of what was measured, or of the
 * surface. */
static hetab_status find_wavelengths(job *j) {
  if (j->request->wavelengths) {
    hetab_status status = hetab_parse_wavelengths(j->ctx, j->request->wavelengths, &j->lambda_um,
                                                  &j->options.lambda_count);
    j->options.lambda_um = j->lambda_um;
    return status;
  }
  size_t count = j->measurements ? hetab_measurements_wavelength_count(j->measurements)
                                 : hetab_surface_band_count(j->surface);
  j->lambda_um = calloc(1, sizeof *j->lambda_um);
  if (!j->lambda_um)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < count; i++) {
    double lambda_um = j->measurements ? hetab_measurements_lambda_um(j->measurements)[i]
                                       : hetab_surface_bands(j->surface)[i].lambda_um;
    if (fabs(lambda_um - preferred_um) < fabs(*j->lambda_um - preferred_um))
      *j->lambda_um = lambda_um;
  }
  j->options.lambda_um = j->lambda_um;
  j->options.lambda_count = 1;
  return HETAB_OK;
}

static hetab_status open_inputs(job *j) {
  const request *r = j->request;
  hetab_engine_options engine = {.devices = r->device,
                                 .precision = r->precision ? HETAB_DOUBLE : HETAB_FLOAT,
                                 .method = r->literal ? HETAB_METHOD_LITERAL : HETAB_METHOD_SERIES};
  hetab_status status = hetab_surface_open(j->ctx, r->surface, &j->surface);
  if (status == HETAB_OK && r->measurements)
    status = hetab_measurements_load(j->ctx, r->measurements, &j->measurements);
  if (status == HETAB_OK)
    status = find_incidences(j);
  if (status == HETAB_OK)
    status = find_wavelengths(j);
  if (status == HETAB_OK)
    status = hetab_engine_create(j->ctx, &engine, &j->engine);
  if (status == HETAB_OK)
    fill_bounds(j);
  return status;
}

/* ---- text ---------------------------------------------------------------------------------- */

static void print_interval(const char *name, double value, hetab_interval interval) {
  printf("%s %.5g um", name, value);
  if (interval.high > interval.low)
    printf(" (%.5g to %.5g)", interval.low, interval.high);
}

static const hetab_bounds *peak_of(const hetab_prediction *p, const hetab_prediction_curve *curve) {
  size_t i = 0;
  while (p->theta_r[i] < curve->peak)
    i++;
  return &curve->f[i];
}

static void print_count(const char *where, const hetab_prediction_count *count) {
  if (count->points)
    printf("measured, %s: %zu points, %zu (%.1f %%) within the bounds, %zu below, %zu above, sum "
           "%+.1f %%\n",
           where, count->points, count->within, 100 * (double)count->within / (double)count->points,
           count->below, count->above, 100 * count->bias);
}

static void print_skipped(const job *j) {
  hetab_measurements_skipped s = hetab_measurements_skipped_of(j->measurements);
  if (s.below_horizon || s.not_finite)
    printf("not used: %zu rows below the horizon, %zu values not finite\n", s.below_horizon,
           s.not_finite);
}

static int has_bounds(const hetab_roughness_bounds *b) {
  return b->sigma0_um.low < b->sigma0_um.high || b->tau_um.low < b->tau_um.high;
}

static void print_text(const job *j) {
  const hetab_prediction *p = j->prediction;
  printf("%s: ", hetab_surface_name(j->surface));
  print_interval("sigma0", hetab_surface_sigma0_um(j->surface), p->bounds.sigma0_um);
  print_interval(", tau", hetab_surface_tau_um(j->surface), p->bounds.tau_um);
  printf("\n\n%6s %8s %8s %10s %10s %10s %10s %10s %10s\n", "nm", "theta_i", "peak at", "f, 1/sr",
         "low", "high", "rho_s", "low", "high");
  for (size_t i = 0; i < p->curve_count; i++) {
    const hetab_prediction_curve *c = &p->curves[i];
    const hetab_bounds *peak = peak_of(p, c);
    printf("%6.5g %8.4g %8.4g %10.4g %10.4g %10.4g %10.3g %10.3g %10.3g\n", 1000 * c->lambda_um,
           hetab_degrees(c->theta_i), hetab_degrees(c->peak), peak->nominal, peak->low, peak->high,
           predict_shown(c->specular.nominal), predict_shown(c->specular.low),
           predict_shown(c->specular.high));
  }
  if (has_bounds(&p->bounds))
    printf("\nthe bounds miss less than %.1g of the value\n", p->error);
  else
    puts("\nno bounds: the surface's file has none; give --non-uniformity, --sigma0 or --tau");
  if (!j->measurements)
    return;
  print_count("incidence plane", &p->plane);
  print_count("hemisphere", &p->hemisphere);
  print_skipped(j);
}

/* ---- CSV ----------------------------------------------------------------------------------- */

static void write_csv(FILE *out, const hetab_prediction *p) {
  fputs("wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f,low,high,error,measured,side\n", out);
  for (size_t i = 0; i < p->curve_count; i++)
    for (size_t k = 0; k < p->theta_r_count; k++) {
      const hetab_prediction_curve *c = &p->curves[i];
      double theta_r_deg = hetab_degrees(p->theta_r[k]);
      fprintf(out, "%.9g,%.9g,%.9g,%d,%.9g,%.9g,%.9g,%.3g,,\n", 1000 * c->lambda_um,
              hetab_degrees(c->theta_i), fabs(theta_r_deg), theta_r_deg > 0 ? 180 : 0,
              c->f[k].nominal, c->f[k].low, c->f[k].high, c->f[k].error);
    }
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_predicted_point *point = &p->points[i];
    const hetab_directions *d = &point->directions;
    fprintf(out, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.3g,%.9g,%d\n",
            1000 * p->curves[point->curve].lambda_um, hetab_degrees(d->theta_i),
            hetab_degrees(d->theta_r), hetab_degrees(d->phi), point->f.nominal, point->f.low,
            point->f.high, point->f.error, point->measured, point->side);
  }
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static json_t *bounds_json(double value, double low, double high) {
  return json_pack("{sf sf sf}", "value", value, "low", low, "high", high);
}

static json_t *degrees_json(const double *radians, size_t count) {
  json_t *array = json_array();
  for (size_t i = 0; i < count; i++)
    json_array_append_new(array, json_real(hetab_degrees(radians[i])));
  return array;
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

static json_t *measured_json(const job *j) {
  if (!j->measurements)
    return json_null();
  const hetab_prediction *p = j->prediction;
  hetab_measurements_skipped s = hetab_measurements_skipped_of(j->measurements);
  json_t *points = json_array();
  for (size_t i = 0; i < p->point_count; i++)
    json_array_append_new(points, point_json(p, &p->points[i]));
  return json_pack("{so sf so so s{sI sI sI} so}", "name",
                   cli_json_text(hetab_measurements_name(j->measurements)), "accuracy",
                   j->options.accuracy, "plane", count_json(&p->plane), "hemisphere",
                   count_json(&p->hemisphere), "skipped", "below_horizon",
                   (json_int_t)s.below_horizon, "negative", (json_int_t)s.negative, "not_finite",
                   (json_int_t)s.not_finite, "points", points);
}

static int print_json(const job *j) {
  const hetab_prediction *p = j->prediction;
  hetab_roughness_bounds b = p->bounds;
  json_t *curves = json_array();
  for (size_t i = 0; i < p->curve_count; i++)
    json_array_append_new(curves, curve_json(p, &p->curves[i]));
  return cli_json_print(json_pack(
      "{so ss so so sf so so so}", "surface", cli_json_text(hetab_surface_name(j->surface)),
      "version", hetab_version(), "sigma0_um",
      bounds_json(hetab_surface_sigma0_um(j->surface), b.sigma0_um.low, b.sigma0_um.high), "tau_um",
      bounds_json(hetab_surface_tau_um(j->surface), b.tau_um.low, b.tau_um.high), "error", p->error,
      "theta_r_deg", degrees_json(p->theta_r, p->theta_r_count), "curves", curves, "measured",
      measured_json(j)));
}

/* ---- the command --------------------------------------------------------------------------- */

static int save_csv(const job *j) {
  cli_text text;
  int status = cli_text_begin(&text);
  if (status >= 0)
    return status;
  write_csv(text.stream, j->prediction);
  return cli_text_save(&text, j->ctx, j->request->csv, j->request->force);
}

static int save_page(const job *j) {
  predict_report report = {.surface = j->surface,
                           .measurements = j->measurements,
                           .prediction = j->prediction,
                           .theta_i_count = j->options.theta_i_count,
                           .lambda_count = j->options.lambda_count,
                           .accuracy = j->options.accuracy};
  cli_text text;
  int status = cli_text_begin(&text);
  if (status >= 0)
    return status;
  predict_html(text.stream, &report);
  return cli_text_save(&text, j->ctx, j->request->html, j->request->force);
}

static int publish(const job *j) {
  const request *r = j->request;
  int status = r->csv ? save_csv(j) : -1;
  if (status < 0 && r->html)
    status = save_page(j);
  if (status < 0)
    status = cli_publish(j->ctx);
  if (status >= 0)
    return status;
  if (r->json)
    return print_json(j);
  if (!r->quiet)
    print_text(j);
  return CLI_OK;
}

static int predict(job *j) {
  const request *r = j->request;
  if ((r->csv && !cli_output_allowed(j->ctx, r->csv, r->force)) ||
      (r->html && !cli_output_allowed(j->ctx, r->html, r->force)))
    return CLI_FAILURE;
  hetab_status status = open_inputs(j);
  j->options.measurements = j->measurements;
  if (status == HETAB_OK)
    status = hetab_predict(j->ctx, j->engine, j->surface, &j->options, &j->prediction);
  return status == HETAB_OK ? publish(j) : cli_fail_context(j->ctx);
}

static int run_request(const request *r, const hetab_roughness_bounds *bounds) {
  job j = {.request = r,
           .ctx = cli_context(),
           .options = {.bounds = *bounds,
                       .step = hetab_radians(r->step_deg),
                       .accuracy = r->accuracy,
                       .exclude_mirror = hetab_radians(r->exclude_mirror_deg)}};
  if (!j.ctx)
    return CLI_FAILURE;
  int status = predict(&j);
  hetab_prediction_free(j.prediction);
  hetab_measurements_free(j.measurements);
  hetab_engine_free(j.engine);
  hetab_grid_free(j.grid);
  hetab_surface_free(j.surface);
  free(j.theta_i);
  free(j.lambda_um);
  hetab_context_free(j.ctx);
  return status;
}

static int check_files(const cli_command *self, const request *r) {
  if (r->csv && r->html && hetab_same_file(r->csv, r->html))
    return cli_usage(self, "--csv and --html would both write %s: give one another name", r->csv);
  return -1;
}

static int parse(const cli_command *self, int argc, char **argv, request *r, int *first) {
  const cli_option options[] = {
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incident polar angles in degrees: start:stop:count, cells:N, or a list (those measured, or "
       "15,30,45,60,75)",
       &r->theta_i, 0, 0},
      {CLI_TEXT, "wavelengths", 0, "SPEC",
       "wavelengths in nm: start:stop:step or a list (the one nearest to 550)", &r->wavelengths, 0,
       0},
      {CLI_NUMBER, "non-uniformity", 0, "X",
       "bounds sigma0 (1 - X) and sigma0 (1 + X): the standard deviation of sigma0 over its mean",
       &r->non_uniformity, 0, 0.99},
      {CLI_TEXT, "sigma0", 0, "LO:HI", "bounds of sigma0 in um (those in SURFACE's file)",
       &r->sigma0, 0, 0},
      {CLI_TEXT, "tau", 0, "LO:HI", "bounds of tau in um (those in SURFACE's file)", &r->tau, 0, 0},
      {CLI_TEXT, "measurements", 0, "FILE",
       "measured BRDFs to judge: .brdf, .astm, .csv, .binary or .h5", &r->measurements, 0, 0},
      {CLI_NUMBER, "accuracy", 0, "X", "relative error that a measured value may have (0)",
       &r->accuracy, 0, 0.99},
      {CLI_NUMBER, "exclude-mirror", 0, "DEG",
       "leave out measurements this near the mirror direction, where the specular delta is (0)",
       &r->exclude_mirror_deg, 0, 90},
      {CLI_NUMBER, "step", 0, "DEG", "of theta_r in the curves (0.5)", &r->step_deg, 0.01, 90},
      {CLI_TEXT, "csv", 0, "FILE", "write FILE, the curves and the measured points", &r->csv, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with the plots", &r->html, 0, 0},
      {CLI_FLAG, "force", 'f', NULL, "overwrite these files", &r->force, 0, 0},
      {CLI_CHOICE, "precision", 0, "float|double", "arithmetic on the device (float)",
       &r->precision, 0, 0},
      {CLI_CHOICE, "method", 0, "series|literal",
       "the kernels' series, or the printed equations in double on the host (series)", &r->literal,
       0, 0},
      {CLI_TEXT, "device", 0, "SEL", "number or part of the name of a device ('hetab devices')",
       &r->device, 0, 0},
      {CLI_FLAG, "quiet", 'q', NULL, "print nothing", &r->quiet, 0, 0},
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {surface, version, sigma0_um: {value, low, high}, tau_um, error, theta_r_deg, "
       "curves: [{wavelength_nm, theta_i_deg, peak_theta_r_deg, f, low, high, rho_s}], measured: "
       "{name, accuracy, plane: {points, within, below, above, fraction_within, bias}, "
       "hemisphere, skipped, points}}",
       &r->json, 0, 0},
      {0},
  };
  return cli_parse_options(self, options, argc, argv, first);
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.non_uniformity = -1};
  hetab_roughness_bounds bounds = {0};
  int first, status = parse(self, argc, argv, &r, &first);
  if (status < 0 && !argv[first])
    status = cli_usage(self, "no SURFACE given");
  if (status < 0 && argv[first + 1])
    status = cli_usage(self, "unexpected argument '%s'", argv[first + 1]);
  if (status < 0)
    status = check_bounds(self, &r, &bounds);
  if (status < 0)
    status = check_files(self, &r);
  if (status >= 0)
    return status;
  r.surface = argv[first];
  return run_request(&r, &bounds);
}

const cli_command cli_predict = {
    .name = "predict",
    .arguments = "SURFACE",
    .summary = "the BRDF with bounds from a measured non-uniformity",
    .description =
        "The direct problem: from the roughness of SURFACE (a preset or a YAML file) and its "
        "measured spread to the BRDF in the incidence plane with an upper and a lower bound, and "
        "how many measured points lie between them.\n\n"
        "The bounds are the model's envelope over the whole interval of sigma0 and tau, not its "
        "values at the ends. theta_r > 0 is the mirror side (phi 180 in files), theta_r < 0 the "
        "light's. The curves are dd + ud in 1/sr; the specular delta is apart, as rho_s.\n\n"
        "Columns of --csv: wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, f, low, high, error "
        "(by how much the bounds may be off), and, of measured points, measured and side: -1 "
        "below the bounds, 0 within, 1 above.",
    .run = run,
};
