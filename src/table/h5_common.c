#include "table/h5_common.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

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
  if (!file)
    return NULL;
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

/* Bytes past the end of the file are zero, as HDF5 wants them. */
static herr_t driver_read(H5FD_t *base, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t size,
                          void *data) {
  int fd = ((driver_file *)base)->descriptor->fd;
  char *next = data;
  while (size) {
    ssize_t count = pread(fd, next, size, (off_t)address);
    if (count < 0 && errno != EINTR)
      return -1;
    if (count == 0) {
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

/* Access through the driver; the oldest file format that holds the table, for old readers. */
static hid_t access_list(hetab_h5_descriptor *descriptor) {
  hid_t id = H5FDregister(&driver);
  hid_t list = H5Pcreate(H5P_FILE_ACCESS);
  herr_t set = H5Pset_driver(list, id, &descriptor);
  H5FDunregister(id); /* the list keeps it */
  if (set < 0 || H5Pset_libver_bounds(list, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18) < 0) {
    H5Pclose(list);
    return H5I_INVALID_HID;
  }
  return list;
}

hid_t hetab_h5_file_create(hetab_h5_descriptor *descriptor) {
  hid_t list = access_list(descriptor);
  hid_t file = H5Fcreate("table", H5F_ACC_TRUNC, H5P_DEFAULT, list);
  H5Pclose(list);
  return file;
}

static hid_t open_file(hetab_h5_descriptor *descriptor, unsigned access) {
  hid_t list = access_list(descriptor);
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
