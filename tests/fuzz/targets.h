/* What is fuzzed: each target takes bytes to one reader, as a file of its kind, and checks that
 * what the reader accepts keeps the promises of its header. Broken promises abort. */
#ifndef HETAB_TESTS_FUZZ_TARGETS_H
#define HETAB_TESTS_FUZZ_TARGETS_H

#include <stddef.h>
#include <stdint.h>

typedef struct fuzz_target {
  const char *name; /* of tests/fuzz/corpus/NAME, too */
  const char *file; /* what the reader is given; NULL: a text on the command line */
  void (*run)(const uint8_t *data, size_t size, const char *path);
} fuzz_target;

extern const fuzz_target fuzz_targets[];
extern const size_t fuzz_target_count;

/* Runs one input, in a folder of its own in memory. */
void fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size);

#endif
