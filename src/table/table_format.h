/* Which format a table's file has, by its first bytes. */
#ifndef HETAB_TABLE_TABLE_FORMAT_H
#define HETAB_TABLE_TABLE_FORMAT_H

#include <hetab/types.h>

#include "core/context.h"

/* HETAB_ERR_PARSE, naming the formats, if it is none of them. */
hetab_status hetab_format_of(hetab_context *ctx, const char *path, hetab_format *out);

#endif
