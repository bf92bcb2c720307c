#include "cl/program.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cl/device.h"

static const char *source_of(const char *name) {
  for (const hetab_kernel_source *s = hetab_kernel_sources; s->name; s++)
    if (strcmp(s->name, name) == 0)
      return s->text;
  return NULL;
}

/* FNV-1a, 128 bits: wide enough to name files by. */
typedef unsigned __int128 hash128;

#define HASH_PRIME (((hash128)1 << 88) + 0x13b)
#define HASH_START (((hash128)0x6c62272e07bb0142 << 64) | 0x62b821756295c58d)

static hash128 hash_text(hash128 hash, const char *text) {
  for (const unsigned char *c = (const unsigned char *)text;; c++) {
    hash = (hash ^ *c) * HASH_PRIME;
    if (!*c)
      return hash;
  }
}

static hash128 hash_platform(hash128 hash, cl_device_id device) {
  cl_platform_id platform = NULL;
  char text[256] = "";
  clGetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
  clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof text - 1, text, NULL);
  return hash_text(hash, text);
}

static hash128 cache_key(cl_device_id device, const char *source, const char *options) {
  static const cl_device_info facts[] = {CL_DEVICE_NAME, CL_DEVICE_VERSION, CL_DRIVER_VERSION,
                                         CL_DEVICE_VENDOR};
  char text[256];
  hash128 hash = hash_text(hash_text(HASH_START, source), options);
  for (size_t i = 0; i < sizeof facts / sizeof *facts; i++) {
    hetab_cl_device_text(device, facts[i], text, sizeof text);
    hash = hash_text(hash, text);
  }
  return hash_platform(hash, device);
}

/* $XDG_CACHE_HOME/hetab or ~/.cache/hetab, created if need be; 0 where there is no such place. */
static int cache_directory(char *path, size_t size) {
  const char *base = getenv("XDG_CACHE_HOME");
  const char *home = getenv("HOME");
  if (base && *base == '/')
    snprintf(path, size, "%s", base);
  else if (home && *home == '/')
    snprintf(path, size, "%s/.cache", home);
  else
    return 0;
  mkdir(path, 0777);
  size_t length = strlen(path);
  if (length + sizeof "/hetab" > size)
    return 0;
  memcpy(path + length, "/hetab", sizeof "/hetab");
  return mkdir(path, 0777) == 0 || errno == EEXIST;
}

static int cache_path(cl_device_id device, const char *source, const char *options, char *path,
                      size_t size) {
  char directory[3800];
  if (!cache_directory(directory, sizeof directory))
    return 0;
  hash128 key = cache_key(device, source, options);
  int written = snprintf(path, size, "%s/%016llx%016llx.bin", directory,
                         (unsigned long long)(key >> 64), (unsigned long long)key);
  return written > 0 && (size_t)written < size;
}

/* What stands before a cached binary. OpenCL implementations trust what they are given, and read
 * past the end of a truncated one. */
typedef struct cache_header {
  char magic[8];
  unsigned long long size;
  hash128 hash;
} cache_header;

static hash128 hash_bytes(const unsigned char *bytes, size_t size) {
  hash128 hash = HASH_START;
  for (size_t i = 0; i < size; i++)
    hash = (hash ^ bytes[i]) * HASH_PRIME;
  return hash;
}

static cache_header header_of(const unsigned char *bytes, size_t size) {
  cache_header header = {.magic = "hetabcl", .size = size, .hash = hash_bytes(bytes, size)};
  return header;
}

static unsigned char *read_file(const char *path, size_t *size) {
  unsigned char *bytes = NULL;
  struct stat info;
  FILE *file = fopen(path, "rb");
  if (!file)
    return NULL;
  if (fstat(fileno(file), &info) == 0 && info.st_size > 0) {
    *size = (size_t)info.st_size;
    bytes = malloc(*size);
    if (bytes && fread(bytes, 1, *size, file) != *size) {
      free(bytes);
      bytes = NULL;
    }
  }
  fclose(file);
  return bytes;
}

static int is_whole(const unsigned char *bytes, size_t size) {
  cache_header header;
  if (size < sizeof header)
    return 0;
  memcpy(&header, bytes, sizeof header);
  cache_header expected = header_of(bytes + sizeof header, size - sizeof header);
  return memcmp(&header, &expected, sizeof header) == 0;
}

