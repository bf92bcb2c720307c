/* The program that libFuzzer drives: FUZZ_TARGET names the target (`make fuzz T=scan SECONDS=300`).
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "targets.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const fuzz_target *find(const char *name) {
  for (size_t i = 0; i < fuzz_target_count; i++)
    if (name && strcmp(name, fuzz_targets[i].name) == 0)
      return &fuzz_targets[i];
  fprintf(stderr, "FUZZ_TARGET is one of:");
  for (size_t i = 0; i < fuzz_target_count; i++)
    fprintf(stderr, " %s", fuzz_targets[i].name);
  fprintf(stderr, "\n");
  exit(2);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const fuzz_target *target;
  if (!target)
    target = find(getenv("FUZZ_TARGET"));
  fuzz_run(target, data, size);
  return 0;
}
