#include "table/table_writer.h"

#include <stdlib.h>

hetab_status hetab_table_begin(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_table_class *class, const char *path, int overwrite,
                               size_t channels, const hetab_grid *grid) {
  writer->class = class;
  writer->channels = channels;
  for (hetab_axis a = 0; a < HETAB_AXIS_COUNT; a++)
    writer->count[a] = hetab_grid_count(grid, a);
  writer->rows_left = channels * writer->count[HETAB_THETA_I];
  writer->written = hetab_alloc(ctx, writer->rows_left, 1);
  return writer->written ? hetab_atomic_create(ctx, path, overwrite, &writer->file)
                         : HETAB_ERR_MEMORY;
}

static hetab_status check_slab(hetab_context *ctx, const hetab_table_writer *w,
                               const hetab_slab *slab) {
  size_t rows = w->count[HETAB_THETA_I];
  if (slab->wavelength >= w->channels || slab->theta_i_first >= rows || !slab->theta_i_count ||
      slab->theta_i_count > rows - slab->theta_i_first)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "a slab of wavelength %zu, theta_i %zu and %zu more is not in the table of "
                      "%zu wavelengths and %zu theta_i",
                      slab->wavelength, slab->theta_i_first, slab->theta_i_count, w->channels,
                      rows);
  for (size_t i = 0; i < slab->theta_i_count; i++)
    if (w->written[slab->wavelength * rows + slab->theta_i_first + i])
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "theta_i %zu of wavelength %zu is given twice to '%s'",
                        slab->theta_i_first + i, slab->wavelength, hetab_atomic_path(w->file));
  return HETAB_OK;
}

hetab_status hetab_table_write_slab(hetab_context *ctx, void *user, const hetab_slab *slab) {
  hetab_table_writer *w = user;
  HETAB_TRY(check_slab(ctx, w, slab));
  HETAB_TRY(w->class->slab(ctx, w, slab));
  for (size_t i = 0; i < slab->theta_i_count; i++)
    w->written[slab->wavelength * w->count[HETAB_THETA_I] + slab->theta_i_first + i] = 1;
  w->rows_left -= slab->theta_i_count;
  return HETAB_OK;
}

hetab_status hetab_table_write_specular(hetab_context *ctx, hetab_table_writer *w,
                                        const double *rho_s) {
  HETAB_TRY(w->class->specular(ctx, w, rho_s));
  w->specular_written = true;
  return HETAB_OK;
}

hetab_status hetab_table_write_report(hetab_context *ctx, hetab_table_writer *w,
                                      const hetab_report *report) {
  return w->class->report(ctx, w, report);
}

size_t hetab_table_saturated_count(const hetab_table_writer *w) {
  return w->saturated;
}

/* Everything but the publication; frees the writer, whatever the outcome. */
static hetab_status finish(hetab_context *ctx, hetab_table_writer *w, hetab_atomic_file **out) {
  hetab_status status = HETAB_OK;
  *out = NULL;
  if (w->rows_left || !w->specular_written)
    status = hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "'%s' not written: %zu theta_i rows%s are missing from the table",
                        hetab_atomic_path(w->file), w->rows_left,
                        w->specular_written ? "" : " and the specular reflectance");
  if (status == HETAB_OK)
    status = w->class->finish(ctx, w);
  if (status == HETAB_OK) {
    *out = w->file;
    w->file = NULL;
  }
  hetab_table_abort(w);
  return status;
}

hetab_status hetab_table_commit(hetab_context *ctx, hetab_table_writer *w) {
  hetab_atomic_file *file;
  HETAB_TRY(finish(ctx, w, &file));
  return hetab_atomic_commit(ctx, file);
}

void hetab_table_abort(hetab_table_writer *w) {
  if (!w)
    return;
  w->class->clear(w);
  hetab_atomic_abort(w->file);
  free(w->written);
  free(w);
}
