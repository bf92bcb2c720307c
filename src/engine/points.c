/* Single points: angles become the kernel's columns in double, so that nothing cancels in float. */
#include <hetab/evaluate.h>

#include <math.h>
#include <stdlib.h>

#include "cl/device.h"
#include "engine/engine_internal.h"
#include "kernels/tables.h"
#include "model/model.h"

enum { BATCH = 1 << 16 };

static hetab_status check_point(hetab_context *ctx, const hetab_point *p, size_t index) {
  const struct {
    const char *name;
    double value, low, high;
  } fields[] = {
      {"lambda_um", p->lambda_um, 1e-6, 1e6},
      {"theta_i", p->theta_i, 0.0, M_PI_2},
      {"theta_r", p->theta_r, 0.0, M_PI_2},
      {"phi", p->phi, -1e6, 1e6},
      {"sigma0_um", p->sigma0_um, 1e-9, 1e6},
      {"tau_um", p->tau_um, 1e-9, 1e6},
      {"n", p->n, 1e-6, 1e3},
      {"k", p->k, 0.0, 1e3},
      {"diffuse_brdf", p->diffuse_brdf, 0.0, 1e3},
  };
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
    if (!(fields[i].value >= fields[i].low && fields[i].value <= fields[i].high))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "point %zu: %s = %g is not in [%g, %g]", index,
                        fields[i].name, fields[i].value, fields[i].low, fields[i].high);
  return HETAB_OK;
}

static hetab_status check_points(hetab_context *ctx, const hetab_point *points, size_t count) {
  for (size_t i = 0; i < count; i++)
    HETAB_TRY(check_point(ctx, &points[i], i));
  return HETAB_OK;
}

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
  HETAB_TRY(check_points(ctx, points, count));
  if (engine->method == HETAB_METHOD_LITERAL)
    return hetab_evaluate_literal(ctx, points, count, values);
  HETAB_TRY(
      hetab_lane_kernel(ctx, engine, &engine->lanes[0], NULL, "points", "hetab_k_points", &kernel));
  hetab_status status = run_batches(ctx, engine, kernel, points, count, values);
  clReleaseKernel(kernel);
  return status;
}

hetab_status hetab_evaluate_literal(hetab_context *ctx, const hetab_point *points, size_t count,
                                    hetab_value *values) {
  HETAB_TRY(check_points(ctx, points, count));
  for (size_t i = 0; i < count; i++)
    values[i] = hetab_literal(&points[i]);
  return HETAB_OK;
}
