/* OpenCL devices: finding, choosing and describing them. */
#pragma once

#include <CL/cl.h>
#include <stddef.h>

#include "core/context.h"

/* "clBuildProgram failed on DEVICE: CL_OUT_OF_RESOURCES (-5)" unless error is CL_SUCCESS. */
hetab_status hetab_cl_check(hetab_context *ctx, cl_int error, const char *call,
                            cl_device_id device);
#define HETAB_CL_TRY(ctx, device, call, ...)                                                       \
  HETAB_TRY(hetab_cl_check(ctx, call(__VA_ARGS__), #call, device))

/* The devices that `selector` names (see hetab_engine_options.devices); free() *devices.
 * At least one, or a failure whose message says what there is, or which package to install. */
hetab_status hetab_cl_select(hetab_context *ctx, const char *selector, cl_device_id **devices,
                             size_t *count);

void hetab_cl_device_text(cl_device_id device, cl_device_info what, char *text, size_t size);
cl_uint hetab_cl_device_uint(cl_device_id device, cl_device_info what);
int hetab_cl_device_is_cpu(cl_device_id device);
