/* hetab tabulate: from a surface to table files. */
#include <fcntl.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "cli.h"
#include "core/angle.h"
#include "core/atomic_file.h"
#include "core/clock.h"
#include "output.h"
#include "progress.h"
#include "tabulate_job.h"

/* ---- outputs, before any work -------------------------------------------------------------- */

static const struct {
  const char *extension;
  output_format format;
} formats[] = {{".h5", OUTPUT_H5},
               {".hdf5", OUTPUT_H5},
               {".exr", OUTPUT_EXR},
               {".binary", OUTPUT_MERL},
               {".bsdf", OUTPUT_RGL}};

static int find_format(const char *path, output_format *format) {
  size_t length = strlen(path);
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
    size_t tail = strlen(formats[i].extension);
    if (length > tail && strcasecmp(path + length - tail, formats[i].extension) == 0 &&
        path[length - tail - 1] != '/') {
      *format = formats[i].format;
      return 1;
    }
  }
  return 0;
}

/* Formats that leave the specular reflectance to a CSV beside them. */
static int has_sidecar(output_format format) {
  return format == OUTPUT_MERL || format == OUTPUT_RGL;
}

/* NAME.binary -> NAME.specular.csv */
static char *specular_path(const char *path) {
  char *name;
  int stem = (int)(strrchr(path, '.') - path);
  return asprintf(&name, "%.*s.specular.csv", stem, path) < 0 ? NULL : name;
}

/* No two files of the plan, sidecars included, may be one; but tables of two formats may share
 * their sidecar, which is the same. */
static int check_distinct(const cli_command *self, const table_output *a, const table_output *b) {
  const char *files_a[] = {a->path, a->specular_path}, *files_b[] = {b->path, b->specular_path};
  if (hetab_same_file(a->path, b->path))
    return cli_usage(self, "%s: the same output is given twice", b->path);
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++)
      if (files_a[i] && files_b[k] && !(i && k && a->format != b->format) &&
          hetab_same_file(files_a[i], files_b[k]))
        return cli_usage(self, "%s and %s would both write %s: give one another name", a->path,
                         b->path, files_b[k]);
  return -1;
}

static int add_output(const cli_command *self, tabulate_job *job, const char *path) {
  table_output *output = &job->outputs[job->output_count];
  int status = -1;
  if (!find_format(path, &output->format))
    return cli_usage(self, "%s: the name of an output ends in .h5, .hdf5, .exr, .binary or .bsdf",
                     path);
  output->path = path;
  if (has_sidecar(output->format) && !(output->specular_path = specular_path(path)))
    return cli_fail("out of memory");
  for (size_t i = 0; i < job->output_count && status < 0; i++)
    status = check_distinct(self, &job->outputs[i], output);
  job->output_count++;
  return status;
}

static int plan_outputs(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  job->outputs = calloc(r->files.count, sizeof *job->outputs);
  if (!job->outputs)
    return cli_fail("out of memory");
  int status = -1;
  for (size_t i = 0; i < r->files.count && status < 0; i++)
    status = add_output(self, job, r->files.items[i]);
  return status;
}

static int check_outputs(const tabulate_job *job) {
  int force = job->request->force;
  for (size_t i = 0; i < job->output_count; i++) {
    const table_output *o = &job->outputs[i];
    if (!cli_output_allowed(job->ctx, o->path, force) ||
        (o->specular_path && !cli_output_allowed(job->ctx, o->specular_path, force)))
      return CLI_FAILURE;
  }
  return -1;
}

static int has_format(const tabulate_job *job, output_format format) {
  for (size_t i = 0; i < job->output_count; i++)
    if (job->outputs[i].format == format)
      return 1;
  return 0;
}

/* --bands takes words for OpenEXR and RGL tables, and wavelengths for MERL tables. */
static int is_channels(const char *bands) {
  return bands && (strcmp(bands, "rgb") == 0 || strcmp(bands, "spectral") == 0);
}

static int plan_bands(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  int words = is_channels(r->bands), spectral = words && strcmp(r->bands, "spectral") == 0;
  if (words && !has_format(job, OUTPUT_RGL) && !has_format(job, OUTPUT_EXR))
    return cli_usage(self, "--bands %s is for .exr and .bsdf outputs, and there is none", r->bands);
  if (r->bands && !words && !has_format(job, OUTPUT_MERL))
    return cli_usage(self, "--bands: '%s' is neither rgb nor spectral", r->bands);
  if (words && !spectral && r->exr_parts == HETAB_EXR_BY_WAVELENGTH)
    return cli_usage(self, "--exr-parts wavelength holds no colour: take --bands spectral");
  job->rgl_options.table_error = r->table_error;
  job->rgl_options.bands = spectral ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB;
  if (spectral || r->exr_parts == HETAB_EXR_BY_WAVELENGTH)
    job->exr_options.bands = HETAB_EXR_SPECTRAL;
  return -1;
}

