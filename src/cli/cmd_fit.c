/* hetab fit: the parameters of a surface from its measured BRDF. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "fit_command.h"
#include "options.h"
#include "output.h"
#include "progress.h"

typedef struct request {
  const char *measurements, *free, *index, *wavelengths, *theta_i;
  const char *surface, *csv, *points, *html, *device;
  cli_list bounds;
  int weights, constraint, precision, per_wavelength, force, quiet, json;
  size_t seed;
  hetab_fit_options options;
} request;

typedef struct fit_job {
  const request *request;
  hetab_fit_options options;
  hetab_context *ctx;
  hetab_engine *engine;
  hetab_index *index;
  hetab_measurements *measurements;
  hetab_grid *grid; /* of the incidences asked for */
  double *lambda_um;
  fit_report report;
} fit_job;

/* ---- what is free -------------------------------------------------------------------------- */

static const char *const quantities[HETAB_FIT_QUANTITIES] = {"slope", "sigma0", "tau", "n", "a"};

/* The quantity that text[length] names; HETAB_FIT_QUANTITIES: none. */
static int quantity_of(const char *text, size_t length) {
  int q = 0;
  while (q < HETAB_FIT_QUANTITIES &&
         (strlen(quantities[q]) != length || memcmp(quantities[q], text, length) != 0))
    q++;
  return q;
}

static int parse_free(const cli_command *self, request *r) {
  for (const char *text = r->free; *text;) {
    size_t length = strcspn(text, ",");
    int one = length == strlen("a-constant") && memcmp(text, "a-constant", length) == 0;
    int q = one ? HETAB_FIT_DIFFUSE : quantity_of(text, length);
    if (q == HETAB_FIT_QUANTITIES)
      return cli_usage(self, "--free: '%.*s' is none of slope, sigma0, tau, n, a, a-constant",
                       (int)length, text);
    r->options.parameters[q].free = 1;
    r->options.one_diffuse |= one;
    text += length + (text[length] == ',');
  }
  return -1;
}

/* "slope=0.01:0.5" */
static int parse_bounds(const cli_command *self, request *r, const char *text) {
  char low[64], high[64];
  double bounds[2];
  size_t length = strcspn(text, "=");
  int q = quantity_of(text, length);
  const char *colon = strchr(text, ':');
  if (q == HETAB_FIT_QUANTITIES || !text[length] || !colon)
    return cli_usage(self, "--bounds: '%s' is not NAME=LOW:HIGH with a name of --free", text);
  snprintf(low, sizeof low, "%.*s", (int)(colon - text - (ptrdiff_t)length - 1), text + length + 1);
  snprintf(high, sizeof high, "%s", colon + 1);
  if (!cli_number(low, &bounds[0]) || !cli_number(high, &bounds[1]) || bounds[0] >= bounds[1] ||
      bounds[0] < 0)
    return cli_usage(self, "--bounds: '%s': give two numbers, the lower one first", text);
  if (!r->options.parameters[q].free)
    return cli_usage(self, "--bounds: %s is not free: name it in --free", quantities[q]);
  r->options.parameters[q].low = bounds[0];
  r->options.parameters[q].high = bounds[1];
  return -1;
}

static int check_request(const cli_command *self, request *r) {
  int status = parse_free(self, r);
  for (size_t i = 0; i < r->bounds.count && status < 0; i++)
    status = parse_bounds(self, r, r->bounds.items[i]);
  if (status >= 0)
    return status;
  if (!r->index)
    return cli_usage(self, "no --index given: name a metal, n=N or a file");
  const char *outputs[] = {r->surface, r->csv, r->points, r->html};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      if (outputs[i] && outputs[j] && i < j && cli_same_file(outputs[i], outputs[j]))
        return cli_usage(self, "two outputs would be %s: give one another name", outputs[i]);
  for (int i = 0; i < 4; i++)
    if (outputs[i] && cli_same_file(outputs[i], r->measurements))
      return cli_usage(self, "%s is the input: choose another name", outputs[i]);
  if (r->per_wavelength && r->surface)
    return cli_usage(self, "--surface takes one fit: leave out --per-wavelength");
  return -1;
}

/* ---- inputs -------------------------------------------------------------------------------- */

/* "n=1.5" or "n=1.5,k=0.1": 1; another text: 0; malformed: -1. */
static int parse_constant(const char *text, double *n, double *k) {
  char field[64];
  const char *comma = strchr(text, ',');
  if (strncmp(text, "n=", 2) != 0)
    return 0;
  snprintf(field, sizeof field, "%.*s", comma ? (int)(comma - text - 2) : 60, text + 2);
  if (!cli_number(field, n))
    return -1;
  return !comma || (strncmp(comma, ",k=", 3) == 0 && cli_number(comma + 3, k)) ? 1 : -1;
}

