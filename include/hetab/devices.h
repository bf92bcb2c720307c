/* OpenCL devices. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

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
 * None is not an error here: *count = 0, and the context's message says what is missing. */
hetab_status hetab_device_list(hetab_context *ctx, hetab_device_info **list, size_t *count);

/* Starts to load the OpenCL runtime on a thread of its own: it brings a compiler along, and
 * reading inputs and laying out files can go on meanwhile. Never fails (NULL: no
 * thread); what goes wrong shows in hetab_engine_create. Finish it before the process exits.
 * Threads: one at a time. */
typedef struct hetab_preload hetab_preload;
hetab_preload *hetab_preload_create(void);
void hetab_preload_free(hetab_preload *preload); /* waits for the thread; NULL is fine */

HETAB_END
