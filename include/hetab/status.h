/* Status codes, the context, error messages and progress.
 *
 * Every function that can fail returns a hetab_status, HETAB_OK being 0, and sets its handle
 * outputs to NULL on failure; what it left in output arrays then is not to be used. The one-line
 * message that says what went wrong, where, and how to mend it is kept in the context:
 * hetab_error_message(). The library prints nothing and never exits.
 */
#pragma once

/* What stands between them is C, for C++ too. */
#ifdef __cplusplus
#define HETAB_BEGIN extern "C" {
#define HETAB_END }
#else
#define HETAB_BEGIN
#define HETAB_END
#endif

HETAB_BEGIN

typedef enum hetab_status {
  HETAB_OK = 0,
  HETAB_ERR_ARGUMENT,    /* a value that the caller passed makes no sense */
  HETAB_ERR_RANGE,       /* outside the data, or outside the model's domain */
  HETAB_ERR_PARSE,       /* malformed text or binary input */
  HETAB_ERR_IO,          /* the operating system refused a read or a write */
  HETAB_ERR_EXISTS,      /* an output exists already and overwriting was not asked for */
  HETAB_ERR_MEMORY,      /* out of memory */
  HETAB_ERR_DEVICE,      /* no OpenCL device, or an OpenCL call failed */
  HETAB_ERR_UNSUPPORTED, /* the device or the format cannot do this */
  HETAB_ERR_CANCELLED    /* the progress callback asked to stop */
} hetab_status;

/* Threads: one at a time; give each its own. */
typedef struct hetab_context hetab_context;

/* Called now and then from the thread that called the library, with the work done so far and in
 * all (in entries; total > 0). Return 0 to go on, anything else to stop with HETAB_ERR_CANCELLED.
 */
typedef int (*hetab_progress_fn)(void *user, double done, double total);

hetab_status hetab_context_create(hetab_context **out);
void hetab_context_free(hetab_context *ctx); /* NULL is fine */

/* The message of the last failure, one line without a newline; "" after none. Owned by ctx. */
const char *hetab_error_message(const hetab_context *ctx);
/* "out of memory", "no such device": a few words for a code. */
const char *hetab_status_name(hetab_status status);
/* "1.2.3" */
const char *hetab_version(void);

/* fn = NULL: no progress, not cancellable. */
void hetab_set_progress(hetab_context *ctx, hetab_progress_fn fn, void *user);

HETAB_END
