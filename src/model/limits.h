/* What the model is evaluated for: beyond, arithmetic or the literal reference give out. One table
 * for points, tables and reflectances. */
#pragma once

#include <hetab/types.h>
#include <hetab/surface.h>

#include "core/context.h"

/* HETAB_ERR_ARGUMENT, naming point `index`, the field, its value and the range. */
hetab_status hetab_check_points(hetab_context *ctx, const hetab_point *points, size_t count);

/* The same for every wavelength of a surface; the message names the wavelength. */
hetab_status hetab_check_surface(hetab_context *ctx, const hetab_surface *surface);
