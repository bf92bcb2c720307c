#include "batch_workers.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"
#include "core/context.h"
#include "core/cpus.h"
#include "core/number.h"
#include "core/printable.h"
#include "progress.h"
#include "signals.h"

enum { MOST_WORKERS = 256 };

/* ---- a worker ------------------------------------------------------------------------------ */

static int on_progress(void *user, double done, double total) {
  (void)user;
  return cli_signal();
}

/* With a cold cache of kernels, many at once, one in a hundred fails to compile: once more. */
static hetab_status make(batch_job *job, hetab_engine **engine, size_t i, batch_slot *slot) {
  hetab_status status = HETAB_ERR_DEVICE;
  for (int tries = 0; tries < 2 && status == HETAB_ERR_DEVICE; tries++) {
    status =
        hetab_batch_make(job->ctx, engine, job->scene, job->plan, i, job->folder, &slot->result);
    if (status == HETAB_ERR_DEVICE) {
      hetab_engine_free(*engine);
      *engine = NULL;
    }
  }
  return status;
}

static void do_surface(batch_job *job, hetab_engine **engine, size_t i) {
  batch_slot *slot = &job->slots[i];
  slot->worker = getpid();
  atomic_store(&slot->state, BATCH_RUNNING);
  /* Someone else may be at the same folder. */
  if (hetab_batch_done(job->ctx, job->scene, job->plan, i, job->folder, job->verify,
                       &slot->result)) {
    atomic_store(&slot->state, BATCH_KEPT);
    return;
  }
  hetab_status status = make(job, engine, i, slot);
  if (status != HETAB_OK)
    snprintf(slot->message, sizeof slot->message, "%s", hetab_error_message(job->ctx));
  atomic_store(&slot->state, status == HETAB_OK ? BATCH_MADE : BATCH_FAILED);
}

static void work(batch_job *job, atomic_size_t *next) {
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  size_t u;
  prctl(PR_SET_PDEATHSIG, SIGKILL); /* not without the parent */
  setenv("POCL_MAX_PTHREAD_COUNT", "1", 0);
  hetab_cpu_limit(1);
  hetab_set_progress(job->ctx, on_progress, NULL);
  while (!cli_signal() && (u = atomic_fetch_add(next, 1)) < job->unit_count)
    for (size_t n = 0; n < job->units[u].count && !cli_signal(); n++)
      do_surface(job, &engine, job->items[job->units[u].first + n]);
}

/* ---- the parent ---------------------------------------------------------------------------- */

typedef struct crew {
  batch_job *job;
  atomic_size_t *next;
  pid_t pids[MOST_WORKERS];
  int count;
} crew;

/* 0 if there is no process to be had. */
static int start_worker(crew *c) {
  fflush(NULL);
  pid_t pid = fork();
  if (pid == 0) {
    work(c->job, c->next);
    _exit(0);
  }
  if (pid > 0)
    c->pids[c->count++] = pid;
  return pid > 0;
}

/* What the process was at is lost; the rest of its unit is for the next run. */
static void note_death(const crew *c, pid_t pid, int how) {
  for (size_t n = 0; n < c->job->item_count; n++) {
    batch_slot *slot = &c->job->slots[c->job->items[n]];
    if (atomic_load(&slot->state) != BATCH_RUNNING || slot->worker != pid)
      continue;
    snprintf(slot->message, sizeof slot->message, "the process that made it %s %d",
             WIFSIGNALED(how) ? "was killed by signal" : "ended with status",
             WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how));
    atomic_store(&slot->state, BATCH_FAILED);
  }
}

static void reap(crew *c) {
  for (int i = 0; i < c->count;) {
    int how;
    pid_t pid = waitpid(c->pids[i], &how, WNOHANG);
    if (pid == 0 || (pid < 0 && errno == EINTR)) {
      i++;
      continue;
    }
    c->pids[i] = c->pids[--c->count];
    if (pid > 0 && (!WIFEXITED(how) || WEXITSTATUS(how) != 0)) {
      note_death(c, pid, how);
      if (!cli_signal() && atomic_load(c->next) < c->job->unit_count)
        start_worker(c);
    }
  }
}

/* Each number beside what was expected of it. */
static void log_result(const char *name, const hetab_plan_item *item, const batch_slot *slot) {
  const hetab_batch_result *r = &slot->result;
  fprintf(stderr, "%s: %s", name, atomic_load(&slot->state) == BATCH_MADE ? "made" : "was there");
  if (item->kind == HETAB_PLAN_SHARED && !(r->table_bytes > 0.0))
    fprintf(stderr, ", with another's table, error %s %%",
            hetab_two_digits(100.0 * r->error_l1).text);
  if (r->table_bytes > 0.0)
    fprintf(stderr, ", %.3f MB (%.3f expected), error %s %% (%s), %.2f s (%.2f)",
            1e-6 * r->table_bytes, 1e-6 * (double)item->bytes,
            hetab_two_digits(100.0 * r->error_l1).text,
            hetab_two_digits(100.0 * item->error_l1).text, r->seconds, item->seconds);
  fputs(r->fits ? "\n" : ", NOT what was asked for\n", stderr);
}

static void log_surface(const batch_job *job, size_t i) {
  const batch_slot *slot = &job->slots[i];
  char name[256];
  snprintf(name, sizeof name, "%s", hetab_surface_name(hetab_scene_surface(job->scene, i)));
  hetab_make_printable(&(hetab_printable){0}, name, strlen(name), "");
  if (atomic_load(&slot->state) == BATCH_FAILED)
    fprintf(stderr, "hetab: %s: %s\n", name, slot->message);
  else if (!job->quiet && !cli_progress_visible())
    log_result(name, &job->plan->items[i], slot);
}

/* Logs what is new; how many surfaces are done. */
static size_t look(const batch_job *job, unsigned char *logged) {
  size_t done = 0;
  for (size_t n = 0; n < job->item_count; n++) {
    size_t i = job->items[n];
    if (atomic_load(&job->slots[i].state) < BATCH_MADE)
      continue;
    done++;
    if (!logged[n])
      log_surface(job, i);
    logged[n] = 1;
  }
  return done;
}

static void watch(crew *c, unsigned char *logged) {
  const struct timespec pause = {.tv_nsec = 20000000};
  cli_progress_count("batch", "surfaces", c->job->quiet);
  while (c->count) {
    nanosleep(&pause, NULL);
    reap(c);
    hetab_progress(c->job->ctx, (double)look(c->job, logged), (double)c->job->item_count);
    for (int i = 0; cli_signal() && i < c->count; i++)
      kill(c->pids[i], SIGTERM);
  }
  look(c->job, logged);
  cli_progress_end();
}

int batch_run(batch_job *job) {
  crew c = {.job = job, .next = (atomic_size_t *)(job->slots + job->plan->count)};
  HETAB_FREED unsigned char *logged = calloc(job->item_count + 1, 1);
  if (!logged)
    return cli_fail("out of memory");
  int count = job->jobs < MOST_WORKERS ? job->jobs : MOST_WORKERS;
  while (c.count < count && (size_t)c.count < job->unit_count && start_worker(&c))
    ;
  int status = c.count || !job->unit_count ? -1 : cli_fail("cannot start a process: %m");
  watch(&c, logged);
  return status;
}
