/* A dense table as a stream of slabs: a thread per device computes, the caller's thread samples
 * the error and hands each slab to the sink, so that writing overlaps computing. */
#include <hetab/tabulate.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/option_size.h"
#include "core/clock.h"
#include "engine/dense.h"
#include "engine/sample.h"

enum { MOST_SLOTS = 4, LITERAL_SLOTS = 2 };

/* One slab on its way: filled by a lane's thread, emptied by the caller's. */
typedef struct slot {
  enum { FREE, STARTED, READY } state;
  size_t task;
  hetab_output output;
  cl_event kernels[2];
  double *own; /* of the literal method */
} slot;

typedef struct job {
  hetab_context *ctx;
  const hetab_engine *engine;
  hetab_dense dense;
  size_t chunk_count, task_count; /* tasks: chunk of theta_i rows major, wavelength minor */
  pthread_mutex_t mutex;
  pthread_cond_t changed;
  size_t next_task;
  int atlas_ready;       /* the dense job is whole */
  atomic_int stop;       /* set by whoever ends the job early */
  hetab_context failure; /* message of the first thread that failed */
  hetab_status status;
  double kernel_seconds;
} job;

typedef struct worker {
  job *job;
  const hetab_lane *lane; /* NULL: the literal method */
  hetab_dense_lane dense_lane;
  hetab_context ctx; /* one thread, one context */
  slot slots[MOST_SLOTS];
  int slot_count;
  slot *started[MOST_SLOTS]; /* in this order */
  int started_count;
  double kernel_seconds;
  pthread_t thread;
} worker;

static hetab_slab slab_of(const job *job, size_t task) {
  const hetab_dense *d = &job->dense;
  size_t first = task / d->wavelength_count * d->rows_i;
  size_t left = d->count[HETAB_THETA_I] - first;
  return (hetab_slab){.wavelength = task % d->wavelength_count,
                      .theta_i_first = first,
                      .theta_i_count = left < d->rows_i ? left : d->rows_i};
}

static size_t slab_entries(const job *job, const hetab_slab *slab) {
  return slab->theta_i_count * job->dense.count[HETAB_THETA_R] * job->dense.count[HETAB_PHI];
}

static void fill_literal(const job *job, const hetab_slab *slab, double *values) {
  const hetab_dense *d = &job->dense;
  for (size_t i = 0; i < slab->theta_i_count; i++)
    for (size_t r = 0; r < d->count[HETAB_THETA_R]; r++)
      for (size_t p = 0; p < d->count[HETAB_PHI] && !job->stop; p++)
        *values++ = hetab_dense_literal(d, slab->wavelength, slab->theta_i_first + i, r, p);
}

static hetab_status begin_slab(worker *w, slot *s) {
  job *job = w->job;
  hetab_slab slab = slab_of(job, s->task);
  w->started[w->started_count++] = s;
  if (!w->lane) {
    double start = hetab_seconds();
    fill_literal(job, &slab, s->own);
    w->kernel_seconds += hetab_seconds() - start;
    return HETAB_OK;
  }
  hetab_output_return(&s->output);
  HETAB_TRY(hetab_dense_run(&w->ctx, job->engine, &job->dense, &w->dense_lane, slab.wavelength,
                            slab.theta_i_first, slab.theta_i_count, s->output.buffer, s->kernels));
  return hetab_output_fetch(&w->ctx, job->engine, slab_entries(job, &slab), &s->output);
}

/* The slab that was started first arrives. */
static hetab_status end_slab(worker *w, slot **out) {
  slot *s = *out = w->started[0];
  w->started_count--;
  memmove(w->started, w->started + 1, (size_t)w->started_count * sizeof *w->started);
  if (!w->lane)
    return HETAB_OK;
  HETAB_TRY(hetab_output_wait(&w->ctx, &s->output));
  for (int i = 0; i < 2; i++)
    w->kernel_seconds += hetab_lane_seconds(&s->kernels[i]);
  return HETAB_OK;
}

