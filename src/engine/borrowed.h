/* An engine for small jobs, on the devices of another. */
#pragma once

#include <hetab/engine.h>

/* The series at every entry in place of rows, whose polynomials cost a small job more than they
 * save; the literal method stays. Give it back, with hetab_engine_return, before the engine goes.
 */
hetab_status hetab_engine_borrow_series(hetab_context *ctx, const hetab_engine *engine,
                                        hetab_engine **out);
void hetab_engine_return(hetab_engine *borrowed); /* NULL is fine */

/* Number i of a slab's values. */
double hetab_slab_value(const hetab_engine *engine, const void *values, size_t i);
