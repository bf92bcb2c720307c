#pragma once

#include "rgl/rgl_build.h"

/* The size of the file that hetab_rgl_save() writes. */
hetab_status hetab_rgl_bytes(hetab_context *ctx, const hetab_rgl *rgl, size_t *bytes);

/* The same of a table of the source that is yet to be made. */
hetab_status hetab_rgl_shape_bytes(hetab_context *ctx, const hetab_rgl_source *source,
                                   const hetab_rgl_shape *shape, size_t *bytes);
