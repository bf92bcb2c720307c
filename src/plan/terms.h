/* What a surface needs, before the table's error is known: which terms, who carries the delta, and
 * whether a material of the renderer's does. */
#pragma once

#include <hetab/plan.h>

/* Sets the item's kind (TABLE, MIRROR or PLAIN), terms and what they are worth. */
hetab_status hetab_plan_terms(hetab_context *ctx, const hetab_scene *scene,
                              const hetab_surface *surface, hetab_plan_item *item);

/* How a renderer that is linear between the wavelengths of a table misses those left out. Choices
 * are counts, ascending: every s-th wavelength of the surface, where s divides them evenly; the
 * last has all of them. */
enum { HETAB_PLAN_COUNTS = 12 };
typedef struct hetab_plan_counts {
  size_t choices, count[HETAB_PLAN_COUNTS];
  double error[HETAB_PLAN_COUNTS]; /* relative L1, the delta with it, of the worst incidence */
} hetab_plan_counts;

hetab_status hetab_plan_count_errors(hetab_context *ctx, const hetab_scene *scene,
                                     const hetab_surface *surface, hetab_plan_counts *out);
/* The surface at `count` of its wavelengths, evenly chosen; hetab_surface_free() it. */
hetab_status hetab_plan_thinned(hetab_context *ctx, const hetab_surface *surface, size_t count,
                                hetab_surface **out);