static size_t sample_count(const tabulate_request *r) {
  return r->samples ? r->samples : HETAB_NO_SAMPLES;
}

static int plan_merl(const cli_command *self, tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_merl_options *o = &job->merl_options;
  *o = (hetab_merl_options){.sampling = (hetab_merl_sampling)r->sampling,
                            .colour = (hetab_merl_colour)r->colour,
                            .specular_cone = hetab_radians(r->cone_deg),
                            .samples = sample_count(r),
                            .seed = (unsigned)r->seed};
  static const size_t needed[] = {
      [HETAB_MERL_SRGB] = 0, [HETAB_MERL_MONO] = 1, [HETAB_MERL_BANDS] = 3};
  const char *bands = is_channels(r->bands) ? NULL : r->bands;
  size_t given = bands ? cli_wavelength_list(bands, o->band_um, 3) : 0;
  if (bands && !given)
    return cli_usage(
        self, "--bands: '%s' is not one or three wavelengths in nm, nor rgb or spectral", bands);
  if (given != needed[o->colour])
    return cli_usage(self, "--merl-colour %s takes %s",
                     o->colour == HETAB_MERL_SRGB   ? "srgb"
                     : o->colour == HETAB_MERL_MONO ? "mono"
                                                    : "bands",
                     o->colour == HETAB_MERL_SRGB   ? "no --bands"
                     : o->colour == HETAB_MERL_MONO ? "one wavelength in --bands"
                                                    : "three wavelengths in --bands");
  return -1;
}

/* ---- inputs -------------------------------------------------------------------------------- */

static hetab_status set_wavelengths(tabulate_job *job, const char *spec) {
  double *lambda_um;
  size_t count;
  hetab_status status = hetab_parse_wavelengths(job->ctx, spec, &lambda_um, &count);
  if (status != HETAB_OK)
    return status;
  status = hetab_surface_set_wavelengths(job->ctx, job->surface, lambda_um, count);
  free(lambda_um);
  return status;
}

static hetab_status open_inputs(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_status status = hetab_surface_open(job->ctx, r->surface, &job->surface);
  if (status == HETAB_OK && r->wavelengths)
    status = set_wavelengths(job, r->wavelengths);
  if (status == HETAB_OK)
    status = hetab_grid_create(job->ctx, &job->grid);
  for (int axis = 0; axis < HETAB_AXIS_COUNT && status == HETAB_OK; axis++)
    if (r->axes[axis])
      status = hetab_grid_set_axis(job->ctx, job->grid, (hetab_axis)axis, r->axes[axis]);
  return status;
}

/* Float by default, double where the tolerance asks for more than float arithmetic has. */
static hetab_precision choose_precision(const tabulate_request *r) {
  if (r->method == HETAB_METHOD_LITERAL)
    return HETAB_DOUBLE;
  if (r->precision >= 0)
    return (hetab_precision)r->precision;
  return r->tolerance > 0 && r->tolerance < 1e-5 ? HETAB_DOUBLE : HETAB_FLOAT;
}

static hetab_status open_engine(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_engine_options options = {.devices = r->device,
                                  .precision = choose_precision(r),
                                  .method = (hetab_method)r->method,
                                  .tolerance = r->tolerance};
  return hetab_engine_create(job->ctx, &options, &job->engine);
}

/* ---- the specular reflectance -------------------------------------------------------------- */

/* rho_s[band][angle]; free() it. NULL on failure. */
static double *specular_table(tabulate_job *job, const double *theta_i, size_t count,
                              output_format format) {
  size_t total = hetab_surface_band_count(job->surface) * count;
  double *rho = calloc(total, sizeof *rho), *max = &job->specular_max[format];
  if (!rho)
    cli_fail("out of memory");
  else if (hetab_specular_reflectance(job->ctx, job->surface, theta_i, count, rho) != HETAB_OK) {
    cli_fail_context(job->ctx);
    free(rho);
    return NULL;
  }
  for (size_t i = 0; rho && i < total; i++)
    *max = rho[i] > *max ? rho[i] : *max;
  return rho;
}

enum { CSV_ANGLES = 91 }; /* every degree */

