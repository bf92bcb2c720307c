/* Measured MERL tables without their holes. */
#pragma once

#include <hetab/merl.h>

#include "core/context.h"
#include "table/merl_frame.h"

/* How many cells whose middle is above the horizon have no value: marked, negative, infinite or not
 * a number in any channel. */
size_t hetab_merl_holes(const hetab_merl *merl);

/* Gives every cell a value, below the horizon too: ring by ring, the geometric mean of the
 * neighbours that have one. HETAB_ERR_PARSE if no cell has. */
hetab_status hetab_merl_mend(hetab_context *ctx, const char *path, hetab_merl *merl);
