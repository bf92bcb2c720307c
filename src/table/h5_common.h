/* What the HDF5 writer and reader share: files on open descriptors, and errors. */
#pragma once

#include <hdf5.h>
#include <hetab/status.h>

#include "core/unit.h"

/* HDF5 keeps a file open, and tries again at exit, if a write fails while it closes it, or a read.
 * This driver therefore never tells it: the first failure is kept here, later writes go nowhere,
 * and whoever owns the descriptor looks at `error` before believing in what was written or read. */
typedef struct hetab_h5_descriptor {
  int fd;    /* not closed with the HDF5 file */
  int error; /* errno of the first call that failed; writes are dropped while it is not 0 */
} hetab_h5_descriptor;

/* A new table, or an existing one for reading or for changing, on the descriptor, which must
 * outlive the file. Negative on failure. */
hid_t hetab_h5_file_create(hetab_h5_descriptor *descriptor);
hid_t hetab_h5_file_open(hetab_h5_descriptor *descriptor);
hid_t hetab_h5_file_update(hetab_h5_descriptor *descriptor);

/* Opens the dataset `name` of the file, called `path` in messages, for its owner to close: rank
 * axes of floating-point numbers, their sizes in dims[rank]. What would make HDF5 look into other
 * files (external links, external storage, virtual datasets) is refused before it does, and so are
 * filters that it lacks. */
hetab_status hetab_h5_dataset_open(hetab_context *ctx, hid_t file, const char *path,
                                   const char *name, int rank, hsize_t *dims, hid_t *out);

/* The unit that the dataset's attribute `units` names, as hetab_unit() has it; without one, the
 * usual. */
hetab_status hetab_h5_unit(hetab_context *ctx, hid_t dataset, const char *path, const char *name,
                           hetab_quantity quantity, double usual, double *unit);

/* Between begin and end HDF5 prints no errors: the innermost message of the first is kept here.
 * The caller's own setting comes back after. */
typedef struct hetab_h5_errors {
  char text[200];
  H5E_auto2_t print;
  void *print_data;
} hetab_h5_errors;

void hetab_h5_errors_begin(hetab_h5_errors *errors);
void hetab_h5_errors_end(const hetab_h5_errors *errors);
