/* hetab tabulate: from a surface to table files. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "core/angle.h"
#include "numbers.h"
#include "output.h"
#include "progress.h"
#include "tabulate_job.h"

/* ---- options, before any work --------------------------------------------------------------- */

/* --bands takes words for OpenEXR and RGL tables, and wavelengths for MERL tables. */
static int is_channels(const char *bands) {
  return bands && (strcmp(bands, "rgb") == 0 || strcmp(bands, "spectral") == 0);
}

/* What --for asks of the .bsdf; -1 if nothing contradicts it. */
static int plan_renderer(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  if (r->renderer < 0)
    return -1;
  const tabulate_renderer *renderer = &tabulate_renderers[r->renderer];
  int spectral = renderer->bands == HETAB_RGL_SPECTRAL;
  if (is_channels(r->bands) && spectral != (strcmp(r->bands, "spectral") == 0))
    return cli_usage(self, "--for %s reads %s, not --bands %s", renderer->name,
                     spectral ? "spectra" : "rgb", r->bands);
  job->rgl.bands = renderer->bands;
  return -1;
}

static int plan_bands(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  int words = is_channels(r->bands), spectral = words && strcmp(r->bands, "spectral") == 0;
  if (words && !tabulate_has_format(job->request, HETAB_FORMAT_RGL) &&
      !tabulate_has_format(job->request, HETAB_FORMAT_EXR))
    return cli_usage(self, "--bands %s is for .exr and .bsdf outputs, and there is none", r->bands);
  if (r->bands && !words && !tabulate_has_format(job->request, HETAB_FORMAT_MERL))
    return cli_usage(self, "--bands: '%s' is neither rgb nor spectral", r->bands);
  if (words && !spectral && r->exr_parts == HETAB_EXR_BY_WAVELENGTH)
    return cli_usage(self, "--exr-layout wavelength holds no colour: take --bands spectral");
  if (spectral && r->exr_parts == HETAB_EXR_ATLAS)
    return cli_usage(self, "--exr-layout atlas holds R, G and B: leave --bands spectral out");
  job->rgl.table_error = r->table_error;
  job->rgl.specular_cone = hetab_radians(r->cone_deg);
  job->exr.specular_cone = job->rgl.specular_cone;
  job->exr.parts = (hetab_exr_parts)r->exr_parts;
  job->exr.element = r->exr_type >= 0                  ? (hetab_exr_element)r->exr_type
                     : r->exr_parts == HETAB_EXR_ATLAS ? HETAB_EXR_HALF
                                                       : HETAB_EXR_FLOAT;
  job->rgl.bands = spectral ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB;
  if (spectral || r->exr_parts == HETAB_EXR_BY_WAVELENGTH)
    job->exr.bands = HETAB_EXR_SPECTRAL;
  return plan_renderer(self, job);
}

static size_t sample_count(const tabulate_request *r) {
  return r->samples ? r->samples : HETAB_NO_SAMPLES;
}

static int plan_merl(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_merl_options *o = &job->merl;
  *o = (hetab_merl_options){.sampling = (hetab_merl_sampling)r->sampling,
                            .colour = (hetab_merl_colour)r->colour,
                            .specular_cone = hetab_radians(r->cone_deg),
                            .samples = sample_count(r),
                            .seed = (unsigned)r->seed};
  static const struct {
    const char *colour, *takes;
    size_t count;
  } needed[] = {[HETAB_MERL_SRGB] = {"srgb", "no --bands", 0},
                [HETAB_MERL_MONO] = {"mono", "one wavelength in --bands", 1},
                [HETAB_MERL_BANDS] = {"bands", "three wavelengths in --bands", 3}};
  const char *bands = is_channels(r->bands) ? NULL : r->bands;
  size_t given = bands ? cli_wavelength_list(bands, o->band_um, 3) : 0;
  if (bands && !given)
    return cli_usage(
        self, "--bands: '%s' is not one or three wavelengths in nm, nor rgb or spectral", bands);
  if (given != needed[o->colour].count)
    return cli_usage(self, "--merl-colour %s takes %s", needed[o->colour].colour,
                     needed[o->colour].takes);
  return -1;
}

/* ---- inputs -------------------------------------------------------------------------------- */

static hetab_status set_wavelengths(tabulate_job *job, const char *spec) {
  HETAB_FREED double *lambda_um = NULL;
  size_t count;
  HETAB_TRY(hetab_parse_wavelengths(job->ctx, spec, &lambda_um, &count));
  return hetab_surface_set_wavelengths(job->ctx, job->surface, lambda_um, count);
}

static hetab_status open_inputs(tabulate_job *job) {
  const tabulate_request *r = job->request;
  HETAB_TRY(hetab_surface_open(job->ctx, r->surface, &job->surface));
  if (r->wavelengths)
    HETAB_TRY(set_wavelengths(job, r->wavelengths));
  HETAB_TRY(hetab_grid_create(job->ctx, &job->grid));
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    if (r->axes[axis])
      HETAB_TRY(hetab_grid_set_axis(job->ctx, job->grid, (hetab_axis)axis, r->axes[axis]));
  return HETAB_OK;
}

/* Float by default, double where the tolerance asks for more than float arithmetic has, or the
 * surface does. */
static hetab_precision choose_precision(const tabulate_job *job) {
  const tabulate_request *r = job->request;
  if (r->method == HETAB_METHOD_LITERAL)
    return HETAB_DOUBLE;
  if (r->precision >= 0)
    return (hetab_precision)r->precision;
  int fine = (r->tolerance > 0 && r->tolerance < 1e-5) || hetab_wants_double(job->surface);
  return fine ? HETAB_DOUBLE : HETAB_FLOAT;
}

