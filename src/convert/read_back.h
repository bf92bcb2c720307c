/* Whether a file that was written can be read: what cannot is not published. */
#ifndef HETAB_CONVERT_READ_BACK_H
#define HETAB_CONVERT_READ_BACK_H

#include <stddef.h>
#include <hetab/types.h>

/* As its readers do it; exr_parts: how many an OpenEXR file has. */
hetab_status hetab_read_back(hetab_context *ctx, hetab_format format, const char *path,
                             size_t exr_parts);

#endif
