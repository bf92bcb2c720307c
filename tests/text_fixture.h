/* A context, and text files in a folder of their own, for tests of readers. */
#ifndef HETAB_TESTS_TEXT_FIXTURE_H
#define HETAB_TESTS_TEXT_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <hetab/surface.h>

typedef struct text_fixture {
  hetab_context *ctx;
  char folder[64];
  char path[160]; /* of the file written last */
} text_fixture;

static int text_fixture_setup(void **state) {
  text_fixture *fixture = calloc(1, sizeof *fixture);
  strcpy(fixture->folder, "/tmp/hetab-test-XXXXXX");
  *state = fixture;
  return !mkdtemp(fixture->folder) || hetab_context_create(&fixture->ctx) != HETAB_OK;
}

static int text_fixture_teardown(void **state) {
  text_fixture *fixture = *state;
  char command[96];
  hetab_context_free(fixture->ctx);
  snprintf(command, sizeof command, "rm -rf '%s'", fixture->folder);
  int failed = system(command);
  free(fixture);
  return failed;
}

/* Write a file of the fixture's folder and return its path. */
static const char *write_bytes(text_fixture *fixture, const char *name, const void *bytes,
                               size_t length) {
  snprintf(fixture->path, sizeof fixture->path, "%s/%s", fixture->folder, name);
  FILE *file = fopen(fixture->path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, length, file), length);
  assert_int_equal(fclose(file), 0);
  return fixture->path;
}

static const char *write_text_file(text_fixture *fixture, const char *name, const char *text) {
  return write_bytes(fixture, name, text, strlen(text));
}

/* A locale with a decimal comma, made on the spot; 0 where the system has no sources for it. */
static inline int use_decimal_comma(const text_fixture *fixture) {
  char command[256];
  snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 %s/de_DE.UTF-8 >%s/log 2>&1",
           fixture->folder, fixture->folder);
  return system(command) == 0 && setenv("LOCPATH", fixture->folder, 1) == 0 &&
         setlocale(LC_ALL, "de_DE.UTF-8");
}

/* The message is one line and holds every one of the words, up to the first NULL. */
static void assert_message(const text_fixture *fixture, const char *const *words) {
  const char *message = hetab_error_message(fixture->ctx);
  for (; *words; words++)
    if (!strstr(message, *words))
      fail_msg("no '%s' in message '%s'", *words, message);
  assert_null(strchr(message, '\n'));
}

#endif
