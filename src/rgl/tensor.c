#include "rgl/tensor.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "table/table_format.h"
#include "core/atomic_file.h"
#include "core/input_file.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "tensor files are little-endian, and this file takes them as memory");

static const char tensor_magic[] = HETAB_RGL_SIGNATURE;
static const unsigned char tensor_version[2] = {1, 0};

enum {
  TENSOR_ALIGNMENT = 8,
  TENSOR_HEADER = 12 + 2 + 4,   /* magic, version, number of fields */
  TENSOR_FIELD = 2 + 2 + 1 + 8, /* name length, ndim, type, offset; name and shape come on top */
};

enum { MOST_FIELDS = 256 };
static const long long most_bytes = 1LL << 31;

/* ---- types --------------------------------------------------------------------------------- */

static const struct {
  const char *name;
  size_t size;
} types[] = {{"", 0},      {"uint8", 1},   {"int8", 1},    {"uint16", 2},
             {"int16", 2}, {"uint32", 4},  {"int32", 4},   {"uint64", 8},
             {"int64", 8}, {"float16", 2}, {"float32", 4}, {"float64", 8}};

/* Bytes of one number; 0 for what is no type. */
static size_t type_size(hetab_tensor_type type) {
  return (size_t)type < sizeof types / sizeof *types ? types[type].size : 0;
}

const char *hetab_tensor_type_name(hetab_tensor_type type) {
  return type_size(type) ? types[type].name : "an unknown type";
}

size_t hetab_tensor_elements(const hetab_tensor_field *field) {
  size_t count = 1;
  for (size_t d = 0; d < field->ndim; d++)
    count *= field->shape[d];
  return count;
}

static size_t field_bytes(const hetab_tensor_field *field) {
  return hetab_tensor_elements(field) * type_size(field->type);
}

/* ---- reading ------------------------------------------------------------------------------- */

static hetab_status read_stream(hetab_context *ctx, const char *path, FILE *stream,
                                hetab_tensor_file *file) {
  struct stat info;
  if (fstat(fileno(stream), &info) != 0)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", path);
  if (!S_ISREG(info.st_mode))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': not a file", path);
  if (info.st_size > most_bytes)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' has %lld bytes: RGL tables have at most %lld; is this one?", path,
                      (long long)info.st_size, most_bytes);
  file->size = (size_t)info.st_size;
  file->bytes = hetab_alloc(ctx, file->size + 1, 1);
  HETAB_NEED(file->bytes);
  if (fread(file->bytes, 1, file->size, stream) != file->size)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %s", path,
                      ferror(stream) ? strerror(errno) : "it became shorter meanwhile");
  return HETAB_OK;
}

static hetab_status read_bytes(hetab_context *ctx, const char *path, hetab_tensor_file *file) {
  FILE *stream;
  HETAB_TRY(hetab_input_stream(ctx, path, HETAB_INPUT_TABLE, &stream));
  hetab_status status = read_stream(ctx, path, stream, file);
  fclose(stream);
  return status;
}

/* ---- the header ---------------------------------------------------------------------------- */

typedef struct cursor {
  hetab_context *ctx;
  const char *path;
  const hetab_tensor_file *file;
  size_t at;
} cursor;

/* The next bytes of the header. */
static hetab_status take(cursor *c, void *value, size_t size) {
  if (size > c->file->size - c->at)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE,
                      "'%s' is truncated: its header ends after %zu bytes; get a complete copy",
                      c->path, c->file->size);
  memcpy(value, c->file->bytes + c->at, size);
  c->at += size;
  return HETAB_OK;
}

static hetab_status take_name(cursor *c, hetab_tensor_field *field) {
  uint16_t length;
  HETAB_TRY(take(c, &length, sizeof length));
  if (length == 0 || length >= HETAB_TENSOR_NAME)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE,
                      "'%s': a field's name of %u bytes at byte %zu; names have 1 to %d", c->path,
                      (unsigned)length, c->at, HETAB_TENSOR_NAME - 1);
  HETAB_TRY(take(c, field->name, length));
  field->name[length] = '\0';
  return HETAB_OK;
}

