#include <hetab/tabulate_to.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <hetab/devices.h>
#include <hetab/host_model.h>

#include "convert/grid_read.h"
#include "convert/radiant.h"
#include "convert/read_back.h"
#include "convert/slab_fold.h"
#include "convert/surface_specular.h"
#include "core/option_size.h"
#include "core/angle.h"
#include "core/held_files.h"
#include "core/clock.h"
#include "core/context.h"
#include "table/specular.h"

typedef struct output {
  const char *path;
  char *specular;             /* MERL, RGL: the file of the delta beside it */
  hetab_output_report report; /* the caller's in the end */
  hetab_table_writer *writer; /* HDF5, OpenEXR: until it is committed */
  size_t held;                /* files that were held when this one was the last of them */
} output;

typedef struct job {
  hetab_context *ctx;
  const hetab_surface *surface;
  hetab_tabulate_to_options options;
  hetab_tabulate_options sample;
  hetab_h5_options h5;
  hetab_exr_options exr;
  hetab_merl_options merl_options;
  const hetab_grid *grid;
  hetab_grid *own_grid;
  hetab_engine *engine, *own_engine;
  hetab_preload *preload;
  hetab_slab_fold *fold; /* of OpenEXR outputs; NULL: the delta is apart */
  output *outputs;
  size_t count;
  hetab_merl *merl;
  hetab_rgl *rgl;
  hetab_rgl_report rgl_report;
  hetab_report reports[HETAB_FORMAT_EXR + 1];
  hetab_held_files held;
} job;

static bool has(const job *job, hetab_format format) {
  for (size_t i = 0; i < job->count; i++)
    if (job->outputs[i].report.format == format)
      return true;
  return false;
}

static bool is_dense(const output *o) {
  return o->report.format == HETAB_FORMAT_H5 || o->report.format == HETAB_FORMAT_EXR;
}

/* Whether the delta is in the table, as a lobe: then no file of it may be beside. */
static bool is_folded(const job *job, const output *o) {
  const hetab_tabulate_to_options *to = &job->options;
  return o->report.format == HETAB_FORMAT_MERL  ? to->merl && to->merl->specular_cone > 0
         : o->report.format == HETAB_FORMAT_RGL ? to->rgl && to->rgl->specular_cone > 0
                                                : o->report.format == HETAB_FORMAT_EXR && job->fold;
}

static bool has_dense(const job *job) {
  return has(job, HETAB_FORMAT_H5) || has(job, HETAB_FORMAT_EXR);
}

static hetab_precision precision_of(const job *job) {
  const hetab_engine_options *o = job->options.engine;
  if (job->engine)
    return hetab_engine_precision(job->engine);
  return !o ? HETAB_FLOAT : o->method == HETAB_METHOD_LITERAL ? HETAB_DOUBLE : o->precision;
}

/* The wavelengths of a MERL table's channels; 0: the surface's, as colour. */
static size_t channel_count(const job *job, const output *o) {
  const hetab_merl_options *merl = job->options.merl;
  if (o->report.format != HETAB_FORMAT_MERL || !merl || merl->colour == HETAB_MERL_SRGB)
    return 0;
  return merl->colour == HETAB_MERL_MONO ? 1 : 3;
}

/* ---- outputs, before any work -------------------------------------------------------------- */

/* No two files of the job may be one; but tables of two formats may share the file of their delta,
 * where it is the same. */
static hetab_status check_distinct(const job *job, const output *a, const output *b) {
  hetab_context *ctx = job->ctx;
  bool same = a->report.format != b->report.format && !channel_count(job, a) &&
              !channel_count(job, b) && is_folded(job, a) == is_folded(job, b);
  const char *files_a[] = {a->path, a->specular}, *files_b[] = {b->path, b->specular};
  if (hetab_same_file(a->path, b->path))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s: the same output is given twice", b->path);
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++)
      if (files_a[i] && files_b[k] && !(i && k && same) && hetab_same_file(files_a[i], files_b[k]))
        return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                          "%s and %s would both write %s: give one another name", a->path, b->path,
                          files_b[k]);
  return HETAB_OK;
}

