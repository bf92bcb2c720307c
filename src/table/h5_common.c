#include "table/h5_common.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include "core/context.h"

/* --- the file driver ------------------------------------------------------------------------ */

typedef struct driver_file {
  H5FD_t base; /* HDF5's own part comes first */
  hetab_h5_descriptor *descriptor;
  haddr_t eoa, eof; /* end of what is allocated, end of what is there */
} driver_file;

static H5FD_t *driver_open(const char *name, unsigned flags, hid_t fapl, haddr_t max_address) {
  hetab_h5_descriptor *const *info = H5Pget_driver_info(fapl);
  struct stat about;
  if (!info || fstat((*info)->fd, &about))
    return NULL;
  driver_file *file = calloc(1, sizeof *file);
  if (!file) {
    (*info)->error = ENOMEM;
    return NULL;
  }
  file->descriptor = *info;
  file->eof = (haddr_t)about.st_size;
  return &file->base;
}

static herr_t driver_close(H5FD_t *base) {
  free(base);
  return 0;
}

static herr_t driver_query(const H5FD_t *base, unsigned long *features) {
  *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
              H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

static haddr_t driver_get_eoa(const H5FD_t *base, H5FD_mem_t type) {
  return ((const driver_file *)base)->eoa;
}

static herr_t driver_set_eoa(H5FD_t *base, H5FD_mem_t type, haddr_t address) {
  ((driver_file *)base)->eoa = address;
  return 0;
}

static haddr_t driver_get_eof(const H5FD_t *base, H5FD_mem_t type) {
  return ((const driver_file *)base)->eof;
}

/* Bytes past the end of the file are zero, as HDF5 wants them; so are those that cannot be read. */
static herr_t driver_read(H5FD_t *base, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t size,
                          void *data) {
  hetab_h5_descriptor *descriptor = ((driver_file *)base)->descriptor;
  char *next = data;
  while (size) {
    ssize_t count = pread(descriptor->fd, next, size, (off_t)address);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0 && !descriptor->error)
      descriptor->error = errno;
    if (count <= 0) {
      memset(next, 0, size);
      return 0;
    }
    if (count > 0) {
      next += count;
      address += (haddr_t)count;
      size -= (size_t)count;
    }
  }
  return 0;
}

static herr_t driver_write(H5FD_t *base, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t size,
                           const void *data) {
  driver_file *file = (driver_file *)base;
  const char *next = data;
  while (size && !file->descriptor->error) {
    ssize_t count = pwrite(file->descriptor->fd, next, size, (off_t)address);
    if (count < 0 && errno != EINTR)
      file->descriptor->error = errno;
    if (count > 0) {
      next += count;
      address += (haddr_t)count;
      size -= (size_t)count;
    }
  }
  if (address > file->eof)
    file->eof = address;
  return 0;
}

/* A file shorter or longer than what is allocated would be taken for a truncated one. */
static herr_t driver_truncate(H5FD_t *base, hid_t dxpl, hbool_t closing) {
  driver_file *file = (driver_file *)base;
  if (file->eoa == file->eof || file->descriptor->error)
    return 0;
  if (ftruncate(file->descriptor->fd, (off_t)file->eoa))
    file->descriptor->error = errno;
  file->eof = file->eoa;
  return 0;
}

