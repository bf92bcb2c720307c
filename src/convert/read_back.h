#pragma once

#include <hetab/types.h>

/* Reads a table as readers would; the name may be any. exr_parts: how many an OpenEXR file has. */
hetab_status hetab_read_back(hetab_context *ctx, hetab_format format, const char *path,
                             size_t exr_parts);
