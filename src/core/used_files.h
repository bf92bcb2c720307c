/* Which files a context has read and which it is to replace, by device and inode. One that keeps
 * its inputs (hetab_keep_inputs) refuses with HETAB_ERR_IO that one file be both; others note
 * nothing. */
#pragma once

#include <sys/stat.h>
#include "core/context.h"

hetab_status hetab_note_input(hetab_context *ctx, const char *path, const struct stat *about);
hetab_status hetab_note_output(hetab_context *ctx, const char *path, const struct stat *about);
/* It has been replaced: its inode may come to be another file's. */
void hetab_forget_output(hetab_context *ctx, const struct stat *about);
