#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"

/* ---- files --------------------------------------------------------------------------------- */

/* The directory that path lies in: "." for a bare name; free() it. NULL without memory. */
static char *directory_of(const char *path) {
  char *copy = strdup(path);
  char *directory = copy ? strdup(dirname(copy)) : NULL;
  free(copy);
  return directory;
}

static const char *name_of(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

static int directory_allowed(const char *path, const char *directory) {
  struct stat info;
  if (stat(directory, &info) != 0)
    return cli_fail("%s: directory '%s': %s", path, directory, strerror(errno)), 0;
  if (!S_ISDIR(info.st_mode))
    return cli_fail("%s: '%s' is not a directory", path, directory), 0;
  if (access(directory, W_OK | X_OK) != 0)
    return cli_fail("%s: cannot write in directory '%s': %s", path, directory, strerror(errno)), 0;
  return 1;
}

int cli_output_allowed(const char *path, int overwrite) {
  char *directory = directory_of(path);
  if (!directory)
    return cli_fail("out of memory"), 0;
  int allowed = directory_allowed(path, directory);
  free(directory);
  struct stat info;
  if (!allowed)
    return 0;
  if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
    return cli_fail("%s exists and is not a regular file: choose another name", path), 0;
  if (lstat(path, &info) == 0 && !overwrite)
    return cli_fail("%s exists: use --force to overwrite it", path), 0;
  return 1;
}

int cli_same_file(const char *a, const char *b) {
  char *directory_a = directory_of(a), *directory_b = directory_of(b);
  struct stat info_a, info_b;
  int same = directory_a && directory_b && strcmp(name_of(a), name_of(b)) == 0 &&
             stat(directory_a, &info_a) == 0 && stat(directory_b, &info_b) == 0 &&
             info_a.st_dev == info_b.st_dev && info_a.st_ino == info_b.st_ino;
  free(directory_a);
  free(directory_b);
  return same;
}

/* "DIRECTORY/.NAME.PID": hidden, beside the target so that it can be renamed or linked. */
static char *temporary_name(const char *path) {
  char *name;
  int head = (int)(name_of(path) - path);
  return asprintf(&name, "%.*s.%s.%ld", head, path, name_of(path), (long)getpid()) < 0 ? NULL
                                                                                       : name;
}

/* A file without a name if the file system has that: a kill then leaves nothing behind. */
static int open_unpublished(cli_file *file) {
  char *directory = directory_of(file->path);
  int descriptor = directory ? open(directory, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666) : -1;
  free(directory);
  if (descriptor >= 0)
    return descriptor;
  file->temporary = temporary_name(file->path);
  return file->temporary ? open(file->temporary, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666)
                         : -1;
}

int cli_file_create(cli_file *file, const char *path) {
  *file = (cli_file){.path = strdup(path)};
  int descriptor = file->path ? open_unpublished(file) : -1;
  if (descriptor >= 0)
    file->stream = fdopen(descriptor, "w");
  if (file->stream)
    return -1;
  int status = cli_fail("%s: %s", path, strerror(errno));
  if (descriptor >= 0)
    close(descriptor);
  cli_file_abort(file);
  return status;
}

/* link() refuses to replace what exists. */
static int link_as(const cli_file *file, const char *path) {
  char descriptor[64];
  snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", fileno(file->stream));
  return linkat(AT_FDCWD, file->temporary ? file->temporary : descriptor, AT_FDCWD, path,
                AT_SYMLINK_FOLLOW);
}

/* Only a rename replaces an old file in one step, and only what has a name can be renamed. */
static int move_into_place(cli_file *file, int overwrite) {
  if (!overwrite)
    return link_as(file, file->path);
  if (!file->temporary) {
    char *name = temporary_name(file->path);
    if (!name || link_as(file, name) != 0) {
      free(name);
      return -1;
    }
    file->temporary = name;
  }
  return rename(file->temporary, file->path);
}

static void sync_directory(const char *path) {
  char *directory = directory_of(path);
  int descriptor = directory ? open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
  if (descriptor >= 0) {
    fsync(descriptor);
    close(descriptor);
  }
  free(directory);
}

int cli_file_publish(cli_file *file, int overwrite) {
  int status = -1;
  errno = 0;
  if (fflush(file->stream) != 0 || ferror(file->stream) || fsync(fileno(file->stream)) != 0 ||
      move_into_place(file, overwrite) != 0)
    status = cli_fail("%s: %s", file->path, strerror(errno ? errno : EIO));
  else
    sync_directory(file->path);
  cli_file_abort(file);
  return status;
}

void cli_file_abort(cli_file *file) {
  if (file->stream)
    fclose(file->stream);
  if (file->temporary) /* gone already if it was renamed */
    unlink(file->temporary);
  free(file->temporary);
  free(file->path);
  *file = (cli_file){0};
}

/* ---- numbers ------------------------------------------------------------------------------- */

void cli_si(double value, char *text, size_t size) {
  static const char *const prefixes[] = {"", " k", " M", " G", " T", " P"};
  int power = 0;
  while (fabs(value) >= 999.5 && power < 5) {
    value /= 1000;
    power++;
  }
  int decimals = power == 0 && value == floor(value) ? 0 : value < 9.995 ? 2 : value < 99.95;
  snprintf(text, size, "%.*f%s", decimals, value, prefixes[power]);
}

void cli_error_text(const hetab_error_stats *error, double value, char *text, size_t size) {
  if (error->compared)
    snprintf(text, size, "%.1e", value);
  else
    snprintf(text, size, "-");
}

/* ---- JSON ---------------------------------------------------------------------------------- */

json_t *cli_json_text(const char *text) {
  json_t *json = json_string(text);
  char *copy = json ? NULL : strdup(text);
  if (!copy)
    return json;
  for (char *c = copy; *c; c++)
    if (*c < ' ' || *c > '~')
      *c = '?';
  json = json_string(copy);
  free(copy);
  return json;
}

json_t *cli_json_error(const hetab_error_stats *error) {
  if (!error->samples)
    return json_null();
  return json_pack("{sI sI sf sf sf sf sI}", "samples", (json_int_t)error->samples, "compared",
                   (json_int_t)error->compared, "max_rel", error->max_rel, "p99_rel",
                   error->p99_rel, "rms_rel", error->rms_rel, "max_abs_below_floor",
                   error->max_abs_below, "bad", (json_int_t)error->bad);
}

int cli_json_print(json_t *json) {
  if (!json)
    return cli_fail("out of memory");
  json_dumpf(json, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(12));
  putchar('\n');
  json_decref(json);
  return CLI_OK;
}
