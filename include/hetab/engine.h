/* OpenCL devices, and the engine: one or more of them with the kernels compiled for one precision
 * and method. Compiled kernels are kept under $XDG_CACHE_HOME/hetab (or ~/.cache/hetab). */
#ifndef HETAB_ENGINE_H
#define HETAB_ENGINE_H

#include <stddef.h>
#include <hetab/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hetab_precision { HETAB_FLOAT, HETAB_DOUBLE } hetab_precision;

typedef enum hetab_method {
  HETAB_METHOD_ROWS,   /* polynomials of the series, made by the host to the tolerance */
  HETAB_METHOD_SERIES, /* the constant-cost series at every entry */
  HETAB_METHOD_LITERAL /* the printed equations in double on one host core, no device */
} hetab_method;

typedef struct hetab_device_info {
  char name[128];
  char platform[128];
  char driver[64];
  char opencl[64]; /* the device's OpenCL version */
  unsigned compute_units;
  unsigned float_width, double_width; /* native vector widths; 0 = no double */
  unsigned long long memory_bytes;
} hetab_device_info;

/* All OpenCL devices of all platforms, in the order in which --device counts them; free() *list.
 * None is not an error here: *count = 0. */
hetab_status hetab_device_list(hetab_context *ctx, hetab_device_info **list, size_t *count);

typedef struct hetab_engine_options {
  /* "0", "0,1", part of a name, "all"; NULL: the first device. Dense tables share all of them;
   * points, MERL tables and reflectances take the first. */
  const char *devices;
  hetab_precision precision; /* of the arithmetic on the device */
  hetab_method method;
  /* Relative error that the rows method keeps; 0: 1e-5 float, 1e-9 double. At least 1e-5 in float,
   * 1e-11 in double. */
  double tolerance;
} hetab_engine_options;

typedef struct hetab_engine hetab_engine;

/* options = NULL: first device, float, rows. HETAB_ERR_DEVICE if there is no device (the message
 * names the package to install), HETAB_ERR_UNSUPPORTED for double without fp64. */
hetab_status hetab_engine_create(hetab_context *ctx, const hetab_engine_options *options,
                                 hetab_engine **out);
void hetab_engine_free(hetab_engine *engine);

/* Starts to load the OpenCL runtime on a thread of its own: it brings a compiler along, which takes
 * tens of milliseconds that reading inputs and laying out files can overlap. Never fails (NULL: no
 * thread); what goes wrong shows in hetab_engine_create. Finish it before the process exits. */
typedef struct hetab_preload hetab_preload;
hetab_preload *hetab_preload_start(void);
void hetab_preload_finish(hetab_preload *preload); /* waits for the thread; NULL is fine */

hetab_precision hetab_engine_precision(const hetab_engine *engine);
hetab_method hetab_engine_method(const hetab_engine *engine);
double hetab_engine_tolerance(const hetab_engine *engine);
/* "pthread-..., 2 compute units": the devices in words, for reports. Owned by engine. */
const char *hetab_engine_device(const hetab_engine *engine);

const char *hetab_method_name(hetab_method method);          /* "rows" */
const char *hetab_precision_name(hetab_precision precision); /* "float" */

#ifdef __cplusplus
}
#endif
#endif
