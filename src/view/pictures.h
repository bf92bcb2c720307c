/* The pictures of a view as linear data: what <hetab/view.h> says of them. */
#pragma once

#include <hetab/view.h>

#include "view/lobe_table.h"

enum { HETAB_LOBE_POINTS = 479 };

/* The sphere's radius over its image's side. */
#define HETAB_SPHERE_RADIUS 0.46

/* theta_r_deg[HETAB_LOBE_POINTS], ascending, crowded about the mirror direction; rgb likewise. */
hetab_status hetab_view_make_lobe(hetab_context *ctx, const hetab_view_source *source,
                                  double theta_i, float *theta_r_deg, float (*rgb)[3]);

/* rgb[side][side] of theta_i. */
hetab_status hetab_view_make_map(hetab_context *ctx, const hetab_view_source *source,
                                 double theta_i, size_t side, float (*rgb)[3]);

/* rgb[side][side]. */
hetab_status hetab_view_make_sphere(hetab_context *ctx, const hetab_view_source *source,
                                    size_t side, float (*rgb)[3]);