static hetab_status add_output(job *job, const char *path) {
  output *o = &job->outputs[job->count];
  o->path = path;
  if (!hetab_format_by_ending(path, &o->report.format))
    return hetab_fail(job->ctx, HETAB_ERR_ARGUMENT,
                      "%s: the name of an output ends in .h5, .hdf5, .exr, .binary or .bsdf", path);
  job->count++;
  if (!is_dense(o) && !(o->specular = hetab_specular_path(job->ctx, path)))
    return HETAB_ERR_MEMORY;
  for (output *other = job->outputs; other < o; other++)
    HETAB_TRY(check_distinct(job, other, o));
  return HETAB_OK;
}

static hetab_status add_outputs(job *job, const char *const *paths, size_t count) {
  if (!count)
    return hetab_fail(job->ctx, HETAB_ERR_ARGUMENT, "no outputs are given");
  job->outputs = hetab_alloc(job->ctx, count, sizeof *job->outputs);
  if (!job->outputs)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < count; i++)
    HETAB_TRY(add_output(job, paths[i]));
  for (size_t i = 0; i < count; i++) {
    const output *o = &job->outputs[i];
    int overwrite = job->options.overwrite;
    HETAB_TRY(hetab_output_check(job->ctx, paths[i], overwrite));
    if (o->specular) /* the same one may be there, of a table of another format */
      HETAB_TRY(hetab_output_check(job->ctx, o->specular, overwrite || !is_folded(job, o)));
  }
  return HETAB_OK;
}

/* ---- the specular reflectance -------------------------------------------------------------- */

/* rho_s[band][angle], and its largest; free() it. NULL on failure. */
static double *specular_table(job *job, const double *theta_i, size_t count, double *max) {
  size_t total = hetab_surface_band_count(job->surface) * count;
  double *rho = hetab_alloc(job->ctx, total, sizeof *rho);
  if (rho && hetab_specular_reflectance(job->ctx, job->surface, theta_i, count, rho) != HETAB_OK) {
    free(rho);
    rho = NULL;
  }
  for (size_t i = 0; rho && i < total; i++)
    *max = rho[i] > *max ? rho[i] : *max;
  return rho;
}

/* Unless an output before this one has written the same. */
static hetab_status save_specular(job *job, output *o) {
  double theta_i[HETAB_SPECULAR_ANGLES];
  bool written = false;
  for (int i = 0; i < HETAB_SPECULAR_ANGLES; i++)
    theta_i[i] = hetab_radians(i);
  for (const output *other = job->outputs; other < o; other++)
    written |= other->specular && hetab_same_file(other->specular, o->specular);
  double *rho = specular_table(job, theta_i, HETAB_SPECULAR_ANGLES, &o->report.specular_max);
  if (!rho)
    return HETAB_ERR_MEMORY;
  free(rho);
  if (written || is_folded(job, o))
    return HETAB_OK;
  return hetab_surface_specular_save(job->ctx, job->surface, job->merl_options.band_um,
                                     channel_count(job, o), o->specular, job->options.overwrite);
}

/* ---- dense tables -------------------------------------------------------------------------- */

static hetab_h5_options h5_options(const job *job) {
  hetab_h5_options h5 = {.element = precision_of(job)};
  if (job->options.h5)
    h5 = *job->options.h5;
  h5.slabs = precision_of(job);
  h5.overwrite = job->options.overwrite;
  return h5;
}

static hetab_status create_h5(job *job, output *o) {
  hetab_h5_options h5 = h5_options(job);
  return hetab_h5_create(job->ctx, o->path, job->surface, job->grid, &h5, &o->writer);
}

static hetab_status create_exr(job *job, output *o) {
  hetab_exr_options exr = job->exr;
  exr.slabs = hetab_engine_precision(job->engine);
  exr.method = hetab_engine_method(job->engine);
  exr.tolerance = hetab_engine_tolerance(job->engine);
  exr.device = hetab_engine_device(job->engine);
  exr.overwrite = job->options.overwrite;
  return hetab_exr_create(job->ctx, o->path, job->surface, job->grid, &exr, &o->writer);
}

