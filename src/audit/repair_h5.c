#include <hetab/table.h>

#include <math.h>
#include <stdlib.h>

#include "audit/dense_table.h"
#include "audit/repair.h"
#include "table/h5_copy.h"

/* Entries may be rounded to float on their way to the file. */
static const double target = 1 - 1e-6;

typedef struct job {
  hetab_context *ctx;
  hetab_h5_table *file;
  hetab_h5_copy *copy;
  hetab_dense_table table;
  double *specular; /* [wavelength][theta_i] */
  double *scale;    /* [theta_i] */
  int scale_energy, same_axes;
  hetab_repair_report *report;
} job;

static void mend_entries(job *j) {
  const hetab_dense_table *t = &j->table;
  size_t phis = t->count[HETAB_PHI];
  for (size_t i = 0; i < t->count[HETAB_THETA_I]; i++)
    for (size_t r = 0; r < t->count[HETAB_THETA_R]; r++)
      hetab_repair_row(hetab_dense_table_at(t, i, r, 0), phis, j->report);
  for (size_t i = 0; i < t->count[HETAB_THETA_I] && j->same_axes; i++)
    for (size_t r = 0; r < i; r++)
      for (size_t p = 0; p < phis; p++)
        hetab_repair_pair(hetab_dense_table_at(t, i, r, p), hetab_dense_table_at(t, r, i, p),
                          j->report);
}

/* min(s_i, s_r) <= s_i: every incidence comes down at least as far as it has to. */
static void scale_entries(job *j, size_t wavelength) {
  const hetab_dense_table *t = &j->table;
  size_t incidences = t->count[HETAB_THETA_I];
  for (size_t i = 0; i < incidences; i++)
    j->scale[i] = hetab_repair_scale(hetab_dense_table_energy(t, i),
                                     target - j->specular[wavelength * incidences + i], j->report);
  for (size_t i = 0; i < incidences; i++)
    for (size_t r = 0; r < t->count[HETAB_THETA_R]; r++) {
      double factor = j->same_axes ? fmin(j->scale[i], j->scale[r]) : j->scale[i];
      for (size_t p = 0; p < t->count[HETAB_PHI] && factor < 1; p++)
        *hetab_dense_table_at(t, i, r, p) *= factor;
    }
}

static hetab_status mend_wavelength(job *j, size_t wavelength) {
  HETAB_TRY(hetab_h5_read(j->ctx, j->file, wavelength, j->table.values));
  mend_entries(j);
  if (j->scale_energy)
    scale_entries(j, wavelength);
  return hetab_h5_copy_write(j->ctx, j->copy, wavelength, j->table.values);
}

static hetab_status run(job *j, const char *path, const char *out_path, hetab_reading lookup,
                        int overwrite) {
  HETAB_TRY(hetab_h5_open_any(j->ctx, path, &j->file));
  HETAB_TRY(hetab_dense_table_create(j->ctx, hetab_h5_grid(j->file), lookup, &j->table));
  size_t count = hetab_h5_wavelength_count(j->file), incidences = j->table.count[HETAB_THETA_I];
  j->same_axes = hetab_dense_table_same_axes(&j->table);
  j->specular = hetab_alloc(j->ctx, count * incidences, sizeof *j->specular);
  j->scale = hetab_alloc(j->ctx, incidences, sizeof *j->scale);
  HETAB_NEED(j->specular && j->scale);
  HETAB_TRY(hetab_h5_read_specular(j->ctx, j->file, j->specular));
  HETAB_TRY(hetab_h5_copy_create(j->ctx, path, out_path, overwrite, &j->copy));
  for (size_t w = 0; w < count; w++) {
    HETAB_TRY(mend_wavelength(j, w));
    HETAB_TRY(hetab_progress(j->ctx, (double)(w + 1), (double)count));
  }
  hetab_h5_copy *copy = j->copy;
  j->copy = NULL;
  return hetab_h5_copy_commit(j->ctx, copy);
}

hetab_status hetab_repair_h5(hetab_context *ctx, const char *path, const char *out_path,
                             hetab_reading lookup, int scale_energy, int overwrite,
                             hetab_repair_report *report) {
  job j = {.ctx = ctx, .scale_energy = scale_energy, .report = report};
  hetab_status status = run(&j, path, out_path, lookup, overwrite);
  hetab_h5_copy_abort(j.copy);
  hetab_dense_table_clear(&j.table);
  hetab_h5_free(j.file);
  free(j.specular);
  free(j.scale);
  return status;
}
