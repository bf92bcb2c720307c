/* A lit sphere, small enough to stand in a page: PNG in base64. */
#pragma once

#include <hetab/rgl.h>

/* free() it; NULL without memory. Spectra are shown by the channels next to 650, 550 and 450 nm. */
char *hetab_thumbnail(hetab_context *ctx, const hetab_rgl *rgl);
