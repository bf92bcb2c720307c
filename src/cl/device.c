#include "cl/device.h"

#include <dlfcn.h>
#include <glob.h>
#include <limits.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <hetab/devices.h>

static const char *error_name(cl_int error) {
  switch (error) {
#define NAME(code)                                                                                 \
  case code:                                                                                       \
    return #code
    NAME(CL_DEVICE_NOT_AVAILABLE);
    NAME(CL_COMPILER_NOT_AVAILABLE);
    NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE);
    NAME(CL_OUT_OF_RESOURCES);
    NAME(CL_OUT_OF_HOST_MEMORY);
    NAME(CL_BUILD_PROGRAM_FAILURE);
    NAME(CL_MAP_FAILURE);
    NAME(CL_INVALID_VALUE);
    NAME(CL_INVALID_BINARY);
    NAME(CL_INVALID_BUILD_OPTIONS);
    NAME(CL_INVALID_KERNEL_ARGS);
    NAME(CL_INVALID_KERNEL_NAME);
    NAME(CL_INVALID_WORK_GROUP_SIZE);
    NAME(CL_INVALID_BUFFER_SIZE);
#undef NAME
  default:
    return "OpenCL error";
  }
}

hetab_status hetab_cl_check(hetab_context *ctx, cl_int error, const char *call,
                            cl_device_id device) {
  if (error == CL_SUCCESS)
    return HETAB_OK;
  char name[128] = "any device";
  if (device)
    hetab_cl_device_text(device, CL_DEVICE_NAME, name, sizeof name);
  return hetab_fail(ctx, HETAB_ERR_DEVICE, "%s failed on %s: %s (%d)", call, name,
                    error_name(error), error);
}

void hetab_cl_device_text(cl_device_id device, cl_device_info what, char *text, size_t size) {
  text[0] = 0;
  if (clGetDeviceInfo(device, what, size, text, NULL) != CL_SUCCESS)
    snprintf(text, size, "unknown");
  text[size - 1] = 0;
}

cl_uint hetab_cl_device_uint(cl_device_id device, cl_device_info what) {
  cl_uint value = 0;
  clGetDeviceInfo(device, what, sizeof value, &value, NULL);
  return value;
}

int hetab_cl_device_is_cpu(cl_device_id device) {
  cl_device_type type = 0;
  clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  return (type & CL_DEVICE_TYPE_CPU) != 0;
}

/* ---- none ---------------------------------------------------------------------------------- */

/* The first driver that the loader is told of, a file that names its library; or "". */
static void installed_driver(char path[PATH_MAX]) {
  const char *given = getenv("OCL_ICD_VENDORS"), *end = given ? strrchr(given, '.') : NULL;
  glob_t found = {0};
  snprintf(path, PATH_MAX, "%s%s", given ? given : "/etc/OpenCL/vendors",
           end && strcmp(end, ".icd") == 0 ? "" : "/*.icd");
  bool is_there = glob(path, 0, NULL, &found) == 0;
  snprintf(path, PATH_MAX, "%s", is_there ? found.gl_pathv[0] : "");
  globfree(&found);
}

/* What the dynamic linker says of its library; "" if it loads, or is not named. */
static void load_failure(const char *driver, char *text, size_t size) {
  char library[PATH_MAX];
  FILE *file = fopen(driver, "r");
  bool named = file && fscanf(file, " %4095[^\n]", library) == 1;
  if (file)
    fclose(file);
  void *handle = dlopen(named ? library : NULL, RTLD_LAZY | RTLD_LOCAL);
  snprintf(text, size, "%s", handle ? "" : dlerror());
  if (handle)
    dlclose(handle);
}

/* Says why there is no device. */
static void explain_none(hetab_context *ctx, cl_uint platforms) {
  static const char limits[] = "memory and open files must not be limited too much (ulimit -v, -n)";
  char driver[PATH_MAX], failure[256];
  installed_driver(driver);
  load_failure(driver, failure, sizeof failure);
  if (platforms)
    hetab_fail(ctx, HETAB_ERR_DEVICE,
               "no OpenCL device: a driver is there but offers none: it needs a cache folder that "
               "can be written (PoCL's is POCL_CACHE_DIR, else ~/.cache/pocl), and %s",
               limits);
  else if (*driver)
    hetab_fail(ctx, HETAB_ERR_DEVICE,
               "no OpenCL device: the driver of '%s' is there but does not start%s%s; %s", driver,
               *failure ? ": " : "", failure, limits);
  else
    hetab_fail(ctx, HETAB_ERR_DEVICE,
               "no OpenCL device found; install a driver, for example the package "
               "pocl-opencl-icd, which runs OpenCL on the CPU");
}

/* ---- all ----------------------------------------------------------------------------------- */

static pthread_mutex_t start_up = PTHREAD_MUTEX_INITIALIZER;

/* All devices of all platforms; none is not an error, but explained. One thread at a time:
 * implementations come up with the first call, and not all of them stand two at once. */
