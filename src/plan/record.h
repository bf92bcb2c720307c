/* What is written beside a table of a batch: NAME.json. */
#pragma once

#include <stdio.h>
#include <jansson.h>
#include <hetab/batch.h>

/* "FOLDER/NAMEending"; free() it. NULL without memory. */
char *hetab_batch_path(hetab_context *ctx, const char *folder, const char *name,
                       const char *ending);
/* ".bsdf", ".binary", ".h5" or ".exr" */
const char *hetab_batch_ending(hetab_consumer consumer);

/* {path, bytes, modified, md5} of a file of the folder; NULL if it cannot be read. */
json_t *hetab_record_file(hetab_context *ctx, const char *folder, const char *name,
                          const char *ending);
/* The record of surface i; NULL if there is none, or it is not JSON. */
json_t *hetab_record_load(hetab_context *ctx, const hetab_scene *scene, size_t i,
                          const char *folder);
/* Steals the record. */
hetab_status hetab_record_save(hetab_context *ctx, const hetab_scene *scene, size_t i,
                               const char *folder, json_t *record);

/* A member; "", or 0, if there is none. */
const char *hetab_record_text(const json_t *record, const char *key);
double hetab_record_number(const json_t *record, const char *key);

/* A text in the making, for the folder. */
typedef struct hetab_folder_file {
  FILE *stream;
  char *bytes;
  size_t size;
} hetab_folder_file;
hetab_status hetab_folder_text(hetab_context *ctx, hetab_folder_file *file);
/* Whole or not at all; the file is gone in any case. */
hetab_status hetab_folder_save(hetab_context *ctx, hetab_folder_file *file, const char *folder,
                               const char *name);
