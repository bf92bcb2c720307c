#include "core/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/held_files.h"
#include "core/used_files.h"

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
  if (S_ISDIR(about.st_mode) && kind == HETAB_INPUT_TEXT)
    return hetab_fail(ctx, HETAB_ERR_IO, "%s: cannot read: %s: name a readable text file", path,
                      strerror(EISDIR));
  if (kind == HETAB_INPUT_TABLE && !S_ISREG(about.st_mode))
    return unreadable(ctx, path, kind, "it is not a regular file");
  return hetab_note_input(ctx, path, &about);
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
