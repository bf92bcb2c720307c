/* Audits and repairs of tables: which of the two kinds a file is. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "audit/repair.h"
#include "audit/table_audit.h"
#include "core/atomic_file.h"
#include "table/table_format.h"

static int is_h5_file(const char *path) {
  static const char signature[4] = {(char)0x89, 'H', 'D', 'F'};
  char start[sizeof signature] = {0};
  FILE *file = fopen(path, "rbe");
  size_t count = file ? fread(start, 1, sizeof start, file) : 0;
  if (file)
    fclose(file);
  return count == sizeof start && memcmp(start, signature, sizeof start) == 0;
}

static hetab_status measure_file(hetab_context *ctx, const char *path, hetab_audit *audit) {
  struct stat about;
  if (stat(path, &about))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", path);
  if (!S_ISREG(about.st_mode))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': it is not a regular file", path);
  audit->bytes = (unsigned long long)about.st_size;
  return HETAB_OK;
}

hetab_status hetab_audit_table(hetab_context *ctx, hetab_engine *engine, const char *path,
                               const hetab_audit_options *options, hetab_audit **out) {
  hetab_audit_options o;
  hetab_format format;
  int is_h5 = is_h5_file(path);
  hetab_audit *audit;
  *out = NULL;
  HETAB_TRY(hetab_audit_options_take(ctx, options, &o));
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
  int is_h5 = is_h5_file(path);
  *report = (hetab_repair_report){.smallest_scale = 1};
  if (hetab_same_file(path, out_path))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "'%s' is not repaired in place: give another name to write to", path);
  if (lookup == HETAB_READ_DEFAULT)
    lookup = is_h5 ? HETAB_READ_INTERPOLATE : HETAB_READ_TRUNCATE;
  return (is_h5 ? hetab_repair_h5 : hetab_repair_merl)(ctx, path, out_path, lookup, scale_energy,
                                                       overwrite, report);
}
