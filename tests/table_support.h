/* What the tests of table files share: a directory of their own, and a disk that gets full. */
#ifndef HETAB_TESTS_TABLE_SUPPORT_H
#define HETAB_TESTS_TABLE_SUPPORT_H

#include <dirent.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include <hetab/hetab.h>

typedef struct fixture {
  hetab_context *ctx;
  char directory[32]; /* the working directory of the test */
} fixture;

static inline int set_up(void **state) {
  static fixture made;
  strcpy(made.directory, "/tmp/hetab-test-XXXXXX");
  *state = &made;
  return mkdtemp(made.directory) && chdir(made.directory) == 0 &&
                 hetab_context_create(&made.ctx) == HETAB_OK
             ? 0
             : -1;
}

static inline int tear_down(void **state) {
  fixture *made = *state;
  char command[64];
  hetab_context_free(made->ctx);
  umount2("small", MNT_DETACH); /* where a test failed before it could */
  snprintf(command, sizeof command, "rm -rf %s", made->directory);
  return chdir("/") || system(command) ? -1 : 0;
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

static inline void assert_ok(hetab_context *ctx, hetab_status status) {
  if (status != HETAB_OK)
    fail_msg("%s: %s", hetab_status_name(status), hetab_error_message(ctx));
}

/* The status, and what its message must speak of. */
static inline void assert_failure(hetab_context *ctx, hetab_status status, hetab_status expected,
                                  const char *word) {
  assert_int_equal(status, expected);
  if (!strstr(hetab_error_message(ctx), word))
    fail_msg("'%s' is not in: %s", word, hetab_error_message(ctx));
}

static inline size_t count_files(const char *directory) {
  size_t count = 0;
  DIR *list = opendir(directory);
  assert_non_null(list);
  for (struct dirent *entry; (entry = readdir(list));)
    count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
  closedir(list);
  return count;
}

static inline void put_file(const char *path, const void *data, size_t size) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(data, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
}

static inline void assert_content(const char *path, const char *expected) {
  char content[64] = "";
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(content, 1, sizeof content - 1, file), strlen(expected));
  fclose(file);
  assert_string_equal(content, expected);
}

/* The whole file; free() it. */
static inline unsigned char *get_file(const char *path, size_t *size) {
  struct stat about;
  assert_int_equal(stat(path, &about), 0);
  *size = (size_t)about.st_size;
  unsigned char *data = malloc(*size ? *size : 1);
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(data, 1, *size, file), *size);
  fclose(file);
  return data;
}

/* Mounts a disk of `bytes` at ./small. */
static inline int try_mount_small(long long bytes) {
  char options[32];
  snprintf(options, sizeof options, "size=%lld", bytes);
  mkdir("small", 0777);
  return mount("none", "small", "tmpfs", 0, options);
}

static inline void mount_small(long long bytes) {
  assert_int_equal(try_mount_small(bytes), 0);
}

static inline void unmount_small(void) {
  assert_int_equal(umount2("small", MNT_DETACH), 0);
}

/* Skips the test where nothing can be mounted. */
static inline void require_mounting(void) {
  if (try_mount_small(1 << 16)) {
    print_message("skipped: no small disk can be mounted here (needs root)\n");
    skip();
  }
  unmount_small();
}

/* Runs `work` in a child that is killed with SIGKILL once it calls pause_to_be_killed(). */
static inline void pause_to_be_killed(void) {
  raise(SIGSTOP);
}

static inline void kill_within(void (*work)(hetab_context *), hetab_context *ctx) {
  int how;
  pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    work(ctx);
    _exit(1);
  }
  assert_int_equal(waitpid(child, &how, WUNTRACED), child);
  assert_true(WIFSTOPPED(how));
  assert_int_equal(kill(child, SIGKILL), 0);
  assert_int_equal(waitpid(child, &how, 0), child);
  assert_true(WIFSIGNALED(how) && WTERMSIG(how) == SIGKILL);
}

#endif
