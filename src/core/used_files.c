#include "core/used_files.h"

#include <stdlib.h>

#include <hetab/output_file.h>

struct hetab_used_file {
  dev_t device;
  ino_t inode;
  bool written;
};

static hetab_used_file *find(const hetab_context *ctx, const struct stat *about) {
  for (size_t i = 0; i < ctx->used_count; i++)
    if (ctx->used[i].device == about->st_dev && ctx->used[i].inode == about->st_ino)
      return &ctx->used[i];
  return NULL;
}

/* HETAB_ERR_ARGUMENT without words if the file has the other part. */
static hetab_status note(hetab_context *ctx, const struct stat *about, bool written) {
  if (!ctx->keeps_inputs || !S_ISREG(about->st_mode))
    return HETAB_OK;
  const hetab_used_file *known = find(ctx, about);
  if (known)
    return known->written == written ? HETAB_OK : HETAB_ERR_ARGUMENT;
  hetab_used_file *more = realloc(ctx->used, (ctx->used_count + 1) * sizeof *more);
  if (!more)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the list of files");
  more[ctx->used_count++] = (hetab_used_file){about->st_dev, about->st_ino, written};
  ctx->used = more;
  return HETAB_OK;
}

hetab_status hetab_note_input(hetab_context *ctx, const char *path, const struct stat *about) {
  hetab_status status = note(ctx, about, false);
  return status == HETAB_ERR_ARGUMENT
             ? hetab_fail(ctx, HETAB_ERR_IO, "'%s' is an output too: give that another name", path)
             : status;
}

hetab_status hetab_note_output(hetab_context *ctx, const char *path, const struct stat *about) {
  hetab_status status = note(ctx, about, true);
  return status == HETAB_ERR_ARGUMENT
             ? hetab_fail(ctx, HETAB_ERR_IO, "'%s' is an input: give the output another name", path)
             : status;
}

void hetab_forget_output(hetab_context *ctx, const struct stat *about) {
  hetab_used_file *known = find(ctx, about);
  if (known && known->written)
    *known = ctx->used[--ctx->used_count];
}

void hetab_keep_inputs(hetab_context *ctx) {
  ctx->keeps_inputs = true;
}
