/* OpenCL programs from the embedded sources, compiled once and kept in a cache on disk. */
#pragma once

#include <CL/cl.h>

#include "core/context.h"

/* A program of kernels/NAME.cl with its includes, as embedded by scripts/embed_kernels. */
typedef struct hetab_kernel_source {
  const char *name, *text;
} hetab_kernel_source;

extern const hetab_kernel_source hetab_kernel_sources[]; /* ends with a NULL name */

/* Build the program `name` for one device. The cache's key is a hash of everything that the binary
 * depends on (source, options, device, driver, platform version); a cached file that does not load
 * is built anew, one that cannot be written is done without. */
hetab_status hetab_cl_program(hetab_context *ctx, cl_context context, cl_device_id device,
                              const char *name, const char *options, cl_program *out);
