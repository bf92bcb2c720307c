/* Sizes and marks of tensor files, shared by their reader and their writer. */
#ifndef HETAB_RGL_TENSOR_LAYOUT_H
#define HETAB_RGL_TENSOR_LAYOUT_H

#include "rgl/tensor.h"

static const char tensor_magic[12] = "tensor_file";
static const unsigned char tensor_version[2] = {1, 0};

enum {
  TENSOR_ALIGNMENT = 8,
  TENSOR_HEADER = 12 + 2 + 4,   /* magic, version, number of fields */
  TENSOR_FIELD = 2 + 2 + 1 + 8, /* name length, ndim, type, offset; name and shape come on top */
};

/* Bytes of one number; 0 for what is no type. */
size_t hetab_tensor_type_size(hetab_tensor_type type);

#endif
