/* Binary ISO 25178-71 surface data (bISO-1.0, bBCR-1.0) and Digital Surf's .sur: a header of fixed
 * places, then the heights row by row, little-endian. */
#include <endian.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "core/text.h"
#include "core/unit.h"
#include "roughness/heights.h"

static const size_t most_bytes = (size_t)1 << 30;

typedef enum number_type {
  INT8,
  UINT8,
  INT16,
  UINT16,
  INT32,
  UINT32,
  FLOAT32,
  FLOAT64
} number_type;

/* What a header says. */
typedef struct layout {
  double columns, rows, x_um, y_um, z_um; /* the last three: a step, or one unit */
  number_type type;
  bool has_invalid;
  double invalid; /* number of a missing height */
  size_t start;   /* of the heights */
} layout;

typedef struct binary {
  hetab_context *ctx;
  const char *path;
  const unsigned char *bytes;
  size_t size;
} binary;

static hetab_status fail(const binary *b, hetab_status status, const char *what) {
  return hetab_fail(b->ctx, status, "%s: %s", b->path, what);
}

static size_t bytes_of(number_type type) {
  static const size_t bytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return bytes[type];
}

static double number_at(const unsigned char *bytes, number_type type) {
  union {
    uint64_t bits;
    float f32;
    double f64;
  } raw = {0};
  memcpy(&raw.bits, bytes, bytes_of(type));
  raw.bits = le64toh(raw.bits);
  switch (type) {
  case INT8:
    return (int8_t)raw.bits;
  case INT16:
    return (int16_t)raw.bits;
  case INT32:
    return (int32_t)raw.bits;
  case FLOAT32:
    return (double)raw.f32;
  case FLOAT64:
    return raw.f64;
  default:
    return (double)raw.bits;
  }
}

static double field(const binary *b, size_t at, number_type type) {
  return number_at(b->bytes + at, type);
}

/* ---- headers ------------------------------------------------------------------------------- */

/* Version 8, manufacturer 10, two dates of 12, then points, profiles, scales in metres,
 * compression, type of the data, kind of check. */
static hetab_status read_sdf(const binary *b, layout *l) {
  static const number_type types[] = {UINT8, UINT16, UINT32, FLOAT32, INT8, INT16, INT32, FLOAT64};
  enum {
    POINTS = 42,
    PROFILES = 44,
    X = 46,
    Y = 54,
    Z = 62,
    COMPRESSION = 78,
    TYPE = 79,
    CHECK = 80
  };
  if (b->size < CHECK + 1)
    return fail(b, HETAB_ERR_PARSE, "no room for the header: is the file cut off?");
  if (b->bytes[COMPRESSION] || b->bytes[CHECK])
    return fail(b, HETAB_ERR_UNSUPPORTED, "compressed or checksummed SDF: export it without");
  if (b->bytes[TYPE] > 7)
    return fail(b, HETAB_ERR_PARSE, "DataType is none of 0 to 7: is this SDF?");
  *l = (layout){field(b, POINTS, UINT16),   field(b, PROFILES, UINT16), 1e6 * field(b, X, FLOAT64),
                1e6 * field(b, Y, FLOAT64), 1e6 * field(b, Z, FLOAT64), types[b->bytes[TYPE]],
                .start = CHECK + 1};
  l->has_invalid = l->type == INT16 || l->type == INT32;
  l->invalid = l->type == INT16 ? INT16_MIN : INT32_MIN;
  return HETAB_OK;
}

/* The 16 bytes of a unit, padded; Latin-1. */
static double unit_at(const binary *b, size_t at) {
  char text[17] = {0};
  for (size_t i = 0; i < 16; i++) {
    unsigned char c = b->bytes[at + i];
    text[i] = (char)(c == 0xB5 ? 'u' : c == 0xC5 ? 'A' : c);
  }
  return hetab_unit(HETAB_LENGTH, text);
}

