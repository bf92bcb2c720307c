/* Single points: angles become the kernel's columns in double, so that nothing cancels in float. */
#include <hetab/evaluate.h>

#include <math.h>
#include <stdlib.h>

#include "cl/device.h"
#include "core/clock.h"
#include "engine/engine_internal.h"
#include "kernels/tables.h"
#include "model/limits.h"
#include "model/model.h"

enum { BATCH = 1 << 16 };

/* Column c of point i is at columns[c * stride + i]; the order is kernels/tables.h's. */
static void fill_columns(const hetab_point *p, size_t i, size_t stride, double *columns) {
  double tau_2sigma = p->tau_um / (2.0 * p->sigma0_um);
  hetab_direction in = hetab_direction_at(p->theta_i, tau_2sigma);
  hetab_direction out = hetab_direction_at(p->theta_r, tau_2sigma);
  hetab_pair pair = hetab_pair_of(&in, &out), mirror = hetab_pair_of(&in, &in);
  hetab_band band = {p->lambda_um, p->n, p->k, p->diffuse_brdf};
  hetab_wave wave = hetab_wave_of(p->sigma0_um, p->tau_um, &band);
  double s = in.shadow_over_cos * in.mu;
  const double values[HETAB_POINT_REALS] = {wave.g,
                                            wave.x,
                                            wave.amplitude,
                                            wave.e1,
                                            wave.nk,
                                            pair.mu2,
                                            pair.d2 + pair.p * hetab_one_plus_cos(p->phi),
                                            pair.shadow,
                                            pair.ratio2,
                                            in.mu,
                                            s * s,
                                            mirror.ratio2};
  for (size_t c = 0; c < HETAB_POINT_REALS; c++)
    columns[c * stride + i] = values[c];
}

static void take_results(const hetab_engine *engine, const void *results, size_t stride,
                         const hetab_point *points, size_t count, hetab_value *values) {
  for (size_t i = 0; i < count; i++) {
    values[i] = (hetab_value){.dd = hetab_real_at(engine, results, i),
                              .specular = hetab_real_at(engine, results, stride + i),
                              .ud = points[i].diffuse_brdf,
                              .g = hetab_real_at(engine, results, 2 * stride + i),
                              .x = hetab_real_at(engine, results, 3 * stride + i)};
    values[i].total = values[i].dd + values[i].ud;
  }
}

static hetab_status run_batch(hetab_context *ctx, const hetab_engine *engine, cl_kernel kernel,
                              const hetab_point *points, size_t count, double *columns,
                              hetab_value *values) {
  const hetab_lane *lane = &engine->lanes[0];
  cl_mem in = NULL, out = NULL;
  cl_int error = CL_SUCCESS;
  hetab_status status;
  size_t stride = (count + 15) / 16 * 16;
  for (size_t i = 0; i < stride; i++) /* the padding repeats the last point */
    fill_columns(&points[i < count ? i : count - 1], i, stride, columns);
  HETAB_GOTO(hetab_lane_upload(ctx, engine, lane, columns, stride * HETAB_POINT_REALS, &in));
  HETAB_GOTO(hetab_lane_output(ctx, engine, lane, stride * HETAB_RESULT_REALS, &out));
  hetab_args args = {ctx, engine, lane, kernel, 0, HETAB_OK};
  hetab_arg_mem(&args, in);
  hetab_arg_int(&args, stride);
  hetab_arg_mem(&args, out);
  HETAB_GOTO(args.status);
  size_t global = stride / (size_t)lane->vector_width;
  error = clEnqueueNDRangeKernel(lane->queue, kernel, 1, NULL, &global, NULL, 0, NULL, NULL);
  HETAB_GOTO(hetab_cl_check(ctx, error, "clEnqueueNDRangeKernel", lane->device));
  void *results = clEnqueueMapBuffer(lane->queue, out, CL_TRUE, CL_MAP_READ, 0,
                                     stride * HETAB_RESULT_REALS * hetab_real_size(engine), 0, NULL,
                                     NULL, &error);
  HETAB_GOTO(hetab_cl_check(ctx, error, "clEnqueueMapBuffer", lane->device));
  take_results(engine, results, stride, points, count, values);
  clEnqueueUnmapMemObject(lane->queue, out, results, 0, NULL, NULL);
  clFinish(lane->queue);
done:
  hetab_release(in);
  hetab_release(out);
  return status;
}

static hetab_status run_batches(hetab_context *ctx, const hetab_engine *engine, cl_kernel kernel,
                                const hetab_point *points, size_t count, hetab_value *values) {
  hetab_status status = HETAB_OK;
  double *columns = hetab_alloc(ctx, (size_t)BATCH * HETAB_POINT_REALS, sizeof *columns);
  if (!columns)
    return HETAB_ERR_MEMORY;
  for (size_t first = 0; first < count && status == HETAB_OK; first += BATCH) {
    size_t batch = count - first < BATCH ? count - first : BATCH;
    status = run_batch(ctx, engine, kernel, points + first, batch, columns, values + first);
    if (status == HETAB_OK)
      status = hetab_progress(ctx, (double)(first + batch), (double)count);
  }
  free(columns);
  return status;
}

hetab_status hetab_evaluate(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, hetab_value *values) {
  cl_kernel kernel;
  HETAB_TRY(hetab_check_points(ctx, points, count));
  if (engine->method == HETAB_METHOD_LITERAL)
    return hetab_evaluate_literal(ctx, points, count, values);
  HETAB_TRY(
      hetab_lane_kernel(ctx, engine, &engine->lanes[0], NULL, "points", "hetab_k_points", &kernel));
  hetab_status status = run_batches(ctx, engine, kernel, points, count, values);
  clReleaseKernel(kernel);
  return status;
}
