/* Audits and repairs of tables: which of the two kinds a file is. */
#include <sys/stat.h>
#include <unistd.h>

#include <hetab/table.h>

#include "audit/repair.h"
#include "audit/table_audit.h"
#include "core/held_files.h"
#include "core/input_file.h"
#include "table/table_format.h"

/* What is no table of any kind is left to the reader of MERL tables, which says what is wrong. */
static hetab_status find_format(hetab_context *ctx, const char *path, bool *is_h5) {
  unsigned char start[HETAB_FORMAT_START];
  hetab_format format = HETAB_FORMAT_MERL;
  HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TABLE, start, sizeof start));
  hetab_format_by_start(start, &format);
  if (format == HETAB_FORMAT_RGL || format == HETAB_FORMAT_EXR)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED, "'%s' is an %s table: %s and audit that", path,
                      hetab_format_name(format),
                      format == HETAB_FORMAT_RGL ? "convert it to MERL or HDF5"
                                                 : "tabulate its surface as HDF5");
  *is_h5 = format == HETAB_FORMAT_H5;
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
  bool is_h5;
  hetab_audit *audit;
  *out = NULL;
  HETAB_TRY(hetab_audit_options_take(ctx, options, &o));
  HETAB_TRY(find_format(ctx, path, &is_h5));
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
  HETAB_TRY(find_format(ctx, path, &is_h5));
  if (hetab_same_file(path, out_path))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "'%s' is not repaired in place: give another name to write to", path);
  if (lookup == HETAB_READ_DEFAULT)
    lookup = is_h5 ? HETAB_READ_INTERPOLATE : HETAB_READ_TRUNCATE;
  return (is_h5 ? hetab_repair_h5 : hetab_repair_merl)(ctx, path, out_path, lookup, scale_energy,
                                                       overwrite, report);
}
