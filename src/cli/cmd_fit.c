/* hetab fit: the parameters of a surface from its measured BRDF. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "fit_command.h"
#include "fit_request.h"
#include "numbers.h"
#include "output.h"
#include "progress.h"

typedef struct fit_job {
  const fit_request *request;
  hetab_fit_options options;
  hetab_context *ctx;
  hetab_engine *engine;
  hetab_index *index;
  hetab_measurements *measurements;
  hetab_grid *grid; /* of the incidences asked for */
  double *lambda_um;
  fit_report report;
} fit_job;

/* ---- inputs -------------------------------------------------------------------------------- */

static int open_index(fit_job *job) {
  const char *text = job->request->index;
  double n = 0, k = 0;
  int constant = cli_constant_index(text, &n, &k);
  if (constant < 0)
    return cli_fail("--index: '%s' is neither n=N, n=N,k=K nor N,K, nor the name of a file", text);
  hetab_status status = constant ? hetab_index_constant(job->ctx, n, k, &job->index)
                        : strchr(text, '/') || strchr(text, '.')
                            ? hetab_index_load(job->ctx, text, &job->index)
                            : hetab_index_metal(job->ctx, text, &job->index);
  job->options.index = job->index;
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

static hetab_status choose(fit_job *job) {
  const fit_request *r = job->request;
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
    job->options.theta_i = hetab_grid_radians(job->grid, HETAB_THETA_I);
    job->options.theta_i_count = hetab_grid_count(job->grid, HETAB_THETA_I);
  }
  return status;
}

static int open_inputs(fit_job *job) {
  const fit_request *r = job->request;
  hetab_engine_options options = {.devices = r->device,
                                  .precision = r->precision ? HETAB_FLOAT : HETAB_DOUBLE,
                                  .method = HETAB_METHOD_SERIES};
  const char *outputs[] = {r->surface, r->csv, r->points, r->html};
  for (int i = 0; i < 4; i++)
    if (outputs[i] && !cli_output_allowed(job->ctx, outputs[i], r->force))
      return CLI_FAILURE;
  CLI_TRY(open_index(job));
  if (choose(job) != HETAB_OK ||
      hetab_measurements_load_at(job->ctx, r->measurements, job->options.lambda_um,
                                 job->options.lambda_count, &job->measurements) != HETAB_OK ||
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
  size_t count = options.lambda_count ? options.lambda_count
                                      : hetab_measurements_wavelength_count(job->measurements);
  const double *lambda_um =
      options.lambda_count ? options.lambda_um : hetab_measurements_lambda_um(job->measurements);
  options.lambda_count = 1;
  for (size_t i = 0; i < count; i++) {
    options.lambda_um = &lambda_um[i];
    HETAB_TRY(fit_once(job, &options));
  }
  return HETAB_OK;
}

static int compute(fit_job *job) {
  const fit_request *r = job->request;
  job->report.fits =
      calloc(hetab_measurements_wavelength_count(job->measurements) + 1 + job->options.lambda_count,
             sizeof(hetab_fit *));
  if (!job->report.fits)
    return cli_fail("out of memory");
  cli_progress_begin("fit", r->quiet);
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
  CLI_TRY(cli_text_begin(&text));
  write(text.stream, &job->report);
  return cli_text_save(&text, job->ctx, path, job->request->force);
}

static int save_surface(const fit_job *job) {
  const hetab_fit *fit = job->report.fits[0];
  cli_text text;
  HETAB_FREED char *yaml = NULL;
  if (!job->request->surface)
    return -1;
  if (!fit->surface)
    return cli_fail("%s is not written: the constraint cannot be kept within the bounds",
                    job->request->surface);
  CLI_CALL(job->ctx, hetab_surface_yaml(job->ctx, fit->surface, &yaml));
  CLI_TRY(cli_text_begin(&text));
  fputs(yaml, text.stream);
  return cli_text_save(&text, job->ctx, job->request->surface, job->request->force);
}

static int save_page(const fit_job *job) {
  cli_text text;
  if (!job->request->html)
    return -1;
  CLI_TRY(cli_text_begin(&text));
  if (fit_html(job->ctx, text.stream, &job->report) == HETAB_OK)
    return cli_text_save(&text, job->ctx, job->request->html, job->request->force);
  cli_text_free(&text);
  return cli_fail_context(job->ctx);
}

static int publish(const fit_job *job) {
  const fit_request *r = job->request;
  CLI_TRY(save(job, r->csv, fit_csv));
  CLI_TRY(save(job, r->points, fit_points_csv));
  CLI_TRY(save_surface(job));
  CLI_TRY(save_page(job));
  CLI_TRY(cli_publish(job->ctx));
  if (r->json)
    return cli_json_print(fit_json(&job->report));
  fit_print(&job->report);
  return CLI_OK;
}

static int run_request(const fit_request *r) {
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

/* ---- the command --------------------------------------------------------------------------- */

static int run(const cli_command *self, int argc, char **argv) {
  fit_request r = {.free = "slope,a"};
  int status = fit_parse(self, argc, argv, &r);
  if (status < 0)
    status = fit_check(self, &r);
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
        "with wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, f; MERL .binary, its "
        "channels as 610, 550 and 460 nm; HDF5) by the relative RMS, "
        "E = sqrt(sum w (f - f_measured)^2 / sum w f_measured^2), and prints each parameter with "
        "its 95 % interval, the error at each incidence, the margin that rho_dh keeps, and what "
        "the "
        "numbers do not say by themselves. Of slope, sigma0 and tau two have to be free or given: "
        "rough surfaces determine the slope, hardly sigma0 and tau apart.\n\n"
        "CSV of --csv: quantity, wavelength_nm, value, low, high, bootstrap_low, bootstrap_high, "
        "unconstrained (the value that the best fit without the constraint has), error (E), end, "
        "determined, stop. CSV of --points: wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, "
        "measured, model (1/sr), used, distrusted (with --robust). Diffuse parts `a` are "
        "reflectances, pi times the BRDF.\n\n"
        "Example:\n  hetab fit paint.brdf --index n=1.5 --tau 5 --surface paint.yaml",
    .run = run,
};
