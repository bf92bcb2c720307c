#include "core/atomic_file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/atomic_parts.h"
#include "core/context.h"
#include "core/used_files.h"

enum { MAX_LINKS = 40, NAME_TRIES = 100 };

/* --- finding the target -------------------------------------------------------------------- */

/* What `link`, read from the symbolic link at `path`, means; NULL without memory. */
static char *link_target(const char *path, const char *link) {
  const char *slash = strrchr(path, '/');
  int directory = link[0] == '/' || !slash ? 0 : (int)(slash + 1 - path);
  char *joined = NULL;
  return asprintf(&joined, "%.*s%s", directory, path, link) < 0 ? NULL : joined;
}

/* Where a chain of symbolic links ends, whether or not there is a file: realpath() would insist on
 * one. Other failures of readlink come up again, with their reason, when the directory is opened.
 */
static hetab_status follow_links(hetab_context *ctx, const char *path, char **out) {
  char *target = strdup(path);
  for (int hops = 0; target && hops < MAX_LINKS; hops++) {
    char link[PATH_MAX];
    ssize_t length = readlink(target, link, sizeof link - 1);
    if (length < 0) {
      *out = target;
      return HETAB_OK;
    }
    link[length] = '\0';
    char *next = link_target(target, link);
    free(target);
    target = next;
  }
  if (!target)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name '%s'", path);
  free(target);
  return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': it is a loop of symbolic links", path);
}

/* The directory part of file->target is cut off, opened and put back. */
static hetab_status open_directory(hetab_context *ctx, hetab_atomic_file *file) {
  char *slash = strrchr(file->target, '/');
  file->name = slash ? slash + 1 : file->target;
  size_t length = slash ? (size_t)(slash - file->target) : 0;
  HETAB_FREED char *directory = !slash   ? strdup(".")
                                : length ? strndup(file->target, length)
                                         : strdup("/");
  if (!directory)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name '%s'", file->path);
  hetab_status status = HETAB_OK;
  file->directory = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file->directory < 0 && errno == ENOENT)
    status = hetab_fail(ctx, HETAB_ERR_IO,
                        "cannot write '%s': there is no directory '%s'; create it first",
                        file->path, directory);
  else if (file->directory < 0)
    status = hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': cannot open the directory '%s': %m",
                        file->path, directory);
  return status;
}

static hetab_status exists(hetab_context *ctx, const hetab_atomic_file *file) {
  return hetab_fail(ctx, HETAB_ERR_EXISTS,
                    "'%s' exists already; choose another name or force overwriting", file->path);
}

/* *mode: that of the file to be replaced, 0 if there is none. */
static hetab_status check_target(hetab_context *ctx, const hetab_atomic_file *file, mode_t *mode) {
  struct stat old;
  *mode = 0;
  if (!*file->name)
    return hetab_fail(ctx, HETAB_ERR_IO,
                      "cannot write '%s': it names a directory; name a file in it", file->path);
  if (fstatat(file->directory, file->name, &old, 0))
    return errno == ENOENT ? HETAB_OK : hetab_atomic_fail(ctx, file, errno);
  if (S_ISDIR(old.st_mode))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': it is a directory; name a file in it",
                      file->path);
  if (!S_ISREG(old.st_mode))
    return hetab_fail(ctx, HETAB_ERR_IO,
                      "cannot write '%s': it is not a regular file; choose another name",
                      file->path);
  if (!file->overwrite)
    return exists(ctx, file);
  *mode = old.st_mode & 0777;
  return hetab_note_output(ctx, file->path, &old);
}

/* --- temporary files ----------------------------------------------------------------------- */

/* What the hidden names for a target begin with, so that what a killed process left can be told. */
static void temporary_prefix(const hetab_atomic_file *file, char prefix[HETAB_TEMP_NAME]) {
  uint32_t hash = 2166136261u; /* FNV-1a */
  for (const char *c = file->name; *c; c++)
    hash = (hash ^ (unsigned char)*c) * 16777619u;
  snprintf(prefix, HETAB_TEMP_NAME, ".hetab-%08x-", (unsigned)hash);
}

