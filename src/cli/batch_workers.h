/* The processes that make a batch's tables. The parent opens no device. */
#pragma once

#include <stdatomic.h>
#include <hetab/hetab.h>

typedef enum batch_state {
  BATCH_WAITING,
  BATCH_RUNNING,
  BATCH_MADE,
  BATCH_KEPT, /* it was there */
  BATCH_FAILED
} batch_state;

/* One surface, in memory that all processes share. */
typedef struct batch_slot {
  atomic_int state;
  int worker; /* its process */
  hetab_batch_result result;
  char message[1024]; /* of a failure */
} batch_slot;

/* Surfaces that one process does in this order: a table, and those that share it. */
typedef struct batch_unit {
  size_t first, count; /* of `items` */
  double seconds;      /* expected */
} batch_unit;

typedef struct batch_job {
  hetab_context *ctx;
  const hetab_scene *scene;
  const hetab_plan *plan;
  const char *folder;
  int jobs, verify, quiet;
  size_t *items;     /* surfaces, unit by unit */
  batch_unit *units; /* the most expensive first */
  size_t unit_count, item_count;
  batch_slot *slots; /* [plan->count]: of all surfaces */
} batch_job;

/* Until all units are done, or a signal came. -1, or the exit status after saying why no process
 * could be started. */
int batch_run(batch_job *job);
