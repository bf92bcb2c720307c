/* OpenCL devices, and the engine: one or more of them with the kernels compiled for one precision
 * and method. Compiled kernels are kept under $XDG_CACHE_HOME/hetab (or ~/.cache/hetab). With
 * HETAB_SHAPE=cpu or gpu in the environment they are laid out as for that kind of device, whatever
 * the device is: so tests run what a GPU runs. */
#pragma once

#include <stddef.h>
#include <hetab/devices.h>
#include <hetab/types.h>

HETAB_BEGIN

typedef struct hetab_engine_options {
  size_t size; /* of the struct; 0: of this header's */
  /* "0", "0,1", part of a name, "all"; NULL: the first device. Dense tables share all of them;
   * points, MERL tables and reflectances take the first. */
  const char *devices;
  hetab_precision precision; /* of the arithmetic on the device */
  hetab_method method;
  /* Relative error that the rows method keeps; 0: 1e-5 float, 1e-9 double. At least 1e-5 in float,
   * 1e-11 in double. */
  double tolerance;
} hetab_engine_options;

/* Threads: one at a time, whatever the call; engines of several threads work at once. */
typedef struct hetab_engine hetab_engine;

/* options = NULL: first device, float, rows. HETAB_ERR_DEVICE if there is no device (the message
 * names the package to install), HETAB_ERR_UNSUPPORTED for double without fp64. */
hetab_status hetab_engine_create(hetab_context *ctx, const hetab_engine_options *options,
                                 hetab_engine **out);
void hetab_engine_free(hetab_engine *engine);

hetab_precision hetab_engine_precision(const hetab_engine *engine);
hetab_method hetab_engine_method(const hetab_engine *engine);
double hetab_engine_tolerance(const hetab_engine *engine);
/* "pthread-..., 2 compute units": the devices in words, for reports. Owned by engine. */
const char *hetab_engine_device(const hetab_engine *engine);

HETAB_END
