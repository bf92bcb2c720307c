/* Output files, each of which appears whole or not at all. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

/* HETAB_ERR_EXISTS or HETAB_ERR_IO, with the remedy, if a file could not be written under path: by
 * hetab_h5_create, hetab_merl_save or hetab_text_save. Nothing is written. */
hetab_status hetab_output_check(hetab_context *ctx, const char *path, int overwrite);
/* A text file, whole or not at all. */
hetab_status hetab_text_save(hetab_context *ctx, const char *path, const char *text, size_t size,
                             int overwrite);

/* Several outputs, all or none: what is saved after hetab_outputs_begin(), by any function of this
 * context, is complete and on the disk, but gets its name only from hetab_outputs_publish(). Until
 * then it is read under its path by this context's functions, and by nobody else.
 *
 * publish: new names first, then renames over the files that are replaced, after everything else
 * that could fail. If one fails none is there, unless a file was replaced before it: the message
 * then lists what is published. drop, or the end of the context: none is written. The calls nest:
 * an inner publish hands its files to the outer one, an inner drop drops only its own. */
hetab_status hetab_outputs_begin(hetab_context *ctx);
hetab_status hetab_outputs_publish(hetab_context *ctx);
void hetab_outputs_drop(hetab_context *ctx);

/* From now on a file that this context's functions have read is not replaced by them, and one that
 * hetab_output_check() has found replaceable is not read: HETAB_ERR_IO. Files are told by
 * device and inode, whatever their names. For programs whose user names both. */
void hetab_keep_inputs(hetab_context *ctx);

HETAB_END