/* The next task into a free slot; NULL when there is none, or none is wanted any more. Waits for a
 * free slot only if the device has nothing to do meanwhile. */
static slot *take_task(worker *w) {
  job *job = w->job;
  slot *taken = NULL;
  pthread_mutex_lock(&job->mutex);
  while (!job->stop && job->next_task < job->task_count && !taken) {
    for (int i = 0; i < w->slot_count && !taken; i++)
      if (w->slots[i].state == FREE)
        taken = &w->slots[i];
    if (!taken && w->started_count)
      break;
    if (!taken)
      pthread_cond_wait(&job->changed, &job->mutex);
  }
  if (taken) {
    taken->state = STARTED;
    taken->task = job->next_task++;
  }
  pthread_mutex_unlock(&job->mutex);
  return taken;
}

static void hand_over(worker *w, slot *s) {
  pthread_mutex_lock(&w->job->mutex);
  s->state = READY;
  pthread_cond_broadcast(&w->job->changed);
  pthread_mutex_unlock(&w->job->mutex);
}

static void fail(worker *w, hetab_status status) {
  job *job = w->job;
  pthread_mutex_lock(&job->mutex);
  if (job->status == HETAB_OK) {
    job->status = status;
    job->failure = w->ctx;
  }
  job->stop = 1;
  pthread_cond_broadcast(&job->changed);
  pthread_mutex_unlock(&job->mutex);
}

/* The atlas is being made by the caller's thread; 0 if the job ends without it. */
static int wait_for_atlas(job *job) {
  pthread_mutex_lock(&job->mutex);
  while (!job->atlas_ready && !job->stop)
    pthread_cond_wait(&job->changed, &job->mutex);
  int ready = job->atlas_ready;
  pthread_mutex_unlock(&job->mutex);
  return ready;
}

/* The kernels are loaded, or compiled, while the caller's thread makes the atlas. */
static hetab_status prepare_lane(worker *w) {
  const hetab_engine *engine = w->job->engine;
  hetab_dense_kernel which =
      engine->method == HETAB_METHOD_ROWS ? HETAB_DENSE_ROWS : HETAB_DENSE_SERIES;
  HETAB_TRY(
      hetab_dense_lane_create(&w->ctx, engine, w->lane, &w->job->dense, which, &w->dense_lane));
  if (!wait_for_atlas(w->job))
    return HETAB_ERR_CANCELLED;
  return hetab_dense_lane_load(&w->ctx, engine, &w->job->dense, &w->dense_lane);
}

static hetab_status prepare(worker *w) {
  const hetab_dense *d = &w->job->dense;
  size_t entries = d->rows_i * d->count[HETAB_THETA_R] * d->count[HETAB_PHI];
  if (w->lane)
    HETAB_TRY(prepare_lane(w));
  for (; w->slot_count < (w->lane ? w->lane->shape->slabs : LITERAL_SLOTS); w->slot_count++) {
    slot *s = &w->slots[w->slot_count];
    if (w->lane)
      HETAB_TRY(hetab_output_create(&w->ctx, w->job->engine, w->lane, entries, &s->output));
    else if (!(s->own = hetab_alloc(&w->ctx, entries, sizeof *s->own)))
      return HETAB_ERR_MEMORY;
  }
  return HETAB_OK;
}

static void *work(void *argument) {
  worker *w = argument;
  hetab_status status = prepare(w);
  if (status != HETAB_OK)
    fail(w, status);
  while (status == HETAB_OK) {
    slot *s = take_task(w);
    if (!s && !w->started_count)
      break;
    if (s)
      status = begin_slab(w, s);
    else if ((status = end_slab(w, &s)) == HETAB_OK)
      hand_over(w, s);
    if (status != HETAB_OK)
      fail(w, status);
  }
  pthread_mutex_lock(&w->job->mutex);
  w->job->kernel_seconds += w->kernel_seconds;
  pthread_cond_broadcast(&w->job->changed);
  pthread_mutex_unlock(&w->job->mutex);
  return NULL;
}

