#include "engine/lane.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/device.h"
#include "cl/program.h"
#include "engine/engine_internal.h"
#include "kernels/tables.h"

/* CPUs, by `hetab bench` under PoCL on 2 cores: explicit vectors as wide as the registers, a few
 * rows a group so that threads share a slab evenly. GPUs, by reading and cross-compiling, not
 * measured: scalars, neighbours storing neighbours; MERL's rows have 96 samples, 6 an item. */
static const hetab_shape shapes[] = {
    {.name = "cpu", .row_items = 1, .cell_items = 1, .group = 8, .slabs = 2},
    {.name = "gpu",
     .vector_width = 1,
     .row_items = 64,
     .cell_items = 16,
     .group = 64,
     .points = 64,
     .slabs = 4,
     .apart = true},
};
enum { CPU, GPU, SHAPES };

/* ---- opening ------------------------------------------------------------------------------- */

static int power_of_two_up_to_16(cl_uint width) {
  int power = 1;
  while (power < 16 && 2 * power <= (int)width)
    power *= 2;
  return power;
}

static hetab_status choose_shape(hetab_context *ctx, hetab_precision precision, hetab_lane *lane) {
  const char *asked = getenv("HETAB_SHAPE");
  int kind = hetab_cl_device_is_cpu(lane->device) ? CPU : GPU;
  if (asked && *asked)
    for (kind = 0; kind < SHAPES && strcmp(asked, shapes[kind].name) != 0;)
      kind++;
  if (kind == SHAPES)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "HETAB_SHAPE=%s in the environment: kernels are laid out for cpu or gpu",
                      asked);
  size_t most = 0;
  clGetDeviceInfo(lane->device, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof most, &most, NULL);
  lane->shape = &shapes[most < shapes[kind].group ? CPU : kind];
  lane->vector_width = lane->shape->vector_width;
  if (!lane->vector_width)
    lane->vector_width = power_of_two_up_to_16(hetab_cl_device_uint(
        lane->device, precision == HETAB_DOUBLE ? CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE
                                                : CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT));
  return HETAB_OK;
}

static hetab_status open_queue(hetab_context *ctx, const hetab_lane *lane,
                               cl_command_queue_properties properties, cl_command_queue *queue) {
  cl_int error = CL_SUCCESS;
  *queue = clCreateCommandQueue(lane->context, lane->device, properties, &error);
  return hetab_cl_check(ctx, error, "clCreateCommandQueue", lane->device);
}

hetab_status hetab_lane_open(hetab_context *ctx, cl_device_id device, hetab_precision precision,
                             hetab_lane *lane) {
  cl_int error = CL_SUCCESS;
  char name[128];
  lane->device = device;
  hetab_cl_device_text(device, CL_DEVICE_NAME, name, sizeof name);
  snprintf(lane->text, sizeof lane->text, "%s, %u compute units", name,
           hetab_cl_device_uint(device, CL_DEVICE_MAX_COMPUTE_UNITS));
  if (precision == HETAB_DOUBLE &&
      hetab_cl_device_uint(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE) == 0)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "%s has no double precision (fp64); use float, or another device", name);
  HETAB_TRY(choose_shape(ctx, precision, lane));
  lane->context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
  HETAB_TRY(hetab_cl_check(ctx, error, "clCreateContext", device));
  HETAB_TRY(open_queue(ctx, lane, CL_QUEUE_PROFILING_ENABLE, &lane->queue));
  return lane->shape->apart ? open_queue(ctx, lane, 0, &lane->copies) : HETAB_OK;
}

void hetab_lane_close(hetab_lane *lane) {
  if (lane->copies)
    clReleaseCommandQueue(lane->copies);
  if (lane->queue)
    clReleaseCommandQueue(lane->queue);
  if (lane->context)
    clReleaseContext(lane->context);
}

/* ---- kernels ------------------------------------------------------------------------------- */

