#include "core/each.h"

#include <pthread.h>
#include <stdatomic.h>

#include "core/cpus.h"

typedef struct job {
  size_t count;
  bool is_step; /* of a longer job */
  atomic_size_t next;
  hetab_piece_fn piece;
  void *user;
} job;

typedef struct worker {
  job *job;
  int number;
  pthread_t thread;
} worker;

int hetab_worker_count(void) {
  int count = hetab_cpu_count();
  return count < HETAB_MOST_WORKERS ? count : HETAB_MOST_WORKERS;
}

static void *work(void *argument) {
  worker *w = argument;
  for (size_t i; (i = atomic_fetch_add(&w->job->next, 1)) < w->job->count;)
    w->job->piece(w->job->user, i, w->number);
  return NULL;
}

static hetab_status work_and_tell(hetab_context *ctx, job *job) {
  hetab_status status = HETAB_OK;
  for (size_t i; (i = atomic_fetch_add(&job->next, 1)) < job->count && status == HETAB_OK;) {
    job->piece(job->user, i, 0);
    status = job->is_step ? hetab_go_on(ctx, 0)
                          : hetab_progress(ctx, (double)(i + 1), (double)job->count);
  }
  if (status != HETAB_OK)
    atomic_store(&job->next, job->count);
  return status;
}

/* What no thread could be had for the others do. */
static hetab_status each(hetab_context *ctx, job *job) {
  worker workers[HETAB_MOST_WORKERS];
  int most = hetab_worker_count(), started = 1;
  most = (size_t)most < job->count ? most : (int)job->count;
  for (; started < most; started++) {
    workers[started] = (worker){.job = job, .number = started};
    if (pthread_create(&workers[started].thread, NULL, work, &workers[started]) != 0)
      break;
  }
  hetab_status status = work_and_tell(ctx, job);
  for (int i = 1; i < started; i++)
    pthread_join(workers[i].thread, NULL);
  return status;
}

hetab_status hetab_each(hetab_context *ctx, size_t count, hetab_piece_fn piece, void *user) {
  return each(ctx, &(job){.count = count, .piece = piece, .user = user});
}

hetab_status hetab_each_within(hetab_context *ctx, size_t count, hetab_piece_fn piece, void *user) {
  return each(ctx, &(job){.count = count, .is_step = true, .piece = piece, .user = user});
}
