/* Options of the public functions, which callers may have compiled against other headers. */
#pragma once

#include <stddef.h>
#include "core/context.h"

/* Declares `own`, the options in force: as given, what the caller's struct does not reach being 0;
 * all 0 for NULL. Every option struct begins with its size. */
#define HETAB_OPTIONS(ctx, type, own, given)                                                       \
  type own;                                                                                        \
  _Static_assert(offsetof(type, size) == 0, "options begin with their size");                      \
  HETAB_TRY(hetab_options_take(ctx, given, &own, sizeof own))

/* HETAB_ERR_ARGUMENT for a larger struct with anything but 0 in what is not known here. */
hetab_status hetab_options_take(hetab_context *ctx, const void *given, void *own, size_t size);
