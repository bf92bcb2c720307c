/* The audit of a dense HDF5 table, wavelength by wavelength. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/table.h>

#include "audit/dense_table.h"
#include "audit/dense_cells.h"
#include "audit/pairs.h"
#include "audit/separability.h"
#include "audit/table_audit.h"
#include "audit/views.h"
#include "table/specular.h"

/* Rounding of the sum over a table's entries, relative. */
static const double sum_error = 1e-12;

typedef struct job {
  hetab_context *ctx;
  hetab_engine *engine;
  const hetab_audit_options *options;
  hetab_audit *audit;
  hetab_h5_table *file;
  hetab_dense_table table;
  hetab_dense_survey survey;
  hetab_model model; /* without bands: none */
  hetab_pairs *pairs;
  double *specular; /* [wavelength][theta_i], the file's */
} job;

/* ---- opening ------------------------------------------------------------------------------- */

static hetab_status describe(job *j) {
  hetab_audit *audit = j->audit;
  const hetab_grid *grid = hetab_h5_grid(j->file);
  size_t bands = hetab_h5_wavelength_count(j->file);
  HETAB_TRY(hetab_audit_size(j->ctx, audit, bands, hetab_grid_count(grid, HETAB_THETA_I)));
  memcpy(audit->theta_i, hetab_grid_radians(grid, HETAB_THETA_I),
         audit->theta_count * sizeof *audit->theta_i);
  const double *lambda_um = hetab_h5_wavelengths_um(j->file); /* NULL: linear sRGB */
  if (lambda_um)
    audit->lambda_um = hetab_alloc(j->ctx, bands, sizeof *audit->lambda_um);
  j->specular = hetab_alloc(j->ctx, bands * audit->theta_count, sizeof *j->specular);
  if ((lambda_um && !audit->lambda_um) || !j->specular)
    return HETAB_ERR_MEMORY;
  if (lambda_um)
    memcpy(audit->lambda_um, lambda_um, bands * sizeof *audit->lambda_um);
  audit->view_channel = bands / 2;
  audit->specular_cone = hetab_specular_cone_of_h5(j->ctx, j->file);
  return hetab_h5_read_specular(j->ctx, j->file, j->specular);
}

static void note_dims(job *j) {
  j->audit->dims[0] = hetab_h5_wavelength_count(j->file);
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    j->audit->dims[axis + 1] = hetab_grid_count(hetab_h5_grid(j->file), (hetab_axis)axis);
}

static hetab_status model_of_file(job *j) {
  size_t count = j->audit->channel_count;
  HETAB_FREED hetab_band *bands = hetab_alloc(j->ctx, count, sizeof *bands);
  HETAB_NEED(bands);
  HETAB_TRY(hetab_h5_bands(j->ctx, j->file, bands));
  return hetab_model_of_bands(j->ctx, j->options->against, j->audit->sigma0_um, j->audit->tau_um,
                              bands, count, &j->model);
}

/* The surface given, or the file's parameters. A file without them is compared with nothing. */
static hetab_status open_model(job *j) {
  hetab_audit *audit = j->audit;
  int known = audit->lambda_um &&
              hetab_h5_number(j->ctx, j->file, "sigma0_um", &audit->sigma0_um) == HETAB_OK &&
              hetab_h5_number(j->ctx, j->file, "tau_um", &audit->tau_um) == HETAB_OK &&
              audit->sigma0_um > 0 && audit->tau_um > 0;
  if (j->options->no_reference || (!known && !j->options->against))
    return HETAB_OK;
  HETAB_TRY(audit->lambda_um ? model_of_file(j)
                             : hetab_model_of_colour(j->ctx, j->options, &j->model));
  audit->sigma0_um = j->model.sigma0_um;
  audit->tau_um = j->model.tau_um;
  audit->against = hetab_alloc(j->ctx, 1, sizeof *audit->against);
  j->pairs = hetab_alloc(j->ctx, 1, sizeof *j->pairs);
  HETAB_NEED(audit->against && j->pairs);
  audit->against->specular_apart = !(audit->specular_cone > 0.0);
  j->pairs->random = j->options->seed;
  return HETAB_OK;
}

/* ---- one wavelength ------------------------------------------------------------------------ */

static void read_pair(const void *user, size_t first, double theta_i, double theta_r, double phi,
                      double *channels) {
  *channels = hetab_dense_table_read(user, theta_i, theta_r, phi);
}

static double read_view(const void *user, double theta_i, double theta_r, double phi) {
  return hetab_dense_table_read(user, theta_i, theta_r, phi);
}

/* The file's rho_s; what cannot be one is 0, and found. */
static double good_specular(job *j, size_t wavelength, size_t theta) {
  double value = j->specular[wavelength * j->audit->theta_count + theta];
  if (value >= 0 && isfinite(value))
    return value;
  hetab_cells *cells = &j->audit->cells;
  cells->nan += isnan(value) != 0;
  cells->infinite += isinf(value) != 0;
  cells->negative += value < 0 && isfinite(value);
  char *where = isfinite(value) ? j->survey.negative : j->survey.finite, channel[24];
  if (!*where)
    snprintf(where, HETAB_DENSE_WHERE,
             "; first in specular_reflectance at theta_i %.6g deg, %s: %g",
             hetab_degrees(j->audit->theta_i[theta]),
             hetab_audit_channel(j->audit, wavelength, channel), value);
  return 0;
}

