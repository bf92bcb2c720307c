/* A MERL table as a renderer looks it up, at places given in cells. */
#pragma once

#include <hetab/audit.h>

#include "table/merl_frame.h"

/* lookup is not HETAB_READ_DEFAULT. */
static inline void hetab_merl_read(const hetab_merl *merl, hetab_reading lookup,
                                   hetab_merl_place place, double rgb[3]) {
  if (lookup == HETAB_READ_INTERPOLATE)
    hetab_merl_read_interpolated(merl, place, rgb);
  else
    hetab_merl_read_truncated(merl, place, rgb);
}
