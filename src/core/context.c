#include "core/context.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/printable.h"

hetab_status hetab_context_create(hetab_context **out) {
  *out = calloc(1, sizeof **out);
  return *out ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_context_free(hetab_context *ctx) {
  if (!ctx)
    return;
  while (ctx->held)
    ctx->drop_held(ctx);
  free(ctx->used);
  free(ctx);
}

const char *hetab_error_message(const hetab_context *ctx) {
  return ctx->message;
}

const char *hetab_status_name(hetab_status status) {
  static const char *const names[] = {
      [HETAB_OK] = "ok",
      [HETAB_ERR_ARGUMENT] = "invalid argument",
      [HETAB_ERR_RANGE] = "out of range",
      [HETAB_ERR_PARSE] = "malformed input",
      [HETAB_ERR_IO] = "input or output failed",
      [HETAB_ERR_EXISTS] = "output exists",
      [HETAB_ERR_MEMORY] = "out of memory",
      [HETAB_ERR_DEVICE] = "OpenCL device failure",
      [HETAB_ERR_UNSUPPORTED] = "not supported",
      [HETAB_ERR_CANCELLED] = "cancelled",
  };
  size_t count = sizeof names / sizeof *names;
  return (size_t)status < count ? names[status] : "unknown status";
}

const char *hetab_version(void) {
  return HETAB_VERSION;
}

void hetab_set_progress(hetab_context *ctx, hetab_progress_fn fn, void *user) {
  ctx->progress = fn;
  ctx->progress_user = user;
}

hetab_status hetab_fail(hetab_context *ctx, hetab_status status, const char *format, ...) {
  va_list args;
  va_start(args, format);
  vsnprintf(ctx->message, sizeof ctx->message, format, args);
  va_end(args);
  hetab_make_printable(&(hetab_printable){0}, ctx->message, strlen(ctx->message), "");
  return status;
}

bool hetab_stopping(hetab_context *ctx) {
  double total = ctx->total > 0.0 ? ctx->total : 1.0;
  if (ctx->progress && !ctx->stopping)
    ctx->stopping = ctx->progress(ctx->progress_user, ctx->done, total) != 0;
  return ctx->stopping;
}

hetab_status hetab_progress(hetab_context *ctx, double done, double total) {
  ctx->done = done;
  ctx->total = total;
  if (!hetab_stopping(ctx))
    return HETAB_OK;
  ctx->stopping = false;
  return hetab_fail(ctx, HETAB_ERR_CANCELLED, "stopped on request");
}

hetab_status hetab_go_on(hetab_context *ctx, size_t step) {
  return hetab_stopping_at(ctx, step) ? hetab_progress(ctx, ctx->done, ctx->total) : HETAB_OK;
}

void *hetab_alloc(hetab_context *ctx, size_t count, size_t size) {
  void *memory = size && count > SIZE_MAX / size ? NULL : calloc(count ? count : 1, size);
  if (!memory)
    hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for %zu elements of %zu bytes", count, size);
  return memory;
}

hetab_status hetab_grow(hetab_context *ctx, void *array, size_t size, size_t count, size_t *room) {
  void *old, *larger;
  size_t wanted = count + count / 2 + 64;
  if (count <= *room)
    return HETAB_OK;
  memcpy(&old, array, sizeof old);
  larger = wanted > count && wanted < SIZE_MAX / size ? realloc(old, wanted * size) : NULL;
  if (!larger)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for %zu times %zu bytes", wanted, size);
  memcpy(array, &larger, sizeof larger);
  *room = wanted;
  return HETAB_OK;
}
