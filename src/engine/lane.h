/* Lanes: one per device, with its queues, and how kernels are laid over it. One thread at a time
 * uses a lane. */
#pragma once

#include <CL/cl.h>
#include <stdbool.h>

#include <hetab/engine.h>

#include "core/context.h"
#include "model/atlas_fit.h"

/* How kernels are laid over a kind of device; lane.c has the kinds. */
typedef struct hetab_shape {
  const char *name;
  int vector_width;  /* of `vreal`; 0: the device's own */
  size_t row_items;  /* work-items along a row of a dense table */
  size_t cell_items; /* along a row of MERL cells */
  size_t group;      /* work-items of a group of rows */
  size_t points;     /* of a group without rows; 0: the implementation chooses */
  int slabs;         /* of a dense table in flight, the one that is being written included */
  bool apart;        /* memory and series: results are copied, not mapped, by a queue of their own;
                        the MERL kernel's series is a launch of its own, for its registers */
} hetab_shape;

typedef struct hetab_lane {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue, copies; /* copies: NULL where memory is shared */
  const hetab_shape *shape;
  int vector_width;
  char text[160]; /* the device in words */
} hetab_lane;

/* HETAB_SHAPE=NAME in the environment takes the place of the device's kind. Close the lane whatever
 * the outcome. */
hetab_status hetab_lane_open(hetab_context *ctx, cl_device_id device, hetab_precision precision,
                             hetab_lane *lane);
void hetab_lane_close(hetab_lane *lane);

/* ---- kernels ------------------------------------------------------------------------------- */

/* What a kernel is compiled for. */
typedef struct hetab_build {
  const char *program, *kernel; /* kernels/PROGRAM.cl */
  const hetab_atlas *atlas;     /* its degrees; NULL: of none */
  size_t row_items;
  int parts; /* of kernels/half_diff.cl; 0: all */
} hetab_build;

/* Release with clReleaseKernel. */
hetab_status hetab_lane_kernel(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const hetab_build *build, cl_kernel *out);

/* One kernel argument: &value and its size, checked. A real argument goes as hetab_arg_real. */
typedef struct hetab_args {
  hetab_context *ctx;
  const hetab_engine *engine;
  const hetab_lane *lane;
  cl_kernel kernel;
  cl_uint next;
  hetab_status status; /* of the first that failed */
} hetab_args;
void hetab_arg(hetab_args *args, size_t size, const void *value);
void hetab_arg_mem(hetab_args *args, cl_mem buffer);
void hetab_arg_int(hetab_args *args, size_t value);
void hetab_arg_real(hetab_args *args, double value);

/* Start the kernel over rows of row_items, or over items x planes; done (may be NULL) is what
 * hetab_lane_seconds takes. Neither waits: later commands of the lane find the results. */
hetab_status hetab_lane_run_rows(const hetab_args *args, size_t rows, size_t row_items,
                                 cl_event *done);
hetab_status hetab_lane_run(const hetab_args *args, size_t items, size_t planes, cl_event *done);
hetab_status hetab_lane_finish(hetab_context *ctx, const hetab_lane *lane);
/* How long a kernel that has ended ran; releases the event, NULL: 0. */
double hetab_lane_seconds(cl_event *done);

/* ---- buffers ------------------------------------------------------------------------------- */

size_t hetab_real_size(const hetab_engine *engine); /* bytes of the engine's `real` */

/* A read-only buffer holding count doubles converted to the engine's real. */
hetab_status hetab_lane_upload(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const double *values, size_t count,
                               cl_mem *out);
/* A read-only buffer with a copy of some bytes. */
hetab_status hetab_lane_upload_bytes(hetab_context *ctx, const hetab_lane *lane, const void *bytes,
                                     size_t size, cl_mem *out);
void hetab_release(cl_mem buffer); /* NULL is fine */

/* An atlas on a device; zeroed: none. */
typedef struct hetab_atlas_buffers {
  cl_mem panels, segments, coefficients;
} hetab_atlas_buffers;
/* coefficients[segment][table]: of the atlas, or its transpose. */
hetab_status hetab_lane_upload_atlas(hetab_context *ctx, const hetab_engine *engine,
                                     const hetab_lane *lane, const hetab_atlas *atlas,
                                     const double *coefficients, size_t table,
                                     hetab_atlas_buffers *out);
void hetab_atlas_release(hetab_atlas_buffers *buffers);

/* Reals that kernels write and the host reads; zeroed: none. Where memory is shared the buffer is
 * mapped; elsewhere it is the device's own, and copied to pinned memory while kernels run. */
typedef struct hetab_output {
  const hetab_lane *lane;
  cl_mem buffer, pinned;
  void *copy; /* the pinned memory, mapped for good */
  void *values;
  cl_event arrived;
} hetab_output;
hetab_status hetab_output_create(hetab_context *ctx, const hetab_engine *engine,
                                 const hetab_lane *lane, size_t count, hetab_output *out);
/* Have the first `count` reals brought once the kernels so far are done; wait for them; give them
 * back, before kernels write there again. */
hetab_status hetab_output_fetch(hetab_context *ctx, const hetab_engine *engine, size_t count,
                                hetab_output *out);
hetab_status hetab_output_wait(hetab_context *ctx, hetab_output *out);
void hetab_output_return(hetab_output *out);
void hetab_output_free(hetab_output *out);
