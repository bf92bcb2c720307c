#include "engine/engine_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/device.h"
#include "cl/program.h"
#include "kernels/tables.h"

#include "core/option_size.h"

/* What the rows method can keep at best and keeps by default: float arithmetic rounds the exponent
 * to up to 8e-6, double and its polynomials give out at about 1e-11. */
static const double FLOAT_LEAST = 1e-5, FLOAT_USUAL = 1e-5;
static const double DOUBLE_LEAST = 1e-11, DOUBLE_USUAL = 1e-9;

hetab_precision hetab_engine_precision(const hetab_engine *engine) {
  return engine->precision;
}

hetab_method hetab_engine_method(const hetab_engine *engine) {
  return engine->method;
}

double hetab_engine_tolerance(const hetab_engine *engine) {
  return engine->tolerance;
}

const char *hetab_engine_device(const hetab_engine *engine) {
  return engine->device_text;
}

size_t hetab_real_size(const hetab_engine *engine) {
  return engine->precision == HETAB_DOUBLE ? sizeof(double) : sizeof(float);
}

double hetab_real_at(const hetab_engine *engine, const void *reals, size_t i) {
  return engine->precision == HETAB_DOUBLE ? ((const double *)reals)[i]
                                           : (double)((const float *)reals)[i];
}

static int power_of_two_up_to_16(cl_uint width) {
  int power = 1;
  while (power < 16 && 2 * power <= (int)width)
    power *= 2;
  return power;
}

/* CPUs want explicit vectors and a few rows a work-group; GPUs scalars and a work-group along the
 * row, so that neighbours store neighbours. */
static void choose_shape(hetab_lane *lane, hetab_precision precision) {
  cl_device_info width = precision == HETAB_DOUBLE ? CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE
                                                   : CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT;
  if (hetab_cl_device_is_cpu(lane->device)) {
    lane->vector_width = power_of_two_up_to_16(hetab_cl_device_uint(lane->device, width));
    lane->row_items = 1;
    lane->group_rows = 8;
  } else {
    lane->vector_width = 1;
    lane->row_items = 64;
    lane->group_rows = 1;
  }
}

static hetab_status open_lane(hetab_context *ctx, const hetab_engine *engine, cl_device_id device,
                              hetab_lane *lane) {
  cl_int error = CL_SUCCESS;
  lane->device = device;
  if (engine->precision == HETAB_DOUBLE &&
      hetab_cl_device_uint(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE) == 0) {
    char name[128];
    hetab_cl_device_text(device, CL_DEVICE_NAME, name, sizeof name);
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "%s has no double precision (fp64); use float, or another device", name);
  }
  choose_shape(lane, engine->precision);
  lane->context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
  HETAB_TRY(hetab_cl_check(ctx, error, "clCreateContext", device));
  lane->queue = clCreateCommandQueue(lane->context, device, 0, &error);
  return hetab_cl_check(ctx, error, "clCreateCommandQueue", device);
}

/* Every lane in words, and all of them. */
static void describe(hetab_engine *engine) {
  size_t length = 0;
  for (int i = 0; i < engine->lane_count; i++) {
    hetab_lane *lane = &engine->lanes[i];
    char name[128];
    hetab_cl_device_text(lane->device, CL_DEVICE_NAME, name, sizeof name);
    snprintf(lane->text, sizeof lane->text, "%s, %u compute units", name,
             hetab_cl_device_uint(lane->device, CL_DEVICE_MAX_COMPUTE_UNITS));
    int written = snprintf(engine->device_text + length, sizeof engine->device_text - length,
                           "%s%s", i ? "; " : "", lane->text);
    if (written < 0 || (length += (size_t)written) >= sizeof engine->device_text)
      return;
  }
}

hetab_report hetab_report_of(const hetab_engine *engine, const char *device) {
  hetab_report report = {
      .method = engine->method, .precision = engine->precision, .tolerance = engine->tolerance};
  snprintf(report.device, sizeof report.device, "%s", device);
  return report;
}

