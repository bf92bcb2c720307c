#include <hetab/convert.h>

#include <hetab/table.h>

#include "convert/outputs.h"
#include "core/held_files.h"
#include "core/option_size.h"
#include "convert/trial.h"

static hetab_status format_of_output(hetab_context *ctx, const char *path, hetab_format *format) {
  if (hetab_format_by_ending(path, format) && *format != HETAB_FORMAT_EXR)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                    "'%s': tables are converted to .h5 (HDF5), .binary (MERL) or .bsdf (RGL); "
                    "choose the ending",
                    path);
}

/* A table is read while it is written. */
static hetab_status check_not_the_same(hetab_context *ctx, const char *in, const char *out) {
  if (hetab_same_file(in, out))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "'%s' and '%s' are one file; give another output",
                      in, out);
  return HETAB_OK;
}

static hetab_status write_table(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                const hetab_convert_options *options, hetab_format format) {
  switch (format) {
  case HETAB_FORMAT_H5:
    return hetab_convert_to_h5(ctx, source, path, options);
  case HETAB_FORMAT_MERL:
    return hetab_convert_to_merl(ctx, source, path, options);
  case HETAB_FORMAT_RGL:
    return hetab_convert_to_rgl(ctx, source, path, options);
  case HETAB_FORMAT_EXR: /* refused before */
    break;
  }
  return HETAB_ERR_UNSUPPORTED;
}

static hetab_status write_output(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                 const hetab_convert_options *options,
                                 hetab_convert_report *report) {
  HETAB_TRY(hetab_convert_check_specular(ctx, source, report->to, path, options->overwrite,
                                         &report->specular_max));
  HETAB_TRY(hetab_convert_save_specular(ctx, source, report->to, path, options->overwrite, report));
  HETAB_TRY(write_table(ctx, source, path, options, report->to));
  report->clamped = source->clamped;
  return HETAB_OK;
}

/* What has been written is read back before it takes anything's place. */
static hetab_status write_and_try(hetab_context *ctx, hetab_convert_source *source,
                                  const char *path, const hetab_convert_options *options,
                                  hetab_convert_report *report) {
  hetab_held_files held;
  hetab_atomic_hold(ctx, &held);
  hetab_status status = write_output(ctx, source, path, options, report);
  if (status == HETAB_OK)
    status = hetab_convert_trial(ctx, source, path, options->pairs ? options->pairs : 100000,
                                 options->seed, report);
  if (status == HETAB_OK)
    status = hetab_atomic_publish(ctx, &held);
  hetab_atomic_drop(ctx, &held);
  return status;
}

hetab_status hetab_convert(hetab_context *ctx, const char *in, const char *out,
                           const hetab_convert_options *options, hetab_convert_report *report) {
  HETAB_OPTIONS(ctx, hetab_convert_options, o, options);
  hetab_convert_report own;
  hetab_convert_source source;
  report = report ? report : &own;
  *report = (hetab_convert_report){0};
  HETAB_TRY(format_of_output(ctx, out, &report->to));
  HETAB_TRY(check_not_the_same(ctx, in, out));
  HETAB_TRY(hetab_output_check(ctx, out, o.overwrite));
  HETAB_TRY(hetab_convert_open(ctx, in, o.srgb || report->to == HETAB_FORMAT_MERL, &source));
  report->from = source.format;
  report->channels_in = source.channels_in;
  report->channels_out = source.channels;
  report->srgb_in = !hetab_lookup_wavelengths_um(source.table);
  report->srgb_out = !source.lambda_um;
  report->filled = source.filled;
  report->negative = hetab_lookup_negative(source.table);
  hetab_status status = write_and_try(ctx, &source, out, &o, report);
  hetab_convert_close(&source);
  return status;
}
