#include <hetab/table.h>

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "core/option_size.h"
#include "table/h5_layout.h"
#include "table/table_writer.h"

typedef struct h5_writer {
  hetab_table_writer base;
  hetab_h5_descriptor descriptor;
  hetab_h5_options options;
  hid_t h5, slab_type;
  hetab_h5_layout layout;
} h5_writer;

/* What became of a step. A write that failed comes before whatever HDF5 makes of it. */
static hetab_status outcome(hetab_context *ctx, const h5_writer *writer, herr_t result,
                            const hetab_h5_errors *errors) {
  if (writer->descriptor.error)
    return hetab_atomic_fail(ctx, writer->base.file, writer->descriptor.error);
  if (result < 0)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': HDF5: %s",
                      hetab_atomic_path(writer->base.file), errors->text);
  return HETAB_OK;
}

/* ---- slabs --------------------------------------------------------------------------------- */

static herr_t put_slab(const h5_writer *w, const hetab_slab *slab) {
  hsize_t start[RANK] = {slab->wavelength, slab->theta_i_first, 0, 0};
  hsize_t count[RANK] = {1, slab->theta_i_count, w->base.count[HETAB_THETA_R],
                         w->base.count[HETAB_PHI]};
  hid_t memory = H5Screate_simple(RANK, count, NULL);
  hid_t space = H5Dget_space(w->layout.brdf);
  herr_t result = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL);
  if (result >= 0)
    result = H5Dwrite(w->layout.brdf, w->slab_type, memory, space, H5P_DEFAULT, slab->values);
  H5Sclose(space);
  H5Sclose(memory);
  return result;
}

static hetab_status write_slab(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_slab *slab) {
  h5_writer *w = (h5_writer *)writer;
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result = put_slab(w, slab);
  hetab_h5_errors_end(&errors);
  HETAB_TRY(outcome(ctx, w, result, &errors));
  hetab_atomic_start_sync(writer->file);
  return HETAB_OK;
}

static hetab_status write_specular(hetab_context *ctx, hetab_table_writer *writer,
                                   const double *rho_s) {
  h5_writer *w = (h5_writer *)writer;
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result =
      H5Dwrite(w->layout.specular, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, rho_s);
  hetab_h5_errors_end(&errors);
  return outcome(ctx, w, result, &errors);
}

/* ---- the report ---------------------------------------------------------------------------- */

/* Half a unit in the last place of a float, and of one just below the floor of 1e-9 / sr. */
static const double FLOAT_ROUNDING = 6e-8, FLOAT_ROUNDING_BELOW = 6e-17;

hetab_error_stats hetab_h5_error(const hetab_h5_options *options, const hetab_error_stats *error) {
  hetab_error_stats result = *error;
  if (options->slabs != HETAB_DOUBLE || options->element != HETAB_FLOAT)
    return result;
  if (result.compared) {
    result.max_rel += FLOAT_ROUNDING;
    result.p99_rel += FLOAT_ROUNDING;
    result.rms_rel = hypot(result.rms_rel, FLOAT_ROUNDING);
  }
  if (result.compared < result.samples)
    result.max_abs_below += FLOAT_ROUNDING_BELOW;
  return result;
}

static herr_t put_error(hid_t root, const hetab_error_stats *error) {
  if (hetab_h5_put_number(root, "error_max_sampled", error->max_rel) < 0 ||
      hetab_h5_put_number(root, "error_share_above", hetab_error_share_above(error)) < 0 ||
      hetab_h5_put_number(root, "error_p99_rel", error->p99_rel) < 0 ||
      hetab_h5_put_number(root, "error_rms_rel", error->rms_rel) < 0 ||
      hetab_h5_put_number(root, "error_max_abs_below_floor", error->max_abs_below) < 0 ||
      hetab_h5_put_number(root, "error_samples", (double)error->samples) < 0)
    return -1;
  return hetab_h5_put_number(root, "error_compared", (double)error->compared);
}

static herr_t put_report(const h5_writer *w, const hetab_report *report) {
  hetab_error_stats error = hetab_h5_error(&w->options, &report->error);
  if (hetab_h5_put_text(w->h5, "method", hetab_method_name(report->method)) < 0 ||
      hetab_h5_put_text(w->h5, "precision", hetab_precision_name(report->precision)) < 0 ||
      hetab_h5_put_text(w->h5, "device", report->device) < 0 ||
      hetab_h5_put_number(w->h5, "tolerance", report->tolerance) < 0)
    return -1;
  return put_error(w->h5, &error);
}

