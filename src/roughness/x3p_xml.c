#include "roughness/x3p_xml.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <expat.h>
#include "core/number.h"

enum { MAX_DEPTH = 8, MAX_TEXT = 1024 };

typedef struct x3p_parser {
  hetab_context *ctx;
  const char *path;
  XML_Parser xml;
  x3p_description *out;
  hetab_status status;
  char names[MAX_DEPTH][32]; /* of the open elements */
  int depth;
  char text[MAX_TEXT]; /* of the innermost */
  size_t text_length;
  size_t datum_capacity, datum_width; /* absolute axes when the first Datum was read */
} x3p_parser;

static void stop(x3p_parser *p, hetab_status status) {
  if (p->status == HETAB_OK)
    p->status = status;
  XML_StopParser(p->xml, XML_FALSE);
}

static hetab_status malformed(x3p_parser *p, const char *what) {
  return hetab_fail(p->ctx, HETAB_ERR_PARSE, "%s: main.xml:%lu: %s", p->path,
                    (unsigned long)XML_GetCurrentLineNumber(p->xml), what);
}

static bool inside(const x3p_parser *p, const char *parent) {
  return p->depth >= 2 && strcmp(p->names[p->depth - 2], parent) == 0;
}

static bool is_element(const x3p_parser *p, const char *name) {
  return strcmp(p->names[p->depth - 1], name) == 0;
}

/* ---- values -------------------------------------------------------------------------------- */

static void read_number(x3p_parser *p, double *value) {
  if (!p->text[0] && is_element(p, "Offset")) /* several programs leave it empty */
    *value = 0;
  else if (!hetab_number_parse(p->text, value) || !isfinite(*value)) {
    char what[128];
    snprintf(what, sizeof what, "%s is '%.40s': it has to be a number", p->names[p->depth - 1],
             p->text);
    stop(p, malformed(p, what));
  }
}

static void read_axis(x3p_parser *p, x3p_axis *axis) {
  if (is_element(p, "AxisType"))
    axis->absolute = *p->text == 'A';
  else if (is_element(p, "DataType"))
    axis->type = *p->text;
  else if (is_element(p, "Offset"))
    read_number(p, &axis->offset);
  else if (is_element(p, "Increment")) {
    axis->has_increment = true;
    read_number(p, &axis->increment);
  }
}

static void copy_text(x3p_parser *p, const char *name, char *to, size_t size) {
  if (!is_element(p, name))
    return;
  if (p->text_length >= size)
    stop(p, malformed(p, "a name too long for X3P"));
  else
    memcpy(to, p->text, p->text_length + 1);
}

static void read_link(x3p_parser *p) {
  x3p_description *d = p->out;
  copy_text(p, "PointDataLink", d->points, sizeof d->points);
  copy_text(p, "MD5ChecksumPointData", d->points_md5, sizeof d->points_md5);
  copy_text(p, "ValidPointsLink", d->valid, sizeof d->valid);
  copy_text(p, "MD5ChecksumValidPoints", d->valid_md5, sizeof d->valid_md5);
}

static size_t absolute_axes(const x3p_description *d) {
  return (size_t)(d->axis[0].absolute + d->axis[1].absolute + d->axis[2].absolute);
}

static bool grow_datum(x3p_parser *p, size_t needed) {
  if (needed <= p->datum_capacity)
    return true;
  size_t capacity = p->datum_capacity ? 2 * p->datum_capacity : 3072;
  double *larger = realloc(p->out->datum, capacity * sizeof *larger);
  if (!larger) {
    stop(p, hetab_fail(p->ctx, HETAB_ERR_MEMORY, "%s: out of memory for its points", p->path));
    return false;
  }
  p->out->datum = larger;
  p->datum_capacity = capacity;
  return true;
}

/* A Datum has a number for each absolute axis: what these are has to come before, and to stay. */
static hetab_status misplaced(x3p_parser *p) {
  return malformed(p, "axes after the DataList: Record1 has to come before Record3");
}

