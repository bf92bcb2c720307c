/* The engine's inside: one lane per device, with its queue, and kernels built when first used. */
#ifndef HETAB_ENGINE_ENGINE_INTERNAL_H
#define HETAB_ENGINE_ENGINE_INTERNAL_H

#include <CL/cl.h>
#include <stdint.h>

#include <hetab/engine.h>
#include <hetab/tabulate.h>

#include "core/context.h"
#include "model/atlas_fit.h"

enum { HETAB_MOST_LANES = 16 };

/* Everything that one device needs; used by one thread at a time. */
typedef struct hetab_lane {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
  int vector_width;
  char text[160];               /* the device in words */
  size_t row_items, group_rows; /* kernels over rows: work-items a row, rows a work-group */
} hetab_lane;

struct hetab_engine {
  hetab_precision precision;
  hetab_method method;
  double tolerance;
  int lane_count; /* 0 for the literal method */
  hetab_lane lanes[HETAB_MOST_LANES];
  char device_text[512];
};

/* A report that says how its table is made; everything else 0. */
hetab_report hetab_report_of(const hetab_engine *engine, const char *device);

/* Build the kernel of a program (kernels/PROGRAM.cl) for a lane; atlas gives the build options of
 * the row kernels, NULL elsewhere. Release with clReleaseKernel. */
hetab_status hetab_lane_kernel(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const hetab_atlas *atlas,
                               const char *program, const char *kernel, cl_kernel *out);

/* A relative error that can be asked for; 0 stands for the default. */
hetab_status hetab_check_tolerance(hetab_context *ctx, double tolerance);

size_t hetab_real_size(const hetab_engine *engine); /* bytes of the engine's `real` */
double hetab_real_at(const hetab_engine *engine, const void *reals, size_t i);

/* A read-only buffer holding count doubles converted to the engine's real. */
hetab_status hetab_lane_upload(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, const double *values, size_t count,
                               cl_mem *out);
/* A read-only buffer with a copy of some bytes. */
hetab_status hetab_lane_upload_bytes(hetab_context *ctx, const hetab_lane *lane, const void *bytes,
                                     size_t size, cl_mem *out);
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

/* A buffer of count reals that the host maps to read: no copy where memory is shared. */
hetab_status hetab_lane_output(hetab_context *ctx, const hetab_engine *engine,
                               const hetab_lane *lane, size_t count, cl_mem *out);

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

/* Run a kernel over rows; blocks until done. */
hetab_status hetab_lane_run_rows(hetab_context *ctx, const hetab_lane *lane, cl_kernel kernel,
                                 size_t rows);

void hetab_release(cl_mem buffer); /* NULL is fine */

#endif
