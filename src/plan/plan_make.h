/* The making of a plan, alone or with others. */
#pragma once

#include <hetab/plan.h>

/* folder and share_start as in hetab_probe_all(). */
hetab_status hetab_plan_make(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share_start, hetab_plan **out);
