#include "table/h5_copy.h"

#include <errno.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/context.h"
#include "core/input_file.h"
#include "core/atomic_file.h"
#include "table/h5_common.h"

enum { RANK = 4, BUFFER_BYTES = 1 << 20 };

struct hetab_h5_copy {
  hetab_atomic_file *file;
  hetab_h5_descriptor descriptor;
  hid_t h5, brdf;
};

static hetab_status copy_bytes(hetab_context *ctx, int from, const char *source,
                               hetab_atomic_file *to) {
  hetab_status status = HETAB_OK;
  HETAB_FREED char *buffer = hetab_alloc(ctx, BUFFER_BYTES, 1);
  HETAB_NEED(buffer);
  for (ssize_t count = 1; count != 0 && status == HETAB_OK;) {
    count = read(from, buffer, BUFFER_BYTES);
    if (count > 0)
      status = hetab_atomic_write(ctx, to, buffer, (size_t)count);
    else if (count < 0 && errno != EINTR)
      status = hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", source);
  }
  return status;
}

static hetab_status copy_file(hetab_context *ctx, const char *source, hetab_atomic_file *to) {
  int from;
  HETAB_TRY(hetab_input_open(ctx, source, HETAB_INPUT_TABLE, &from));
  hetab_status status = copy_bytes(ctx, from, source, to);
  close(from);
  return status;
}

/* What became of a step. A write that failed comes before whatever HDF5 makes of it. */
static hetab_status outcome(hetab_context *ctx, const hetab_h5_copy *copy, int failed,
                            const hetab_h5_errors *errors) {
  if (copy->descriptor.error)
    return hetab_atomic_fail(ctx, copy->file, copy->descriptor.error);
  if (failed)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': HDF5: %s",
                      hetab_atomic_path(copy->file), errors->text);
  return HETAB_OK;
}

static hetab_status open_copy(hetab_context *ctx, const char *source, hetab_h5_copy *copy) {
  hetab_h5_errors errors;
  hsize_t dims[RANK];
  hetab_h5_errors_begin(&errors);
  copy->descriptor.fd = hetab_atomic_fd(copy->file);
  copy->h5 = hetab_h5_file_update(&copy->descriptor);
  hetab_status status = outcome(ctx, copy, copy->h5 < 0, &errors);
  if (status == HETAB_OK)
    status = hetab_h5_dataset_open(ctx, copy->h5, source, "brdf", RANK, dims, &copy->brdf);
  hetab_h5_errors_end(&errors);
  return status;
}

hetab_status hetab_h5_copy_create(hetab_context *ctx, const char *source, const char *path,
                                  int overwrite, hetab_h5_copy **out) {
  hetab_status status;
  *out = NULL;
  hetab_h5_copy *copy = hetab_alloc(ctx, 1, sizeof *copy);
  HETAB_NEED(copy);
  copy->h5 = copy->brdf = H5I_INVALID_HID;
  HETAB_GOTO(hetab_atomic_create(ctx, path, overwrite, &copy->file));
  HETAB_GOTO(copy_file(ctx, source, copy->file));
  HETAB_GOTO(open_copy(ctx, source, copy));
  *out = copy;
  return HETAB_OK;
done:
  hetab_h5_copy_abort(copy);
  return status;
}

static herr_t put_wavelength(const hetab_h5_copy *copy, size_t wavelength, const double *values) {
  hsize_t start[RANK] = {wavelength}, count[RANK];
  hid_t space = H5Dget_space(copy->brdf);
  herr_t result = H5Sget_simple_extent_dims(space, count, NULL) == RANK ? 0 : -1;
  count[0] = 1;
  hid_t memory = H5Screate_simple(RANK, count, NULL);
  if (result >= 0)
    result = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL);
  if (result >= 0)
    result = H5Dwrite(copy->brdf, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values);
  H5Sclose(memory);
  H5Sclose(space);
  return result;
}

hetab_status hetab_h5_copy_write(hetab_context *ctx, hetab_h5_copy *copy, size_t wavelength,
                                 const double *values) {
  hetab_h5_errors errors;
  hetab_h5_errors_begin(&errors);
  herr_t result = put_wavelength(copy, wavelength, values);
  hetab_h5_errors_end(&errors);
  return outcome(ctx, copy, result < 0, &errors);
}

/* Everything out of HDF5's hands: datasets that are still open are closed with the file. */
static int close_copy(hetab_h5_copy *copy, hetab_h5_errors *errors) {
  hetab_h5_errors_begin(errors);
  int failed = copy->h5 >= 0 && H5Fclose(copy->h5) < 0;
  copy->h5 = H5I_INVALID_HID;
  hetab_h5_errors_end(errors);
  return failed;
}

hetab_status hetab_h5_copy_commit(hetab_context *ctx, hetab_h5_copy *copy) {
  hetab_h5_errors errors;
  int failed = close_copy(copy, &errors);
  hetab_status status = outcome(ctx, copy, failed, &errors);
  if (status == HETAB_OK) {
    status = hetab_atomic_commit(ctx, copy->file);
    copy->file = NULL;
  }
  hetab_h5_copy_abort(copy);
  return status;
}

/* What HDF5 still holds back goes nowhere, as after a failed write. */
void hetab_h5_copy_abort(hetab_h5_copy *copy) {
  hetab_h5_errors errors;
  if (!copy)
    return;
  copy->descriptor.error = ECANCELED;
  close_copy(copy, &errors);
  hetab_atomic_abort(copy->file);
  free(copy);
}
