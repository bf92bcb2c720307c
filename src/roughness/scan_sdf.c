/* ISO 25178-71 surface data, ASCII: a version line, "Name = value" lines to a line "*", the heights
 * row by row to a line "*", and whatever the instrument adds. Lengths are in metres. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "core/csv.h"
#include "core/text.h"
#include "roughness/heights.h"

typedef struct sdf_scan {
  hetab_csv csv;
  double points, profiles, x_scale, y_scale, z_scale, compression, check;
} sdf_scan;

/* "Name = value" */
static hetab_status read_field(sdf_scan *s, char *name) {
  const struct {
    const char *name;
    double *value;
  } fields[] = {{"NumPoints", &s->points}, {"NumProfiles", &s->profiles},
                {"Xscale", &s->x_scale},   {"Yscale", &s->y_scale},
                {"Zscale", &s->z_scale},   {"Compression", &s->compression},
                {"CheckType", &s->check}};
  char *equals = strchr(name, '=');
  if (!equals)
    return HETAB_OK;
  *equals = '\0';
  name[strcspn(name, " \t")] = '\0';
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
    if (strcasecmp(name, fields[i].name) == 0 && !hetab_number_parse(equals + 1, fields[i].value))
      return hetab_csv_fail(&s->csv, "%s is '%.40s': it has to be a number", name, equals + 1);
  return HETAB_OK;
}

/* Reads to the line after "*". */
static hetab_status read_fields(sdf_scan *s) {
  for (;;) {
    HETAB_TRY(hetab_csv_line(&s->csv));
    if (!s->csv.content)
      return hetab_csv_fail(&s->csv, "no '*' after the header: is the file cut off?");
    if (*s->csv.content == '*')
      return HETAB_OK;
    HETAB_TRY(read_field(s, s->csv.content));
  }
}

static bool is_count(double value) {
  return value >= 1 && value <= (double)HETAB_MOST_HEIGHTS && value == floor(value);
}

static hetab_status check_header(const sdf_scan *s) {
  if (!is_count(s->points) || !is_count(s->profiles))
    return hetab_fail(s->csv.ctx, HETAB_ERR_PARSE,
                      "%s: NumPoints %g and NumProfiles %g: both have to be counts", s->csv.path,
                      s->points, s->profiles);
  if (!(s->x_scale > 0 && s->z_scale > 0) || (s->profiles > 1 && !(s->y_scale > 0)))
    return hetab_fail(s->csv.ctx, HETAB_ERR_PARSE,
                      "%s: Xscale %g, Yscale %g, Zscale %g: they have to be above 0, in metres",
                      s->csv.path, s->x_scale, s->y_scale, s->z_scale);
  if (s->compression != 0 || s->check != 0)
    return hetab_fail(s->csv.ctx, HETAB_ERR_UNSUPPORTED,
                      "%s: compressed or checksummed SDF: export it without", s->csv.path);
  return HETAB_OK;
}

static hetab_status read_heights(const sdf_scan *s, const char *cursor, hetab_heights *h) {
  char word[64];
  for (size_t i = 0; i < h->rows * h->columns; i++) {
    double value;
    HETAB_TRY(hetab_go_on(s->csv.ctx, i + 1));
    if (!hetab_next_word(&cursor, word, sizeof word) || *word == '*')
      return hetab_fail(s->csv.ctx, HETAB_ERR_PARSE,
                        "%s: %zu heights, where the header says %zu: is the file cut off?",
                        s->csv.path, i, h->rows * h->columns);
    if (!hetab_number_or_missing(word, &value))
      return hetab_fail(s->csv.ctx, HETAB_ERR_PARSE,
                        "%s: height %zu, '%.40s', is not a number or BAD", s->csv.path, i + 1,
                        word);
    h->z_um[i] = value * s->z_scale * 1e6;
  }
  if (hetab_next_word(&cursor, word, sizeof word) && *word != '*')
    return hetab_fail(s->csv.ctx, HETAB_ERR_PARSE,
                      "%s: more heights than the %zu that the header says: correct NumPoints",
                      s->csv.path, h->rows * h->columns);
  return HETAB_OK;
}

static hetab_status read_scan(sdf_scan *s, hetab_heights **out) {
  HETAB_TRY(read_fields(s));
  HETAB_TRY(check_header(s));
  const char *heights = s->csv.next;
  if (s->points * s->profiles > (double)strlen(heights))
    return hetab_csv_fail(&s->csv, "%g x %g heights do not fit in the file: is it cut off?",
                          s->points, s->profiles);
  HETAB_TRY(
      hetab_heights_new(s->csv.ctx, s->csv.path, (size_t)s->points, (size_t)s->profiles, out));
  (*out)->kind = s->profiles > 1 ? HETAB_HEIGHTS_MAP : HETAB_HEIGHTS_SCANS;
  (*out)->spacing_um = s->x_scale * 1e6;
  (*out)->spacing_y_um = s->profiles > 1 ? s->y_scale * 1e6 : 0;
  return read_heights(s, heights, *out);
}

hetab_status hetab_scan_sdf(hetab_context *ctx, const char *path, const char *text,
                            hetab_heights **out) {
  sdf_scan s = {0};
  hetab_csv_of_text(ctx, path, text, &s.csv);
  hetab_status status = read_scan(&s, out);
  hetab_csv_clear(&s.csv);
  return status;
}