static void temporary_name(const hetab_atomic_file *file, char name[HETAB_TEMP_NAME]) {
  unsigned number;
  if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number)
    number = (unsigned)getpid();
  temporary_prefix(file, name);
  size_t length = strlen(name);
  snprintf(name + length, HETAB_TEMP_NAME - length, "%08x", number);
}

/* Whether it was left behind: processes that live hold a lock on their files. */
static bool is_abandoned(int directory, const char *name) {
  int fd = openat(directory, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  bool abandoned = fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) == 0;
  if (fd >= 0)
    close(fd);
  return abandoned;
}

/* Removes what killed processes left of this target. */
static void sweep(const hetab_atomic_file *file) {
  char prefix[HETAB_TEMP_NAME];
  int fd = openat(file->directory, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR *entries = fd >= 0 ? fdopendir(fd) : NULL;
  if (!entries && fd >= 0)
    close(fd);
  temporary_prefix(file, prefix);
  for (struct dirent *entry; entries && (entry = readdir(entries));)
    if (strncmp(entry->d_name, prefix, strlen(prefix)) == 0 &&
        is_abandoned(file->directory, entry->d_name))
      unlinkat(file->directory, entry->d_name, 0);
  if (entries)
    closedir(entries);
}

/* The way in which an unnamed file is addressed when it is given its name. */
static void descriptor_path(int fd, char path[HETAB_TEMP_NAME]) {
  snprintf(path, HETAB_TEMP_NAME, "/proc/self/fd/%d", fd);
}

/* -1 where the file system has no unnamed files, or where they could not be named: no /proc. */
static int open_unnamed(int directory) {
  char path[HETAB_TEMP_NAME];
  int fd = openat(directory, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (fd < 0)
    return -1;
  descriptor_path(fd, path);
  if (access(path, F_OK) == 0)
    return fd;
  close(fd);
  return -1;
}

static int open_named(hetab_atomic_file *file) {
  int fd = -1;
  for (int i = 0; i < NAME_TRIES && fd < 0; i++) {
    temporary_name(file, file->temp);
    fd = openat(file->directory, file->temp, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
    if (fd < 0 && errno != EEXIST)
      break;
  }
  if (fd < 0)
    file->temp[0] = '\0';
  return fd;
}

/* Whatever keeps an unnamed file from being made, a named one gets the last word and the errno. */
static hetab_status open_temporary(hetab_context *ctx, hetab_atomic_file *file, mode_t mode) {
  file->fd = open_unnamed(file->directory);
  if (file->fd < 0)
    file->fd = open_named(file);
  if (file->fd < 0)
    return hetab_fail(ctx, HETAB_ERR_IO,
                      "cannot write '%s': cannot create files beside it: %m; choose another folder",
                      file->path);
  struct stat own; /* its number may be that of an old output, which another run has replaced */
  if (fstat(file->fd, &own) == 0)
    hetab_forget_output(ctx, &own);
  flock(file->fd, LOCK_EX | LOCK_NB); /* see is_abandoned() */
  if (mode && fchmod(file->fd, mode))
    return hetab_atomic_fail(ctx, file, errno);
  return HETAB_OK;
}

/* --- the interface ------------------------------------------------------------------------- */

hetab_status hetab_atomic_target(hetab_context *ctx, const char *path, hetab_atomic_file **out) {
  hetab_status status;
  *out = NULL;
  hetab_atomic_file *file = hetab_alloc(ctx, 1, sizeof *file);
  HETAB_NEED(file);
  file->directory = file->fd = -1;
  file->path = strdup(path);
  if (!file->path)
    HETAB_GOTO(hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name '%s'", path));
  HETAB_GOTO(follow_links(ctx, path, &file->target));
  HETAB_GOTO(open_directory(ctx, file));
  *out = file;
  return HETAB_OK;
done:
  hetab_atomic_abort(file);
  return status;
}

hetab_status hetab_atomic_create(hetab_context *ctx, const char *path, int overwrite,
                                 hetab_atomic_file **out) {
  hetab_status status;
  hetab_atomic_file *file;
  mode_t mode;
  *out = NULL;
  if (!*path)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "the output's file name is empty");
  HETAB_TRY(hetab_atomic_target(ctx, path, &file));
  file->overwrite = overwrite;
  HETAB_GOTO(check_target(ctx, file, &mode));
  sweep(file);
  HETAB_GOTO(open_temporary(ctx, file, mode));
  *out = file;
  return HETAB_OK;
done:
  hetab_atomic_abort(file);
  return status;
}

int hetab_atomic_fd(const hetab_atomic_file *file) {
  return file->fd;
}

const char *hetab_atomic_path(const hetab_atomic_file *file) {
  return file->path;
}

void hetab_atomic_start_sync(const hetab_atomic_file *file) {
  sync_file_range(file->fd, 0, 0, SYNC_FILE_RANGE_WRITE);
}

hetab_status hetab_atomic_fail(hetab_context *ctx, const hetab_atomic_file *file, int error) {
  int full = error == ENOSPC || error == EDQUOT;
  errno = error;
  return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': %m%s", file->path,
                    full ? "; free some space or choose another disk" : "");
}

hetab_status hetab_atomic_write(hetab_context *ctx, hetab_atomic_file *file, const void *data,
                                size_t size) {
  const char *next = data;
  while (size) {
    ssize_t written = write(file->fd, next, size);
    if (written < 0 && errno != EINTR)
      return hetab_atomic_fail(ctx, file, errno);
    if (written > 0) {
      next += written;
      size -= (size_t)written;
    }
  }
  return HETAB_OK;
}

hetab_status hetab_atomic_reserve(hetab_context *ctx, hetab_atomic_file *file,
                                  unsigned long long bytes) {
  int result;
  do
    result = fallocate(file->fd, FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes);
  while (result && errno == EINTR);
  if (result && (errno == ENOSPC || errno == EDQUOT || errno == EFBIG))
    return hetab_fail(ctx, HETAB_ERR_IO,
                      "cannot write '%s': %m; it needs %.3g GB: ask for less (fewer angles or "
                      "wavelengths), free some space or choose another disk",
                      file->path, 1e-9 * (double)bytes);
  return HETAB_OK;
}

/* Gives an unnamed file `name`; -1 with EEXIST if that is taken. */
static int link_as(const hetab_atomic_file *file, const char *name) {
  char path[HETAB_TEMP_NAME];
  descriptor_path(file->fd, path);
  return linkat(AT_FDCWD, path, file->directory, name, AT_SYMLINK_FOLLOW);
}

/* Moves the temporary name to the target's if that is free: renameat2 sees to it, or a hard link
 * where the file system does not know that flag. */
static int rename_to_free(hetab_atomic_file *file) {
  int result =
      renameat2(file->directory, file->temp, file->directory, file->name, RENAME_NOREPLACE);
  if (result && errno == EINVAL) {
    result = linkat(file->directory, file->temp, file->directory, file->name, 0);
    if (result == 0)
      unlinkat(file->directory, file->temp, 0);
  }
  if (result == 0)
    file->temp[0] = '\0';
  return result;
}

/* A hidden name for an unnamed file: linkat never overwrites. */
static int stage(hetab_atomic_file *file) {
  for (int i = 0; !*file->temp && i < NAME_TRIES; i++) {
    char name[HETAB_TEMP_NAME];
    temporary_name(file, name);
    if (link_as(file, name) == 0)
      strcpy(file->temp, name);
    else if (errno != EEXIST)
      return -1;
  }
  return *file->temp ? 0 : -1;
}

/* The new name is on the disk only with its directory. Some file systems cannot sync one. */
static int sync_directory(int directory) {
  return fsync(directory) && errno != EINVAL && errno != EROFS ? -1 : 0;
}

hetab_status hetab_atomic_name_or_stage(hetab_context *ctx, hetab_atomic_file *file) {
  struct stat old;
  if (fstatat(file->directory, file->name, &old, 0) == 0)
    HETAB_TRY(hetab_note_output(ctx, file->path, &old));
  if ((*file->temp ? rename_to_free(file) : link_as(file, file->name)) == 0) {
    file->stage = HETAB_NAMED;
    return HETAB_OK;
  }
  if (errno == EEXIST && !file->overwrite)
    return exists(ctx, file);
  return errno == EEXIST && stage(file) == 0 ? HETAB_OK : hetab_atomic_fail(ctx, file, errno);
}

hetab_status hetab_atomic_replace(hetab_context *ctx, hetab_atomic_file *file) {
  struct stat old;
  bool known = fstatat(file->directory, file->name, &old, 0) == 0;
  if (renameat(file->directory, file->temp, file->directory, file->name))
    return hetab_atomic_fail(ctx, file, errno);
  file->temp[0] = '\0';
  file->stage = HETAB_REPLACED;
  if (known)
    hetab_forget_output(ctx, &old);
  return HETAB_OK;
}

hetab_status hetab_atomic_sync_name(hetab_context *ctx, const hetab_atomic_file *file) {
  return sync_directory(file->directory)
             ? hetab_fail(
                   ctx, HETAB_ERR_IO,
                   "'%s' is in its place, but its folder cannot be synced: %m; check the disk",
                   file->path)
             : HETAB_OK;
}

void hetab_atomic_take_back(hetab_atomic_file *file) {
  if (file->stage == HETAB_NAMED)
    unlinkat(file->directory, file->name, 0);
  file->stage = HETAB_UNPUBLISHED;
}

static hetab_status publish(hetab_context *ctx, hetab_atomic_file *file) {
  HETAB_TRY(hetab_atomic_name_or_stage(ctx, file));
  if (file->stage != HETAB_NAMED)
    HETAB_TRY(hetab_atomic_replace(ctx, file));
  return hetab_atomic_sync_name(ctx, file);
}

hetab_status hetab_held_add(hetab_context *ctx, hetab_held_files *held, hetab_atomic_file *file) {
  hetab_atomic_file **files = realloc(held->files, (held->count + 1) * sizeof *files);
  if (!files)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", file->path);
  held->files = files;
  files[held->count++] = file;
  return HETAB_OK;
}

hetab_status hetab_atomic_commit(hetab_context *ctx, hetab_atomic_file *file) {
  hetab_status status = fsync(file->fd) ? hetab_atomic_fail(ctx, file, errno) : HETAB_OK;
  if (status == HETAB_OK && ctx->held) {
    status = hetab_held_add(ctx, ctx->held, file);
    if (status == HETAB_OK)
      return HETAB_OK;
  } else if (status == HETAB_OK)
    status = publish(ctx, file);
  hetab_atomic_abort(file);
  return status;
}

void hetab_atomic_abort(hetab_atomic_file *file) {
  if (!file)
    return;
  if (*file->temp)
    unlinkat(file->directory, file->temp, 0);
  if (file->fd >= 0)
    close(file->fd);
  if (file->directory >= 0)
    close(file->directory);
  free(file->target);
  free(file->path);
  free(file);
}

int hetab_atomic_open_again(const hetab_atomic_file *file) {
  char path[HETAB_TEMP_NAME];
  descriptor_path(file->fd, path);
  return *file->temp ? openat(file->directory, file->temp, O_RDONLY | O_CLOEXEC)
                     : open(path, O_RDONLY | O_CLOEXEC);
}
