/* Scans of files: the reader is chosen by the file's first bytes. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "core/input_file.h"
#include "core/option_size.h"
#include "core/text.h"
#include "roughness/heights.h"

static const size_t most_bytes = (size_t)1 << 30;

static hetab_status read_text(hetab_context *ctx, const char *path, char **text) {
  size_t length;
  hetab_status status = hetab_text_read_any(ctx, path, most_bytes, text, &length);
  if (status != HETAB_ERR_PARSE)
    return status;
  return hetab_fail(
      ctx, status,
      "%s: neither X3P, nor SDF, nor .sur, nor text below 1 GiB: export the scan as one of "
      "them",
      path);
}

/* The file's first bytes. Of a pipe none, for its reader would miss them: it is text. */
static hetab_status read_signature(hetab_context *ctx, const char *path, char head[5]) {
  struct stat about;
  memset(head, 0, 5);
  if (stat(path, &about) == 0 && !S_ISREG(about.st_mode))
    return HETAB_OK;
  return hetab_input_start(ctx, path, HETAB_INPUT_TEXT, head, 4);
}

static bool starts(const char *text, const char *with) {
  return strncmp(text, with, strlen(with)) == 0;
}

static hetab_status read_by_content(hetab_context *ctx, const char *path,
                                    const hetab_heights_options *options, hetab_heights **out) {
  char head[5], *text = NULL;
  HETAB_TRY(read_signature(ctx, path, head));
  if (starts(head, "PK\3\4"))
    return hetab_scan_x3p(ctx, path, options, out);
  if (starts(head, "bISO") || starts(head, "bBCR") || starts(head, "DIGI") || starts(head, "DSCO"))
    return hetab_scan_binary(ctx, path, out);
  HETAB_TRY(read_text(ctx, path, &text));
  hetab_status status =
      starts(text, "aISO") || starts(text, "aBCR") ? hetab_scan_sdf(ctx, path, text, out)
      : starts(text, "Zygo ASCII")                 ? hetab_scan_zygo(ctx, path, text, out)
                                                   : hetab_scan_text(ctx, path, text, options, out);
  free(text);
  return status;
}

hetab_status hetab_heights_load(hetab_context *ctx, const char *path,
                                const hetab_heights_options *options, hetab_heights **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_heights_options, own, options);
  return hetab_heights_keep(ctx, read_by_content(ctx, path, &own, out), out);
}