static void write_specular_rows(FILE *stream, const hetab_surface *surface, const double *rho) {
  fputs("wavelength_nm,theta_i_deg,rho_s\n", stream);
  for (size_t band = 0; band < hetab_surface_band_count(surface); band++)
    for (size_t i = 0; i < CSV_ANGLES; i++)
      fprintf(stream, "%.10g,%g,%.9g\n", 1000 * hetab_surface_bands(surface)[band].lambda_um,
              (double)i, rho[band * CSV_ANGLES + i]);
}

/* Whether an output before this one has written its CSV. */
static int specular_is_written(const tabulate_job *job, const table_output *output) {
  for (const table_output *o = job->outputs; o < output; o++)
    if (o->specular_path && hetab_same_file(o->specular_path, output->specular_path))
      return 1;
  return 0;
}

static int save_specular_csv(tabulate_job *job, const table_output *output) {
  double theta_i[CSV_ANGLES];
  cli_text csv = {0};
  for (int i = 0; i < CSV_ANGLES; i++)
    theta_i[i] = hetab_radians(i);
  double *rho = specular_table(job, theta_i, CSV_ANGLES, output->format);
  int status = rho ? cli_text_begin(&csv) : CLI_FAILURE;
  if (status < 0 && !specular_is_written(job, output)) {
    write_specular_rows(csv.stream, job->surface, rho);
    status = cli_text_save(&csv, job->ctx, output->specular_path, job->request->force);
  }
  cli_text_free(&csv);
  free(rho);
  return status;
}

/* ---- dense tables -------------------------------------------------------------------------- */

static hetab_status create_h5(tabulate_job *job, table_output *o, const double *rho) {
  hetab_status status =
      hetab_h5_create(job->ctx, o->path, job->surface, job->grid, &job->h5_options, &o->writer);
  return status == HETAB_OK ? hetab_table_write_specular(job->ctx, o->writer, rho) : status;
}

static hetab_status create_exr(tabulate_job *job, table_output *o, const double *rho) {
  hetab_status status =
      hetab_exr_create(job->ctx, o->path, job->surface, job->grid, &job->exr_options, &o->exr);
  return status == HETAB_OK ? hetab_table_write_specular(job->ctx, o->exr, rho) : status;
}

static void choose_exr(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_exr_options *o = &job->exr_options;
  o->parts = (hetab_exr_parts)r->exr_parts;
  o->element = (hetab_exr_element)r->exr_type;
  o->slabs = hetab_engine_precision(job->engine);
  o->method = hetab_engine_method(job->engine);
  o->tolerance = hetab_engine_tolerance(job->engine);
  o->device = hetab_engine_device(job->engine);
  o->overwrite = r->force;
}

static int create_writers(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_precision precision = choose_precision(r);
  if (has_format(job, OUTPUT_EXR))
    choose_exr(job);
  job->h5_options =
      (hetab_h5_options){.element = r->element < 0 ? precision : (hetab_precision)r->element,
                         .slabs = precision,
                         .compression = (int)r->compression,
                         .overwrite = r->force};
  double *rho = specular_table(job, hetab_grid_radians(job->grid, HETAB_THETA_I),
                               hetab_grid_count(job->grid, HETAB_THETA_I), OUTPUT_H5);
  if (!rho)
    return CLI_FAILURE;
  hetab_status status = HETAB_OK;
  for (size_t i = 0; i < job->output_count && status == HETAB_OK; i++) {
    table_output *o = &job->outputs[i];
    if (o->format == OUTPUT_H5)
      status = create_h5(job, o, rho);
    else if (o->format == OUTPUT_EXR)
      status = create_exr(job, o, rho);
  }
  free(rho);
  job->specular_max[OUTPUT_EXR] = job->specular_max[OUTPUT_H5];
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

enum { BLOCK = 1024 }; /* a fixed count is what compilers vectorise */

/* Whether all are finite and not negative; NaN fails both comparisons. */
static int floats_radiant(const float *values, size_t count) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  return !bad;
}

static int doubles_radiant(const double *values, size_t count, double most) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0) | !(values[i] <= most);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0) | !(values[i] <= most);
  return !bad;
}

static int slab_radiant(const tabulate_job *job, const hetab_slab *slab) {
  const hetab_h5_options *o = &job->h5_options;
  size_t count = slab->theta_i_count * hetab_grid_count(job->grid, HETAB_THETA_R) *
                 hetab_grid_count(job->grid, HETAB_PHI);
  return o->slabs == HETAB_FLOAT
             ? floats_radiant(slab->values, count)
             : doubles_radiant(slab->values, count,
                               o->element == HETAB_FLOAT ? (double)FLT_MAX : DBL_MAX);
}

