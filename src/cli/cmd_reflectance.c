/* hetab reflectance: hemispherical reflectances, with their errors. */
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"
#include "options.h"
#include "output.h"
#include "progress.h"

typedef struct request {
  const char *surface, *theta_i, *wavelengths, *device;
  int precision, white_sky, rgb, json, quiet;
  double tolerance;
} request;

typedef struct reflectance_job {
  const request *request;
  hetab_context *ctx;
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_engine *engine;
  const double *theta_i_deg;
  size_t count;                            /* of incidences; 1 for the white sky, which has none */
  hetab_reflectance *values;               /* [band][count] */
  hetab_reflectance_colour *dh, *polished; /* [count], with --rgb */
} reflectance_job;

/* ---- what to compute ----------------------------------------------------------------------- */

static hetab_status set_wavelengths(reflectance_job *job) {
  HETAB_FREED double *lambda_um = NULL;
  size_t count;
  hetab_status status =
      hetab_parse_wavelengths(job->ctx, job->request->wavelengths, &lambda_um, &count);
  if (status != HETAB_OK)
    return status;
  status = hetab_surface_set_wavelengths(job->ctx, job->surface, lambda_um, count);
  return status;
}

static hetab_status open_inputs(reflectance_job *job) {
  const request *r = job->request;
  hetab_engine_options options = {.devices = r->device,
                                  .precision = (hetab_precision)r->precision,
                                  .method = HETAB_METHOD_SERIES};
  hetab_status status = hetab_surface_open(job->ctx, r->surface, &job->surface);
  if (status == HETAB_OK && r->wavelengths)
    status = set_wavelengths(job);
  if (status == HETAB_OK)
    status = hetab_grid_create(job->ctx, &job->grid);
  if (status == HETAB_OK)
    status = hetab_grid_set_axis(job->ctx, job->grid, HETAB_THETA_I, r->theta_i);
  if (status == HETAB_OK)
    status = hetab_engine_create(job->ctx, &options, &job->engine);
  if (status != HETAB_OK)
    return status;
  job->theta_i_deg = hetab_grid_deg(job->grid, HETAB_THETA_I);
  job->count = r->white_sky ? 1 : hetab_grid_count(job->grid, HETAB_THETA_I);
  return HETAB_OK;
}

static hetab_status integrate(reflectance_job *job) {
  const request *r = job->request;
  return r->white_sky
             ? hetab_reflectance_hh(job->ctx, job->engine, job->surface, r->tolerance, job->values)
             : hetab_reflectance_dh(job->ctx, job->engine, job->surface,
                                    hetab_grid_radians(job->grid, HETAB_THETA_I), job->count,
                                    r->tolerance, job->values);
}

