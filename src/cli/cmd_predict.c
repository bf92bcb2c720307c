/* hetab predict: the BRDF in the incidence plane with bounds, beside measured points. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/number.h"
#include "core/angle.h"
#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "core/held_files.h"
#include "output.h"
#include "predict_command.h"

static const double preferred_um = 0.55;

typedef struct request {
  const char *surface, *theta_i, *wavelengths, *sigma0, *tau, *slope, *measurements;
  const char *csv, *html, *device;
  double non_uniformity, slope_spread, accuracy, exclude_mirror_deg, step_deg;
  int vary, precision, literal, json, force, quiet;
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
  hetab_prediction *prediction, *with_tau;
} job;

/* What carries a spread that is the slope's: sigma0 at its tau, tau at its sigma0, or one drawn
 * beside the other. */
enum { VARY_SIGMA0, VARY_TAU, VARY_BOTH };

/* ---- bounds -------------------------------------------------------------------------------- */

/* "LO:HI"; a usage error names the option. */
static int parse_interval(const cli_command *self, const char *option, const char *text,
                          hetab_interval *out) {
  if (text && !(cli_interval(text, &out->low, &out->high) && out->low > 0))
    return cli_usage(self, "--%s: '%s' is no interval LO:HI of numbers above 0, lengths in um",
                     option, text);
  return -1;
}

static int check_bounds(const cli_command *self, const request *r, hetab_roughness_bounds *bounds) {
  int given = !!r->sigma0 + !!r->slope + (r->non_uniformity >= 0) + (r->slope_spread >= 0);
  int status = parse_interval(self, "sigma0", r->sigma0 ? r->sigma0 : r->slope, &bounds->sigma0_um);
  if (status < 0)
    status = parse_interval(self, "tau", r->tau, &bounds->tau_um);
  if (status < 0 && given > 1)
    status = cli_usage(self, "--sigma0, --non-uniformity, --slope and --slope-spread bound the "
                             "same: keep one");
  if (status < 0 && r->vary && (r->tau || r->sigma0))
    status = cli_usage(self, "--vary says what carries the slope's spread: leave out --sigma0 and "
                             "--tau");
  if (status < 0 && r->vary == VARY_BOTH && r->csv)
    status = cli_usage(self, "--csv has one pair of bounds: give --vary sigma0 or --vary tau");
  return status;
}

/* What no option says, the surface's file may. A slope is sigma0 at this tau. */
static void fill_bounds(job *j) {
  const request *r = j->request;
  hetab_roughness_bounds *bounds = &j->options.bounds;
  double sigma0_um[2], tau_um[2], own = hetab_surface_sigma0_um(j->surface);
  double spread = fmax(r->non_uniformity, r->slope_spread);
  hetab_surface_bounds(j->surface, sigma0_um, tau_um);
  if (spread >= 0)
    bounds->sigma0_um = (hetab_interval){own * (1 - spread), own * (1 + spread)};
  else if (r->slope) {
    bounds->sigma0_um.low *= hetab_surface_tau_um(j->surface);
    bounds->sigma0_um.high *= hetab_surface_tau_um(j->surface);
  } else if (!r->sigma0)
    bounds->sigma0_um = (hetab_interval){sigma0_um[0], sigma0_um[1]};
  if (!r->tau && !r->vary)
    bounds->tau_um = (hetab_interval){tau_um[0], tau_um[1]};
}

/* The same slopes, by tau. */
static void vary_tau(job *j) {
  hetab_roughness_bounds *bounds = &j->options.bounds;
  double slopes = hetab_surface_sigma0_um(j->surface) * hetab_surface_tau_um(j->surface);
  if (bounds->sigma0_um.low > 0)
    bounds->tau_um =
        (hetab_interval){slopes / bounds->sigma0_um.high, slopes / bounds->sigma0_um.low};
  bounds->sigma0_um = (hetab_interval){0, 0};
}

/* ---- incidences and wavelengths ------------------------------------------------------------ */

/* The measured incidences, each once. */
static hetab_status measured_incidences(job *j) {
  size_t count = hetab_measurements_pair_count(j->measurements), kept = 0;
  const hetab_directions *pairs = hetab_measurements_pairs(j->measurements);
  double *theta_i = j->theta_i = calloc(count + 1, sizeof *theta_i);
  HETAB_NEED(theta_i);
  for (size_t i = 0; i < count; i++)
    theta_i[i] = pairs[i].theta_i;
  hetab_sort(theta_i, count);
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
  HETAB_TRY(hetab_grid_create(j->ctx, &j->grid));
  HETAB_TRY(hetab_grid_set_axis(j->ctx, j->grid, HETAB_THETA_I, spec ? spec : "15,30,45,60,75"));
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
  HETAB_NEED(j->lambda_um);
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
  HETAB_TRY(hetab_surface_open(j->ctx, r->surface, &j->surface));
  if (r->measurements)
    HETAB_TRY(hetab_measurements_load(j->ctx, r->measurements, &j->measurements));
  HETAB_TRY(find_incidences(j));
  HETAB_TRY(find_wavelengths(j));
  HETAB_TRY(hetab_engine_create(j->ctx, &engine, &j->engine));
  fill_bounds(j);
  return HETAB_OK;
}

/* ---- the command --------------------------------------------------------------------------- */