static hetab_status open_lanes(hetab_context *ctx, const char *selector, hetab_engine *engine) {
  cl_device_id *devices;
  size_t count;
  hetab_status status = HETAB_OK;
  HETAB_TRY(hetab_cl_select(ctx, selector, &devices, &count));
  for (size_t i = 0; i < count && i < HETAB_MOST_LANES && status == HETAB_OK; i++)
    status = open_lane(ctx, engine, devices[i], &engine->lanes[engine->lane_count++]);
  free(devices);
  describe(engine);
  return status;
}

hetab_status hetab_check_tolerance(hetab_context *ctx, double tolerance) {
  if (tolerance >= 0.0 && tolerance < 1.0)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "tolerance %g: give a relative error between 0 and 1, for example 1e-5",
                    tolerance);
}

static hetab_status check_rows_tolerance(hetab_context *ctx, const hetab_engine_options *o) {
  double least = o->precision == HETAB_DOUBLE ? DOUBLE_LEAST : FLOAT_LEAST;
  HETAB_TRY(hetab_check_tolerance(ctx, o->tolerance));
  if (o->method != HETAB_METHOD_ROWS || o->tolerance == 0.0 || o->tolerance >= least)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "tolerance %g is below %g, what rows in %s can keep; use %s", o->tolerance,
                    least, hetab_precision_name(o->precision),
                    o->precision == HETAB_DOUBLE ? "the series method" : "double precision");
}

hetab_status hetab_engine_create(hetab_context *ctx, const hetab_engine_options *options,
                                 hetab_engine **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_engine_options, o, options);
  HETAB_TRY(check_rows_tolerance(ctx, &o));
  hetab_engine *engine = hetab_alloc(ctx, 1, sizeof *engine);
  if (!engine)
    return HETAB_ERR_MEMORY;
  engine->precision = o.method == HETAB_METHOD_LITERAL ? HETAB_DOUBLE : o.precision;
  engine->method = o.method;
  double usual = engine->precision == HETAB_DOUBLE ? DOUBLE_USUAL : FLOAT_USUAL;
  engine->tolerance = o.tolerance > 0.0 ? o.tolerance : usual;
  hetab_status status = HETAB_OK;
  if (o.method == HETAB_METHOD_LITERAL)
    snprintf(engine->device_text, sizeof engine->device_text, "host, 1 core");
  else
    status = open_lanes(ctx, o.devices, engine);
  if (status != HETAB_OK) {
    hetab_engine_free(engine);
    return status;
  }
  *out = engine;
  return HETAB_OK;
}

void hetab_engine_free(hetab_engine *engine) {
  if (!engine)
    return;
  for (int i = 0; i < engine->lane_count; i++) {
    if (engine->lanes[i].queue)
      clReleaseCommandQueue(engine->lanes[i].queue);
    if (engine->lanes[i].context)
      clReleaseContext(engine->lanes[i].context);
  }
  free(engine);
}

hetab_status hetab_lane_kernel(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const hetab_atlas *atlas,
                               const char *program, const char *kernel, cl_kernel *out) {
  static const hetab_atlas none = {.degree_x = 2, .degree_g = 2, .pad_x = 16, .pad_g = 16};
  const hetab_atlas *a = atlas ? atlas : &none;
  char options[256];
  cl_program built;
  cl_int error = CL_SUCCESS;
  snprintf(
      options, sizeof options,
      "-cl-std=CL1.2 -DHETAB_REAL_BITS=%d -DHETAB_VW=%d -DHETAB_ROW_ITEMS=%d -DHETAB_ATLAS_X=%d "
      "-DHETAB_ATLAS_X_PAD=%d -DHETAB_ATLAS_G=%d -DHETAB_ATLAS_G_PAD=%d",
      engine->precision == HETAB_DOUBLE ? 64 : 32, lane->vector_width, (int)lane->row_items,
      a->degree_x, a->pad_x, a->degree_g, a->pad_g);
  HETAB_TRY(hetab_cl_program(ctx, lane->context, lane->device, program, options, &built));
  *out = clCreateKernel(built, kernel, &error);
  clReleaseProgram(built); /* the kernel holds it */
  return hetab_cl_check(ctx, error, "clCreateKernel", lane->device);
}