/* A slab goes to every HDF5 and OpenEXR output. A bad one stops the job: nothing is published. */
static hetab_status fan_out(hetab_context *ctx, void *user, const hetab_slab *slab) {
  tabulate_job *job = user;
  hetab_status status = HETAB_OK;
  if (!slab_radiant(job, slab)) {
    job->bad_slab = 1;
    return HETAB_ERR_ARGUMENT;
  }
  for (size_t i = 0; i < job->output_count && status == HETAB_OK; i++)
    if (job->outputs[i].writer)
      status = hetab_table_write_slab(ctx, job->outputs[i].writer, slab);
    else if (job->outputs[i].exr)
      status = hetab_table_write_slab(ctx, job->outputs[i].exr, slab);
  return status;
}

/* The sample is of all that was evaluated: a second look at dense tables, and the one at MERL
 * tables before hetab_merl_save goes through their cells. */
static int check_report(const hetab_report *report) {
  if (report->error.bad)
    return cli_fail("%zu of %zu sampled entries are NaN, infinite or negative: nothing written; "
                    "please report this",
                    report->error.bad, report->error.samples);
  return -1;
}

static int fill_dense(tabulate_job *job) {
  const tabulate_request *r = job->request;
  hetab_tabulate_options options = {.samples = sample_count(r), .seed = (unsigned)r->seed};
  hetab_report *report = &job->reports[OUTPUT_H5];
  cli_progress_begin(job->ctx, hetab_surface_name(job->surface), r->quiet);
  hetab_status done = hetab_tabulate(job->ctx, job->engine, job->surface, job->grid, &options,
                                     fan_out, job, report);
  cli_progress_end();
  job->reports[OUTPUT_EXR] = *report;
  if (job->bad_slab)
    return cli_fail("entries of the table are NaN, infinite or negative: nothing written; please "
                    "report this");
  return done == HETAB_OK ? check_report(report) : cli_fail_context(job->ctx);
}

static int fill_merl(tabulate_job *job) {
  hetab_report *report = &job->reports[OUTPUT_MERL];
  cli_progress_begin(job->ctx, hetab_surface_name(job->surface), job->request->quiet);
  hetab_status done = hetab_tabulate_merl(job->ctx, job->engine, job->surface, &job->merl_options,
                                          &job->merl, report);
  cli_progress_end();
  return done == HETAB_OK ? check_report(report) : cli_fail_context(job->ctx);
}

static int fill_rgl(tabulate_job *job) {
  cli_progress_begin(job->ctx, hetab_surface_name(job->surface), job->request->quiet);
  double start = hetab_seconds();
  hetab_status done =
      hetab_tabulate_rgl(job->ctx, job->surface, &job->rgl_options, &job->rgl, &job->rgl_report);
  cli_progress_end();
  if (done != HETAB_OK)
    return cli_fail_context(job->ctx);
  const hetab_rgl_report *r = &job->rgl_report;
  job->reports[OUTPUT_RGL] =
      (hetab_report){.entries = (double)(r->theta_i_count * r->resolution * r->resolution *
                                         hetab_rgl_channel_count(job->rgl)),
                     .wall_seconds = hetab_seconds() - start};
  return -1;
}

/* ---- publication --------------------------------------------------------------------------- */

