#include "view/view_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/option_size.h"

enum { LEAST_WIDTH = 640, MOST_WIDTH = 8192, DEFAULT_WIDTH = 1280 };

static hetab_status take_options(hetab_context *ctx, const hetab_view_options *o,
                                 hetab_view *view) {
  static const double usual[] = {0.0, M_PI / 6.0, M_PI / 3.0, 80.0 / 180.0 * M_PI};
  const double *theta = o->theta_i ? o->theta_i : usual;
  size_t count = o->theta_i ? o->theta_i_count : sizeof usual / sizeof *usual;
  size_t width = o->width ? o->width : DEFAULT_WIDTH;
  if (count < 1 || count > HETAB_VIEW_MOST_THETA_I)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "a view of %zu theta_i; give 1 to %d", count,
                      HETAB_VIEW_MOST_THETA_I);
  if (width < LEAST_WIDTH || width > MOST_WIDTH)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "a page of %zu pixels; give %d to %d", width,
                      LEAST_WIDTH, MOST_WIDTH);
  view->what = o->what;
  view->width = (int)width;
  view->exposure = o->exposure;
  view->colour = !(o->wavelength_um > 0);
  view->theta_i_count = count;
  for (size_t i = 0; i < count; i++) {
    if (!(theta[i] >= 0.0 && theta[i] < M_PI_2))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "a view at theta_i = %g degrees; give angles from 0 to below 90",
                        hetab_degrees(theta[i]));
    if (i > 0 && !(theta[i] > theta[i - 1]))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "a view at theta_i = %g degrees after %g; give ascending angles",
                        hetab_degrees(theta[i]), hetab_degrees(theta[i - 1]));
    view->theta_i[i] = theta[i];
  }
  view->map_side = hetab_page_map_side(view);
  view->sphere_side = hetab_page_sphere_side(view);
  return HETAB_OK;
}

static int shows(const hetab_view *view, hetab_view_what what) {
  return view->what == HETAB_VIEW_ALL || view->what == what;
}

static hetab_status fill(hetab_context *ctx, const hetab_view_source *source, hetab_view *view) {
  size_t map = view->map_side * view->map_side, sphere = view->sphere_side * view->sphere_side;
  for (size_t i = 0; i < view->theta_i_count && shows(view, HETAB_VIEW_LOBES); i++) {
    view->lobes[i] = hetab_alloc(ctx, HETAB_LOBE_POINTS, sizeof *view->lobes[i]);
    view->lobe_theta_r_deg[i] = hetab_alloc(ctx, HETAB_LOBE_POINTS, sizeof(float));
    HETAB_NEED(view->lobes[i] && view->lobe_theta_r_deg[i]);
    HETAB_TRY(hetab_view_make_lobe(ctx, source, view->theta_i[i], view->lobe_theta_r_deg[i],
                                   view->lobes[i]));
  }
  for (size_t i = 0; i < view->theta_i_count && shows(view, HETAB_VIEW_MAPS); i++) {
    if (!(view->maps[i] = hetab_alloc(ctx, map, sizeof *view->maps[i])))
      return HETAB_ERR_MEMORY;
    HETAB_TRY(hetab_view_make_map(ctx, source, view->theta_i[i], view->map_side, view->maps[i]));
  }
  if (!shows(view, HETAB_VIEW_SPHERE))
    return HETAB_OK;
  if (!(view->sphere = hetab_alloc(ctx, sphere, sizeof *view->sphere)))
    return HETAB_ERR_MEMORY;
  return hetab_view_make_sphere(ctx, source, view->sphere_side, view->sphere);
}

/* Takes over what the source holds. */
static hetab_status make_view(hetab_context *ctx, hetab_view_source *source,
                              const hetab_view_options *options, hetab_view **out) {
  hetab_view *view = hetab_alloc(ctx, 1, sizeof *view);
  hetab_status status = view ? take_options(ctx, options, view) : HETAB_ERR_MEMORY;
  if (status == HETAB_OK) {
    memcpy(view->title, source->title, sizeof view->title);
    memcpy(view->subtitle, source->subtitle, sizeof view->subtitle);
    status = fill(ctx, source, view);
  }
  hetab_view_source_clear(source);
  *out = view;
  HETAB_MADE(hetab_view, out, status);
}

hetab_status hetab_view_surface(hetab_context *ctx, hetab_engine *engine,
                                const hetab_surface *surface, const hetab_view_options *options,
                                hetab_view **out) {
  hetab_view_source source;
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_view_options, o, options);
  HETAB_TRY(hetab_view_source_surface(ctx, engine, surface, o.wavelength_um, &source));
  return make_view(ctx, &source, &o, out);
}

hetab_status hetab_view_table(hetab_context *ctx, const hetab_lookup *table, const char *title,
                              const hetab_view_options *options, hetab_view **out) {
  hetab_view_source source;
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_view_options, o, options);
  HETAB_TRY(hetab_view_source_table(ctx, table, title, o.wavelength_um, &source));
  return make_view(ctx, &source, &o, out);
}

void hetab_view_free(hetab_view *view) {
  for (size_t i = 0; view && i < HETAB_VIEW_MOST_THETA_I; i++) {
    free(view->lobes[i]);
    free(view->lobe_theta_r_deg[i]);
    free(view->maps[i]);
  }
  if (view)
    free(view->sphere);
  free(view);
}

/* ---- the data ------------------------------------------------------------------------------ */

const float *hetab_view_sphere(const hetab_view *view, size_t *side) {
  *side = view->sphere_side;
  return view->sphere ? view->sphere[0] : NULL;
}

const float *hetab_view_map(const hetab_view *view, size_t i, size_t *side) {
  *side = view->map_side;
  return i < view->theta_i_count && view->maps[i] ? view->maps[i][0] : NULL;
}

const float *hetab_view_lobe(const hetab_view *view, size_t i, size_t *count) {
  *count = HETAB_LOBE_POINTS;
  return i < view->theta_i_count && view->lobes[i] ? view->lobes[i][0] : NULL;
}

void hetab_view_lobe_theta_r(const hetab_view *view, size_t i, float *theta_r) {
  for (size_t k = 0; i < view->theta_i_count && view->lobes[i] && k < HETAB_LOBE_POINTS; k++)
    theta_r[k] = (float)hetab_radians((double)view->lobe_theta_r_deg[i][k]);
}
