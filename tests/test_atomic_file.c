/* Files appear whole or not at all: whatever fails, and whenever the process dies. */
#include "table_support.h"

#include <errno.h>
#include <sys/syscall.h>

#include <hetab/output_file.h>

#include "core/held_files.h"
#include "core/input_file.h"

/* --- faults: these stand in for the C library's ---------------------------------------------- */

static int no_unnamed_files, no_noreplace, failing_sync, kill_in_sync;

int openat(int directory, const char *path, int flags, ...) {
  va_list args;
  va_start(args, flags);
  mode_t mode = va_arg(args, mode_t);
  va_end(args);
  if (no_unnamed_files && (flags & O_TMPFILE) == O_TMPFILE) {
    errno = EOPNOTSUPP;
    return -1;
  }
  return (int)syscall(SYS_openat, directory, path, flags, mode);
}

int renameat2(int from, const char *old, int to, const char *new, unsigned flags) {
  if (no_noreplace && flags) {
    errno = EINVAL;
    return -1;
  }
  return (int)syscall(SYS_renameat2, from, old, to, new, flags);
}

int fsync(int fd) {
  if (kill_in_sync)
    pause_to_be_killed();
  if (!failing_sync)
    return (int)syscall(SYS_fsync, fd);
  errno = EIO;
  return -1;
}

/* --- helpers -------------------------------------------------------------------------------- */

static hetab_status write_text(hetab_context *ctx, const char *path, int overwrite,
                               const char *text) {
  hetab_atomic_file *file;
  hetab_status status = hetab_atomic_create(ctx, path, overwrite, &file);
  if (status != HETAB_OK) {
    assert_null(file);
    return status;
  }
  assert_ok(ctx, hetab_atomic_write(ctx, file, text, strlen(text)));
  return hetab_atomic_commit(ctx, file);
}

static mode_t mode_of(const char *path) {
  struct stat about;
  assert_int_equal(stat(path, &about), 0);
  return about.st_mode & 07777;
}

/* --- tests ---------------------------------------------------------------------------------- */

static void test_publish(void **state) {
  fixture *f = *state;
  hetab_atomic_file *file;
  mode_t old = umask(027);
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "new", 0, &file));
  umask(old);
  assert_ok(f->ctx, hetab_atomic_write(f->ctx, file, "whole", 5));
  assert_int_equal(count_files("."), 0);
  assert_ok(f->ctx, hetab_atomic_commit(f->ctx, file));
  assert_content("new", "whole");
  assert_int_equal(mode_of("new"), 0640);
  assert_int_equal(count_files("."), 1);
}

static void test_replace(void **state) {
  fixture *f = *state;
  assert_ok(f->ctx, write_text(f->ctx, "a", 0, "old"));
  assert_int_equal(chmod("a", 0600), 0);
  assert_failure(f->ctx, write_text(f->ctx, "a", 0, "new"), HETAB_ERR_EXISTS, "'a'");
  assert_content("a", "old");
  assert_ok(f->ctx, write_text(f->ctx, "a", 1, "new"));
  assert_content("a", "new");
  assert_int_equal(mode_of("a"), 0600);
  assert_int_equal(count_files("."), 1);
}

static void test_abort(void **state) {
  fixture *f = *state;
  hetab_atomic_file *file;
  put_file("a", "old", 3);
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "a", 1, &file));
  assert_ok(f->ctx, hetab_atomic_write(f->ctx, file, "half", 4));
  hetab_atomic_abort(file);
  hetab_atomic_abort(NULL);
  assert_content("a", "old");
  assert_int_equal(count_files("."), 1);
}

/* Someone else's file that came up meanwhile is not lost. */
static void test_target_appears_meanwhile(void **state) {
  fixture *f = *state;
  hetab_atomic_file *file;
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "a", 0, &file));
  put_file("a", "theirs", 6);
  assert_failure(f->ctx, hetab_atomic_commit(f->ctx, file), HETAB_ERR_EXISTS, "'a'");
  assert_content("a", "theirs");
  assert_int_equal(count_files("."), 1);
}

