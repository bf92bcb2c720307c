#include <string.h>

#include "rgl/tensor.h"
#include "rgl/tensor_layout.h"
#include "core/atomic_file.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "tensor files are little-endian, and this file writes memory as it is");

size_t hetab_tensor_elements(const hetab_tensor_field *field) {
  size_t count = 1;
  for (size_t d = 0; d < field->ndim; d++)
    count *= field->shape[d];
  return count;
}

static size_t field_bytes(const hetab_tensor_field *field) {
  return hetab_tensor_elements(field) * hetab_tensor_type_size(field->type);
}

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
