/* The model at the measured pairs. As hetab_evaluate, but what depends on the directions alone is
 * computed once for all wavelengths, and the kernel is kept between evaluations. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdlib.h>

#include "cl/device.h"
#include "engine/engine_internal.h"
#include "kernels/tables.h"
#include "model/model.h"
#include "surface/index_parts.h"
#include "surface/surface_parts.h"

enum { BATCH = 1 << 16 }; /* of values */

/* ---- the surface ------------------------------------------------------------------------------
 */

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
  if (hetab_engine_method(engine) == HETAB_METHOD_LITERAL)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "fits run on a device: create the engine with the series method");
  model->engine = engine;
  HETAB_TRY(make_surface(ctx, options, data, &model->surface));
  model->columns = hetab_alloc(ctx, (size_t)BATCH * HETAB_POINT_REALS, sizeof *model->columns);
  model->reflectances =
      hetab_alloc(ctx, data->bands * data->incidence_count, sizeof *model->reflectances);
  model->theta_i = hetab_alloc(ctx, data->incidence_count, sizeof *model->theta_i);
  if (!model->columns || !model->reflectances || !model->theta_i)
    return HETAB_ERR_MEMORY;
  return hetab_lane_kernel(ctx, engine, &engine->lanes[0], NULL, "points", "hetab_k_points",
                           &model->kernel);
}

void hetab_fit_model_clear(hetab_fit_model *model) {
  if (model->kernel)
    clReleaseKernel(model->kernel);
  hetab_surface_free(model->surface);
  free(model->columns);
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

/* ---- f_dd -------------------------------------------------------------------------------------
 */

/* Columns as kernels/tables.h orders them; the specular term is left at nothing. */
static void fill_pair(const hetab_surface *surface, const hetab_wave *waves,
                      const hetab_directions *p, size_t first, size_t stride, double *columns) {
  double tau_2sigma = surface->tau_um / (2 * surface->sigma0_um);
  hetab_direction in = hetab_direction_at(p->theta_i, tau_2sigma);
  hetab_direction out = hetab_direction_at(p->theta_r, tau_2sigma);
  hetab_pair pair = hetab_pair_of(&in, &out);
  double lateral2 = pair.d2 + pair.p * hetab_one_plus_cos(p->phi);
  for (size_t b = 0; b < surface->count; b++) {
    const hetab_wave *w = &waves[b];
    const double values[HETAB_POINT_REALS] = {w->g,     w->x,     w->amplitude, w->e1,       w->nk,
                                              pair.mu2, lateral2, pair.shadow,  pair.ratio2, in.mu,
                                              0,        0};
    for (size_t c = 0; c < HETAB_POINT_REALS; c++)
      columns[c * stride + first + b] = values[c];
  }
}

/* The padding repeats the last value. */
static void pad(size_t count, size_t stride, double *columns) {
  for (size_t c = 0; c < HETAB_POINT_REALS; c++)
    for (size_t i = count; i < stride; i++)
      columns[c * stride + i] = columns[c * stride + count - 1];
}

static hetab_status run_kernel(hetab_context *ctx, const hetab_fit_model *model, size_t count,
                               size_t stride, double *dd) {
  const hetab_engine *engine = model->engine;
  const hetab_lane *lane = &engine->lanes[0];
  cl_mem in = NULL, out = NULL;
  cl_int error = CL_SUCCESS;
  hetab_status status;
  HETAB_GOTO(hetab_lane_upload(ctx, engine, lane, model->columns, stride * HETAB_POINT_REALS, &in));
  HETAB_GOTO(hetab_lane_output(ctx, engine, lane, stride * HETAB_RESULT_REALS, &out));
  hetab_args args = {ctx, engine, lane, model->kernel, 0, HETAB_OK};
  hetab_arg_mem(&args, in);
  hetab_arg_int(&args, stride);
  hetab_arg_mem(&args, out);
  HETAB_GOTO(args.status);
  size_t global = stride / (size_t)lane->vector_width;
  error = clEnqueueNDRangeKernel(lane->queue, model->kernel, 1, NULL, &global, NULL, 0, NULL, NULL);
  HETAB_GOTO(hetab_cl_check(ctx, error, "clEnqueueNDRangeKernel", lane->device));
  void *results = clEnqueueMapBuffer(lane->queue, out, CL_TRUE, CL_MAP_READ, 0,
                                     stride * hetab_real_size(engine), 0, NULL, NULL, &error);
  HETAB_GOTO(hetab_cl_check(ctx, error, "clEnqueueMapBuffer", lane->device));
  for (size_t i = 0; i < count; i++)
    dd[i] = hetab_real_at(engine, results, i);
  clEnqueueUnmapMemObject(lane->queue, out, results, 0, NULL, NULL);
  clFinish(lane->queue);
done:
  hetab_release(in);
  hetab_release(out);
  return status;
}

hetab_status hetab_fit_model_dd(hetab_context *ctx, hetab_fit_model *model,
                                const hetab_directions *pairs, size_t count, double *dd) {
  const hetab_surface *surface = model->surface;
  hetab_wave waves[HETAB_FIT_MOST_BANDS];
  size_t bands = surface->count, batch = BATCH / bands;
  for (size_t b = 0; b < bands; b++)
    waves[b] = hetab_wave_of(surface->sigma0_um, surface->tau_um, &surface->bands[b]);
  for (size_t first = 0; first < count; first += batch) {
    size_t here = count - first < batch ? count - first : batch;
    size_t stride = (here * bands + 15) / 16 * 16;
    for (size_t i = 0; i < here; i++)
      fill_pair(surface, waves, &pairs[first + i], i * bands, stride, model->columns);
    pad(here * bands, stride, model->columns);
    HETAB_TRY(run_kernel(ctx, model, here * bands, stride, dd + first * bands));
  }
  return HETAB_OK;
}

/* ---- the constraint ---------------------------------------------------------------------------
 */

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
      double bound = constraint == HETAB_FIT_ENERGY ? 1 : r->fresnel;
      room[t * data->bands + b] = known ? bound - r->dd.value - r->specular : HUGE_VAL;
    }
    a += (size_t)(known && a + 1 < count);
  }
  return HETAB_OK;
}
