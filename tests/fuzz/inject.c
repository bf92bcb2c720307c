/* Faults for `make inject`: linked into the program with --wrap, so that the calls of our own code
 * fail and those of other libraries do not. HETAB_FAIL=KIND:N fails the N-th call of a kind (and of
 * writes all that follow, as on a full disk); HETAB_COUNT=FILE receives how many there were. */
#include <errno.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

enum kind { ALLOC, WRITE, SYNC, LINK, RENAME, READ, KINDS };
static const char *const names[KINDS] = {"alloc", "write", "sync", "link", "rename", "read"};
static atomic_long counts[KINDS];
static long fail_at[KINDS];

static void __attribute__((constructor)) begin(void) {
  const char *what = getenv("HETAB_FAIL");
  for (int k = 0; what && k < KINDS; k++)
    if (strncmp(what, names[k], strlen(names[k])) == 0)
      fail_at[k] = atol(what + strlen(names[k]) + 1);
}

static void __attribute__((destructor)) end(void) {
  const char *path = getenv("HETAB_COUNT");
  FILE *file = path ? fopen(path, "w") : NULL;
  for (int k = 0; file && k < KINDS; k++)
    fprintf(file, "%s %ld\n", names[k], atomic_load(&counts[k]));
  if (file)
    fclose(file);
}

static int fails(enum kind kind, int error) {
  long count = atomic_fetch_add(&counts[kind], 1) + 1;
  if (!fail_at[kind] || count < fail_at[kind] || (kind != WRITE && count != fail_at[kind]))
    return 0;
  errno = error;
  return 1;
}

/* A call like the wrapped one, which fails when it is its turn. */
#define WRAP(type, name, parameters, arguments, kind, error, failure)                              \
  type __real_##name parameters;                                                                   \
  type __wrap_##name parameters;                                                                   \
  type __wrap_##name parameters {                                                                  \
    return fails(kind, error) ? failure : __real_##name arguments;                                 \
  }

WRAP(void *, malloc, (size_t size), (size), ALLOC, ENOMEM, NULL)
WRAP(void *, calloc, (size_t count, size_t size), (count, size), ALLOC, ENOMEM, NULL)
WRAP(void *, realloc, (void *old, size_t size), (old, size), ALLOC, ENOMEM, NULL)
WRAP(char *, strdup, (const char *text), (text), ALLOC, ENOMEM, NULL)
WRAP(char *, strndup, (const char *text, size_t size), (text, size), ALLOC, ENOMEM, NULL)
WRAP(FILE *, open_memstream, (char **text, size_t *size), (text, size), ALLOC, ENOMEM, NULL)
WRAP(ssize_t, write, (int fd, const void *data, size_t size), (fd, data, size), WRITE, ENOSPC, -1)
WRAP(ssize_t, pwrite, (int fd, const void *data, size_t size, off_t at), (fd, data, size, at),
     WRITE, ENOSPC, -1)
WRAP(int, ftruncate, (int fd, off_t size), (fd, size), WRITE, ENOSPC, -1)
WRAP(int, fsync, (int fd), (fd), SYNC, EIO, -1)
WRAP(int, linkat, (int from, const char *old, int to, const char *new, int flags),
     (from, old, to, new, flags), LINK, EIO, -1)
WRAP(int, renameat, (int from, const char *old, int to, const char *new), (from, old, to, new),
     RENAME, EIO, -1)
WRAP(ssize_t, read, (int fd, void *data, size_t size), (fd, data, size), READ, EIO, -1)
WRAP(ssize_t, pread, (int fd, void *data, size_t size, off_t at), (fd, data, size, at), READ, EIO,
     -1)

int __wrap_asprintf(char **text, const char *format, ...);
int __wrap_asprintf(char **text, const char *format, ...) {
  va_list args;
  if (fails(ALLOC, ENOMEM))
    return -1;
  va_start(args, format);
  int length = vasprintf(text, format, args);
  va_end(args);
  return length;
}

size_t __real_fread(void *data, size_t size, size_t count, FILE *file);
size_t __wrap_fread(void *data, size_t size, size_t count, FILE *file);
size_t __wrap_fread(void *data, size_t size, size_t count, FILE *file) {
  if (!fails(READ, EIO))
    return __real_fread(data, size, count, file);
  file->_flags |= 0x20; /* glibc's mark of an error */
  return 0;
}
