#include "core/cpus.h"

#include <sched.h>

static _Thread_local int limit;

int hetab_cpu_limit(int most) {
  int before = limit;
  limit = most;
  return before;
}

int hetab_cpu_count(void) {
  cpu_set_t set;
  int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
  count = limit > 0 && count > limit ? limit : count;
  return count > 0 ? count : 1;
}
