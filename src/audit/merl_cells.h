/* The cells of a MERL table, one by one. */
#pragma once

#include "audit/audit_internal.h"

/* Fills audit->cells, isotropy and bilateral, and adds the checks "finite", "negative", "horizon",
 * "reciprocity", "isotropy" and "bilateral". */
void hetab_audit_merl_cells(const hetab_merl *merl, hetab_audit *audit);
