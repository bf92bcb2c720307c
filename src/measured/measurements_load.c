/* Which reader a file of measurements gets. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include <hetab/table.h>

#include "measured/measurement_sheet.h"
#include "core/input_file.h"
#include "core/text.h"
#include "table/table_format.h"

enum { MAX_TEXT = 256 << 20 };

static const char *const brdf_extensions[] = {".brdf", NULL};
static const char *const astm_extensions[] = {".astm", NULL};
static const char *const csv_extensions[] = {".csv", NULL};

/* By the file's first bytes, else its name. The first bytes of a pipe would be lost to its reader:
 * it is text. */
static hetab_status find_format(hetab_context *ctx, const char *path, bool *known,
                                hetab_format *format) {
  unsigned char start[HETAB_FORMAT_START] = {0};
  struct stat about;
  if (stat(path, &about) == 0 && S_ISREG(about.st_mode))
    HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TEXT, start, sizeof start));
  *known = hetab_format_by_start(start, format) || hetab_format_by_ending(path, format);
  return HETAB_OK;
}

static bool has_line(const char *text, const char *key) {
  size_t length = strlen(key);
  while (*text) {
    if (strncasecmp(text, key, length) == 0 && isspace((unsigned char)text[length]))
      return true;
    text += strcspn(text, "\n");
    text += *text == '\n';
  }
  return false;
}

/* Whether the first word that is in no comment is a number. */
static bool begins_with_number(const char *text) {
  while (*text && (isspace((unsigned char)*text) || *text == '#'))
    text += *text == '#' ? strcspn(text, "\n") : 1;
  return *text && strchr("+-.0123456789", *text);
}

typedef hetab_status (*text_reader)(hetab_sheet *sheet);

static text_reader choose(const char *path, const char *text) {
  if (hetab_has_extension(path, brdf_extensions))
    return hetab_measurements_read_brdf;
  if (hetab_has_extension(path, astm_extensions))
    return hetab_measurements_read_astm;
  if (hetab_has_extension(path, csv_extensions))
    return hetab_measurements_read_csv;
  if (has_line(text, "VARS"))
    return hetab_measurements_read_astm;
  return begins_with_number(text) ? hetab_measurements_read_brdf : hetab_measurements_read_csv;
}

static hetab_status read_text(hetab_sheet *sheet) {
  HETAB_TRY(hetab_csv_open(sheet->ctx, sheet->path, MAX_TEXT, &sheet->csv));
  return choose(sheet->path, sheet->csv.text)(sheet);
}

static hetab_status read_file(hetab_sheet *sheet) {
  hetab_format format;
  bool known;
  HETAB_TRY(find_format(sheet->ctx, sheet->path, &known, &format));
  if (known && format == HETAB_FORMAT_H5)
    return hetab_measurements_read_h5(sheet);
  if (known && format == HETAB_FORMAT_MERL)
    return hetab_measurements_read_merl(sheet);
  if (known && format == HETAB_FORMAT_RGL)
    return hetab_measurements_read_rgl(sheet);
  return read_text(sheet);
}

hetab_status hetab_measurements_load_at(hetab_context *ctx, const char *path,
                                        const double *lambda_um, size_t count,
                                        hetab_measurements **out) {
  hetab_sheet sheet = {.ctx = ctx, .path = path, .given_um = lambda_um, .given = count};
  *out = NULL;
  hetab_status status = read_file(&sheet);
  if (status == HETAB_OK)
    status = hetab_sheet_finish(&sheet, out);
  hetab_sheet_clear(&sheet);
  hetab_csv_clear(&sheet.csv);
  return status;
}

hetab_status hetab_measurements_load(hetab_context *ctx, const char *path,
                                     hetab_measurements **out) {
  return hetab_measurements_load_at(ctx, path, NULL, 0, out);
}
