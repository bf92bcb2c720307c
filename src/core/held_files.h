/* Several files, all or none as far as renames allow: from hold to publish or drop, what is
 * committed with the context is kept, whole and synced, without its name. The context's readers see
 * it under its path (core/input_file.h). Holds nest: an inner one hands its files to the outer. */
#pragma once

#include <stdbool.h>
#include "core/atomic_file.h"

void hetab_atomic_hold(hetab_context *ctx, hetab_held_files *held);
/* Where a held file can be read; free() it. NULL without memory. */
char *hetab_atomic_held_path(hetab_context *ctx, const hetab_held_files *held, size_t i);
/* Ends the hold: new names first, then replacements. Where one fails, none is published unless a
 * file has been replaced: then those that have their names keep them, and the message lists them.
 */
hetab_status hetab_atomic_publish(hetab_context *ctx, hetab_held_files *held);
/* Ends the hold and drops what is not published; fine after publish, and on a zeroed one. */
void hetab_atomic_drop(hetab_context *ctx, hetab_held_files *held);

/* A descriptor for reading what is held for path, or -1. */
int hetab_held_open(hetab_context *ctx, const char *path);

/* Two paths of one file, existing or not. */
bool hetab_same_file(const char *a, const char *b);