static cl_program load_cached(cl_context context, cl_device_id device, const char *path,
                              const char *options) {
  size_t size = 0;
  cl_int error = CL_SUCCESS, binary_status = CL_SUCCESS;
  unsigned char *bytes = read_file(path, &size);
  if (!bytes || !is_whole(bytes, size)) {
    free(bytes);
    return NULL;
  }
  const unsigned char *binary = bytes + sizeof(cache_header);
  size -= sizeof(cache_header);
  cl_program program =
      clCreateProgramWithBinary(context, 1, &device, &size, &binary, &binary_status, &error);
  free(bytes);
  if (error != CL_SUCCESS || binary_status != CL_SUCCESS)
    return NULL;
  if (clBuildProgram(program, 1, &device, options, NULL, NULL) == CL_SUCCESS)
    return program;
  clReleaseProgram(program);
  return NULL;
}

/* Best effort: a cache that cannot be written costs time, not correctness. */
static void store_cached(cl_program program, const char *path) {
  size_t size = 0;
  char temporary[4200];
  if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, NULL) != CL_SUCCESS ||
      size == 0)
    return;
  HETAB_FREED unsigned char *bytes = malloc(size);
  if (!bytes)
    return;
  if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof bytes, &bytes, NULL) == CL_SUCCESS) {
    snprintf(temporary, sizeof temporary, "%s.XXXXXX", path);
    int fd = mkstemp(temporary);
    FILE *file = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (file) {
      cache_header header = header_of(bytes, size);
      int whole = fwrite(&header, sizeof header, 1, file) == 1;
      whole &= fwrite(bytes, 1, size, file) == size;
      whole &= fclose(file) == 0;
      if (!whole || rename(temporary, path) != 0)
        unlink(temporary);
    }
  }
}

static hetab_status build_failure(hetab_context *ctx, cl_program program, cl_device_id device,
                                  const char *name, cl_int error) {
  size_t size = 0;
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size);
  HETAB_FREED char *log = calloc(size + 1, 1);
  if (log)
    clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
  hetab_status status = hetab_cl_check(ctx, error, "clBuildProgram", device);
  if (log && *log)
    hetab_fail(ctx, status, "cannot compile kernels/%s.cl: %s", name, log);
  return status;
}

/* A compiler that runs out of addresses takes the program with it: PoCL's needs 380 MB. */
static hetab_status check_room(hetab_context *ctx) {
  const size_t room = (size_t)400 << 20;
  void *trial = mmap(NULL, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (trial == MAP_FAILED)
    return hetab_fail(ctx, HETAB_ERR_MEMORY,
                      "compiling kernels takes %zu MiB more of addresses than there are: raise the "
                      "limit (ulimit -v)",
                      room >> 20);
  munmap(trial, room);
  return HETAB_OK;
}

static hetab_status build(hetab_context *ctx, cl_context context, cl_device_id device,
                          const char *name, const char *source, const char *options,
                          cl_program *out) {
  cl_int error = CL_SUCCESS;
  HETAB_TRY(check_room(ctx));
  cl_program program = clCreateProgramWithSource(context, 1, &source, NULL, &error);
  HETAB_TRY(hetab_cl_check(ctx, error, "clCreateProgramWithSource", device));
  error = clBuildProgram(program, 1, &device, options, NULL, NULL);
  if (error == CL_SUCCESS) {
    *out = program;
    return HETAB_OK;
  }
  hetab_status status = build_failure(ctx, program, device, name, error);
  clReleaseProgram(program);
  return status;
}

hetab_status hetab_cl_program(hetab_context *ctx, cl_context context, cl_device_id device,
                              const char *name, const char *options, cl_program *out) {
  char path[4096];
  const char *source = source_of(name);
  if (!source)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "no kernel program is called '%s'", name);
  int cached = cache_path(device, source, options, path, sizeof path);
  *out = cached ? load_cached(context, device, path, options) : NULL;
  if (*out)
    return HETAB_OK;
  HETAB_TRY(build(ctx, context, device, name, source, options, out));
  if (cached)
    store_cached(*out, path);
  return HETAB_OK;
}
