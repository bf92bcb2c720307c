/* The surfaces of a batch as materials of the renderer's scene. */
#pragma once

#include <jansson.h>
#include <hetab/plan.h>

/* Mitsuba: scene.xml, scene.py and, where a surface needs it, he_torrance.py; pbrt: scene.pbrt;
 * nothing for others. records[surface]. */
hetab_status hetab_renderer_scene(hetab_context *ctx, const hetab_scene *scene,
                                  const hetab_plan *plan, const json_t *records,
                                  const char *folder);