static hetab_status take_shape(cursor *c, hetab_tensor_field *field) {
  uint16_t ndim;
  uint64_t extent;
  HETAB_TRY(take(c, &ndim, sizeof ndim));
  if (ndim > HETAB_TENSOR_DIMS)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s', field %s: %u dimensions; at most %d", c->path,
                      field->name, (unsigned)ndim, HETAB_TENSOR_DIMS);
  field->ndim = ndim;
  uint8_t type;
  uint64_t offset;
  HETAB_TRY(take(c, &type, sizeof type));
  field->type = (hetab_tensor_type)type;
  if (!type_size(field->type))
    return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s', field %s: there is no type %u", c->path,
                      field->name, (unsigned)type);
  HETAB_TRY(take(c, &offset, sizeof offset));
  size_t bytes = type_size(field->type);
  for (size_t d = 0; d < field->ndim; d++) {
    HETAB_TRY(take(c, &extent, sizeof extent));
    field->shape[d] = (size_t)extent;
    if (__builtin_mul_overflow(bytes, field->shape[d], &bytes))
      bytes = SIZE_MAX;
  }
  if (offset > c->file->size || bytes > c->file->size - offset)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE,
                      "'%s', field %s: %zu bytes at byte %llu, but the file has %zu bytes; get a "
                      "complete copy",
                      c->path, field->name, bytes, (unsigned long long)offset, c->file->size);
  field->data = c->file->bytes + offset;
  return HETAB_OK;
}

static hetab_status take_header(cursor *c, hetab_tensor_file *file) {
  char magic[sizeof tensor_magic];
  unsigned char version[sizeof tensor_version];
  uint32_t count;
  if (file->size < sizeof magic || memcmp(file->bytes, tensor_magic, sizeof magic) != 0)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE,
                      "'%s' is no RGL table: it does not begin with \"tensor_file\"", c->path);
  HETAB_TRY(take(c, magic, sizeof magic));
  HETAB_TRY(take(c, version, sizeof version));
  if (memcmp(version, tensor_version, sizeof version) != 0)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE,
                      "'%s' is a tensor file of version %u.%u; only 1.0 is known", c->path,
                      (unsigned)version[0], (unsigned)version[1]);
  HETAB_TRY(take(c, &count, sizeof count));
  if (count > MOST_FIELDS)
    return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s' claims %u fields; at most %d", c->path,
                      (unsigned)count, MOST_FIELDS);
  file->fields = hetab_alloc(c->ctx, count + 1, sizeof *file->fields);
  HETAB_NEED(file->fields);
  for (; file->count < count; file->count++) {
    HETAB_TRY(take_name(c, &file->fields[file->count]));
    HETAB_TRY(take_shape(c, &file->fields[file->count]));
  }
  return HETAB_OK;
}

/* ---- fields against each other ------------------------------------------------------------- */

static const unsigned char *end_of(const hetab_tensor_field *field) {
  return (const unsigned char *)field->data + field_bytes(field);
}

static hetab_status check_fields(const cursor *c) {
  const hetab_tensor_file *file = c->file;
  for (size_t i = 0; i < file->count; i++) {
    const hetab_tensor_field *a = &file->fields[i];
    if (hetab_tensor_elements(a) && (const unsigned char *)a->data < file->bytes + c->at)
      return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s', field %s lies in the file's header",
                        c->path, a->name);
    for (size_t k = 0; k < i; k++) {
      const hetab_tensor_field *b = &file->fields[k];
      if (strcmp(a->name, b->name) == 0)
        return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s' has two fields %s", c->path, a->name);
      if ((const unsigned char *)a->data < end_of(b) && (const unsigned char *)b->data < end_of(a))
        return hetab_fail(c->ctx, HETAB_ERR_PARSE, "'%s': fields %s and %s overlap", c->path,
                          b->name, a->name);
    }
  }
  return HETAB_OK;
}

hetab_status hetab_tensor_load(hetab_context *ctx, const char *path, hetab_tensor_file *out) {
  hetab_status status;
  *out = (hetab_tensor_file){0};
  cursor c = {ctx, path, out, 0};
  HETAB_GOTO(read_bytes(ctx, path, out));
  HETAB_GOTO(take_header(&c, out));
  HETAB_GOTO(check_fields(&c));
  return HETAB_OK;
done:
  hetab_tensor_clear(out);
  return status;
}