static void release_worker(worker *w) {
  for (int i = 0; i < MOST_SLOTS; i++) {
    slot *s = &w->slots[i];
    hetab_output_free(&s->output);
    for (int k = 0; k < 2; k++)
      hetab_lane_seconds(&s->kernels[k]);
    free(s->own);
  }
  hetab_dense_lane_clear(&w->dense_lane);
}

static slot *find_ready(worker *workers, int count) {
  for (int w = 0; w < count; w++)
    for (int i = 0; i < MOST_SLOTS; i++)
      if (workers[w].slots[i].state == READY)
        return &workers[w].slots[i];
  return NULL;
}

/* A finished slab; NULL when a thread failed, or after a tenth of a second with neither, so that
 * the caller can look after progress and cancellation. */
static slot *wait_ready(job *job, worker *workers, int count) {
  struct timespec until;
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += 100000000;
  until.tv_sec += until.tv_nsec / 1000000000;
  until.tv_nsec %= 1000000000;
  pthread_mutex_lock(&job->mutex);
  slot *found = find_ready(workers, count);
  if (!found && !job->stop) {
    pthread_cond_timedwait(&job->changed, &job->mutex, &until);
    found = find_ready(workers, count);
  }
  pthread_mutex_unlock(&job->mutex);
  return found;
}

static hetab_status thread_failure(job *job) {
  pthread_mutex_lock(&job->mutex);
  hetab_status status = hetab_fail(job->ctx, job->status, "%s", job->failure.message);
  pthread_mutex_unlock(&job->mutex);
  return status;
}

static void set_free(job *job, slot *s) {
  pthread_mutex_lock(&job->mutex);
  s->state = FREE;
  pthread_cond_broadcast(&job->changed);
  pthread_mutex_unlock(&job->mutex);
}

/* Compare the sampled entries of one slab: positions count entries within [task][slab]. */
static void sample_slab(const job *job, const hetab_slab *slab, uint64_t first,
                        hetab_sample *sample) {
  const hetab_dense *d = &job->dense;
  uint64_t last = first + slab_entries(job, slab);
  for (size_t n = hetab_sample_from(sample, first); n < sample->count; n++) {
    uint64_t position = sample->positions[n];
    if (position >= last)
      break;
    size_t at = (size_t)(position - first), phi = d->count[HETAB_PHI];
    size_t r = at / phi % d->count[HETAB_THETA_R];
    size_t i = slab->theta_i_first + at / phi / d->count[HETAB_THETA_R];
    hetab_sample_add(sample, hetab_real_at(job->engine, slab->values, at),
                     hetab_dense_literal(d, slab->wavelength, i, r, at % phi));
  }
}

/* Flat position of a task's first entry: chunks before it hold all wavelengths. */
static uint64_t task_start(const job *job, const hetab_slab *slab) {
  const hetab_dense *d = &job->dense;
  uint64_t row = (uint64_t)d->count[HETAB_THETA_R] * d->count[HETAB_PHI];
  return row * (slab->theta_i_first * d->wavelength_count + slab->wavelength * slab->theta_i_count);
}

/* The caller's thread: every slab once, to the sample and to the sink. */
static hetab_status deliver(job *job, worker *workers, int count, hetab_sample *sample,
                            hetab_slab_fn sink, void *user, double total) {
  double done = 0.0;
  for (size_t delivered = 0; delivered < job->task_count;) {
    HETAB_TRY(hetab_progress(job->ctx, done, total));
    slot *s = wait_ready(job, workers, count);
    if (!s && job->stop)
      return thread_failure(job);
    if (!s)
      continue;
    hetab_slab slab = slab_of(job, s->task);
    slab.values = s->own ? s->own : s->output.values;
    sample_slab(job, &slab, task_start(job, &slab), sample);
    if (sink)
      HETAB_TRY(sink(job->ctx, user, &slab));
    done += (double)slab_entries(job, &slab);
    delivered++;
    set_free(job, s);
  }
  return hetab_progress(job->ctx, done, total);
}

