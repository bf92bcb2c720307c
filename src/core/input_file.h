/* The one way in for every file that is read.
 *
 * Within hetab_outputs_begin() a path that this context has saved, and not published yet, is read
 * as saved. A context that keeps its inputs (hetab_keep_inputs) notes which files were read and
 * which are to be written, by device and inode, and refuses that one file be both. */
#pragma once

#include <stdio.h>
#include "core/context.h"

/* Tables are regular files, so that nobody waits for a pipe; text may come through one. */
typedef enum hetab_input_kind { HETAB_INPUT_TABLE, HETAB_INPUT_TEXT } hetab_input_kind;

/* HETAB_ERR_IO naming the path, errno telling why; close() *fd. */
hetab_status hetab_input_open(hetab_context *ctx, const char *path, hetab_input_kind kind, int *fd);
/* The same as a stream; fclose() it. */
hetab_status hetab_input_stream(hetab_context *ctx, const char *path, hetab_input_kind kind,
                                FILE **out);

/* The first bytes, zeros where it has fewer: formats are told apart by them. */
hetab_status hetab_input_start(hetab_context *ctx, const char *path, hetab_input_kind kind,
                               void *start, size_t size);
