/* The steps that publishing is made of, for core/atomic_file.c and core/held_files.c alone. */
#pragma once

#include "core/atomic_file.h"

enum { HETAB_TEMP_NAME = 32 };

typedef enum hetab_stage {
  HETAB_UNPUBLISHED,
  HETAB_NAMED,   /* under a name that was free */
  HETAB_REPLACED /* in the place of another file */
} hetab_stage;

struct hetab_atomic_file {
  char *path;   /* as the caller gave it, for messages */
  char *target; /* the same with symbolic links followed; name points into it */
  const char *name;
  int directory; /* the target's; everything happens relative to it */
  int fd;
  int overwrite;
  char temp[HETAB_TEMP_NAME]; /* the name in the directory until published; "" while unnamed */
  hetab_stage stage;
};

/* Where path leads, with nothing made yet. */
hetab_status hetab_atomic_target(hetab_context *ctx, const char *path, hetab_atomic_file **out);

/* First the target's name if that is free, or else a hidden one: leaves no trace if it fails. Then
 * in the place of the target, if it is not published yet; and the directory on the disk. */
hetab_status hetab_atomic_name_or_stage(hetab_context *ctx, hetab_atomic_file *file);
hetab_status hetab_atomic_replace(hetab_context *ctx, hetab_atomic_file *file);
hetab_status hetab_atomic_sync_name(hetab_context *ctx, const hetab_atomic_file *file);
/* Undoes the first step. */
void hetab_atomic_take_back(hetab_atomic_file *file);

hetab_status hetab_held_add(hetab_context *ctx, hetab_held_files *held, hetab_atomic_file *file);

/* A descriptor for reading what is not published, or -1. */
int hetab_atomic_open_again(const hetab_atomic_file *file);
