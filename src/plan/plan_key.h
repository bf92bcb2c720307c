/* What a plan, or one table of it, was made of. */
#pragma once

#include <hetab/plan.h>

enum { HETAB_KEY = 33 };

/* Of the version, the surface and the consumer; of all surfaces and the scene's limits. */
hetab_status hetab_surface_key(hetab_context *ctx, const hetab_scene *scene, size_t i,
                               char key[HETAB_KEY]);
hetab_status hetab_scene_key(hetab_context *ctx, const hetab_scene *scene, char key[HETAB_KEY]);
/* Of the surface's key and what is planned for it. */
hetab_status hetab_item_key(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan,
                            size_t i, char key[HETAB_KEY]);