static int open_index(fit_job *job) {
  const char *text = job->request->index;
  double n = 0, k = 0;
  int constant = parse_constant(text, &n, &k);
  if (constant < 0)
    return cli_fail("--index: '%s' is not n=N or n=N,k=K", text);
  hetab_status status = constant ? hetab_index_constant(job->ctx, n, k, &job->index)
                        : strchr(text, '/') || strchr(text, '.')
                            ? hetab_index_load(job->ctx, text, &job->index)
                            : hetab_index_metal(job->ctx, text, &job->index);
  job->options.index = job->index;
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

static hetab_status choose(fit_job *job) {
  const request *r = job->request;
  hetab_status status = HETAB_OK;
  if (r->wavelengths && strcmp(r->wavelengths, "all") != 0)
    status = hetab_parse_wavelengths(job->ctx, r->wavelengths, &job->lambda_um,
                                     &job->options.lambda_count);
  if (status != HETAB_OK || !r->theta_i) {
    job->options.lambda_um = job->lambda_um;
    return status;
  }
  job->options.lambda_um = job->lambda_um;
  status = hetab_grid_create(job->ctx, &job->grid);
  if (status == HETAB_OK)
    status = hetab_grid_set_axis(job->ctx, job->grid, HETAB_THETA_I, r->theta_i);
  if (status == HETAB_OK) {
    job->options.theta_i_deg = hetab_grid_deg(job->grid, HETAB_THETA_I);
    job->options.theta_i_count = hetab_grid_count(job->grid, HETAB_THETA_I);
  }
  return status;
}

static int open_inputs(fit_job *job) {
  const request *r = job->request;
  hetab_engine_options options = {.devices = r->device,
                                  .precision = r->precision ? HETAB_FLOAT : HETAB_DOUBLE,
                                  .method = HETAB_METHOD_SERIES};
  const char *outputs[] = {r->surface, r->csv, r->points, r->html};
  for (int i = 0; i < 4; i++)
    if (outputs[i] && !cli_output_allowed(job->ctx, outputs[i], r->force))
      return CLI_FAILURE;
  int status = open_index(job);
  if (status >= 0)
    return status;
  if (choose(job) != HETAB_OK ||
      hetab_measurements_load(job->ctx, r->measurements, &job->measurements) != HETAB_OK ||
      hetab_engine_create(job->ctx, &options, &job->engine) != HETAB_OK)
    return cli_fail_context(job->ctx);
  job->report.measurements = job->measurements;
  job->report.device = hetab_engine_device(job->engine);
  job->report.precision = options.precision;
  return -1;
}

/* ---- fits ---------------------------------------------------------------------------------- */

static hetab_status fit_once(fit_job *job, const hetab_fit_options *options) {
  hetab_status status = hetab_fit_create(job->ctx, job->engine, job->measurements, options,
                                         &job->report.fits[job->report.count]);
  job->report.count += status == HETAB_OK;
  return status;
}

static hetab_status fit_each(fit_job *job) {
  hetab_fit_options options = job->options;
  hetab_status status = HETAB_OK;
  size_t count = options.lambda_count ? options.lambda_count
                                      : hetab_measurements_wavelengths(job->measurements);
  const double *lambda_um =
      options.lambda_count ? options.lambda_um : hetab_measurements_lambda_um(job->measurements);
  options.lambda_count = 1;
  for (size_t i = 0; i < count && status == HETAB_OK; i++) {
    options.lambda_um = &lambda_um[i];
    status = fit_once(job, &options);
  }
  return status;
}

static int compute(fit_job *job) {
  const request *r = job->request;
  job->report.fits =
      calloc(hetab_measurements_wavelengths(job->measurements) + 1 + job->options.lambda_count,
             sizeof(hetab_fit *));
  if (!job->report.fits)
    return cli_fail("out of memory");
  cli_progress_begin(job->ctx, "fit", r->quiet);
  hetab_status status = r->per_wavelength ? fit_each(job) : fit_once(job, &job->options);
  cli_progress_end();
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

/* ---- outputs ------------------------------------------------------------------------------- */

static int save(const fit_job *job, const char *path,
                void (*write)(FILE *stream, const fit_report *report)) {
  cli_text text;
  if (!path)
    return -1;
  int status = cli_text_begin(&text);
  if (status >= 0)
    return status;
  write(text.stream, &job->report);
  return cli_text_save(&text, job->ctx, path, job->request->force);
}

static int save_surface(const fit_job *job) {
  const hetab_fit *fit = job->report.fits[0];
  cli_text text;
  char *yaml;
  if (!job->request->surface)
    return -1;
  if (!fit->surface)
    return cli_fail("%s is not written: the constraint cannot be kept within the bounds",
                    job->request->surface);
  if (hetab_surface_yaml(job->ctx, fit->surface, &yaml) != HETAB_OK)
    return cli_fail_context(job->ctx);
  int status = cli_text_begin(&text);
  if (status < 0) {
    fputs(yaml, text.stream);
    status = cli_text_save(&text, job->ctx, job->request->surface, job->request->force);
  }
  free(yaml);
  return status;
}

static int save_page(const fit_job *job) {
  cli_text text;
  if (!job->request->html)
    return -1;
  int status = cli_text_begin(&text);
  if (status >= 0)
    return status;
  if (fit_html(job->ctx, text.stream, &job->report) == HETAB_OK)
    return cli_text_save(&text, job->ctx, job->request->html, job->request->force);
  cli_text_free(&text);
  return cli_fail_context(job->ctx);
}

static int publish(const fit_job *job) {
  const request *r = job->request;
  int status = save(job, r->csv, fit_csv);
  if (status < 0)
    status = save(job, r->points, fit_points_csv);
  if (status < 0)
    status = save_surface(job);
  if (status < 0)
    status = save_page(job);
  if (status >= 0)
    return status;
  if (r->json)
    return cli_json_print(fit_json(&job->report));
  fit_print(&job->report);
  return CLI_OK;
}

static int run_request(const request *r) {
  fit_job job = {.request = r, .options = r->options, .ctx = cli_context()};
  if (!job.ctx)
    return CLI_FAILURE;
  job.options.weights = (hetab_fit_weights)r->weights;
  job.options.constraint = (hetab_fit_constraint)r->constraint;
  job.options.seed = r->seed;
  int status = open_inputs(&job);
  if (status < 0)
    status = compute(&job);
  if (status < 0)
    status = publish(&job);
  for (size_t i = 0; i < job.report.count; i++)
    hetab_fit_free(job.report.fits[i]);
  free(job.report.fits);
  free(job.lambda_um);
  hetab_grid_free(job.grid);
  hetab_measurements_free(job.measurements);
  hetab_index_free(job.index);
  hetab_engine_free(job.engine);
  hetab_context_free(job.ctx);
  return status;
}

/* ---- the command line ---------------------------------------------------------------------- */

static int parse(const cli_command *self, int argc, char **argv, request *r, int *first) {
  hetab_fit_options *o = &r->options;
  hetab_fit_parameter *p = o->parameters;
  const cli_option options[] = {
      {CLI_TEXT, "free", 0, "LIST",
       "what is fitted, of slope, sigma0, tau, n, a (one for each wavelength), a-constant (one for "
       "all) (slope,a)",
       &r->free, 0, 0},
      {CLI_NUMBER, "slope", 0, "S", "sigma0 / tau: given, or a start if it is free",
       &p[HETAB_FIT_SLOPE].value, 1e-4, 10},
      {CLI_NUMBER, "sigma0", 0, "UM", "rms height, likewise", &p[HETAB_FIT_SIGMA0].value, 1e-4,
       1e3},
      {CLI_NUMBER, "tau", 0, "UM", "correlation length, likewise", &p[HETAB_FIT_TAU].value, 1e-3,
       1e4},
      {CLI_NUMBER, "a", 0, "R", "diffuse part as a reflectance, if it is not free (0)",
       &p[HETAB_FIT_DIFFUSE].value, 0, 10},
      {CLI_TEXT, "index", 0, "INDEX",
       "refractive index: a metal ('hetab surfaces'), n=N or n=N,k=K, or a file", &r->index, 0, 0},
      {CLI_FLAG, "extrapolate", 0, NULL, "allow wavelengths outside the index data",
       &o->extrapolate_index, 0, 0},
      {CLI_LIST, "bounds", 0, "NAME=LOW:HIGH",
       "bounds of what is free (slope 0.005:1, sigma0 0.01:10, tau 0.3:100, n 1.05:3, a 0:1)",
       &r->bounds, 0, 0},
      {CLI_TEXT, "wavelengths", 0, "SPEC", "those used, in nm: start:stop:step, a list, all (all)",
       &r->wavelengths, 0, 0},
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incidences used, in degrees: start:stop:count or a list (all)", &r->theta_i, 0, 0},
      {CLI_FLAG, "plane", 0, NULL, "use the incidence plane alone", &o->plane, 0, 0},
      {CLI_NUMBER, "exclude-mirror", 0, "DEG",
       "leave out views this near the mirror direction, where instruments see the specular delta "
       "(0)",
       &o->exclude_mirror_deg, 0, 180},
      {CLI_COUNT, "max-points", 0, "N", "pairs of directions used at most, evenly (100000)",
       &o->max_points, 10, 1e7},
      {CLI_CHOICE, "weights", 0, "energy|equal|relative|log", "of the squared differences (energy)",
       &r->weights, 0, 0},
      {CLI_CHOICE, "constraint", 0, "auto|polished|energy|none",
       "rho_dh at most that of the polished material, or 1; auto: polished if k > 0 (auto)",
       &r->constraint, 0, 0},
      {CLI_NUMBER, "ask-a", 0, "R", "say what this diffuse part would need", &o->asked_diffuse, 0,
       10},
      {CLI_FLAG, "per-wavelength", 0, NULL, "a fit of its own for each wavelength",
       &r->per_wavelength, 0, 0},
      {CLI_COUNT, "starts", 0, "N", "random starts (4)", &o->starts, 1, 10000},
      {CLI_COUNT, "seed", 0, "N", "of the starts and the bootstrap (0)", &r->seed, 0, 4294967295.0},
      {CLI_COUNT, "max-evaluations", 0, "N", "of the objective, in all (20000)",
       &o->max_evaluations, 10, 1e9},
      {CLI_FLAG, "derivative-free", 0, NULL, "COBYLA alone, without SLSQP after it",
       &o->derivative_free, 0, 0},
      {CLI_COUNT, "bootstrap", 0, "N", "intervals also from N resamplings of the pairs (0)",
       &o->bootstrap, 0, 100000},
      {CLI_TEXT, "surface", 0, "FILE", "write the fitted surface as YAML, for 'hetab tabulate'",
       &r->surface, 0, 0},
      {CLI_TEXT, "csv", 0, "FILE", "write the estimates as CSV", &r->csv, 0, 0},
      {CLI_TEXT, "points", 0, "FILE", "write measured and fitted values as CSV", &r->points, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with the plots", &r->html, 0, 0},
      {CLI_CHOICE, "precision", 0, "double|float", "arithmetic on the device (double)",
       &r->precision, 0, 0},
      {CLI_TEXT, "device", 0, "SEL", "number or part of the name of a device ('hetab devices')",
       &r->device, 0, 0},
      {CLI_FLAG, "force", 'f', NULL, "overwrite outputs", &r->force, 0, 0},
      {CLI_FLAG, "quiet", 'q', NULL, "print no progress", &r->quiet, 0, 0},
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {measurements, device, precision, version, fits: [{error, rms, weights, "
       "constraint, stop, on_constraint, ambiguous, margin, pairs, values, missing, thinned, "
       "evaluations, estimates: [{quantity, wavelength_nm, value, low, high, bootstrap_low, "
       "bootstrap_high, unconstrained, end, determined}], correlation: {estimates, matrix}, "
       "incidences: [{theta_i_deg, values, error, rms, mean, bias, margin, margin_wavelength_nm, "
       "rho_dh, bound, polished_margin, room, excess}], starts: [{start, end, error, feasible, "
       "best}], notes}]}",
       &r->json, 0, 0},
      {0},
  };
  return cli_parse_options(self, options, argc, argv, first);
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.free = "slope,a"};
  int first, status = parse(self, argc, argv, &r, &first);
  if (status < 0 && first == argc)
    status = cli_usage(self, "no MEASUREMENTS given");
  if (status < 0 && argv[first + 1])
    status = cli_usage(self, "unexpected argument '%s'", argv[first + 1]);
  if (status < 0) {
    r.measurements = argv[first];
    status = check_request(self, &r);
  }
  if (status < 0)
    status = run_request(&r);
  free(r.bounds.items);
  return status;
}

const cli_command cli_fit = {
    .name = "fit",
    .arguments = "MEASUREMENTS",
    .summary = "the parameters of a surface from its measured BRDF",
    .description =
        "Fits slope, roughness, index and diffuse part to measurements (Cornell .brdf, .astm, CSV "
        "with wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, f; MERL .binary; HDF5) by the "
        "report's energy-weighted RMS, E = sqrt(sum w (f - f_measured)^2 / sum w f_measured^2) "
        "with w = cos(theta_i) cos(theta_r) dOmega, and prints each parameter with its 95 % "
        "interval, the error at each incidence, the margin that rho_dh keeps, and what the "
        "numbers do not say by themselves. Of slope, sigma0 and tau two have to be free or given: "
        "rough surfaces determine the slope, hardly sigma0 and tau apart.\n\n"
        "CSV of --csv: quantity, wavelength_nm, value, low, high, bootstrap_low, bootstrap_high, "
        "unconstrained (the value that the best fit without the constraint has), error (E), end, "
        "determined, stop. CSV of --points: wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, "
        "measured, model (1/sr), used. Diffuse parts `a` are reflectances, pi times the BRDF.\n\n"
        "Example:\n  hetab fit paint.brdf --index n=1.5 --tau 5 --surface paint.yaml",
    .run = run,
};