static void test_symbolic_links(void **state) {
  fixture *f = *state;
  assert_int_equal(mkdir("data", 0777), 0);
  assert_int_equal(symlink("data/real", "link"), 0);
  assert_int_equal(symlink("link", "link to link"), 0);
  assert_ok(f->ctx, write_text(f->ctx, "link to link", 0, "first"));
  assert_content("data/real", "first");
  assert_failure(f->ctx, write_text(f->ctx, "link", 0, "second"), HETAB_ERR_EXISTS, "'link'");
  assert_ok(f->ctx, write_text(f->ctx, "link", 1, "second"));
  assert_content("data/real", "second");
  assert_int_equal(count_files("data"), 1);
  assert_int_equal(symlink("loop", "loop"), 0);
  assert_failure(f->ctx, write_text(f->ctx, "loop", 1, ""), HETAB_ERR_IO, "loop");
}

static void test_refused_at_once(void **state) {
  fixture *f = *state;
  assert_int_equal(mkdir("dir", 0777), 0);
  assert_int_equal(mkfifo("fifo", 0666), 0);
  put_file("plain", "", 0);
  assert_failure(f->ctx, write_text(f->ctx, "", 1, ""), HETAB_ERR_ARGUMENT, "empty");
  assert_failure(f->ctx, write_text(f->ctx, "dir", 1, ""), HETAB_ERR_IO, "is a directory");
  assert_failure(f->ctx, write_text(f->ctx, "dir/", 1, ""), HETAB_ERR_IO, "directory");
  assert_failure(f->ctx, write_text(f->ctx, ".", 1, ""), HETAB_ERR_IO, "is a directory");
  assert_failure(f->ctx, write_text(f->ctx, "/", 1, ""), HETAB_ERR_IO, "directory");
  assert_failure(f->ctx, write_text(f->ctx, "fifo", 1, ""), HETAB_ERR_IO, "regular");
  assert_failure(f->ctx, write_text(f->ctx, "none/x", 0, ""), HETAB_ERR_IO, "create it first");
  assert_failure(f->ctx, write_text(f->ctx, "plain/x", 0, ""), HETAB_ERR_IO, "Not a directory");
}

/* Root may write everywhere: as root, the attempt is somebody else's. */
static void test_unwritable_directory(void **state) {
  fixture *f = *state;
  assert_int_equal(mkdir("closed", 0555), 0);
  assert_int_equal(chmod(f->directory, 0755), 0);
  int root = geteuid() == 0;
  if (root)
    assert_int_equal(seteuid(65534), 0);
  hetab_status status = write_text(f->ctx, "closed/x", 0, "");
  if (root)
    assert_int_equal(seteuid(0), 0);
  assert_failure(f->ctx, status, HETAB_ERR_IO, "Permission denied");
  assert_int_equal(count_files("closed"), 0);
  assert_failure(f->ctx, write_text(f->ctx, "/proc/x", 0, ""), HETAB_ERR_IO, "'/proc/x'");
}

static void test_failing_sync(void **state) {
  fixture *f = *state;
  put_file("a", "old", 3);
  failing_sync = 1;
  hetab_status status = write_text(f->ctx, "a", 1, "new");
  failing_sync = 0;
  assert_failure(f->ctx, status, HETAB_ERR_IO, "'a': Input/output error");
  assert_content("a", "old");
  assert_int_equal(count_files("."), 1);
}

static void test_full_disk(void **state) {
  fixture *f = *state;
  require_mounting();
  hetab_atomic_file *file;
  char block[1 << 16] = {0};
  hetab_status status = HETAB_OK;
  mount_small(256 << 10);
  put_file("small/a", "old", 3);
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "small/a", 1, &file));
  assert_failure(f->ctx, hetab_atomic_reserve(f->ctx, file, 1 << 20), HETAB_ERR_IO,
                 "'small/a': No space left");
  for (int i = 0; i < 8 && status == HETAB_OK; i++)
    status = hetab_atomic_write(f->ctx, file, block, sizeof block);
  assert_failure(f->ctx, status, HETAB_ERR_IO, "'small/a': No space left");
  hetab_atomic_abort(file);
  assert_content("small/a", "old");
  assert_int_equal(count_files("small"), 1);
  unmount_small();
}

static void write_half(hetab_context *ctx) {
  hetab_atomic_file *file;
  if (hetab_atomic_create(ctx, "a", 1, &file) == HETAB_OK &&
      hetab_atomic_write(ctx, file, "half", 4) == HETAB_OK)
    pause_to_be_killed();
}

static void die_in_commit(hetab_context *ctx) {
  kill_in_sync = 1;
  write_text(ctx, "a", 1, "new");
}

static void test_killed(void **state) {
  fixture *f = *state;
  put_file("a", "old", 3);
  kill_within(write_half, f->ctx);
  kill_within(die_in_commit, f->ctx);
  assert_content("a", "old");
  assert_int_equal(count_files("."), 1);
}

