/* Every input that fuzzing found worth keeping, through its reader: see tests/fuzz. */
#include "table_support.h"

#include <dirent.h>
#include <limits.h>

#include "fuzz/targets.h"

enum { MOST_BYTES = 1 << 20 };

static void replay(const fuzz_target *target, const char *path) {
  static uint8_t data[MOST_BYTES];
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  size_t size = fread(data, 1, sizeof data, file);
  fclose(file);
  fuzz_run(target, data, size);
}

static void test_corpus(void **state) {
  char root[PATH_MAX], path[PATH_MAX + 600];
  size_t inputs = 0;
  assert_non_null(realpath("tests/fuzz/corpus", root));
  for (size_t i = 0; i < fuzz_target_count; i++) {
    snprintf(path, sizeof path, "%s/%s", root, fuzz_targets[i].name);
    DIR *folder = opendir(path);
    assert_non_null(folder);
    for (struct dirent *entry; (entry = readdir(folder));)
      if (entry->d_name[0] != '.') {
        snprintf(path, sizeof path, "%s/%s/%s", root, fuzz_targets[i].name, entry->d_name);
        replay(&fuzz_targets[i], path);
        inputs++;
      }
    closedir(folder);
  }
  print_message("  %zu inputs of %zu readers\n", inputs, fuzz_target_count);
  assert_true(inputs >= fuzz_target_count);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_corpus)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
