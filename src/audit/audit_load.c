/* Audits and repairs of tables: which of the formats a file has. */
#include <stdbool.h>
#include <sys/stat.h>
#include <unistd.h>

#include <hetab/table.h>

#include "audit/repair.h"
#include "audit/table_audit.h"
#include "core/held_files.h"
#include "core/input_file.h"
#include "table/table_format.h"

/* By content; what has no telling one, but the name of a table, is one that is damaged. */
static hetab_status find_format(hetab_context *ctx, const char *path, hetab_format *out) {
  unsigned char start[HETAB_FORMAT_START];
  HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TABLE, start, sizeof start));
  bool known = hetab_format_by_start(start, out) || hetab_format_by_ending(path, out);
  return known && *out != HETAB_FORMAT_EXR ? HETAB_OK : hetab_format_of(ctx, path, out);
}

/* What each format's audit is, and how its readers read. */
static const struct {
  hetab_audit_kind kind;
  hetab_status (*audit)(hetab_context *ctx, hetab_engine *engine, const char *path,
                        const hetab_audit_options *options, hetab_audit *audit);
  hetab_reading lookup;
} FORMATS[] = {
    [HETAB_FORMAT_H5] = {HETAB_AUDIT_H5, hetab_audit_h5, HETAB_READ_INTERPOLATE},
    [HETAB_FORMAT_MERL] = {HETAB_AUDIT_MERL, hetab_audit_merl, HETAB_READ_TRUNCATE},
    [HETAB_FORMAT_RGL] = {HETAB_AUDIT_RGL, hetab_audit_lookup, HETAB_READ_INTERPOLATE},
};

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
  hetab_audit *audit;
  *out = NULL;
  HETAB_TRY(hetab_audit_options_take(ctx, options, &o));
  HETAB_TRY(find_format(ctx, path, &format));
  hetab_status status = hetab_audit_new(ctx, FORMATS[format].kind, path, &audit);
  if (status == HETAB_OK)
    status = measure_file(ctx, path, audit);
  if (status == HETAB_OK) {
    if (o.lookup == HETAB_READ_DEFAULT || format == HETAB_FORMAT_RGL)
      o.lookup = FORMATS[format].lookup;
    audit->lookup = o.lookup;
    status = FORMATS[format].audit(ctx, engine, path, &o, audit);
  }
  *out = audit;
  HETAB_MADE(hetab_audit, out, status);
}

hetab_status hetab_repair(hetab_context *ctx, const char *path, const char *out_path,
                          hetab_reading lookup, int scale_energy, int overwrite,
                          hetab_repair_report *report) {
  hetab_format format;
  *report = (hetab_repair_report){.smallest_scale = 1};
  HETAB_TRY(find_format(ctx, path, &format));
  if (hetab_same_file(path, out_path))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "'%s' is not repaired in place: give another name to write to", path);
  if (format == HETAB_FORMAT_RGL)
    return hetab_fail(
        ctx, HETAB_ERR_UNSUPPORTED,
        "'%s' is an RGL table, which is not repaired: convert it to HDF5 or MERL, and "
        "repair that",
        path);
  if (lookup == HETAB_READ_DEFAULT)
    lookup = FORMATS[format].lookup;
  return (format == HETAB_FORMAT_H5 ? hetab_repair_h5 : hetab_repair_merl)(
      ctx, path, out_path, lookup, scale_energy, overwrite, report);
}
