/* hetab audit: surfaces and tables, judged. */
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "audit_command.h"
#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "core/held_files.h"
#include "output.h"
#include "progress.h"

/* What the command line asks for. */
typedef struct audit_request {
  const char *against, *repair, *html, *bands, *device;
  int lookup, colour, precision, scale_energy, force, json, quiet; /* lookup -1: by the format */
  size_t seed;
  hetab_audit_options options;
} audit_request;

typedef struct audit_job {
  const audit_request *request;
  hetab_audit_options options;
  hetab_context *ctx;
  hetab_engine *engine; /* when it is needed */
  hetab_surface *against;
  audit_report report;
} audit_job;

/* ---- inputs -------------------------------------------------------------------------------- */

static int is_preset(const char *name) {
  for (size_t i = 0; i < hetab_preset_count(); i++)
    if (strcasecmp(name, hetab_preset_name(i)) == 0)
      return 1;
  return 0;
}

/* By its name; what has no telling one is a table if it is a file. */
static int is_table(const char *name) {
  struct stat about;
  hetab_format format;
  const char *dot = strrchr(name, '.');
  if (hetab_format_by_ending(name, &format))
    return 1;
  if ((dot && (strcasecmp(dot, ".yml") == 0 || strcasecmp(dot, ".yaml") == 0)) || is_preset(name))
    return 0;
  return stat(name, &about) == 0;
}

static int is_h5(const char *name) {
  hetab_format format;
  return hetab_format_by_ending(name, &format) && format == HETAB_FORMAT_H5;
}

/* ---- what the audits need ------------------------------------------------------------------ */

static int open_engine(audit_job *job) {
  hetab_engine_options options = {.devices = job->request->device,
                                  .precision = (hetab_precision)job->request->precision};
  if (job->engine || hetab_engine_create(job->ctx, &options, &job->engine) == HETAB_OK)
    return -1;
  return cli_fail_context(job->ctx);
}

static int open_against(audit_job *job) {
  if (!job->request->against)
    return -1;
  CLI_CALL(job->ctx, hetab_surface_open(job->ctx, job->request->against, &job->against));
  job->options.against = job->against;
  return -1;
}

static int check_colour(const cli_command *self, audit_request *r) {
  static const size_t needed[] = {
      [HETAB_MERL_SRGB] = 0, [HETAB_MERL_MONO] = 1, [HETAB_MERL_BANDS] = 3};
  size_t given = r->bands ? cli_wavelength_list(r->bands, r->options.band_um, 3) : 0;
  if (r->bands && !given)
    return cli_usage(self, "--bands: '%s' is not one or three wavelengths in nm", r->bands);
  if (given != needed[r->colour])
    return cli_usage(self, "--merl-colour %s takes %s",
                     r->colour == HETAB_MERL_SRGB   ? "srgb"
                     : r->colour == HETAB_MERL_MONO ? "mono"
                                                    : "bands",
                     r->colour == HETAB_MERL_SRGB   ? "no --bands"
                     : r->colour == HETAB_MERL_MONO ? "one wavelength in --bands"
                                                    : "three wavelengths in --bands");
  r->options.colour = (hetab_merl_colour)r->colour;
  return -1;
}

/* ---- one audit ----------------------------------------------------------------------------- */

static hetab_status run_surface(audit_job *job, const char *input, hetab_audit **audit) {
  HETAB_ENDS(hetab_surface_end) hetab_surface *surface = NULL;
  HETAB_TRY(hetab_surface_open(job->ctx, input, &surface));
  return hetab_audit_surface(job->ctx, job->engine, surface, &job->options, audit);
}

/* Adds the input's audit to the report. */
static int audit_one(audit_job *job, const char *input, int table) {
  audit_result *result = &job->report.results[job->report.count];
  int needs_engine =
      !table || (!job->options.no_reference && (job->options.against || is_h5(input)));
  CLI_TRY(needs_engine ? open_engine(job) : -1);
  result->input = input;
  cli_progress_begin(input, job->request->quiet);
  hetab_status done =
      table ? hetab_audit_table(job->ctx, job->engine, input, &job->options, &result->audit)
            : run_surface(job, input, &result->audit);
  cli_progress_end();
  CLI_CALL(job->ctx, done);
  job->report.count++;
  if (!job->request->json && !job->request->quiet)
    audit_print(result);
  return -1;
}