static void assert_held(fixture *f, const hetab_held_files *held, size_t i, const char *text) {
  char *path = hetab_atomic_held_path(f->ctx, held, i);
  assert_non_null(path);
  assert_content(path, text);
  free(path);
}

static void test_several(void **state) {
  fixture *f = *state;
  hetab_held_files held;
  put_file("b", "old", 3);
  hetab_atomic_hold(f->ctx, &held);
  assert_ok(f->ctx, write_text(f->ctx, "a", 0, "first"));
  assert_ok(f->ctx, write_text(f->ctx, "b", 1, "second"));
  assert_int_equal(access("a", F_OK), -1);
  assert_content("b", "old");
  assert_held(f, &held, 0, "first");
  assert_held(f, &held, 1, "second");
  assert_ok(f->ctx, hetab_atomic_publish(f->ctx, &held));
  hetab_atomic_drop(f->ctx, &held);
  assert_int_equal(held.published, 2);
  assert_content("a", "first");
  assert_content("b", "second");
  assert_ok(f->ctx, write_text(f->ctx, "c", 0, "at once")); /* the hold has ended */
  assert_content("c", "at once");
  for (const char *name = "abc"; *name; name++)
    assert_int_equal(unlink((char[]){*name, 0}), 0);
  assert_int_equal(count_files("."), 0);
}

static void test_several_dropped(void **state) {
  fixture *f = *state;
  hetab_held_files held;
  hetab_atomic_hold(f->ctx, &held);
  assert_ok(f->ctx, write_text(f->ctx, "a", 0, "first"));
  hetab_atomic_drop(f->ctx, &held);
  assert_int_equal(count_files("."), 0);
}

/* A name that is taken meanwhile: none is there. */
static void test_several_or_none(void **state) {
  fixture *f = *state;
  hetab_held_files held;
  put_file("old", "kept", 4);
  hetab_atomic_hold(f->ctx, &held);
  assert_ok(f->ctx, write_text(f->ctx, "a", 0, "first"));
  assert_ok(f->ctx, write_text(f->ctx, "old", 1, "second"));
  assert_ok(f->ctx, write_text(f->ctx, "b", 0, "third"));
  put_file("b", "someone else's", 14);
  assert_failure(f->ctx, hetab_atomic_publish(f->ctx, &held), HETAB_ERR_EXISTS, "'b' exists");
  assert_int_equal(held.published, 0);
  assert_content("old", "kept");
  assert_content("b", "someone else's");
  assert_int_equal(count_files("."), 2);
  assert_int_equal(unlink("old") | unlink("b"), 0);
}

/* A replacement that fails after another one: what has its name is told. */
static void test_several_in_part(void **state) {
  fixture *f = *state;
  hetab_held_files held;
  put_file("old", "old", 3);
  put_file("b", "old", 3);
  hetab_atomic_hold(f->ctx, &held);
  assert_ok(f->ctx, write_text(f->ctx, "old", 1, "first"));
  assert_ok(f->ctx, write_text(f->ctx, "b", 1, "second"));
  assert_ok(f->ctx, write_text(f->ctx, "c", 0, "third"));
  assert_int_equal(unlink("b") | mkdir("b", 0777), 0);
  assert_failure(f->ctx, hetab_atomic_publish(f->ctx, &held), HETAB_ERR_IO,
                 "published before that: 'old', 'c'");
  assert_int_equal(held.published, 1);
  assert_content("old", "first");
  assert_content("c", "third");
  assert_int_equal(unlink("old") | unlink("c") | rmdir("b"), 0);
  assert_int_equal(count_files("."), 0);
}

/* An inner hold hands over or drops its own; readers see what is held, under any name of it. */
static void test_nested(void **state) {
  fixture *f = *state;
  char start[5];
  hetab_held_files outer, inner;
  hetab_atomic_hold(f->ctx, &outer);
  hetab_atomic_hold(f->ctx, &inner);
  assert_ok(f->ctx, write_text(f->ctx, "a", 0, "first"));
  assert_ok(f->ctx, hetab_atomic_publish(f->ctx, &inner));
  hetab_atomic_hold(f->ctx, &inner);
  assert_ok(f->ctx, write_text(f->ctx, "b", 0, "second"));
  hetab_atomic_drop(f->ctx, &inner);
  assert_int_equal(access("a", F_OK), -1);
  assert_ok(f->ctx, hetab_input_start(f->ctx, "./a", HETAB_INPUT_TABLE, start, sizeof start));
  assert_memory_equal(start, "first", sizeof start);
  assert_failure(f->ctx, hetab_input_start(f->ctx, "b", HETAB_INPUT_TABLE, start, sizeof start),
                 HETAB_ERR_IO, "cannot read 'b'");
  assert_ok(f->ctx, hetab_atomic_publish(f->ctx, &outer));
  assert_content("a", "first");
  assert_int_equal(unlink("a"), 0);
  assert_int_equal(count_files("."), 0);
}

