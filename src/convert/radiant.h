/* Whether all values are finite and not negative, at a memory's speed. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include <hetab/types.h>

/* values[count] of that precision; as_floats: doubles have to be finite as floats, too. */
bool hetab_radiant(const void *values, size_t count, hetab_precision precision, bool as_floats);

/* The sample is of all that was evaluated: a second look at dense tables, and the one at MERL
 * tables before hetab_merl_save goes through their cells. */
hetab_status hetab_report_radiant(hetab_context *ctx, const hetab_report *report);
