/* The model at single points, on the device, by the kernels that make the tables. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/host_model.h>
#include <hetab/types.h>

HETAB_BEGIN

/* values[count] for points[count]. Bad points: HETAB_ERR_ARGUMENT naming the index and the field.
 * Error against 40-digit values (tests/test_golden.c): relative <= 1e-5 float, <= 1e-12 double
 * where dd >= 1e-9 / sr; absolute <= 1e-14 below. Except around the critical angle of n < 1 with
 * k near 0 (total reflection), where Fresnel's square root has float lose digits: up to 6e-3 within
 * 0.01 degrees of it, 5e-5 beyond. Never NaN, infinite or negative. The rows method has no rows
 * here: it evaluates the series, as HETAB_METHOD_SERIES. */
hetab_status hetab_evaluate(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, hetab_value *values);

HETAB_END
