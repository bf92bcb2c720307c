/* Tensor files: named arrays in one little-endian container, as RGL tables are stored.
 *
 *   char[12] "tensor_file\0", u8 1, u8 0, u32 number of fields; per field u16 name length, name
 *   without NUL, u16 ndim, u8 dtype, u64 absolute offset, u64 shape[ndim]; then the data in C
 *   order, each array aligned to 8 bytes. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/context.h"

/* The format's numbers for its types. */
typedef enum hetab_tensor_type {
  HETAB_TENSOR_U8 = 1,
  HETAB_TENSOR_I8,
  HETAB_TENSOR_U16,
  HETAB_TENSOR_I16,
  HETAB_TENSOR_U32,
  HETAB_TENSOR_I32,
  HETAB_TENSOR_U64,
  HETAB_TENSOR_I64,
  HETAB_TENSOR_F16,
  HETAB_TENSOR_F32,
  HETAB_TENSOR_F64
} hetab_tensor_type;

enum { HETAB_TENSOR_NAME = 64, HETAB_TENSOR_DIMS = 8 };

typedef struct hetab_tensor_field {
  char name[HETAB_TENSOR_NAME];
  hetab_tensor_type type;
  size_t ndim;
  size_t shape[HETAB_TENSOR_DIMS];
  const void *data; /* as in the file: perhaps not aligned */
} hetab_tensor_field;

typedef struct hetab_tensor_file {
  unsigned char *bytes; /* the whole file; the fields point into it */
  size_t size;
  size_t count;
  hetab_tensor_field *fields;
} hetab_tensor_file;

/* Reads and checks the container: names, types, sizes and offsets; what the arrays hold is not
 * looked at. HETAB_ERR_PARSE names the field. */
hetab_status hetab_tensor_load(hetab_context *ctx, const char *path, hetab_tensor_file *out);
void hetab_tensor_clear(hetab_tensor_file *file);
/* NULL if there is none. */
const hetab_tensor_field *hetab_tensor_find(const hetab_tensor_file *file, const char *name);
/* Numbers in an array. */
size_t hetab_tensor_elements(const hetab_tensor_field *field);
const char *hetab_tensor_type_name(hetab_tensor_type type); /* "float32" */

/* Whole or not at all. */
hetab_status hetab_tensor_save(hetab_context *ctx, const char *path, int overwrite,
                               const hetab_tensor_field *fields, size_t count);
/* The size of such a file. */
size_t hetab_tensor_bytes(const hetab_tensor_field *fields, size_t count);