static hetab_status write_report(hetab_context *ctx, hetab_table_writer *writer,
                                 const hetab_report *report) {
  h5_writer *w = (h5_writer *)writer;
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result = put_report(w, report);
  hetab_h5_errors_end(&errors);
  return outcome(ctx, w, result, &errors);
}

/* ---- the end ------------------------------------------------------------------------------- */

/* Everything out of HDF5's hands: datasets that are still open are closed with the file. */
static herr_t close_table(h5_writer *w) {
  herr_t result = w->h5 < 0 ? 0 : H5Fclose(w->h5);
  w->h5 = H5I_INVALID_HID;
  return result;
}

static hetab_status finish(hetab_context *ctx, hetab_table_writer *writer) {
  h5_writer *w = (h5_writer *)writer;
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result = close_table(w);
  hetab_h5_errors_end(&errors);
  return outcome(ctx, w, result, &errors);
}

/* What HDF5 still holds back goes nowhere, as after a failed write. */
static void clear(hetab_table_writer *writer) {
  h5_writer *w = (h5_writer *)writer;
  hetab_h5_errors errors;
  w->descriptor.error = ECANCELED;
  hetab_h5_errors_begin(&errors);
  close_table(w);
  hetab_h5_errors_end(&errors);
}

/* ---- the beginning ------------------------------------------------------------------------- */

static hetab_status check_options(hetab_context *ctx, const hetab_h5_options *options) {
  if (options->compression < 0 || options->compression > 9)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "the compression level is %d; give 0 (none) to 9 (smallest)",
                      options->compression);
  if (options->compression && H5Zfilter_avail(H5Z_FILTER_DEFLATE) <= 0)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "this HDF5 library was built without deflate; write uncompressed tables");
  return HETAB_OK;
}

/* The file's structure, and the disk space that is known to be needed. */
static hetab_status begin_table(hetab_context *ctx, h5_writer *w, const hetab_h5_head *head,
                                const hetab_grid *grid) {
  hetab_h5_errors errors;
  hsize_t size = 0;
  herr_t result = -1;
  hetab_status status = HETAB_OK;
  hetab_h5_errors_begin(&errors);
  w->h5 = hetab_h5_file_create(&w->descriptor);
  if (w->h5 >= 0)
    status = hetab_h5_lay_out(ctx, w->h5, head, grid, &w->options, &w->layout, &result);
  if (result >= 0)
    result = H5Fget_filesize(w->h5, &size);
  hetab_h5_errors_end(&errors);
  HETAB_TRY(status);
  HETAB_TRY(outcome(ctx, w, result, &errors));
  return hetab_atomic_reserve(ctx, w->base.file, size);
}

hetab_status hetab_h5_create_from(hetab_context *ctx, const char *path, const hetab_h5_head *head,
                                  const hetab_grid *grid, const hetab_h5_options *options,
                                  hetab_table_writer **out) {
  static const hetab_table_class class = {write_slab, write_specular, write_report, finish, clear};
  hetab_status status;
  *out = NULL;
  HETAB_TRY(check_options(ctx, options));
  h5_writer *w = hetab_alloc(ctx, 1, sizeof *w);
  HETAB_NEED(w);
  w->h5 = H5I_INVALID_HID;
  w->options = *options;
  w->slab_type = options->slabs == HETAB_FLOAT ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
  HETAB_GOTO(
      hetab_table_begin(ctx, &w->base, &class, path, options->overwrite, head->channels, grid));
  w->descriptor.fd = hetab_atomic_fd(w->base.file);
  HETAB_GOTO(begin_table(ctx, w, head, grid));
  *out = &w->base;
  return HETAB_OK;
done:
  hetab_table_abort(&w->base);
  return status;
}

hetab_status hetab_h5_create(hetab_context *ctx, const char *path, const hetab_surface *surface,
                             const hetab_grid *grid, const hetab_h5_options *options,
                             hetab_table_writer **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_h5_options, own, options);
  size_t count = hetab_surface_band_count(surface);
  HETAB_FREED double *lambda_um = hetab_alloc(ctx, count, sizeof *lambda_um);
  HETAB_NEED(lambda_um);
  for (size_t i = 0; i < count; i++)
    lambda_um[i] = hetab_surface_bands(surface)[i].lambda_um;
  hetab_h5_head head = {.name = hetab_surface_name(surface),
                        .sigma0_um = hetab_surface_sigma0_um(surface),
                        .tau_um = hetab_surface_tau_um(surface),
                        .index_source = hetab_index_source(hetab_surface_index(surface)),
                        .channels = count,
                        .lambda_um = lambda_um,
                        .bands = hetab_surface_bands(surface)};
  return hetab_h5_create_from(ctx, path, &head, grid, &own, out);
}