static int repair(audit_job *job, const char *input) {
  const audit_request *r = job->request;
  cli_progress_begin("repair", r->quiet);
  hetab_status done = hetab_repair(job->ctx, input, r->repair, job->options.lookup, r->scale_energy,
                                   r->force, &job->report.repair);
  cli_progress_end();
  CLI_CALL(job->ctx, done);
  job->report.repaired = r->repair;
  if (!r->json && !r->quiet)
    audit_print_repair(&job->report);
  return audit_one(job, r->repair, 1);
}

/* ---- all ----------------------------------------------------------------------------------- */

static int save_page(const audit_job *job) {
  cli_text page;
  CLI_TRY(cli_text_begin(&page));
  audit_html(page.stream, &job->report);
  return cli_text_save(&page, job->ctx, job->request->html, job->request->force);
}

static int publish(audit_job *job) {
  const audit_request *r = job->request;
  CLI_TRY(r->html ? save_page(job) : -1);
  CLI_TRY(cli_publish(job->ctx));
  int status = audit_exit_status(&job->report);
  if (r->json)
    return cli_json_print(audit_json(&job->report)) == CLI_OK ? status : CLI_FAILURE;
  if (!r->quiet)
    audit_print_summary(&job->report);
  return status;
}

/* A missing file comes out before the work on the others. */
static int check_inputs(char **inputs, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (is_table(inputs[i]) && access(inputs[i], R_OK))
      return cli_fail("%s: %m", inputs[i]);
  return -1;
}

static int run_job(audit_job *job, char **inputs, size_t count) {
  const audit_request *r = job->request;
  CLI_TRY(check_inputs(inputs, count));
  if ((r->html && !cli_output_allowed(job->ctx, r->html, r->force)) ||
      (r->repair && !cli_output_allowed(job->ctx, r->repair, r->force)))
    return CLI_FAILURE;
  CLI_TRY(open_against(job));
  for (size_t i = 0; i < count; i++)
    CLI_TRY(audit_one(job, inputs[i], is_table(inputs[i])));
  if (r->repair)
    CLI_TRY(repair(job, inputs[0]));
  return publish(job);
}

static int start(const audit_request *request, char **inputs, size_t count) {
  audit_job job = {.request = request, .options = request->options};
  int status = CLI_FAILURE;
  job.options.lookup = (hetab_reading)(request->lookup + 1);
  job.options.seed = (unsigned)request->seed;
  job.options.views = request->html != NULL;
  job.report.results = calloc(count + 1, sizeof *job.report.results);
  if (!job.report.results)
    return cli_fail("out of memory");
  if ((job.ctx = cli_context()))
    status = run_job(&job, inputs, count);
  for (size_t i = 0; i < job.report.count; i++)
    hetab_audit_free(job.report.results[i].audit);
  free(job.report.results);
  hetab_surface_free(job.against);
  hetab_engine_free(job.engine);
  hetab_context_free(job.ctx);
  return status;
}

static int check_page(const cli_command *self, const audit_request *r) {
  if (r->html && r->repair && hetab_same_file(r->html, r->repair))
    return cli_usage(self, "--html and --repair would both write %s: give one another name",
                     r->html);
  return -1;
}

static int check_repair(const cli_command *self, const audit_request *r, char **inputs, int count) {
  if (r->scale_energy && !r->repair)
    return cli_usage(self, "--scale-energy goes with --repair");
  if (!r->repair)
    return -1;
  if (count != 1)
    return cli_usage(self, "--repair takes one INPUT, not %d", count);
  if (!is_table(inputs[0]))
    return cli_usage(self, "--repair: %s is a surface, not a table", inputs[0]);
  if (is_h5(inputs[0]) != is_h5(r->repair))
    return cli_usage(self, "--repair: %s and %s are of different formats", inputs[0], r->repair);
  return -1;
}

