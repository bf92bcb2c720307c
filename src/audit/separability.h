/* How much of a dense table one product of functions holds. */
#pragma once

#include "audit/dense_table.h"

/* The largest s such that f(theta_i, theta_r, phi) = u(theta_i) v(theta_r, phi) explains that share
 * of the sum of squares: the first singular value's (after DeYoung & Fournier, Graphics Interface
 * 1997). 1: the table is one product; entries that are no numbers count as 0. */
hetab_status hetab_separability(hetab_context *ctx, const hetab_dense_table *table, double *share);