hetab_status hetab_lane_upload_bytes(hetab_context *ctx, const hetab_lane *lane, const void *bytes,
                                     size_t size, cl_mem *out) {
  cl_int error = CL_SUCCESS;
  union {
    const void *in;
    void *out; /* OpenCL takes the source of a copy without const */
  } source = {bytes};
  *out = clCreateBuffer(lane->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, size, source.out,
                        &error);
  return hetab_cl_check(ctx, error, "clCreateBuffer", lane->device);
}

hetab_status hetab_lane_upload(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const double *values, size_t count,
                               cl_mem *out) {
  if (engine->precision == HETAB_DOUBLE)
    return hetab_lane_upload_bytes(ctx, lane, values, count * sizeof *values, out);
  float *narrow = hetab_alloc(ctx, count, sizeof *narrow);
  if (!narrow)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < count; i++)
    narrow[i] = (float)values[i];
  hetab_status status = hetab_lane_upload_bytes(ctx, lane, narrow, count * sizeof *narrow, out);
  free(narrow);
  return status;
}

hetab_status hetab_lane_upload_atlas(hetab_context *ctx, const hetab_engine *engine,
                                     const hetab_lane *lane, const hetab_atlas *atlas,
                                     const double *coefficients, size_t table,
                                     hetab_atlas_buffers *out) {
  HETAB_TRY(hetab_lane_upload(ctx, engine, lane, atlas->panels,
                              atlas->panel_count * HETAB_PANEL_REALS, &out->panels));
  HETAB_TRY(hetab_lane_upload(ctx, engine, lane, atlas->segments,
                              atlas->segment_count * HETAB_SEGMENT_REALS, &out->segments));
  return hetab_lane_upload(ctx, engine, lane, coefficients, atlas->segment_count * table,
                           &out->coefficients);
}

void hetab_atlas_release(hetab_atlas_buffers *buffers) {
  hetab_release(buffers->panels);
  hetab_release(buffers->segments);
  hetab_release(buffers->coefficients);
  *buffers = (hetab_atlas_buffers){0};
}

hetab_status hetab_lane_output(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, size_t count, cl_mem *out) {
  cl_int error = CL_SUCCESS;
  *out = clCreateBuffer(lane->context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR,
                        count * hetab_real_size(engine), NULL, &error);
  return hetab_cl_check(ctx, error, "clCreateBuffer", lane->device);
}

void hetab_arg(hetab_args *args, size_t size, const void *value) {
  cl_int error = clSetKernelArg(args->kernel, args->next++, size, value);
  if (args->status == HETAB_OK)
    args->status = hetab_cl_check(args->ctx, error, "clSetKernelArg", args->lane->device);
}

void hetab_arg_mem(hetab_args *args, cl_mem buffer) {
  hetab_arg(args, sizeof buffer, &buffer);
}

void hetab_arg_int(hetab_args *args, size_t value) {
  cl_int number = (cl_int)value;
  hetab_arg(args, sizeof number, &number);
}

void hetab_arg_real(hetab_args *args, double value) {
  float narrow = (float)value;
  if (args->engine->precision == HETAB_DOUBLE)
    hetab_arg(args, sizeof value, &value);
  else
    hetab_arg(args, sizeof narrow, &narrow);
}

hetab_status hetab_lane_run_rows(hetab_context *ctx, const hetab_lane *lane, cl_kernel kernel,
                                 size_t rows) {
  size_t group = lane->row_items * lane->group_rows, most = 0;
  clGetKernelWorkGroupInfo(kernel, lane->device, CL_KERNEL_WORK_GROUP_SIZE, sizeof most, &most,
                           NULL);
  size_t groups = (rows + lane->group_rows - 1) / lane->group_rows, global = groups * group;
  /* a device that does not take such groups chooses its own: the kernels have no barriers */
  const size_t *local = group <= most ? &group : NULL;
  HETAB_CL_TRY(ctx, lane->device, clEnqueueNDRangeKernel, lane->queue, kernel, 1, NULL, &global,
               local, 0, NULL, NULL);
  HETAB_CL_TRY(ctx, lane->device, clFinish, lane->queue);
  return HETAB_OK;
}

void hetab_release(cl_mem buffer) {
  if (buffer)
    clReleaseMemObject(buffer);
}
