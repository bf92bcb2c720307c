/* The model as a source of RGL tables, on the host, on all cores. */
#pragma once

#include <hetab/surface.h>

#include "rgl/rgl_build.h"

typedef struct hetab_rgl_model hetab_rgl_model;

/* The surface has to live as long. Values are within 1e-4, relative L1, of the
 * series. options: the bands and the cone count. */
hetab_status hetab_rgl_model_create(hetab_context *ctx, const hetab_surface *surface,
                                    const hetab_rgl_options *options, hetab_rgl_model **out);
void hetab_rgl_model_free(hetab_rgl_model *model); /* NULL is fine */
const hetab_rgl_source *hetab_rgl_model_source(const hetab_rgl_model *model);
