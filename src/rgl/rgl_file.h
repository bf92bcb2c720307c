#ifndef HETAB_RGL_RGL_FILE_H
#define HETAB_RGL_RGL_FILE_H

#include <hetab/rgl.h>

/* The size of the file that hetab_rgl_save() writes. */
hetab_status hetab_rgl_bytes(hetab_context *ctx, const hetab_rgl *rgl, size_t *bytes);

#endif
