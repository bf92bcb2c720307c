/* Output files, each of which appears whole or not at all. */
#ifndef HETAB_OUTPUT_FILE_H
#define HETAB_OUTPUT_FILE_H

#include <stddef.h>
#include <hetab/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* HETAB_ERR_EXISTS or HETAB_ERR_IO, with the remedy, if a file could not be written under path: by
 * hetab_h5_create, hetab_merl_save or hetab_text_save. Nothing is written. */
hetab_status hetab_output_check(hetab_context *ctx, const char *path, int overwrite);
/* A text file, whole or not at all. */
hetab_status hetab_text_save(hetab_context *ctx, const char *path, const char *text, size_t size,
                             int overwrite);

#ifdef __cplusplus
}
#endif
#endif
