/* The values that tables of a surface would hold. */
#pragma once

#include "audit/audit_internal.h"

enum { HETAB_WHERE = 96 };

/* Fills audit->cells, audit->reciprocity and the bands' min and max from the surface computed at
 * every degree of theta_i and theta_r and every second of phi; `where` tells of the worst pair. */
hetab_status hetab_surface_values(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, hetab_audit *audit,
                                  char where[HETAB_WHERE]);