void hetab_tensor_clear(hetab_tensor_file *file) {
  free(file->bytes);
  free(file->fields);
  *file = (hetab_tensor_file){0};
}

const hetab_tensor_field *hetab_tensor_find(const hetab_tensor_file *file, const char *name) {
  for (size_t i = 0; i < file->count; i++)
    if (strcmp(file->fields[i].name, name) == 0)
      return &file->fields[i];
  return NULL;
}

/* ---- writing ------------------------------------------------------------------------------- */

static size_t aligned(size_t offset) {
  return (offset + TENSOR_ALIGNMENT - 1) / TENSOR_ALIGNMENT * TENSOR_ALIGNMENT;
}

static size_t header_bytes(const hetab_tensor_field *fields, size_t count) {
  size_t bytes = TENSOR_HEADER;
  for (size_t i = 0; i < count; i++)
    bytes += TENSOR_FIELD + strlen(fields[i].name) + fields[i].ndim * sizeof(uint64_t);
  return bytes;
}

size_t hetab_tensor_bytes(const hetab_tensor_field *fields, size_t count) {
  size_t bytes = header_bytes(fields, count);
  for (size_t i = 0; i < count; i++)
    bytes = aligned(bytes) + field_bytes(&fields[i]);
  return bytes;
}

static void put(unsigned char **at, const void *value, size_t size) {
  memcpy(*at, value, size);
  *at += size;
}

static void put_field(unsigned char **at, const hetab_tensor_field *field, size_t offset) {
  uint16_t length = (uint16_t)strlen(field->name), ndim = (uint16_t)field->ndim;
  uint8_t type = (uint8_t)field->type;
  uint64_t place = offset;
  put(at, &length, sizeof length);
  put(at, field->name, length);
  put(at, &ndim, sizeof ndim);
  put(at, &type, sizeof type);
  put(at, &place, sizeof place);
  for (size_t d = 0; d < field->ndim; d++) {
    uint64_t extent = field->shape[d];
    put(at, &extent, sizeof extent);
  }
}

static hetab_status write_header(hetab_context *ctx, hetab_atomic_file *file,
                                 const hetab_tensor_field *fields, size_t count) {
  unsigned char header[4096], *at = header;
  uint32_t number = (uint32_t)count;
  size_t offset = header_bytes(fields, count);
  if (offset > sizeof header)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "too many fields for a tensor file");
  put(&at, tensor_magic, sizeof tensor_magic);
  put(&at, tensor_version, sizeof tensor_version);
  put(&at, &number, sizeof number);
  for (size_t i = 0; i < count; i++) {
    offset = aligned(offset);
    put_field(&at, &fields[i], offset);
    offset += field_bytes(&fields[i]);
  }
  return hetab_atomic_write(ctx, file, header, (size_t)(at - header));
}

static hetab_status write_fields(hetab_context *ctx, hetab_atomic_file *file,
                                 const hetab_tensor_field *fields, size_t count) {
  static const char zeros[TENSOR_ALIGNMENT] = {0};
  size_t offset = header_bytes(fields, count);
  HETAB_TRY(write_header(ctx, file, fields, count));
  for (size_t i = 0; i < count; i++) {
    size_t start = aligned(offset), bytes = field_bytes(&fields[i]);
    HETAB_TRY(hetab_atomic_write(ctx, file, zeros, start - offset));
    HETAB_TRY(hetab_atomic_write(ctx, file, fields[i].data, bytes));
    offset = start + bytes;
  }
  return HETAB_OK;
}

hetab_status hetab_tensor_save(hetab_context *ctx, const char *path, int overwrite,
                               const hetab_tensor_field *fields, size_t count) {
  hetab_atomic_file *file;
  hetab_status status;
  HETAB_TRY(hetab_atomic_create(ctx, path, overwrite, &file));
  HETAB_GOTO(hetab_atomic_reserve(ctx, file, hetab_tensor_bytes(fields, count)));
  HETAB_GOTO(write_fields(ctx, file, fields, count));
  return hetab_atomic_commit(ctx, file);
done:
  hetab_atomic_abort(file);
  return status;
}