static void plan_engine(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_precision precision = choose_precision(job);
  job->engine = (hetab_engine_options){.devices = r->device,
                                       .precision = precision,
                                       .method = (hetab_method)r->method,
                                       .tolerance = r->tolerance};
  job->sample = (hetab_tabulate_options){.samples = sample_count(r), .seed = (unsigned)r->seed};
  job->h5 = (hetab_h5_options){.element = r->element < 0 ? precision : (hetab_precision)r->element,
                               .compression = (int)r->compression};
}

/* ---- the command --------------------------------------------------------------------------- */

static int fail_if_existing(const tabulate_job *job, const char *path) {
  hetab_format format;
  if (!cli_output_allowed(job->ctx, path, 0))
    return 1;
  if (!hetab_format_by_ending(path, &format) ||
      (format != HETAB_FORMAT_MERL && format != HETAB_FORMAT_RGL))
    return 0;
  HETAB_FREED char *beside = hetab_specular_path(job->ctx, path);
  return beside && !cli_output_allowed(job->ctx, beside, 0);
}

/* Says which file exists, and what to do about it; 0 if none does any more. */
static int fail_existing(const tabulate_job *job) {
  for (size_t i = 0; i < job->request->files.count; i++)
    if (fail_if_existing(job, job->request->files.items[i]))
      return 1;
  return 0;
}

static int write_tables(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  const hetab_tabulate_to_options options = {.engine = &job->engine,
                                             .grid = job->grid,
                                             .sample = &job->sample,
                                             .h5 = &job->h5,
                                             .exr = &job->exr,
                                             .merl = &job->merl,
                                             .rgl = &job->rgl,
                                             .overwrite = r->force};
  job->reports = calloc(r->files.count, sizeof *job->reports);
  if (!job->reports)
    return cli_fail("out of memory");
  cli_progress_begin(hetab_surface_name(job->surface), r->quiet);
  hetab_status status = hetab_tabulate_to(job->ctx, NULL, job->surface, r->files.items,
                                          r->files.count, &options, job->reports);
  cli_progress_end();
  if (status == HETAB_ERR_ARGUMENT) /* files that do not go together */
    return cli_usage(self, "%s", hetab_error_message(job->ctx));
  if (status == HETAB_ERR_EXISTS && fail_existing(job))
    return CLI_FAILURE;
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

static int run_job(const cli_command *self, const tabulate_request *request) {
  tabulate_job job = {.request = request};
  int status = plan_bands(self, &job);
  if (status < 0)
    status = plan_merl(self, &job);
  if (status < 0)
    status = (job.ctx = cli_context()) ? -1 : CLI_FAILURE;
  if (status < 0 && open_inputs(&job) != HETAB_OK)
    status = cli_fail_context(job.ctx);
  if (status < 0) {
    plan_engine(&job);
    status = write_tables(self, &job);
  }
  if (status < 0)
    status = cli_publish(job.ctx);
  if (status < 0)
    status = tabulate_summary(&job);
  free(job.reports);
  hetab_grid_free(job.grid);
  hetab_surface_free(job.surface);
  hetab_context_free(job.ctx);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  tabulate_request request = {
      .precision = -1, .element = -1, .exr_type = -1, .renderer = -1, .samples = 2000, .seed = 1};
  int status = tabulate_parse(self, argc, argv, &request);
  if (status < 0)
    status = run_job(self, &request);
  free(request.files.items);
  return status;
}

const cli_command cli_tabulate = {
    .name = "tabulate",
    .arguments = "SURFACE -o FILE [-o FILE]...",
    .summary = "write the tables of a surface as HDF5, OpenEXR, MERL and RGL files",
    .description =
        "Evaluates SURFACE (a preset, see 'hetab surfaces', or a YAML file) over a whole grid and "
        "writes the table to each FILE: dd + ud, in 1/sr, without a cosine. All files appear, or "
        "none, and none is overwritten without --force.\n\n"
        "The specular delta is not in the tables. An HDF5 file holds its reflectance rho_s as "
        "/specular_reflectance, an OpenEXR file as its last part; beside NAME.binary and NAME.bsdf "
        "it is written to NAME.specular.csv.\n\n"
        "An OpenEXR file holds a part for each theta_i (rows theta_r, columns phi; channels R G B, "
        "or T.550,000000nm and so on), or for each wavelength (rows theta_i and theta_r), with the "
        "surface and the axes as attributes; with --exr-layout atlas all theta_i are tiles of one "
        "picture, rho_s is among the attributes, and scripts/exr_atlas.glsl reads it.\n\n"
        "A .bsdf is an RGL table, as small as --table-error allows, for the renderer named by "
        "--for: linear sRGB and spectra are two kinds of file, and each reader takes one of them. "
        "It is made on the host and needs no device.\n\n"
        "--json prints an object with surface, device, method, precision, tolerance (these null "
        "where no device was needed), version and outputs, an array of objects with file, format "
        "(hdf5, exr, merl or rgl), entries, seconds, entries_per_second, kernel_seconds, "
        "kernel_entries_per_second, error (samples, compared, max_sampled, share_above, p99_rel, "
        "rms_rel, max_abs_below_floor, bad; null without samples), specular (max, share of the "
        "light, file, in_table, cone_deg), loads_in and, for merl, clamped and, of a folded "
        "delta, delta_as_read (theta_i_deg, rho_s, read: by readers that truncate); for exr, "
        "saturated; "
        "for "
        "hdf5 and exr, linear_readers (error_l1, lobe_deg, step_deg, theta_needed, phi_needed); "
        "for rgl, table (bands, table_error, error_l1, bias, error_grazing, theta_i, resolution, "
        "bytes, clamped).",
    .run = run,
};