static void stop_all(job *job, worker *workers, int started) {
  pthread_mutex_lock(&job->mutex);
  job->stop = 1;
  pthread_cond_broadcast(&job->changed);
  pthread_mutex_unlock(&job->mutex);
  for (int i = 0; i < started; i++) {
    pthread_join(workers[i].thread, NULL);
    release_worker(&workers[i]);
  }
}

static hetab_status make_atlas(job *job) {
  HETAB_TRY(hetab_dense_make_atlas(job->ctx, job->engine, &job->dense));
  pthread_mutex_lock(&job->mutex);
  job->atlas_ready = 1;
  pthread_cond_broadcast(&job->changed);
  pthread_mutex_unlock(&job->mutex);
  return HETAB_OK;
}

static hetab_status run(job *job, hetab_sample *sample, hetab_slab_fn sink, void *user,
                        double total) {
  int count = job->engine->lane_count ? job->engine->lane_count : 1, started = 0;
  hetab_status status = HETAB_OK;
  HETAB_FREED worker *workers = hetab_alloc(job->ctx, (size_t)count, sizeof *workers);
  HETAB_NEED(workers);
  for (; started < count && status == HETAB_OK; started++) {
    worker *w = &workers[started];
    w->job = job;
    w->lane = job->engine->lane_count ? &job->engine->lanes[started] : NULL;
    if (pthread_create(&w->thread, NULL, work, w) != 0) {
      status = hetab_fail(job->ctx, HETAB_ERR_MEMORY, "cannot start a thread");
      break;
    }
  }
  if (status == HETAB_OK)
    status = make_atlas(job);
  if (status == HETAB_OK)
    status = deliver(job, workers, count, sample, sink, user, total);
  stop_all(job, workers, started);
  return status;
}

hetab_status hetab_tabulate(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                            const hetab_grid *grid, const hetab_tabulate_options *options,
                            hetab_slab_fn sink, void *user, hetab_report *report) {
  HETAB_OPTIONS(ctx, hetab_tabulate_options, o, options);
  o.samples = o.samples == HETAB_NO_SAMPLES ? 0 : o.samples ? o.samples : 2000;
  double start = hetab_seconds();
  job job = {.ctx = ctx,
             .engine = engine,
             .mutex = PTHREAD_MUTEX_INITIALIZER,
             .changed = PTHREAD_COND_INITIALIZER};
  hetab_sample sample = {0};
  hetab_status status;
  HETAB_TRY(hetab_dense_create(ctx, engine, surface, grid, &job.dense));
  const hetab_dense *d = &job.dense;
  job.chunk_count = (d->count[HETAB_THETA_I] + d->rows_i - 1) / d->rows_i;
  job.task_count = job.chunk_count * d->wavelength_count;
  double total = (double)d->count[HETAB_THETA_I] * (double)d->count[HETAB_THETA_R] *
                 (double)d->count[HETAB_PHI] * (double)d->wavelength_count;
  HETAB_GOTO(hetab_sample_create(ctx, o.samples, (uint64_t)total, o.seed, &sample));
  HETAB_GOTO(run(&job, &sample, sink, user, total));
  if (report) {
    *report = hetab_report_of(engine, engine->device_text);
    report->entries = total;
    report->kernel_seconds = job.kernel_seconds;
    report->wall_seconds = hetab_seconds() - start;
    report->error = hetab_sample_finish(&sample);
  }
done:
  hetab_sample_clear(&sample);
  hetab_dense_clear(&job.dense);
  return status;
}