static hetab_status create_of(job *job, hetab_format format, const double *rho, double max) {
  for (output *o = job->outputs; o < job->outputs + job->count; o++) {
    if (o->report.format != format)
      continue;
    HETAB_TRY(format == HETAB_FORMAT_H5 ? create_h5(job, o) : create_exr(job, o));
    HETAB_TRY(hetab_table_write_specular(job->ctx, o->writer, rho));
    o->report.specular_max = max;
  }
  return HETAB_OK;
}

static hetab_status create_writers(job *job) {
  size_t count = hetab_grid_count(job->grid, HETAB_THETA_I);
  double max = 0;
  double *rho = specular_table(job, hetab_grid_radians(job->grid, HETAB_THETA_I), count, &max);
  if (!rho)
    return HETAB_ERR_MEMORY;
  hetab_status status = create_of(job, HETAB_FORMAT_H5, rho, max);
  if (job->fold) /* what is in a table as a lobe is not beside it */
    memset(rho, 0, hetab_surface_band_count(job->surface) * count * sizeof *rho);
  if (status == HETAB_OK)
    status = create_of(job, HETAB_FORMAT_EXR, rho, max);
  free(rho);
  return status;
}

/* Of doubles, those that become floats in a file have to be floats. */
static bool slab_radiant(const job *job, const hetab_slab *slab) {
  const hetab_h5_options *h5 = job->options.h5;
  bool floats = has(job, HETAB_FORMAT_EXR) || (h5 && h5->element == HETAB_FLOAT);
  size_t count = slab->theta_i_count * hetab_grid_count(job->grid, HETAB_THETA_R) *
                 hetab_grid_count(job->grid, HETAB_PHI);
  return hetab_radiant(slab->values, count, precision_of(job), floats);
}

/* A slab goes to every HDF5 and OpenEXR output. A bad one stops the job: nothing is published. */
static hetab_status fan_out(hetab_context *ctx, void *user, const hetab_slab *slab) {
  job *job = user;
  if (!slab_radiant(job, slab))
    return hetab_fail(ctx, HETAB_ERR_DEVICE,
                      "NaN, infinite or negative entries: nothing written; please report this");
  hetab_slab folded = *slab;
  if (job->fold)
    HETAB_TRY(hetab_slab_fold_in(ctx, job->fold, slab, &folded));
  for (output *o = job->outputs; o < job->outputs + job->count; o++)
    if (o->writer)
      HETAB_TRY(hetab_table_write_slab(ctx, o->writer, is_folded(job, o) ? &folded : slab));
  return HETAB_OK;
}

/* ---- the work ------------------------------------------------------------------------------ */

static hetab_status fill_dense(job *job) {
  hetab_report *report = &job->reports[HETAB_FORMAT_H5];
  HETAB_TRY(hetab_tabulate(job->ctx, job->engine, job->surface, job->grid, &job->sample, fan_out,
                           job, report));
  job->reports[HETAB_FORMAT_EXR] = *report;
  return hetab_report_radiant(job->ctx, report);
}

static hetab_status fill_merl(job *job) {
  hetab_report *report = &job->reports[HETAB_FORMAT_MERL];
  HETAB_TRY(hetab_tabulate_merl(job->ctx, job->engine, job->surface, &job->merl_options, &job->merl,
                                report));
  return hetab_report_radiant(job->ctx, report);
}

static hetab_status fill_rgl(job *job) {
  double start = hetab_seconds();
  hetab_rgl_report *r = &job->rgl_report;
  HETAB_TRY(hetab_tabulate_rgl(job->ctx, job->surface, job->options.rgl, &job->rgl, r));
  job->reports[HETAB_FORMAT_RGL] =
      (hetab_report){.entries = (double)(r->theta_i_count * r->resolution * r->resolution *
                                         hetab_rgl_channel_count(job->rgl)),
                     .wall_seconds = hetab_seconds() - start};
  return HETAB_OK;
}

