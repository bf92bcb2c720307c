/* Audits and repairs of tables: which of the two kinds a file is. */
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "audit/repair.h"
#include "audit/table_audit.h"
#include "core/held_files.h"
#include "core/input_file.h"
#include "table/table_format.h"

static hetab_status is_h5_file(hetab_context *ctx, const char *path, bool *is_h5) {
  static const char signature[4] = {(char)0x89, 'H', 'D', 'F'};
  char start[sizeof signature];
  HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TABLE, start, sizeof start));
  *is_h5 = memcmp(start, signature, sizeof start) == 0;
  return HETAB_OK;
}

static hetab_status measure_file(hetab_context *ctx, const char *path, hetab_audit *audit) {
  int fd;
  struct stat about = {0};
  HETAB_TRY(hetab_input_open(ctx, path, HETAB_INPUT_TABLE, &fd));
  fstat(fd, &about);
  close(fd);
  audit->bytes = (unsigned long long)about.st_size;
  return HETAB_OK;
}

hetab_status hetab_audit_table(hetab_context *ctx, hetab_engine *engine, const char *path,
                               const hetab_audit_options *options, hetab_audit **out) {
  hetab_audit_options o;
  hetab_format format;
  bool is_h5;
  hetab_audit *audit;
  *out = NULL;
  HETAB_TRY(hetab_audit_options_take(ctx, options, &o));
  HETAB_TRY(is_h5_file(ctx, path, &is_h5));
  if (hetab_format_of(ctx, path, &format) == HETAB_OK && format == HETAB_FORMAT_RGL)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "'%s' is an RGL table: convert it to MERL or HDF5 and audit that", path);
  hetab_status status =
      hetab_audit_new(ctx, is_h5 ? HETAB_AUDIT_H5 : HETAB_AUDIT_MERL, path, &audit);
  if (status == HETAB_OK)
    status = measure_file(ctx, path, audit);
  if (status == HETAB_OK) {
    if (o.lookup == HETAB_READ_DEFAULT)
      o.lookup = is_h5 ? HETAB_READ_INTERPOLATE : HETAB_READ_TRUNCATE;
    audit->lookup = o.lookup;
    status = (is_h5 ? hetab_audit_h5 : hetab_audit_merl)(ctx, engine, path, &o, audit);
  }
  if (status == HETAB_OK)
    *out = audit;
  else
    hetab_audit_free(audit);
  return status;
}

hetab_status hetab_repair(hetab_context *ctx, const char *path, const char *out_path,
                          hetab_reading lookup, int scale_energy, int overwrite,
                          hetab_repair_report *report) {
  bool is_h5;
  *report = (hetab_repair_report){.smallest_scale = 1};
  HETAB_TRY(is_h5_file(ctx, path, &is_h5));
  if (hetab_same_file(path, out_path))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "'%s' is not repaired in place: give another name to write to", path);
  if (lookup == HETAB_READ_DEFAULT)
    lookup = is_h5 ? HETAB_READ_INTERPOLATE : HETAB_READ_TRUNCATE;
  return (is_h5 ? hetab_repair_h5 : hetab_repair_merl)(ctx, path, out_path, lookup, scale_energy,
                                                       overwrite, report);
}
