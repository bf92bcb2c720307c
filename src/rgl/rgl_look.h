/* Look-ups of an RGL table that share their work. */
#pragma once

#include <hetab/rgl.h>

#include "table/band_places.h"

/* hetab_rgl_eval() at the places (NULL: all channels) and hetab_rgl_pdf(); value and pdf may be
 * NULL. */
void hetab_rgl_look(const hetab_rgl *rgl, const float wi[3], const float wo[3],
                    const hetab_band_places *places, float *value, float *pdf);