static int publish_h5(tabulate_job *job, table_output *output) {
  hetab_table_writer *writer = output->writer;
  if (hetab_table_write_report(job->ctx, writer, &job->reports[OUTPUT_H5]) != HETAB_OK)
    return cli_fail_context(job->ctx); /* the writer is aborted with the job */
  output->writer = NULL;
  return hetab_table_commit(job->ctx, writer) == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

static int publish_exr(tabulate_job *job, table_output *output) {
  hetab_table_writer *writer = output->exr;
  output->exr = NULL;
  output->saturated = hetab_table_saturated_count(writer);
  hetab_table_write_report(job->ctx, writer, &job->reports[OUTPUT_EXR]);
  return hetab_table_commit(job->ctx, writer) == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

static hetab_status save_table(tabulate_job *job, const table_output *output) {
  int force = job->request->force;
  return output->format == OUTPUT_RGL ? hetab_rgl_save(job->ctx, job->rgl, output->path, force)
                                      : hetab_merl_save(job->ctx, job->merl, output->path, force);
}

/* The CSV first: no table is without it. */
static int publish_with_csv(tabulate_job *job, const table_output *output) {
  int was_there = faccessat(AT_FDCWD, output->specular_path, F_OK, AT_SYMLINK_NOFOLLOW) == 0;
  int status = save_specular_csv(job, output);
  if (status >= 0)
    return status;
  if (save_table(job, output) == HETAB_OK)
    return -1;
  if (!was_there)
    unlink(output->specular_path);
  return cli_fail_context(job->ctx);
}

static int publish(tabulate_job *job) {
  int status = -1;
  for (size_t i = 0; i < job->output_count && status < 0; i++) {
    table_output *o = &job->outputs[i];
    if (cli_signal())
      return cli_fail("stopped");
    status = o->format == OUTPUT_H5    ? publish_h5(job, o)
             : o->format == OUTPUT_EXR ? publish_exr(job, o)
                                       : publish_with_csv(job, o);
  }
  return status;
}

/* ---- the command --------------------------------------------------------------------------- */

/* Inputs, the files' layout and the engine, if one is needed; the OpenCL runtime loads meanwhile.
 * OpenEXR headers name the device, and come after it. */
static int prepare(tabulate_job *job) {
  int has_h5 = has_format(job, OUTPUT_H5), has_exr = has_format(job, OUTPUT_EXR), status = -1;
  int device = has_h5 || has_exr || has_format(job, OUTPUT_MERL);
  if (device && job->request->method != HETAB_METHOD_LITERAL)
    job->preload = hetab_preload_create();
  if (open_inputs(job) != HETAB_OK)
    return cli_fail_context(job->ctx);
  if (has_h5 && !has_exr)
    status = create_writers(job);
  if (status < 0 && device && open_engine(job) != HETAB_OK)
    status = cli_fail_context(job->ctx);
  return status < 0 && has_exr ? create_writers(job) : status;
}

static int evaluate(tabulate_job *job) {
  int status = prepare(job);
  if (status < 0 && has_format(job, OUTPUT_RGL))
    status = fill_rgl(job);
  if (status < 0 && has_format(job, OUTPUT_MERL)) /* first: it can refuse, and is the shorter job */
    status = fill_merl(job);
  if (status < 0 && (has_format(job, OUTPUT_H5) || has_format(job, OUTPUT_EXR)))
    status = fill_dense(job);
  return status < 0 ? publish(job) : status;
}

static int run_job(const cli_command *self, const tabulate_request *request) {
  tabulate_job job = {.request = request};
  int status = plan_outputs(self, &job);
  if (status < 0)
    status = plan_bands(self, &job);
  if (status < 0)
    status = plan_merl(self, &job);
  if (status < 0)
    status = (job.ctx = cli_context()) ? check_outputs(&job) : CLI_FAILURE;
  if (status < 0)
    status = evaluate(&job);
  if (status < 0)
    status = tabulate_summary(&job);
  for (size_t i = 0; i < job.output_count; i++) {
    hetab_table_abort(job.outputs[i].writer);
    hetab_table_abort(job.outputs[i].exr);
    free(job.outputs[i].specular_path);
  }
  free(job.outputs);
  hetab_merl_free(job.merl);
  hetab_rgl_free(job.rgl);
  hetab_engine_free(job.engine);
  hetab_preload_free(job.preload);
  hetab_grid_free(job.grid);
  hetab_surface_free(job.surface);
  hetab_context_free(job.ctx);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  tabulate_request request = {.precision = -1, .element = -1, .samples = 2000, .seed = 1};
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
        "writes the table to each FILE: dd + ud, in 1/sr, without a cosine. Files appear whole or "
        "not at all, and none is overwritten without --force.\n\n"
        "The specular delta is not in the tables. An HDF5 file holds its reflectance rho_s as "
        "/specular_reflectance, an OpenEXR file as its last part; beside NAME.binary and NAME.bsdf "
        "it is written to NAME.specular.csv.\n\n"
        "An OpenEXR file holds a part for each theta_i (rows theta_r, columns phi; channels R G B, "
        "or T.550,000000nm and so on), or for each wavelength (rows theta_i and theta_r), with the "
        "surface and the axes as attributes.\n\n"
        "A .bsdf is an RGL table for Mitsuba 3's and pbrt-v4's measured materials, as small as "
        "--table-error allows; it is made on the host and needs no device.\n\n"
        "--json prints an object with surface, device, method, precision, tolerance (these null "
        "where no device was needed), version and outputs, an array of objects with file, format "
        "(hdf5, exr, merl or rgl), entries, seconds, entries_per_second, kernel_seconds, "
        "kernel_entries_per_second, error (samples, compared, max_rel, p99_rel, rms_rel, "
        "max_abs_below_floor, bad; null without samples), specular (max, file, in_table, cone_deg) "
        "and, for merl, clamped; for exr, saturated; for rgl, table (bands, table_error, error_l1, "
        "bias, error_grazing, theta_i, resolution, bytes, clamped).",
    .run = run,
};