static int compute(reflectance_job *job) {
  size_t bands = hetab_surface_band_count(job->surface);
  job->values = calloc(bands * job->count, sizeof *job->values);
  job->dh = calloc(job->count, sizeof *job->dh);
  job->polished = calloc(job->count, sizeof *job->polished);
  if (!job->values || !job->dh || !job->polished)
    return cli_fail("out of memory");
  cli_progress_begin(hetab_surface_name(job->surface), job->request->quiet);
  hetab_status status = integrate(job);
  cli_progress_end();
  if (status == HETAB_OK && job->request->rgb)
    status = hetab_reflectance_rgb(job->ctx, job->surface, job->values, job->count, job->dh,
                                   job->polished);
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

/* ---- CSV ----------------------------------------------------------------------------------- */

static int digits_of(const reflectance_job *job) {
  return job->request->precision ? 17 : 9;
}

/* The incidence, where there is one. */
static void print_theta(const reflectance_job *job, size_t i) {
  if (!job->request->white_sky)
    printf("%.10g,", job->theta_i_deg[i]);
}

static double wavelength_nm(const reflectance_job *job, size_t band) {
  return 1000 * hetab_surface_bands(job->surface)[band].lambda_um;
}

static void print_spectral(const reflectance_job *job) {
  int d = digits_of(job);
  printf("wavelength_nm,%srho_dd,rho_s,rho_ud,%s,error,fresnel\n",
         job->request->white_sky ? "" : "theta_i_deg,",
         job->request->white_sky ? "rho_hh" : "rho_dh");
  for (size_t b = 0; b < hetab_surface_band_count(job->surface); b++)
    for (size_t i = 0; i < job->count; i++) {
      const hetab_reflectance *r = &job->values[b * job->count + i];
      printf("%.10g,", wavelength_nm(job, b));
      print_theta(job, i);
      printf("%.*g,%.*g,%.*g,%.*g,%.3g,%.*g\n", d, r->dd.value, d, r->specular, d, r->ud, d, r->dh,
             r->dd.error, d, r->fresnel);
    }
}

static void print_colours(const reflectance_job *job) {
  int d = digits_of(job);
  printf("%sred,green,blue,luminance,error,fresnel_red,fresnel_green,fresnel_blue,"
         "fresnel_luminance\n",
         job->request->white_sky ? "" : "theta_i_deg,");
  for (size_t i = 0; i < job->count; i++) {
    const hetab_reflectance_colour *c = &job->dh[i], *p = &job->polished[i];
    print_theta(job, i);
    printf("%.*g,%.*g,%.*g,%.*g,%.3g,%.*g,%.*g,%.*g,%.*g\n", d, c->rgb[0], d, c->rgb[1], d,
           c->rgb[2], d, c->luminance, c->error, d, p->rgb[0], d, p->rgb[1], d, p->rgb[2], d,
           p->luminance);
  }
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static json_t *spectral_json(const reflectance_job *job, size_t band, size_t i) {
  const hetab_reflectance *r = &job->values[band * job->count + i];
  json_t *json = json_pack("{sf sf sf sf sf sf sf sI ss}", "wavelength_nm",
                           wavelength_nm(job, band), "rho_dd", r->dd.value, "rho_s", r->specular,
                           "rho_ud", r->ud, job->request->white_sky ? "rho_hh" : "rho_dh", r->dh,
                           "error", r->dd.error, "fresnel", r->fresnel, "evaluations",
                           (json_int_t)r->dd.evaluations, "stop", hetab_stop_name(r->dd.stop));
  if (json && !job->request->white_sky)
    json_object_set_new(json, "theta_i_deg", json_real(job->theta_i_deg[i]));
  return json;
}

static json_t *colour_json(const reflectance_job *job, size_t i) {
  const hetab_reflectance_colour *c = &job->dh[i], *p = &job->polished[i];
  json_t *json = json_pack("{s[fff] sf sf s[fff] sf}", "rgb", c->rgb[0], c->rgb[1], c->rgb[2],
                           "luminance", c->luminance, "error", c->error, "fresnel_rgb", p->rgb[0],
                           p->rgb[1], p->rgb[2], "fresnel_luminance", p->luminance);
  if (json && !job->request->white_sky)
    json_object_set_new(json, "theta_i_deg", json_real(job->theta_i_deg[i]));
  return json;
}

static int print_json(const reflectance_job *job) {
  json_t *list = json_array();
  size_t bands = job->request->rgb ? 1 : hetab_surface_band_count(job->surface);
  for (size_t b = 0; b < bands; b++)
    for (size_t i = 0; i < job->count; i++)
      json_array_append_new(list,
                            job->request->rgb ? colour_json(job, i) : spectral_json(job, b, i));
  return cli_json_print(json_pack("{so so ss ss so}", "surface",
                                  cli_json_text(hetab_surface_name(job->surface)), "device",
                                  cli_json_text(hetab_engine_device(job->engine)), "precision",
                                  hetab_precision_name(hetab_engine_precision(job->engine)),
                                  "version", hetab_version(), "reflectances", list));
}

/* ---- the command --------------------------------------------------------------------------- */

static int print(const reflectance_job *job) {
  if (job->request->json)
    return print_json(job);
  if (job->request->rgb)
    print_colours(job);
  else
    print_spectral(job);
  return CLI_OK;
}

static int run_request(const request *r) {
  reflectance_job job = {.request = r, .ctx = cli_context()};
  if (!job.ctx)
    return CLI_FAILURE;
  int status = open_inputs(&job) == HETAB_OK ? compute(&job) : cli_fail_context(job.ctx);
  if (status < 0)
    status = print(&job);
  free(job.values);
  free(job.dh);
  free(job.polished);
  hetab_engine_free(job.engine);
  hetab_grid_free(job.grid);
  hetab_surface_free(job.surface);
  hetab_context_free(job.ctx);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.theta_i = "0:85:18"};
  const cli_option options[] = {
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incident polar angles in degrees: start:stop:count, cells:N, or a list (0:85:18)",
       &r.theta_i, 0, 0},
      {CLI_TEXT, "wavelengths", 0, "SPEC",
       "wavelengths in nm: start:stop:step or a list (the surface's own)", &r.wavelengths, 0, 0},
      {CLI_FLAG, "white-sky", 0, NULL,
       "the hemispherical-hemispherical reflectance rho_hh, over all incidences", &r.white_sky, 0,
       0},
      {CLI_FLAG, "rgb", 0, NULL,
       "the colour of rho_dh and of the polished material: linear sRGB and luminance under D65",
       &r.rgb, 0, 0},
      {CLI_SHARE, "tolerance", 0, "E", "relative error of rho_dd (1e-5 in float, 1e-9 in double)",
       &r.tolerance, 1e-12, 0.1},
      CLI_PRECISION(&r.precision),
      CLI_DEVICE(&r.device),
      {CLI_FLAG, "quiet", 'q', NULL, "print no progress", &r.quiet, 0, 0},
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {surface, device, precision, version, reflectances: [{wavelength_nm, "
       "theta_i_deg, rho_dd, rho_s, rho_ud, rho_dh, error, fresnel, evaluations, stop}]}, with "
       "--rgb of [{theta_i_deg, rgb, luminance, error, fresnel_rgb, fresnel_luminance}]",
       &r.json, 0, 0},
      {0},
  };
  CLI_TRY(cli_parse_operand(self, options, argc, argv, "SURFACE", &r.surface));
  return run_request(&r);
}

const cli_command cli_reflectance = {
    .name = "reflectance",
    .arguments = "SURFACE",
    .summary = "hemispherical reflectances, each with its error",
    .description =
        "Integrates f cos(theta_r) of SURFACE (a preset, see 'hetab surfaces', or a YAML file) "
        "over the hemisphere of viewers and prints CSV: wavelength_nm, theta_i_deg, rho_dd, rho_s, "
        "rho_ud (directional-diffuse, specular, uniform-diffuse), rho_dh (their sum), error (the "
        "estimate of the absolute error of rho_dd, rounding included) and fresnel (the reflectance "
        "of the polished material, an upper bound). --white-sky prints rho_hh, without "
        "theta_i_deg; --rgb prints theta_i_deg, red, green, blue, luminance, error, and the same "
        "four of the polished material.\n\n"
        "scripts/plot_reflectance PLOT.png plots the CSV from its standard input.",
    .run = run,
};