static hetab_status all_devices(hetab_context *ctx, cl_device_id **devices, size_t *count) {
  enum { MOST = 64 };
  cl_platform_id platforms[MOST];
  cl_uint platform_count = 0;
  *count = 0;
  *devices = hetab_alloc(ctx, MOST, sizeof **devices);
  HETAB_NEED(*devices);
  pthread_mutex_lock(&start_up);
  if (clGetPlatformIDs(MOST, platforms, &platform_count) != CL_SUCCESS)
    platform_count = 0;
  for (cl_uint p = 0; p < platform_count && p < MOST && *count < MOST; p++) {
    cl_uint found = 0;
    cl_uint room = (cl_uint)(MOST - *count);
    if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, room, *devices + *count, &found) ==
        CL_SUCCESS)
      *count += found < room ? found : room;
  }
  if (!*count)
    explain_none(ctx, platform_count);
  pthread_mutex_unlock(&start_up);
  return HETAB_OK;
}

static void *load_runtime(void *unused) {
  hetab_context ctx = {0};
  cl_device_id *devices = NULL;
  size_t count;
  if (all_devices(&ctx, &devices, &count) == HETAB_OK)
    free(devices);
  return NULL;
}

struct hetab_preload {
  pthread_t thread;
};

hetab_preload *hetab_preload_create(void) {
  hetab_preload *preload = malloc(sizeof *preload);
  if (preload && pthread_create(&preload->thread, NULL, load_runtime, NULL) == 0)
    return preload;
  free(preload);
  return NULL;
}

void hetab_preload_free(hetab_preload *preload) {
  if (preload)
    pthread_join(preload->thread, NULL);
  free(preload);
}

static void describe(cl_device_id device, hetab_device_info *info) {
  cl_platform_id platform;
  cl_ulong memory = 0;
  hetab_cl_device_text(device, CL_DEVICE_NAME, info->name, sizeof info->name);
  hetab_cl_device_text(device, CL_DRIVER_VERSION, info->driver, sizeof info->driver);
  hetab_cl_device_text(device, CL_DEVICE_VERSION, info->opencl, sizeof info->opencl);
  clGetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof info->platform, info->platform, NULL);
  info->compute_units = hetab_cl_device_uint(device, CL_DEVICE_MAX_COMPUTE_UNITS);
  info->float_width = hetab_cl_device_uint(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT);
  info->double_width = hetab_cl_device_uint(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE);
  clGetDeviceInfo(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory, NULL);
  info->memory_bytes = memory;
}

hetab_status hetab_device_list(hetab_context *ctx, hetab_device_info **list, size_t *count) {
  HETAB_FREED cl_device_id *devices = NULL;
  *list = NULL;
  *count = 0;
  HETAB_TRY(all_devices(ctx, &devices, count));
  *list = hetab_alloc(ctx, *count, sizeof **list);
  for (size_t i = 0; *list && i < *count; i++)
    describe(devices[i], &(*list)[i]);
  return *list ? HETAB_OK : HETAB_ERR_MEMORY;
}

/* Does one word of the selector, [word, end), name device number `index`? */
static int word_matches(const char *word, const char *end, size_t index, cl_device_id device) {
  char text[128], name[128];
  size_t length = (size_t)(end - word);
  if (length == 0 || length >= sizeof text)
    return 0;
  memcpy(text, word, length);
  text[length] = 0;
  if (strspn(text, "0123456789") == length)
    return strtoul(text, NULL, 10) == index;
  hetab_cl_device_text(device, CL_DEVICE_NAME, name, sizeof name);
  return strcmp(text, "all") == 0 || strcasestr(name, text) != NULL;
}

static int selector_matches(const char *selector, size_t index, cl_device_id device) {
  for (const char *word = selector;; word++) {
    const char *end = word + strcspn(word, ",");
    if (word_matches(word, end, index, device))
      return 1;
    if (!*end)
      return 0;
    word = end;
  }
}

static hetab_status no_match(hetab_context *ctx, const char *word, size_t all) {
  return hetab_fail(
      ctx, HETAB_ERR_DEVICE,
      "no OpenCL device matches '%.*s'; there %s %zu, numbered from 0 (see the list of "
      "devices)",
      (int)strcspn(word, ","), word, all == 1 ? "is" : "are", all);
}

/* Every word of the selector has to name a device. */
static hetab_status check_words(hetab_context *ctx, const char *selector,
                                const cl_device_id *devices, size_t count) {
  for (const char *word = selector;; word++) {
    const char *end = word + strcspn(word, ",");
    int found = 0;
    for (size_t i = 0; i < count && !found; i++)
      found = word_matches(word, end, i, devices[i]);
    if (!found)
      return no_match(ctx, word, count);
    if (!*end)
      return HETAB_OK;
    word = end;
  }
}

hetab_status hetab_cl_select(hetab_context *ctx, const char *selector, cl_device_id **devices,
                             size_t *count) {
  const char *words = selector ? selector : "0";
  size_t all = 0;
  *count = 0;
  HETAB_TRY(all_devices(ctx, devices, &all));
  hetab_status status = all ? check_words(ctx, words, *devices, all) : HETAB_ERR_DEVICE;
  if (status != HETAB_OK) {
    free(*devices);
    *devices = NULL;
    return status;
  }
  for (size_t i = 0; i < all; i++)
    if (selector_matches(words, i, (*devices)[i]))
      (*devices)[(*count)++] = (*devices)[i];
  return HETAB_OK;
}