/* "x;y;z" of the absolute axes; an empty one is a missing point. */
static void read_datum(x3p_parser *p) {
  x3p_description *d = p->out;
  size_t width = absolute_axes(d), count = 0;
  char *text = p->text;
  if (d->datum_count == 0)
    p->datum_width = width;
  if (width == 0 || width != p->datum_width) {
    stop(p, misplaced(p));
    return;
  }
  if (!grow_datum(p, (d->datum_count + 1) * width))
    return;
  double *values = d->datum + d->datum_count++ * width;
  for (; count < width && *text; count++) {
    char *end = text + strcspn(text, ";"), mark = *end;
    *end = '\0';
    if (!hetab_number_or_missing(text, &values[count]))
      stop(p, malformed(p, "a Datum is no number"));
    text = mark ? end + 1 : end;
  }
  if (*text || (count && count < width))
    stop(p, malformed(p, "a Datum has not as many numbers as there are absolute axes"));
  for (; count < width; count++)
    values[count] = (double)NAN;
}

static void read_element(x3p_parser *p) {
  static const char *const axes[] = {"CX", "CY", "CZ"};
  static const char *const sizes[] = {"SizeX", "SizeY", "SizeZ"};
  x3p_description *d = p->out;
  for (int i = 0; i < 3; i++) {
    if (inside(p, axes[i]))
      read_axis(p, &d->axis[i]);
    if (inside(p, "MatrixDimension") && is_element(p, sizes[i]))
      read_number(p, &d->size[i]);
  }
  if (is_element(p, "ListDimension"))
    read_number(p, &d->list_size);
  if (inside(p, "Record1"))
    copy_text(p, "FeatureType", d->feature, sizeof d->feature);
  if (inside(p, "DataLink"))
    read_link(p);
  if (inside(p, "DataList") && is_element(p, "Datum"))
    read_datum(p);
}

/* ---- expat's calls ------------------------------------------------------------------------- */

static void XMLCALL on_start(void *user, const XML_Char *name, const XML_Char **attributes) {
  (void)attributes;
  x3p_parser *p = user;
  const char *local = strrchr(name, ':');
  if (p->depth == MAX_DEPTH) {
    stop(p, malformed(p, "elements deeper than X3P has them"));
    return;
  }
  snprintf(p->names[p->depth++], sizeof p->names[0], "%s", local ? local + 1 : name);
  p->text[p->text_length = 0] = '\0';
}

static void trim(x3p_parser *p) {
  size_t skip = strspn(p->text, " \t\r\n");
  p->text_length -= skip;
  memmove(p->text, p->text + skip, p->text_length + 1);
  while (p->text_length && strchr(" \t\r\n", p->text[p->text_length - 1]))
    p->text[--p->text_length] = '\0';
}

static void XMLCALL on_end(void *user, const XML_Char *name) {
  (void)name;
  x3p_parser *p = user;
  if (p->status != HETAB_OK)
    return;
  trim(p);
  read_element(p);
  p->depth--;
  p->text[p->text_length = 0] = '\0';
}

/* What is longer than any value that is read (a comment, say) is cut. */
static void XMLCALL on_text(void *user, const XML_Char *text, int length) {
  x3p_parser *p = user;
  size_t room = sizeof p->text - 1 - p->text_length;
  size_t kept = (size_t)length < room ? (size_t)length : room;
  memcpy(p->text + p->text_length, text, kept);
  p->text_length += kept;
  p->text[p->text_length] = '\0';
}

/* X3P has none, and entities are how XML goes off. */
static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system,
                               const XML_Char *public, int internal) {
  (void)name, (void)system, (void)public, (void)internal;
  x3p_parser *p = user;
  stop(p, malformed(p, "a document type: X3P has none"));
}

hetab_status hetab_x3p_parse(hetab_context *ctx, const char *path, const char *xml, size_t length,
                             x3p_description *description) {
  *description = (x3p_description){0};
  x3p_parser p = {.ctx = ctx, .path = path, .out = description, .xml = XML_ParserCreate(NULL)};
  if (!p.xml)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "%s: out of memory for main.xml", path);
  XML_SetUserData(p.xml, &p);
  XML_SetElementHandler(p.xml, on_start, on_end);
  XML_SetCharacterDataHandler(p.xml, on_text);
  XML_SetStartDoctypeDeclHandler(p.xml, on_doctype);
  if (XML_Parse(p.xml, xml, (int)length, 1) != XML_STATUS_OK && p.status == HETAB_OK)
    p.status = malformed(&p, XML_ErrorString(XML_GetErrorCode(p.xml)));
  if (p.status == HETAB_OK && description->datum_count &&
      absolute_axes(description) != p.datum_width)
    p.status = misplaced(&p);
  XML_ParserFree(p.xml);
  return p.status;
}