hetab_status hetab_lane_kernel(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const hetab_build *build, cl_kernel *out) {
  static const hetab_atlas none = {.degree_x = 2, .degree_g = 2, .pad_x = 16, .pad_g = 16};
  const hetab_atlas *a = build->atlas ? build->atlas : &none;
  char options[256];
  cl_program built;
  cl_int error = CL_SUCCESS;
  int length = snprintf(
      options, sizeof options,
      "-cl-std=CL1.2 -DHETAB_REAL_BITS=%d -DHETAB_VW=%d -DHETAB_ROW_ITEMS=%d -DHETAB_ATLAS_X=%d "
      "-DHETAB_ATLAS_X_PAD=%d -DHETAB_ATLAS_G=%d -DHETAB_ATLAS_G_PAD=%d",
      engine->precision == HETAB_DOUBLE ? 64 : 32, lane->vector_width,
      build->row_items ? (int)build->row_items : 1, a->degree_x, a->pad_x, a->degree_g, a->pad_g);
  if (build->parts)
    snprintf(options + length, sizeof options - (size_t)length, " -DHETAB_PARTS=%d", build->parts);
  HETAB_TRY(hetab_cl_program(ctx, lane->context, lane->device, build->program, options, &built));
  *out = clCreateKernel(built, build->kernel, &error);
  clReleaseProgram(built); /* the kernel holds it */
  return hetab_cl_check(ctx, error, "clCreateKernel", lane->device);
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

/* Whole groups of `group` items, 0: the implementation's; kernels leave out what is too much. */
static hetab_status launch(const hetab_args *args, size_t items, size_t planes, size_t group,
                           cl_event *done) {
  const hetab_lane *lane = args->lane;
  size_t local[2] = {group, 1}, global[2] = {items, planes};
  HETAB_TRY(args->status);
  if (group)
    global[0] = (items + group - 1) / group * group;
  HETAB_CL_TRY(args->ctx, lane->device, clEnqueueNDRangeKernel, lane->queue, args->kernel,
               planes > 1 ? 2 : 1, NULL, global, group ? local : NULL, 0, NULL, done);
  return HETAB_OK;
}

hetab_status hetab_lane_run_rows(const hetab_args *args, size_t rows, size_t row_items,
                                 cl_event *done) {
  return launch(args, rows * row_items, 1, args->lane->shape->group, done);
}

hetab_status hetab_lane_run(const hetab_args *args, size_t items, size_t planes, cl_event *done) {
  return launch(args, items, planes, args->lane->shape->points, done);
}

hetab_status hetab_lane_finish(hetab_context *ctx, const hetab_lane *lane) {
  return hetab_cl_check(ctx, clFinish(lane->queue), "clFinish", lane->device);
}

double hetab_lane_seconds(cl_event *done) {
  cl_ulong start = 0, end = 0;
  if (!*done)
    return 0.0;
  clGetEventProfilingInfo(*done, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL);
  clGetEventProfilingInfo(*done, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL);
  clReleaseEvent(*done);
  *done = NULL;
  return end > start ? 1e-9 * (double)(end - start) : 0.0;
}

/* ---- buffers ------------------------------------------------------------------------------- */

size_t hetab_real_size(const hetab_engine *engine) {
  return engine->precision == HETAB_DOUBLE ? sizeof(double) : sizeof(float);
}

static hetab_status make_buffer(hetab_context *ctx, const hetab_lane *lane, cl_mem_flags flags,
                                size_t size, const void *bytes, cl_mem *out) {
  cl_int error = CL_SUCCESS;
  union {
    const void *in;
    void *out; /* OpenCL takes the source of a copy without const */
  } source = {bytes};
  *out = clCreateBuffer(lane->context, flags, size, source.out, &error);
  return hetab_cl_check(ctx, error, "clCreateBuffer", lane->device);
}

hetab_status hetab_lane_upload_bytes(hetab_context *ctx, const hetab_lane *lane, const void *bytes,
                                     size_t size, cl_mem *out) {
  return make_buffer(ctx, lane, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, size, bytes, out);
}

hetab_status hetab_lane_upload(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const double *values, size_t count,
                               cl_mem *out) {
  if (engine->precision == HETAB_DOUBLE)
    return hetab_lane_upload_bytes(ctx, lane, values, count * sizeof *values, out);
  HETAB_FREED float *narrow = hetab_alloc(ctx, count, sizeof *narrow);
  HETAB_NEED(narrow);
  for (size_t i = 0; i < count; i++)
    narrow[i] = (float)values[i];
  return hetab_lane_upload_bytes(ctx, lane, narrow, count * sizeof *narrow, out);
}

void hetab_release(cl_mem buffer) {
  if (buffer)
    clReleaseMemObject(buffer);
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

hetab_status hetab_output_create(hetab_context *ctx, const hetab_engine *engine,
                                 const hetab_lane *lane, size_t count, hetab_output *out) {
  size_t size = count * hetab_real_size(engine);
  cl_int error = CL_SUCCESS;
  *out = (hetab_output){.lane = lane};
  if (!lane->copies)
    return make_buffer(ctx, lane, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, size, NULL,
                       &out->buffer);
  HETAB_TRY(make_buffer(ctx, lane, CL_MEM_READ_WRITE, size, NULL, &out->buffer));
  HETAB_TRY(make_buffer(ctx, lane, CL_MEM_ALLOC_HOST_PTR, size, NULL, &out->pinned));
  out->copy = clEnqueueMapBuffer(lane->copies, out->pinned, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0,
                                 size, 0, NULL, NULL, &error);
  return hetab_cl_check(ctx, error, "clEnqueueMapBuffer", lane->device);
}

/* A queue of its own has to be told to begin, and when: after the kernels so far. */
static hetab_status start_copy(hetab_context *ctx, size_t size, hetab_output *out) {
  const hetab_lane *lane = out->lane;
  cl_event computed = NULL;
  HETAB_CL_TRY(ctx, lane->device, clEnqueueMarkerWithWaitList, lane->queue, 0, NULL, &computed);
  cl_int error = clEnqueueReadBuffer(lane->copies, out->buffer, CL_FALSE, 0, size, out->copy, 1,
                                     &computed, &out->arrived);
  clReleaseEvent(computed);
  HETAB_TRY(hetab_cl_check(ctx, error, "clEnqueueReadBuffer", lane->device));
  out->values = out->copy;
  clFlush(lane->queue);
  clFlush(lane->copies);
  return HETAB_OK;
}

hetab_status hetab_output_fetch(hetab_context *ctx, const hetab_engine *engine, size_t count,
                                hetab_output *out) {
  const hetab_lane *lane = out->lane;
  size_t size = count * hetab_real_size(engine);
  cl_int error = CL_SUCCESS;
  if (lane->copies)
    return start_copy(ctx, size, out);
  out->values = clEnqueueMapBuffer(lane->queue, out->buffer, CL_FALSE, CL_MAP_READ, 0, size, 0,
                                   NULL, &out->arrived, &error);
  HETAB_TRY(hetab_cl_check(ctx, error, "clEnqueueMapBuffer", lane->device));
  clFlush(lane->queue);
  return HETAB_OK;
}

hetab_status hetab_output_wait(hetab_context *ctx, hetab_output *out) {
  cl_int error = clWaitForEvents(1, &out->arrived);
  clReleaseEvent(out->arrived);
  out->arrived = NULL;
  return hetab_cl_check(ctx, error, "clWaitForEvents", out->lane->device);
}

void hetab_output_return(hetab_output *out) {
  if (out->values && !out->lane->copies)
    clEnqueueUnmapMemObject(out->lane->queue, out->buffer, out->values, 0, NULL, NULL);
  out->values = NULL;
}

void hetab_output_free(hetab_output *out) {
  if (out->arrived) {
    clWaitForEvents(1, &out->arrived);
    clReleaseEvent(out->arrived);
  }
  hetab_output_return(out);
  if (out->copy)
    clEnqueueUnmapMemObject(out->lane->copies, out->pinned, out->copy, 0, NULL, NULL);
  if (out->lane) {
    clFinish(out->lane->queue);
    if (out->lane->copies)
      clFinish(out->lane->copies);
  }
  hetab_release(out->buffer);
  hetab_release(out->pinned);
  *out = (hetab_output){0};
}