static const H5FD_class_t driver = {
#if H5_VERSION_GE(1, 13, 0)
    .version = H5FD_CLASS_VERSION,
    .value = (H5FD_class_value_t)512, /* the first that is free for development */
#endif
    .name = "hetab_descriptor",
    .maxaddr = (haddr_t)INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(hetab_h5_descriptor *),
    .open = driver_open,
    .close = driver_close,
    .query = driver_query,
    .get_eoa = driver_get_eoa,
    .set_eoa = driver_set_eoa,
    .get_eof = driver_get_eof,
    .read = driver_read,
    .write = driver_write,
    .truncate = driver_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

/* Registered once, for the life of the process: HDF5 calls on it until the last file is closed, and
 * does not count files as users of it. */
static hid_t driver_id(void) {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  static hid_t id = H5I_INVALID_HID;
  pthread_mutex_lock(&mutex);
  if (H5Iget_type(id) != H5I_VFL) /* never yet, or gone with H5close() */
    id = H5FDregister(&driver);
  hid_t now = id;
  pthread_mutex_unlock(&mutex);
  return now;
}

/* Access through the driver, of formats up to `high`. */
static hid_t access_list(hetab_h5_descriptor *descriptor, H5F_libver_t high) {
  hid_t list = H5Pcreate(H5P_FILE_ACCESS);
  if (H5Pset_driver(list, driver_id(), &descriptor) < 0 ||
      H5Pset_libver_bounds(list, H5F_LIBVER_EARLIEST, high) < 0) {
    H5Pclose(list);
    return H5I_INVALID_HID;
  }
  return list;
}

/* The oldest file format that holds the table, for old readers. */
hid_t hetab_h5_file_create(hetab_h5_descriptor *descriptor) {
  hid_t list = access_list(descriptor, H5F_LIBVER_V18);
  hid_t file = H5Fcreate("table", H5F_ACC_TRUNC, H5P_DEFAULT, list);
  H5Pclose(list);
  return file;
}

static hid_t open_file(hetab_h5_descriptor *descriptor, unsigned access) {
  hid_t list = access_list(descriptor, H5F_LIBVER_LATEST);
  hid_t file = H5Fopen("table", access, list);
  H5Pclose(list);
  return file;
}

hid_t hetab_h5_file_open(hetab_h5_descriptor *descriptor) {
  return open_file(descriptor, H5F_ACC_RDONLY);
}

hid_t hetab_h5_file_update(hetab_h5_descriptor *descriptor) {
  return open_file(descriptor, H5F_ACC_RDWR);
}

/* --- datasets ------------------------------------------------------------------------------- */

enum { LARGEST_NUMBER = 16 }; /* bytes: long double */

static hetab_status no_table(hetab_context *ctx, const char *path, const char *name,
                             const char *what) {
  return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s' is no hetab table: /%s %s", path, name, what);
}

static herr_t follow_nothing(const char *file, const char *group, const char *child,
                             const char *object, unsigned *flags, hid_t access, void *user) {
  return -1;
}

/* -1 if there is none, or it is in another file. */
static hid_t open_inside(hid_t file, const char *name) {
  hid_t list = H5Pcreate(H5P_DATASET_ACCESS);
  H5Pset_elink_cb(list, follow_nothing, NULL);
  hid_t dataset = H5Dopen2(file, name, list);
  H5Pclose(list);
  return dataset;
}

static hetab_status check_filters(hetab_context *ctx, hid_t creation, const char *path,
                                  const char *name) {
  for (int i = 0; i < H5Pget_nfilters(creation); i++) {
    unsigned flags, config;
    size_t values = 0;
    char filter[64] = "";
    H5Z_filter_t id = H5Pget_filter2(creation, (unsigned)i, &flags, &values, NULL, sizeof filter,
                                     filter, &config);
    filter[sizeof filter - 1] = '\0';
    if (H5Zfilter_avail(id) <= 0)
      return hetab_fail(
          ctx, HETAB_ERR_UNSUPPORTED,
          "'%s': /%s is compressed with filter %d%s%s, which is not installed; install "
          "its plug-in, or rewrite the file where it is: h5repack -f NONE",
          path, name, (int)id, *filter ? ", " : "", filter);
  }
  return HETAB_OK;
}

static hetab_status check_storage(hetab_context *ctx, hid_t dataset, const char *path,
                                  const char *name) {
  hid_t creation = H5Dget_create_plist(dataset);
  H5D_layout_t layout = H5Pget_layout(creation);
  hetab_status status = check_filters(ctx, creation, path, name);
  if (layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT)
    status = no_table(ctx, path, name, "is neither chunked nor contiguous nor compact");
  else if (H5Pget_external_count(creation) != 0)
    status = no_table(ctx, path, name, "lies in other files");
  H5Pclose(creation);
  return status;
}

static hetab_status check_numbers(hetab_context *ctx, hid_t dataset, const char *path,
                                  const char *name) {
  hid_t type = H5Dget_type(dataset);
  bool sound = H5Tget_class(type) == H5T_FLOAT && H5Tget_size(type) <= LARGEST_NUMBER;
  H5Tclose(type);
  return sound ? HETAB_OK : no_table(ctx, path, name, "does not hold floating-point numbers");
}

static hetab_status check_rank(hetab_context *ctx, hid_t dataset, const char *path,
                               const char *name, int rank, hsize_t *dims) {
  hid_t space = H5Dget_space(dataset);
  int found = H5Sget_simple_extent_ndims(space);
  if (found == rank)
    H5Sget_simple_extent_dims(space, dims, NULL);
  H5Sclose(space);
  return found == rank ? HETAB_OK
                       : hetab_fail(ctx, HETAB_ERR_PARSE,
                                    "'%s' is no hetab table: /%s has %d dimensions in place of %d",
                                    path, name, found, rank);
}

/* The storage first: the rest looks into it. */
hetab_status hetab_h5_dataset_open(hetab_context *ctx, hid_t file, const char *path,
                                   const char *name, int rank, hsize_t *dims, hid_t *out) {
  hetab_status status;
  *out = H5I_INVALID_HID;
  if (H5Lexists(file, name, H5P_DEFAULT) <= 0)
    return no_table(ctx, path, name, "is missing");
  hid_t dataset = open_inside(file, name);
  if (dataset < 0)
    return no_table(ctx, path, name, "is not a dataset of this file");
  HETAB_GOTO(check_storage(ctx, dataset, path, name));
  HETAB_GOTO(check_rank(ctx, dataset, path, name, rank, dims));
  HETAB_GOTO(check_numbers(ctx, dataset, path, name));
  *out = dataset;
  return HETAB_OK;
done:
  H5Dclose(dataset);
  return status;
}

/* --- units ---------------------------------------------------------------------------------- */

/* A text of fixed or variable length; false if the attribute is none. */
static bool read_text(hid_t attribute, char *text, size_t size) {
  hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  bool sound = H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1;
  bool variable = sound && H5Tis_variable_str(type) > 0;
  char *read = NULL;
  if (variable && H5Aread(attribute, type, &read) >= 0 && read)
    snprintf(text, size, "%s", read);
  else if (sound && !variable && H5Tget_size(type) < size)
    sound = H5Aread(attribute, type, text) >= 0;
  else
    sound = false;
  H5free_memory(read);
  H5Sclose(space);
  H5Tclose(type);
  return sound;
}

hetab_status hetab_h5_unit(hetab_context *ctx, hid_t dataset, const char *path, const char *name,
                           hetab_quantity quantity, double usual, double *unit) {
  char text[64] = "";
  *unit = usual;
  if (H5Aexists(dataset, "units") <= 0)
    return HETAB_OK;
  hid_t attribute = H5Aopen(dataset, "units", H5P_DEFAULT);
  bool sound = attribute >= 0 && read_text(attribute, text, sizeof text);
  H5Aclose(attribute);
  *unit = sound ? hetab_unit(quantity, text) : 0.0;
  return *unit > 0.0 ? HETAB_OK
                     : hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                                  "'%s': the attribute units of /%s is '%s': give %s", path, name,
                                  text, quantity == HETAB_ANGLE ? "degree or rad" : "nm, um or m");
}

/* --- errors --------------------------------------------------------------------------------- */

/* H5Ewalk2 goes from the innermost message outwards, and stops at the first. */
static herr_t copy_message(unsigned n, const H5E_error2_t *error, void *text) {
  snprintf(text, sizeof((hetab_h5_errors *)0)->text, "%s", error->desc ? error->desc : "");
  return 1;
}

static herr_t keep_first(hid_t stack, void *data) {
  hetab_h5_errors *errors = data;
  if (!*errors->text)
    H5Ewalk2(stack, H5E_WALK_UPWARD, copy_message, errors->text);
  return 0;
}

void hetab_h5_errors_begin(hetab_h5_errors *errors) {
  errors->text[0] = '\0';
  H5Eget_auto2(H5E_DEFAULT, &errors->print, &errors->print_data);
  H5Eset_auto2(H5E_DEFAULT, keep_first, errors);
}

void hetab_h5_errors_end(const hetab_h5_errors *errors) {
  H5Eset_auto2(H5E_DEFAULT, errors->print, errors->print_data);
}
