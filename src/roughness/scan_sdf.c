/* ISO 25178-71 surface data, ASCII: a version line, "Name = value" lines to a line "*", the heights
 * row by row to a line "*", and whatever the instrument adds. Lengths are in metres. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "roughness/heights.h"
#include "core/number.h"
#include "core/text.h"

typedef struct sdf_scan {
  hetab_context *ctx;
  const char *path;
  double points, profiles, x_scale, y_scale, z_scale, compression, check;
} sdf_scan;

static hetab_status read_field(sdf_scan *s, const char *name, const char *value, size_t line) {
  const struct {
    const char *name;
    double *value;
  } fields[] = {{"NumPoints", &s->points}, {"NumProfiles", &s->profiles},
                {"Xscale", &s->x_scale},   {"Yscale", &s->y_scale},
                {"Zscale", &s->z_scale},   {"Compression", &s->compression},
                {"CheckType", &s->check}};
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
    if (strcasecmp(name, fields[i].name) == 0 && !hetab_number_parse(value, fields[i].value))
      return hetab_fail(s->ctx, HETAB_ERR_PARSE, "%s:%zu: %s is '%.40s': it has to be a number",
                        s->path, line, name, value);
  return HETAB_OK;
}

/* Reads to the line after "*"; *cursor is at the heights then. */
static hetab_status read_fields(sdf_scan *s, char **cursor) {
  char *line = *cursor;
  for (size_t number = 1; *line; number++) {
    char *end = line + strcspn(line, "\n"), *next = *end ? end + 1 : end;
    *end = '\0';
    char *name = line + strspn(line, " \t");
    if (*name == '*') {
      *cursor = next;
      return HETAB_OK;
    }
    char *equals = strchr(name, '=');
    if (equals) {
      *equals = '\0';
      name[strcspn(name, " \t")] = '\0';
      HETAB_TRY(read_field(s, name, equals + 1, number));
    }
    line = next;
  }
  return hetab_fail(s->ctx, HETAB_ERR_PARSE, "%s: no '*' after the header: is the file cut off?",
                    s->path);
}

static bool is_count(double value) {
  return value >= 1 && value <= (double)HETAB_MOST_HEIGHTS && value == floor(value);
}

static hetab_status check_header(const sdf_scan *s) {
  if (!is_count(s->points) || !is_count(s->profiles))
    return hetab_fail(s->ctx, HETAB_ERR_PARSE,
                      "%s: NumPoints %g and NumProfiles %g: both have to be counts", s->path,
                      s->points, s->profiles);
  if (!(s->x_scale > 0 && s->z_scale > 0) || (s->profiles > 1 && !(s->y_scale > 0)))
    return hetab_fail(s->ctx, HETAB_ERR_PARSE,
                      "%s: Xscale %g, Yscale %g, Zscale %g: they have to be above 0, in metres",
                      s->path, s->x_scale, s->y_scale, s->z_scale);
  if (s->compression != 0 || s->check != 0)
    return hetab_fail(s->ctx, HETAB_ERR_UNSUPPORTED,
                      "%s: compressed or checksummed SDF: export it without", s->path);
  return HETAB_OK;
}

static hetab_status read_heights(const sdf_scan *s, const char *cursor, hetab_heights *h) {
  char word[64];
  for (size_t i = 0; i < h->rows * h->columns; i++) {
    double value;
    if (!hetab_next_word(&cursor, word, sizeof word) || *word == '*')
      return hetab_fail(s->ctx, HETAB_ERR_PARSE,
                        "%s: %zu heights, where the header says %zu: is the file cut off?", s->path,
                        i, h->rows * h->columns);
    if (!hetab_height_parse(word, &value))
      return hetab_fail(s->ctx, HETAB_ERR_PARSE, "%s: height %zu, '%.40s', is not a number or BAD",
                        s->path, i + 1, word);
    h->z_um[i] = value * s->z_scale * 1e6;
  }
  if (hetab_next_word(&cursor, word, sizeof word) && *word != '*')
    return hetab_fail(s->ctx, HETAB_ERR_PARSE,
                      "%s: more heights than the %zu that the header says: correct NumPoints",
                      s->path, h->rows * h->columns);
  return HETAB_OK;
}

hetab_status hetab_scan_sdf(hetab_context *ctx, const char *path, char *text, hetab_heights **out) {
  sdf_scan s = {.ctx = ctx, .path = path};
  size_t length = strlen(text);
  HETAB_TRY(read_fields(&s, &text));
  HETAB_TRY(check_header(&s));
  if (s.points * s.profiles > (double)length)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "%s: %g x %g heights do not fit in the file: is it cut off?", path, s.points,
                      s.profiles);
  HETAB_TRY(hetab_heights_new(ctx, path, (size_t)s.points, (size_t)s.profiles, out));
  (*out)->kind = s.profiles > 1 ? HETAB_HEIGHTS_MAP : HETAB_HEIGHTS_SCANS;
  (*out)->spacing_um = s.x_scale * 1e6;
  (*out)->spacing_y_um = s.profiles > 1 ? s.y_scale * 1e6 : 0;
  return read_heights(&s, text, *out);
}
