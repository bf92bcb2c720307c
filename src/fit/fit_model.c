/* The model at the measured pairs: a surface without a diffuse part, whose roughness changes. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdlib.h>

#include "surface/index_parts.h"
#include "surface/surface_parts.h"

/* ---- the surface ----------------------------------------------------------------------------- */

static hetab_status make_surface(hetab_context *ctx, const hetab_fit_options *options,
                                 const hetab_fit_data *data, hetab_surface **out) {
  HETAB_TRY(hetab_surface_new(ctx, "fit", out));
  (*out)->sigma0_um = (*out)->tau_um = 1;
  (*out)->extrapolate = options->extrapolate_index;
  HETAB_TRY(hetab_index_copy(ctx, options->index, &(*out)->index));
  return hetab_surface_sample(ctx, *out, data->lambda_um, data->bands);
}

hetab_status hetab_fit_model_create(hetab_context *ctx, hetab_engine *engine,
                                    const hetab_fit_options *options, const hetab_fit_data *data,
                                    hetab_fit_model *model) {
  model->engine = engine;
  HETAB_TRY(make_surface(ctx, options, data, &model->surface));
  model->reflectances =
      hetab_alloc(ctx, data->bands * data->incidence_count, sizeof *model->reflectances);
  model->theta_i = hetab_alloc(ctx, data->incidence_count, sizeof *model->theta_i);
  HETAB_NEED(model->reflectances && model->theta_i);
  return hetab_places_create(ctx, engine, &model->places);
}

void hetab_fit_model_clear(hetab_fit_model *model) {
  hetab_places_free(model->places);
  hetab_surface_free(model->surface);
  free(model->reflectances);
  free(model->theta_i);
  *model = (hetab_fit_model){0};
}

void hetab_fit_model_set(hetab_fit_model *model, double sigma0_um, double tau_um, double n) {
  model->surface->sigma0_um = sigma0_um;
  model->surface->tau_um = tau_um;
  for (size_t b = 0; n > 0 && b < model->surface->count; b++)
    model->surface->bands[b].n = n;
}

/* ---- f_dd ------------------------------------------------------------------------------------ */

hetab_status hetab_fit_model_dd(hetab_context *ctx, hetab_fit_model *model,
                                const hetab_directions *pairs, size_t count, double *dd) {
  const hetab_surface *surface = model->surface;
  return hetab_places_evaluate(ctx, model->places, surface->sigma0_um, surface->tau_um,
                               surface->bands, surface->count, NULL, pairs, count, dd);
}

/* ---- the constraint -------------------------------------------------------------------------- */

/* The integrals' own progress is not the fit's. */
static hetab_status integrate(hetab_context *ctx, hetab_fit_model *model, const double *theta_i,
                              size_t count) {
  double tolerance = hetab_engine_precision(model->engine) == HETAB_DOUBLE ? 1e-7 : 1e-5;
  hetab_progress_fn progress = ctx->progress;
  ctx->progress = NULL;
  hetab_status status = hetab_reflectance_dh(ctx, model->engine, model->surface, theta_i, count,
                                             tolerance, model->reflectances);
  ctx->progress = progress;
  return status;
}

hetab_status hetab_fit_model_room(hetab_context *ctx, hetab_fit_model *model,
                                  const hetab_fit_data *data, hetab_fit_constraint constraint,
                                  const unsigned char *active, double *room) {
  size_t count = 0;
  for (size_t t = 0; t < data->incidence_count; t++)
    if (!active || active[t])
      model->theta_i[count++] = data->theta_i[t];
  HETAB_TRY(integrate(ctx, model, model->theta_i, count));
  for (size_t t = 0, a = 0; t < data->incidence_count; t++) {
    int known = !active || active[t];
    for (size_t b = 0; b < data->bands; b++) {
      const hetab_reflectance *r = &model->reflectances[b * count + a];
      double left = (constraint == HETAB_FIT_ENERGY ? 1 : r->fresnel) - r->dd.value - r->specular;
      if (model->own_excess > 0)
        left = fmax(left, fmin(HETAB_FIT_SLACK, left + model->own_excess * r->fresnel));
      room[t * data->bands + b] = known ? left : HUGE_VAL;
    }
    a += (size_t)(known && a + 1 < count);
  }
  return HETAB_OK;
}
