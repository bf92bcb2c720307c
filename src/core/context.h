/* The context behind the public handle: the error message and the progress callback. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include "core/scope.h"

typedef struct hetab_used_file hetab_used_file;

struct hetab_context {
  char message[1024];
  hetab_progress_fn progress;
  void *progress_user;
  double done, total;    /* as last told */
  bool stopping;         /* hetab_stopping() was asked, and hetab_progress() not yet */
  bool keeps_inputs;     /* see core/input_file.h: no output may be an input */
  hetab_used_file *used; /* [used_count] */
  size_t used_count;
  struct hetab_held_files *held; /* see core/atomic_file.h; NULL: files are published at once */
  void (*drop_held)(struct hetab_context *ctx); /* for the end of the context */
};

/* Record the message and return `status`, so that callers write `return hetab_fail(...)`. Control
 * characters in the formatted text (from hostile file names, say) become '?': one line, always. */
hetab_status hetab_fail(hetab_context *ctx, hetab_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Calls the progress callback, if any; HETAB_ERR_CANCELLED if it asks to stop. */
hetab_status hetab_progress(hetab_context *ctx, double done, double total);

/* Whether the callback asks to stop, to be asked between the parts of one long step: the step ends
 * early, with whatever it has, and the next hetab_progress() fails. */
bool hetab_stopping(hetab_context *ctx);
/* The same, asked at some of a long loop's steps, which are quick. */
static inline bool hetab_stopping_at(hetab_context *ctx, size_t step) {
  return step % (1 << 16) == 0 && hetab_stopping(ctx);
}
/* HETAB_ERR_CANCELLED where it is to stop. */
hetab_status hetab_go_on(hetab_context *ctx, size_t step);

/* Zeroed memory for count elements; NULL with HETAB_ERR_MEMORY recorded on failure or overflow. */
void *hetab_alloc(hetab_context *ctx, size_t count, size_t size);

/* Room for `count` elements of that size in *(T **)array, which has *room of them and grows by
 * half.
 */
hetab_status hetab_grow(hetab_context *ctx, void *array, size_t size, size_t count, size_t *room);