/* Whichever comes first, and by whatever name: a hard link, a symbolic one. */
static void test_no_output_is_an_input(void **state) {
  fixture *f = *state;
  char start[4];
  hetab_context *ctx;
  put_file("a", "data", 4);
  assert_int_equal(link("a", "hard") | symlink("a", "soft"), 0);
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  hetab_keep_inputs(ctx);
  assert_ok(ctx, hetab_input_start(ctx, "hard", HETAB_INPUT_TABLE, start, sizeof start));
  assert_failure(ctx, write_text(ctx, "soft", 1, "x"), HETAB_ERR_IO, "'soft' is an input");
  assert_ok(ctx, write_text(ctx, "b", 1, "x"));
  assert_ok(ctx, write_text(ctx, "b", 1, "y"));
  assert_ok(ctx, hetab_input_start(ctx, "b", HETAB_INPUT_TABLE, start, sizeof start));
  hetab_context_free(ctx);
  assert_int_equal(hetab_context_create(&ctx), HETAB_OK);
  hetab_keep_inputs(ctx);
  assert_ok(ctx, hetab_output_check(ctx, "a", 1));
  assert_failure(ctx, hetab_input_start(ctx, "hard", HETAB_INPUT_TABLE, start, sizeof start),
                 HETAB_ERR_IO, "'hard' is an output too");
  hetab_context_free(ctx);
  assert_content("a", "data");
  assert_ok(f->ctx, write_text(f->ctx, "a", 1, "new")); /* a context that does not ask for it */
  assert_int_equal(unlink("a") | unlink("b") | unlink("hard") | unlink("soft"), 0);
}

/* What a killed process left is gone with the next run to that target; what a living one has is
 * not, nor what belongs to another target. */
static void test_sweep(void **state) {
  fixture *f = *state;
  hetab_atomic_file *file, *other;
  no_unnamed_files = 1;
  for (const char *name = "ab"; *name; name++) {
    pid_t child = fork();
    if (child == 0) {
      hetab_atomic_create(f->ctx, (char[]){*name, 0}, 0, &file);
      _exit(0);
    }
    waitpid(child, NULL, 0);
  }
  assert_int_equal(count_files("."), 2);
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "a", 0, &file));
  assert_ok(f->ctx, hetab_atomic_create(f->ctx, "a", 0, &other));
  assert_int_equal(count_files("."), 3); /* these two, and that of b */
  hetab_atomic_abort(file);
  hetab_atomic_abort(other);
  assert_ok(f->ctx, write_text(f->ctx, "b", 0, "whole"));
  assert_int_equal(count_files("."), 1);
  assert_int_equal(unlink("b"), 0);
  no_unnamed_files = 0;
}

/* The same on file systems that lack unnamed files, and then the flag of renameat2. */
static void test_named_temporaries(void **state) {
  no_unnamed_files = 1;
  for (no_noreplace = 0; no_noreplace < 2; no_noreplace++) {
    test_replace(state);
    assert_int_equal(unlink("a"), 0);
    test_target_appears_meanwhile(state);
    test_failing_sync(state);
    test_abort(state);
    assert_int_equal(unlink("a"), 0);
    test_several(state);
    test_several_dropped(state);
    test_several_or_none(state);
    test_several_in_part(state);
    test_nested(state);
  }
  no_unnamed_files = no_noreplace = 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(test_publish),
      TEST(test_replace),
      TEST(test_abort),
      TEST(test_target_appears_meanwhile),
      TEST(test_symbolic_links),
      TEST(test_refused_at_once),
      TEST(test_unwritable_directory),
      TEST(test_failing_sync),
      TEST(test_full_disk),
      TEST(test_killed),
      TEST(test_several),
      TEST(test_several_dropped),
      TEST(test_several_or_none),
      TEST(test_several_in_part),
      TEST(test_nested),
      TEST(test_no_output_is_an_input),
      TEST(test_sweep),
      TEST(test_named_temporaries),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