static int save(const job *j, const char *path,
                void (*write)(FILE *stream, const predict_report *report),
                const predict_report *report) {
  cli_text text;
  if (!path)
    return -1;
  CLI_TRY(cli_text_begin(&text));
  write(text.stream, report);
  return cli_text_save(&text, j->ctx, path, j->request->force);
}

static int publish(const job *j) {
  const request *r = j->request;
  const predict_report report = {.surface = j->surface,
                                 .measurements = j->measurements,
                                 .prediction = j->prediction,
                                 .with_tau = j->with_tau,
                                 .theta_i_count = j->options.theta_i_count,
                                 .lambda_count = j->options.lambda_count,
                                 .accuracy = j->options.accuracy};
  CLI_TRY(save(j, r->csv, predict_csv, &report));
  CLI_TRY(save(j, r->html, predict_html, &report));
  CLI_TRY(cli_publish(j->ctx));
  if (r->json)
    return cli_json_print(predict_json(&report));
  if (!r->quiet)
    predict_print(&report);
  return CLI_OK;
}

static int predict(job *j) {
  const request *r = j->request;
  if ((r->csv && !cli_output_allowed(j->ctx, r->csv, r->force)) ||
      (r->html && !cli_output_allowed(j->ctx, r->html, r->force)))
    return CLI_FAILURE;
  CLI_CALL(j->ctx, open_inputs(j));
  j->options.measurements = j->measurements;
  if (r->vary == VARY_TAU)
    vary_tau(j);
  CLI_CALL(j->ctx, hetab_predict(j->ctx, j->engine, j->surface, &j->options, &j->prediction));
  if (r->vary == VARY_BOTH) {
    vary_tau(j);
    CLI_CALL(j->ctx, hetab_predict(j->ctx, j->engine, j->surface, &j->options, &j->with_tau));
  }
  return publish(j);
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
  hetab_prediction_free(j.with_tau);
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

static int parse(const cli_command *self, int argc, char **argv, request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incident polar angles in degrees: start:stop:count, cells:N, or a list (those measured, or "
       "15,30,45,60,75)",
       &r->theta_i, 0, 0},
      {CLI_TEXT, "wavelengths", 0, "SPEC",
       "wavelengths in nm: start:stop:step or a list (the one nearest to 550)", &r->wavelengths, 0,
       0},
      {CLI_SHARE, "non-uniformity", 0, "X",
       "bounds sigma0 (1 - X) and sigma0 (1 + X): the standard deviation of sigma0 over its mean; "
       "0.068 or 6.8%",
       &r->non_uniformity, 0, 0.99},
      {CLI_TEXT, "slope", 0, "LO:HI", "bounds of sigma0 / tau", &r->slope, 0, 0},
      {CLI_SHARE, "slope-spread", 0, "X",
       "bounds of sigma0 / tau: the slope times 1 - X and 1 + X, as the report varies it",
       &r->slope_spread, 0, 0.99},
      {CLI_CHOICE, "vary", 0, "sigma0|tau|both",
       "what carries the spread of the slope: sigma0 at the surface's tau, tau at its sigma0, or "
       "one drawn beside the other (sigma0)",
       &r->vary, 0, 0},
      {CLI_TEXT, "sigma0", 0, "LO:HI", "bounds of sigma0 in um (those in SURFACE's file)",
       &r->sigma0, 0, 0},
      {CLI_TEXT, "tau", 0, "LO:HI", "bounds of tau in um (those in SURFACE's file)", &r->tau, 0, 0},
      {CLI_TEXT, "measurements", 0, "FILE",
       "measured BRDFs to judge: .brdf, .astm, .csv, .binary or .h5", &r->measurements, 0, 0},
      {CLI_SHARE, "accuracy", 0, "X", "relative error that a measured value may have (0)",
       &r->accuracy, 0, 0.99},
      {CLI_NUMBER, "exclude-mirror", 0, "DEG",
       "leave out measurements this near the mirror direction, where the specular delta is (0)",
       &r->exclude_mirror_deg, 0, 90},
      {CLI_NUMBER, "step", 0, "DEG", "of theta_r in the curves (0.5)", &r->step_deg, 0.01, 90},
      {CLI_TEXT, "csv", 0, "FILE", "write FILE, the curves and the measured points", &r->csv, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with the plots", &r->html, 0, 0},
      CLI_FORCE(&r->force),
      CLI_PRECISION(&r->precision),
      {CLI_CHOICE, "method", 0, "series|literal",
       "the kernels' series, or the printed equations in double on the host (series)", &r->literal,
       0, 0},
      CLI_DEVICE(&r->device),
      CLI_QUIET(&r->quiet),
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {surface, version, sigma0_um: {value, low, high}, tau_um, error, theta_r_deg, "
       "curves: [{wavelength_nm, theta_i_deg, peak_theta_r_deg, f, low, high, rho_s}], measured: "
       "{name, accuracy, plane: {points, within, below, above, fraction_within, bias}, "
       "hemisphere, skipped, points}, with_tau: the curves of --vary both again}",
       &r->json, 0, 0},
      {0},
  };
  return cli_parse_operand(self, options, argc, argv, "SURFACE", &r->surface);
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.non_uniformity = -1, .slope_spread = -1};
  hetab_roughness_bounds bounds = {0};
  CLI_TRY(parse(self, argc, argv, &r));
  CLI_TRY(check_bounds(self, &r, &bounds));
  CLI_TRY(check_files(self, &r));
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
