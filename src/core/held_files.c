#include "core/held_files.h"

#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <hetab/output_file.h>

#include "core/atomic_parts.h"
#include "core/context.h"

/* ---- holding ------------------------------------------------------------------------------- */

void hetab_atomic_hold(hetab_context *ctx, hetab_held_files *held) {
  *held = (hetab_held_files){.outer = ctx->held};
  ctx->held = held;
}

char *hetab_atomic_held_path(hetab_context *ctx, const hetab_held_files *held, size_t i) {
  const hetab_atomic_file *file = held->files[i];
  char *path = NULL;
  int directory = (int)(file->name - file->target);
  int made = *file->temp ? asprintf(&path, "%.*s%s", directory, file->target, file->temp)
                         : asprintf(&path, "/proc/self/fd/%d", file->fd);
  if (made >= 0)
    return path;
  hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name '%s'", file->path);
  return NULL;
}

/* ---- publishing --------------------------------------------------------------------------- */

/* Adds which files have their names to the message of a failure. */
static void list_published(hetab_context *ctx, hetab_status status, const hetab_held_files *held) {
  char reason[sizeof ctx->message], names[512] = "";
  size_t length = 0;
  snprintf(reason, sizeof reason, "%s", ctx->message);
  for (size_t i = 0; i < held->count && length < sizeof names; i++)
    if (held->files[i]->stage != HETAB_UNPUBLISHED)
      length += (size_t)snprintf(names + length, sizeof names - length, "%s'%s'",
                                 length ? ", " : "", held->files[i]->path);
  hetab_fail(ctx, status, "%s; published before that: %s", reason, names);
}

static hetab_status publish(hetab_context *ctx, hetab_held_files *held) {
  hetab_status status;
  bool replaced = false;
  for (size_t i = 0; i < held->count; i++)
    HETAB_GOTO(hetab_atomic_name_or_stage(ctx, held->files[i]));
  for (size_t i = 0; i < held->count; i++)
    if (held->files[i]->stage == HETAB_UNPUBLISHED) {
      HETAB_GOTO(hetab_atomic_replace(ctx, held->files[i]));
      replaced = true;
    }
  for (size_t i = 0; i < held->count; i++)
    HETAB_TRY(hetab_atomic_sync_name(ctx, held->files[i]));
  return HETAB_OK;
done:
  if (replaced)
    list_published(ctx, status, held);
  for (size_t i = 0; i < held->count && !replaced; i++)
    hetab_atomic_take_back(held->files[i]);
  return status;
}

static hetab_status hand_over(hetab_context *ctx, hetab_held_files *held) {
  while (held->published < held->count) {
    HETAB_TRY(hetab_held_add(ctx, held->outer, held->files[held->published]));
    held->files[held->published++] = NULL;
  }
  return HETAB_OK;
}

hetab_status hetab_atomic_publish(hetab_context *ctx, hetab_held_files *held) {
  hetab_status status = held->outer ? hand_over(ctx, held) : publish(ctx, held);
  while (held->published < held->count && held->files[held->published]->stage != HETAB_UNPUBLISHED)
    held->published++;
  hetab_atomic_drop(ctx, held);
  return status;
}

void hetab_atomic_drop(hetab_context *ctx, hetab_held_files *held) {
  for (size_t i = 0; i < held->count; i++)
    hetab_atomic_abort(held->files[i]);
  free(held->files);
  held->files = NULL;
  held->count = 0;
  if (ctx->held == held)
    ctx->held = held->outer;
}

/* ---- for programs -------------------------------------------------------------------------- */

hetab_status hetab_outputs_begin(hetab_context *ctx) {
  hetab_held_files *held = hetab_alloc(ctx, 1, sizeof *held);
  HETAB_NEED(held);
  hetab_atomic_hold(ctx, held);
  ctx->drop_held = hetab_outputs_drop;
  return HETAB_OK;
}

hetab_status hetab_outputs_publish(hetab_context *ctx) {
  HETAB_FREED hetab_held_files *held = ctx->held;
  return hetab_atomic_publish(ctx, held);
}

void hetab_outputs_drop(hetab_context *ctx) {
  HETAB_FREED hetab_held_files *held = ctx->held;
  hetab_atomic_drop(ctx, held);
}

/* ---- reading ------------------------------------------------------------------------------- */

static bool same_target(const hetab_atomic_file *a, const hetab_atomic_file *b) {
  struct stat about_a, about_b;
  return strcmp(a->name, b->name) == 0 && fstat(a->directory, &about_a) == 0 &&
         fstat(b->directory, &about_b) == 0 && about_a.st_dev == about_b.st_dev &&
         about_a.st_ino == about_b.st_ino;
}

int hetab_held_open(hetab_context *ctx, const char *path) {
  hetab_atomic_file *wanted;
  int fd = -1;
  if (!ctx->held || hetab_atomic_target(ctx, path, &wanted) != HETAB_OK)
    return -1;
  for (const hetab_held_files *held = ctx->held; held && fd < 0; held = held->outer)
    for (size_t i = 0; i < held->count && fd < 0; i++)
      if (same_target(held->files[i], wanted))
        fd = hetab_atomic_open_again(held->files[i]);
  hetab_atomic_abort(wanted);
  return fd;
}

/* --- one file or two ------------------------------------------------------------------------ */

/* The directory that path lies in: "." for a bare name; free() it. NULL without memory. */
static char *directory_of(const char *path) {
  HETAB_FREED char *copy = strdup(path);
  return copy ? strdup(dirname(copy)) : NULL;
}

static const char *name_of(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

static bool same_inode(const char *a, const char *b) {
  struct stat info_a, info_b;
  return stat(a, &info_a) == 0 && stat(b, &info_b) == 0 && info_a.st_dev == info_b.st_dev &&
         info_a.st_ino == info_b.st_ino;
}

bool hetab_same_file(const char *a, const char *b) {
  HETAB_FREED char *directory_a = directory_of(a), *directory_b = directory_of(b);
  bool same =
      same_inode(a, b) || (directory_a && directory_b && strcmp(name_of(a), name_of(b)) == 0 &&
                           same_inode(directory_a, directory_b));
  return same;
}
