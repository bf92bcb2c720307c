/* The formats of tables: their names, endings and first bytes. */
#pragma once

#include <stdbool.h>
#include <hetab/types.h>

#include "core/context.h"

enum { HETAB_FORMAT_START = 12 };         /* bytes that tell */
#define HETAB_RGL_SIGNATURE "tensor_file" /* its NUL belongs to it */

/* Which format a file that begins so has; false: none of them. */
bool hetab_format_by_start(const unsigned char start[HETAB_FORMAT_START], hetab_format *out);

/* Of a file that can be read as a table (an OpenEXR file is none). HETAB_ERR_PARSE, naming the
 * formats, if it is none of them. */
hetab_status hetab_format_of(hetab_context *ctx, const char *path, hetab_format *out);