/* The files' layout and the engine, if one is needed; the OpenCL runtime loads meanwhile. OpenEXR
 * headers name the device, and come after it. */
static hetab_status prepare(job *job) {
  const hetab_engine_options *o = job->options.engine;
  bool exr = has(job, HETAB_FORMAT_EXR);
  bool make_engine = !job->engine && (has_dense(job) || has(job, HETAB_FORMAT_MERL));
  if (make_engine && !(o && o->method == HETAB_METHOD_LITERAL))
    job->preload = hetab_preload_create();
  if (!job->options.grid)
    HETAB_TRY(hetab_grid_create(job->ctx, &job->own_grid));
  job->grid = job->own_grid ? job->own_grid : job->options.grid;
  if (exr && job->exr.specular_cone > 0.0)
    HETAB_TRY(hetab_slab_fold_create(job->ctx, job->surface, job->grid, job->exr.specular_cone,
                                     precision_of(job), &job->fold));
  if (has(job, HETAB_FORMAT_H5) && !exr)
    HETAB_TRY(create_writers(job));
  if (make_engine) {
    HETAB_TRY(hetab_engine_create(job->ctx, job->options.engine, &job->own_engine));
    job->engine = job->own_engine;
  }
  return exr ? create_writers(job) : HETAB_OK;
}

/* What the grid makes of the surface, whatever the numbers of its nodes. */
static hetab_status try_grid(job *job) {
  hetab_grid_report report = {0};
  if (has_dense(job))
    HETAB_TRY(hetab_grid_try(job->ctx, job->surface, job->grid, &report));
  for (output *o = job->outputs; o < job->outputs + job->count; o++)
    if (is_dense(o))
      o->report.grid = report;
  return HETAB_OK;
}

/* MERL before dense tables: it can refuse, and is the shorter job. */
static hetab_status fill(job *job) {
  if (has(job, HETAB_FORMAT_RGL))
    HETAB_TRY(fill_rgl(job));
  if (has(job, HETAB_FORMAT_MERL))
    HETAB_TRY(fill_merl(job));
  return has_dense(job) ? fill_dense(job) : HETAB_OK;
}

/* ---- publication --------------------------------------------------------------------------- */

/* Of the file's numbers. */
static hetab_error_stats file_error(const job *job, const output *o) {
  const hetab_error_stats *error = &o->report.report.error;
  hetab_h5_options h5 = h5_options(job);
  if (o->report.format == HETAB_FORMAT_EXR)
    h5.element = HETAB_FLOAT;
  return is_dense(o) ? hetab_h5_error(&h5, error) : *error;
}

static hetab_status save_dense(job *job, output *o) {
  hetab_table_writer *writer = o->writer;
  o->writer = NULL;
  o->report.saturated = hetab_table_saturated_count(writer);
  hetab_status status = hetab_table_write_report(job->ctx, writer, &o->report.report);
  if (status == HETAB_OK)
    return hetab_table_commit(job->ctx, writer);
  hetab_table_abort(writer);
  return status;
}

static hetab_status save(job *job, output *o) {
  int overwrite = job->options.overwrite;
  o->report.report = job->reports[o->report.format];
  if (o->specular) /* first: no table is without it */
    HETAB_TRY(save_specular(job, o));
  if (o->report.format == HETAB_FORMAT_RGL) {
    o->report.rgl = job->rgl_report;
    HETAB_TRY(hetab_rgl_save(job->ctx, job->rgl, o->path, overwrite));
  } else if (o->report.format == HETAB_FORMAT_MERL)
    HETAB_TRY(hetab_merl_save(job->ctx, job->merl, o->path, overwrite));
  else
    HETAB_TRY(save_dense(job, o));
  o->report.report.error = file_error(job, o);
  o->held = job->held.count;
  return HETAB_OK;
}