static void fill_energy(job *j, size_t wavelength) {
  for (size_t t = 0; t < j->audit->theta_count; t++) {
    hetab_energy *e = hetab_audit_energy(j->audit, wavelength, t);
    e->dd = hetab_dense_table_energy(&j->table, t);
    e->specular = good_specular(j, wavelength, t);
    e->dh = e->dd + e->specular;
    e->error = sum_error * fabs(e->dh);
  }
}

static hetab_status view_wavelength(job *j, size_t wavelength) {
  if (!j->options->views || wavelength != j->audit->view_channel)
    return HETAB_OK;
  HETAB_TRY(hetab_views_of_table(j->ctx, j->audit, read_view, &j->table));
  if (!j->model.bands)
    return HETAB_OK;
  return hetab_views_of_model(j->ctx, j->engine, j->model.sigma0_um, j->model.tau_um,
                              j->model.bands, j->model.weights + wavelength * j->model.band_count,
                              j->model.band_count, j->audit);
}

/* Of one wavelength. */
static double entries_of(const job *j) {
  return (double)j->audit->dims[1] * (double)j->audit->dims[2] * (double)j->audit->dims[3];
}

static hetab_status take_wavelength(job *j, size_t wavelength) {
  HETAB_TRY(hetab_h5_read(j->ctx, j->file, wavelength, j->table.values));
  hetab_dense_survey_add(&j->table, wavelength, j->audit, &j->survey);
  fill_energy(j, wavelength);
  if (wavelength == j->audit->view_channel)
    HETAB_TRY(hetab_separability(j->ctx, &j->table, &j->audit->separability));
  HETAB_TRY(view_wavelength(j, wavelength));
  if (!j->pairs)
    return HETAB_OK;
  j->pairs->progress = entries_of(j) * (double)wavelength;
  j->pairs->progress_step = entries_of(j);
  j->pairs->progress_total = entries_of(j) * (double)j->audit->channel_count;
  return hetab_pairs_add(j->ctx, j->engine, &j->model, wavelength, 1,
                         j->options->pairs / j->audit->channel_count + 1, read_pair, &j->table,
                         j->pairs);
}

/* ---- the audit ----------------------------------------------------------------------------- */

static hetab_status judge(job *j) {
  const hetab_audit_options *o = j->options;
  hetab_dense_survey_judge(&j->table, o->max_asymmetry, j->audit, &j->survey);
  hetab_check_energy(j->audit, o->max_excess);
  if (!j->pairs)
    return HETAB_OK;
  HETAB_FREED double *specular = hetab_alloc(j->ctx, j->audit->channel_count, sizeof *specular);
  hetab_hush hush = hetab_hush_begin(j->ctx);
  hetab_status status = specular
                            ? hetab_model_energy(j->ctx, j->engine, &j->model, j->audit, specular)
                            : HETAB_ERR_MEMORY;
  hetab_hush_end(j->ctx, hush);
  if (status == HETAB_OK) {
    hetab_check_fresnel(j->audit, o->max_excess);
    hetab_pairs_finish(j->pairs, j->audit->against);
    hetab_audit_judge_against(o, specular, j->audit);
  }
  return status;
}

static hetab_status run(job *j) {
  size_t count = hetab_h5_wavelength_count(j->file);
  HETAB_TRY(describe(j));
  HETAB_TRY(
      hetab_dense_table_create(j->ctx, hetab_h5_grid(j->file), j->options->lookup, &j->table));
  HETAB_TRY(open_model(j));
  for (size_t w = 0; w < count; w++) {
    HETAB_TRY(take_wavelength(j, w));
    HETAB_TRY(
        hetab_progress(j->ctx, entries_of(j) * (double)(w + 1), entries_of(j) * (double)count));
  }
  return judge(j);
}

hetab_status hetab_audit_h5(hetab_context *ctx, hetab_engine *engine, const char *path,
                            const hetab_audit_options *o, hetab_audit *audit) {
  job j = {.ctx = ctx, .engine = engine, .options = o, .audit = audit};
  hetab_status opened = hetab_h5_open_any(ctx, path, &j.file);
  if (opened == HETAB_OK)
    note_dims(&j);
  hetab_status status = hetab_audit_structure(ctx, opened, audit);
  if (status == HETAB_OK && j.file)
    status = run(&j);
  if (status == HETAB_ERR_PARSE) { /* a chunk that cannot be read */
    audit->check_count = audit->channel_count = 0;
    status = hetab_audit_structure(ctx, HETAB_ERR_PARSE, audit);
  }
  hetab_dense_table_clear(&j.table);
  hetab_model_clear(&j.model);
  free(j.pairs);
  free(j.specular);
  hetab_h5_free(j.file);
  return status;
}