static int parse(const cli_command *self, int argc, char **argv, audit_request *r, int *first) {
  hetab_audit_options *o = &r->options;
  const cli_option options[] = {
      {CLI_TEXT, "against", 0, "SURFACE",
       "compare tables with SURFACE (HDF5: with the parameters in the file)", &r->against, 0, 0},
      {CLI_FLAG, "no-reference", 0, NULL, "do not compare with parameters in the file",
       &o->no_reference, 0, 0},
      {CLI_CHOICE, "merl-colour", 0, "srgb|mono|bands",
       "what the three channels of a table are, with --against (srgb)", &r->colour, 0, 0},
      {CLI_TEXT, "bands", 0, "NM", "their wavelengths: one for mono, three for bands", &r->bands, 0,
       0},
      {CLI_CHOICE, "lookup", 0, "truncate|interpolate",
       "how the renderer reads between entries (MERL truncate, HDF5 interpolate; RGL has one way)",
       &r->lookup, 0, 0},
      {CLI_TEXT, "repair", 0, "OUT",
       "write OUT, the table made finite, non-negative and reciprocal, and audit it too: the exit "
       "status is its",
       &r->repair, 0, 0},
      {CLI_FLAG, "scale-energy", 0, NULL, "and scaled so that no incidence reflects more than 1",
       &r->scale_energy, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with the plots", &r->html, 0, 0},
      CLI_FORCE(&r->force),
      {CLI_NUMBER, "max-excess", 0, "X", "rho_dh may exceed its bounds by X (0)", &o->max_excess, 0,
       10},
      {CLI_NUMBER, "max-asymmetry", 0, "X",
       "entries that should be equal may differ by X, relative (1e-3)", &o->max_asymmetry, 0, 1},
      {CLI_NUMBER, "max-error", 0, "X",
       "FAIL for a relative L1 error against the model above X, WARN above X/4 (0.25)",
       &o->max_error, 0, 1e6},
      {CLI_NUMBER, "max-missing", 0, "X",
       "WARN for a missing specular term of more white-sky energy than X (0.01)", &o->max_missing,
       0, 1},
      {CLI_SHARE, "tolerance", 0, "X", "of the energy that a MERL lookup gives back (1e-3)",
       &o->tolerance, 1e-6, 1},
      {CLI_COUNT, "pairs", 0, "N", "direction pairs of the comparison (1000000)", &o->pairs, 1,
       1e9},
      {CLI_COUNT, "seed", 0, "N", "of those pairs (0)", &r->seed, 0, 4294967295.0},
      CLI_DEVICE(&r->device),
      CLI_PRECISION(&r->precision),
      CLI_QUIET(&r->quiet),
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {version, verdict, summary: {pass, warn, fail}, repair: {output, entries, "
       "replaced, clamped, symmetrised, max_change_abs, max_change_rel, scaled_incidences, "
       "smallest_scale}, results: [{input, kind, verdict, lookup, bytes, dimensions, checks: "
       "[{name, verdict, value, error, threshold, detail}], theta_i_deg, channels: [{wavelength_nm "
       "or channel, rho_dh, error, rho_dd, rho_s, rho_ud, fresnel, model; of a surface a, a_unit, "
       "max_a_brdf, max_a_reflectance, max_a_fresnel, rho_dh_if_brdf, rho_dh_if_reflectance, min, "
       "max, specular_share, grazing}], cells, reciprocity, isotropy, bilateral, separability, "
       "against}]}",
       &r->json, 0, 0},
      {0},
  };
  return cli_parse_options(self, options, argc, argv, first);
}

static int run(const cli_command *self, int argc, char **argv) {
  audit_request r = {.lookup = -1};
  int first, status = parse(self, argc, argv, &r, &first);
  if (status < 0 && first == argc)
    status = cli_usage(self, "no INPUT given");
  if (status < 0)
    status = check_colour(self, &r);
  if (status < 0)
    status = check_repair(self, &r, argv + first, argc - first);
  if (status < 0)
    status = check_page(self, &r);
  return status < 0 ? start(&r, argv + first, (size_t)(argc - first)) : status;
}

const cli_command cli_audit = {
    .name = "audit",
    .arguments = "INPUT...",
    .summary = "judge surfaces and tables: energy, reciprocity, table error",
    .description =
        "INPUT is a surface (a preset or a YAML file), or a table, HDF5 (.h5, .hdf5), MERL "
        "(.binary) or RGL (.bsdf), of this program or any other. Each gets a line per check with "
        "PASS, WARN or "
        "FAIL, the number judged, and where it was found. What numerical error could explain is no "
        "finding.\n\n"
        "Surfaces: rho_dh at 90 incidences and every wavelength against 1 and against the polished "
        "material, sign, range and reciprocity of the values, the share of the specular delta, the "
        "largest diffuse part that conserves energy. Tables, as a renderer looks them up: rho_dh, "
        "NaN, negative and misplaced entries, reciprocity, isotropy, bilateral symmetry; and "
        "against the model the error at random direction pairs.\n\n"
        "Exit status: 0 no check failed, 3 a check failed, 1 the audit could not run, 2 mistake on "
        "the command line.",
    .run = run,
};