/* What does not read back is not published. */
static hetab_status check_output(job *job, const output *o) {
  char reason[sizeof job->ctx->message];
  char *path = hetab_atomic_held_path(job->ctx, &job->held, o->held - 1);
  if (!path)
    return HETAB_ERR_MEMORY;
  size_t parts =
      job->exr.parts == HETAB_EXR_BY_WAVELENGTH ? 1 + hetab_surface_band_count(job->surface)
      : job->exr.parts == HETAB_EXR_ATLAS       ? 1
                                                : 1 + hetab_grid_count(job->grid, HETAB_THETA_I);
  hetab_status status = hetab_read_back(job->ctx, o->report.format, path, parts);
  free(path);
  if (status == HETAB_OK)
    return HETAB_OK;
  memcpy(reason, job->ctx->message, sizeof reason);
  return hetab_fail(job->ctx, HETAB_ERR_IO, "%s not written: what was written cannot be read: %s",
                    o->path, reason);
}

static hetab_status publish(job *job) {
  output *end = job->outputs + job->count;
  hetab_atomic_hold(job->ctx, &job->held);
  for (output *o = job->outputs; o < end; o++)
    HETAB_TRY(save(job, o));
  for (const output *o = job->outputs; o < end; o++)
    HETAB_TRY(check_output(job, o));
  HETAB_TRY(hetab_progress(job->ctx, 1, 1));
  hetab_status status = hetab_atomic_publish(job->ctx, &job->held);
  for (const output *o = job->outputs; o < end && status == HETAB_OK; o++)
    if (o->specular && is_folded(job, o))
      unlink(o->specular); /* of an earlier table: readers would add it */
  for (output *o = job->outputs; o < end; o++)
    o->report.published = o->held <= job->held.published;
  return status;
}

/* ---- the interface ------------------------------------------------------------------------- */

static void clear(job *job) {
  hetab_atomic_drop(job->ctx, &job->held);
  for (output *o = job->outputs; o < job->outputs + job->count; o++) {
    hetab_table_abort(o->writer);
    free(o->specular);
  }
  free(job->outputs);
  hetab_merl_free(job->merl);
  hetab_rgl_free(job->rgl);
  hetab_slab_fold_free(job->fold);
  hetab_engine_free(job->own_engine);
  hetab_preload_free(job->preload);
  hetab_grid_free(job->own_grid);
}

/* The options of each format as this library knows them. */
static hetab_status take_nested(job *job) {
  hetab_tabulate_to_options *o = &job->options;
  HETAB_TRY(hetab_options_take(job->ctx, o->sample, &job->sample, sizeof job->sample));
  if (!o->sample)
    job->sample.seed = 1;
  HETAB_TRY(hetab_options_take(job->ctx, o->h5, &job->h5, sizeof job->h5));
  HETAB_TRY(hetab_options_take(job->ctx, o->exr, &job->exr, sizeof job->exr));
  HETAB_TRY(hetab_options_take(job->ctx, o->merl, &job->merl_options, sizeof job->merl_options));
  o->h5 = o->h5 ? &job->h5 : NULL;
  if (!o->merl)
    job->merl_options =
        (hetab_merl_options){.samples = job->sample.samples, .seed = job->sample.seed};
  return HETAB_OK;
}

hetab_status hetab_tabulate_to(hetab_context *ctx, hetab_engine *engine,
                               const hetab_surface *surface, const char *const *paths, size_t count,
                               const hetab_tabulate_to_options *options,
                               hetab_output_report *reports) {
  HETAB_OPTIONS(ctx, hetab_tabulate_to_options, own, options);
  job job = {.ctx = ctx, .surface = surface, .engine = engine, .options = own};
  HETAB_TRY(take_nested(&job));
  hetab_status status = add_outputs(&job, paths, count);
  if (status == HETAB_OK)
    status = prepare(&job);
  if (status == HETAB_OK)
    status = try_grid(&job);
  if (status == HETAB_OK)
    status = fill(&job);
  if (status == HETAB_OK)
    status = publish(&job);
  for (size_t i = 0; reports && i < count; i++)
    reports[i] = i < job.count ? job.outputs[i].report : (hetab_output_report){0};
  clear(&job);
  return status;
}
