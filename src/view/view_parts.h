/* A view's data, and what draws them. */
#pragma once

#include <hetab/view.h>

#include "view/canvas.h"
#include "view/pictures.h"

struct hetab_view {
  hetab_view_what what;
  int width; /* of the page */
  double exposure;
  int colour; /* else one wavelength */
  char title[96], subtitle[160];
  size_t theta_i_count, map_side, sphere_side;
  double theta_i[HETAB_VIEW_MOST_THETA_I];
  float (*lobes[HETAB_VIEW_MOST_THETA_I])[3]; /* [HETAB_LOBE_POINTS] */
  float *lobe_theta_r_deg[HETAB_VIEW_MOST_THETA_I];
  float (*maps[HETAB_VIEW_MOST_THETA_I])[3]; /* [map_side][map_side] */
  float (*sphere)[3];                        /* [sphere_side][sphere_side] */
};

/* Pixels that the page has for the two. */
size_t hetab_page_map_side(const hetab_view *view);
size_t hetab_page_sphere_side(const hetab_view *view);

hetab_status hetab_page_draw(hetab_context *ctx, const hetab_view *view, hetab_canvas *page);
