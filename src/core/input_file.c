#include "core/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/held_files.h"

/* ---- what is read, and what is written ----------------------------------------------------- */

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

/* ---- opening ------------------------------------------------------------------------------- */

static hetab_status unreadable(hetab_context *ctx, const char *path, hetab_input_kind kind,
                               const char *why) {
  int reason = errno;
  hetab_fail(ctx, HETAB_ERR_IO,
             kind == HETAB_INPUT_TEXT ? "%s: cannot open: %s: check the path"
                                      : "cannot read '%s': %s",
             path, why);
  errno = reason;
  return HETAB_ERR_IO;
}

static hetab_status check(hetab_context *ctx, const char *path, hetab_input_kind kind, int fd) {
  struct stat about;
  if (fstat(fd, &about))
    return unreadable(ctx, path, kind, strerror(errno));
  if (S_ISDIR(about.st_mode))
    return unreadable(ctx, path, kind, strerror(EISDIR));
  if (kind == HETAB_INPUT_TABLE && !S_ISREG(about.st_mode))
    return unreadable(ctx, path, kind, "it is not a regular file");
  hetab_status status = note(ctx, &about, false);
  return status == HETAB_ERR_ARGUMENT
             ? hetab_fail(ctx, HETAB_ERR_IO, "'%s' is an output too: give that another name", path)
             : status;
}

hetab_status hetab_input_open(hetab_context *ctx, const char *path, hetab_input_kind kind,
                              int *out) {
  *out = hetab_held_open(ctx, path);
  if (*out >= 0)
    return HETAB_OK;
  int flags = O_RDONLY | O_CLOEXEC | O_NOCTTY | (kind == HETAB_INPUT_TABLE ? O_NONBLOCK : 0);
  int fd = open(path, flags);
  if (fd < 0)
    return unreadable(ctx, path, kind, strerror(errno));
  hetab_status status = check(ctx, path, kind, fd);
  if (status == HETAB_OK)
    *out = fd;
  else
    close(fd);
  return status;
}

hetab_status hetab_input_stream(hetab_context *ctx, const char *path, hetab_input_kind kind,
                                FILE **out) {
  int fd;
  *out = NULL;
  HETAB_TRY(hetab_input_open(ctx, path, kind, &fd));
  *out = fdopen(fd, "rb");
  if (*out)
    return HETAB_OK;
  close(fd);
  return unreadable(ctx, path, kind, strerror(ENOMEM));
}

hetab_status hetab_input_start(hetab_context *ctx, const char *path, hetab_input_kind kind,
                               void *start, size_t size) {
  FILE *file;
  memset(start, 0, size);
  HETAB_TRY(hetab_input_stream(ctx, path, kind, &file));
  hetab_status status = HETAB_OK;
  if (fread(start, 1, size, file) < size && ferror(file))
    status = unreadable(ctx, path, kind, strerror(errno));
  fclose(file);
  return status;
}
