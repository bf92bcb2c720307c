#include "launcher.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

/* A whole number that is the whole text. */
static int parse_count(const char *text, size_t *value) {
  char *end;
  if (*text < '0' || *text > '9' || strlen(text) > 9)
    return 0;
  *value = strtoul(text, &end, 10);
  return !*end;
}

int launcher_parse(const char *text, launcher_share *share) {
  const char *slash = strchr(text, '/');
  char first[16];
  if (!slash || slash - text >= (long)sizeof first)
    return 0;
  snprintf(first, sizeof first, "%.*s", (int)(slash - text), text);
  return parse_count(first, &share->number) && parse_count(slash + 1, &share->count) &&
         share->number >= 1 && share->number <= share->count;
}

/* 1: taken, 0: not set, -1: failed. */
static int from_pair(const char *rank_name, const char *size_name, launcher_share *share) {
  const char *rank = getenv(rank_name), *size = getenv(size_name);
  if (!rank && !size)
    return 0;
  if (!rank || !size || !parse_count(rank, &share->number) || !parse_count(size, &share->count) ||
      share->number >= share->count) {
    cli_fail("%s=%s and %s=%s do not fit together: unset them, or use --shard I/N", rank_name,
             rank ? rank : "", size_name, size ? size : "");
    return -1;
  }
  share->number++;
  snprintf(share->source, sizeof share->source, "%s and %s", rank_name, size_name);
  return 1;
}

/* Outside a step the variables are the batch script's, and there is one of it however many tasks
 * were asked for. */
static int from_step(launcher_share *share) {
  const char *step = getenv("SLURM_STEP_ID");
  if (!step || !getenv("SLURM_STEP_NUM_TASKS"))
    return 0;
  return from_pair("SLURM_PROCID", "SLURM_STEP_NUM_TASKS", share);
}

static int from_array(launcher_share *share) {
  static const char *const names[] = {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN",
                                      "SLURM_ARRAY_TASK_STEP", "SLURM_ARRAY_TASK_COUNT"};
  size_t value[4];
  if (!getenv(names[0]))
    return 0;
  for (int i = 0; i < 4; i++) {
    const char *text = getenv(names[i]);
    if (!text || !parse_count(text, &value[i])) {
      cli_fail("%s is %s: use --shard I/N", names[i], text ? text : "not set");
      return -1;
    }
  }
  size_t step = value[2] ? value[2] : 1, offset = value[0] - value[1];
  if (value[0] < value[1] || offset % step || offset / step >= value[3]) {
    cli_fail("the array's task %zu does not fit minimum %zu, step %zu and count %zu: use --shard "
             "I/N",
             value[0], value[1], value[2], value[3]);
    return -1;
  }
  share->number = offset / step + 1;
  share->count = value[3];
  snprintf(share->source, sizeof share->source, "SLURM_ARRAY_TASK_ID");
  return 1;
}

int launcher_find(launcher_share *share) {
  *share = (launcher_share){.number = 1, .count = 1};
  int found = from_pair("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", share);
  if (found == 0)
    found = from_pair("PMI_RANK", "PMI_SIZE", share);
  if (found == 0)
    found = from_step(share);
  if (found == 0 || (found > 0 && share->count == 1)) { /* one task in each job of an array */
    int array = from_array(share);
    found = array ? array : found;
  }
  return found < 0 ? CLI_FAILURE : -1;
}