static hetab_status read_sur(const binary *b, layout *l) {
  enum { FORMAT = 12, SPECIAL = 86, BITS = 98, MIN = 100, COLUMNS = 108, ROWS = 112, POINTS = 116 };
  enum { X = 120, Y = 124, Z = 128, X_UNIT = 180, Y_UNIT = 196, Z_UNIT = 212 };
  enum { COMMENT = 334, PRIVATE = 336, HEADER = 512 };
  if (b->size < HEADER)
    return fail(b, HETAB_ERR_PARSE, "no room for the header: is the file cut off?");
  if (memcmp(b->bytes, "DSCOMPRESSED", 12) == 0)
    return fail(b, HETAB_ERR_UNSUPPORTED, "compressed .sur: save it without compression");
  if (memcmp(b->bytes, "DIGITAL SURF", 12) != 0)
    return fail(b, HETAB_ERR_PARSE, "no Digital Surf header: is this .sur?");
  double bits = field(b, BITS, UINT16);
  if (field(b, FORMAT, UINT16) != 0 || (bits != 16 && bits != 32))
    return fail(b, HETAB_ERR_UNSUPPORTED,
                "a .sur of another machine, or not of 16 or 32 bits: save it as X3P or SDF");
  *l = (layout){field(b, COLUMNS, INT32),
                field(b, ROWS, INT32),
                field(b, X, FLOAT32) * unit_at(b, X_UNIT),
                field(b, Y, FLOAT32) * unit_at(b, Y_UNIT),
                field(b, Z, FLOAT32) * unit_at(b, Z_UNIT),
                bits == 16 ? INT16 : INT32,
                field(b, SPECIAL, UINT16) != 0,
                field(b, MIN, INT32) - 2,
                HEADER + (size_t)field(b, COMMENT, UINT16) + (size_t)field(b, PRIVATE, UINT16)};
  if (l->columns * l->rows != field(b, POINTS, UINT32))
    return fail(b, HETAB_ERR_PARSE, "its numbers of points do not agree: is the file damaged?");
  return HETAB_OK;
}

/* ---- heights ------------------------------------------------------------------------------- */

static hetab_status read_heights(const binary *b, const layout *l, hetab_heights **out) {
  double most = (double)HETAB_MOST_HEIGHTS,
         needed = l->columns * l->rows * (double)bytes_of(l->type);
  if (!(l->columns >= 1 && l->rows >= 1 && l->columns * l->rows <= most))
    return hetab_fail(b->ctx, HETAB_ERR_PARSE,
                      "%s: %g x %g heights: both have to be counts, and at "
                      "most 2^27 together",
                      b->path, l->columns, l->rows);
  if (!(l->x_um > 0 && l->z_um > 0) || (l->rows > 1 && !(l->y_um > 0)))
    return fail(b, HETAB_ERR_PARSE, "its scales of x, y and z have to be above 0, and in lengths");
  if ((double)b->size < (double)l->start + needed)
    return hetab_fail(b->ctx, HETAB_ERR_PARSE,
                      "%s: %zu bytes, where %g x %g heights need %.0f: is it cut off?", b->path,
                      b->size, l->columns, l->rows, (double)l->start + needed);
  HETAB_TRY(hetab_heights_new(b->ctx, b->path, (size_t)l->columns, (size_t)l->rows, out));
  hetab_heights *h = *out;
  h->kind = h->rows > 1 ? HETAB_HEIGHTS_MAP : HETAB_HEIGHTS_SCANS;
  h->spacing_um = l->x_um;
  h->spacing_y_um = h->rows > 1 ? l->y_um : 0;
  for (size_t i = 0; i < h->rows * h->columns; i++) {
    HETAB_TRY(hetab_go_on(b->ctx, i + 1));
    double value = field(b, l->start + i * bytes_of(l->type), l->type);
    bool valid = isfinite(value) && !(l->has_invalid && value == l->invalid);
    h->z_um[i] = valid ? value * l->z_um : (double)NAN;
  }
  return HETAB_OK;
}

hetab_status hetab_scan_binary(hetab_context *ctx, const char *path, hetab_heights **out) {
  HETAB_FREED char *bytes = NULL;
  layout l = {0};
  binary b = {.ctx = ctx, .path = path};
  *out = NULL;
  HETAB_TRY(hetab_bytes_read(ctx, path, most_bytes, &bytes, &b.size));
  b.bytes = (const unsigned char *)bytes;
  HETAB_TRY(*bytes == 'b' ? read_sdf(&b, &l) : read_sur(&b, &l));
  return read_heights(&b, &l, out);
}
