/* hetab batch: a scene's tables, by several processes, on several machines, as far as they are not
 * there.
 *
 * Why this holds for a thousand workers: they share a folder and nothing else; there is no lock and
 * no message. Each reads the scene; they plan it together, in chunks that whoever does one leaves
 * for the others (plan/probe.h), and the first plan that is written is everybody's. Each then looks
 * at the records of its own part, a read and a stat or two for each surface, and writes its own
 * files, whole, by rename. Parts are dealt by expected seconds, the largest first to whoever has
 * least, so that the tail is at most one table: 0.2 s for a .bsdf, 0.03 s to plan it. At its end
 * each looks for the first record that is missing, mostly one of the next; whoever finds all writes
 * the overview, which is one read of every record; two that finish together write the same. Ten
 * thousand surfaces by a thousand workers: 10 tables or 2 s each, and 10 surfaces or 0.3 s to plan.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "batch_workers.h"
#include "cli.h"
#include "core/clock.h"
#include "core/context.h"
#include "core/cpus.h"
#include "core/number.h"
#include "launcher.h"
#include "options.h"
#include "output.h"
#include "signals.h"

typedef struct batch_request {
  const char *scene, *folder, *shard;
  cli_list only;
  size_t jobs;
  int verify, dry_run, report, quiet, json;
  launcher_share share;
} batch_request;

/* ---- which surfaces ------------------------------------------------------------------------ */

static int is_wanted(const batch_request *r, const char *name) {
  for (size_t n = 0; n < r->only.count; n++)
    if (strcmp(r->only.items[n], name) == 0)
      return 1;
  return r->only.count == 0;
}

static int by_cost(const void *a, const void *b) {
  const batch_unit *u = a, *v = b;
  return u->seconds > v->seconds   ? -1
         : u->seconds < v->seconds ? 1
                                   : (u->first > v->first) - (u->first < v->first);
}

/* A unit for each table and for each surface without one, all in job->items. */
static void make_units(batch_job *job) {
  const hetab_plan *plan = job->plan;
  for (size_t i = 0; i < plan->count; i++) {
    if (plan->items[i].kind == HETAB_PLAN_SHARED)
      continue;
    batch_unit *unit = &job->units[job->unit_count++];
    *unit = (batch_unit){.first = job->item_count, .seconds = plan->items[i].seconds};
    job->items[job->item_count++] = i;
    for (size_t k = 0; k < plan->count && plan->items[i].kind == HETAB_PLAN_TABLE; k++)
      if (plan->items[k].kind == HETAB_PLAN_SHARED && plan->items[k].shares == i)
        job->items[job->item_count++] = k;
    unit->count = job->item_count - unit->first;
  }
  qsort(job->units, job->unit_count, sizeof *job->units, by_cost);
}

/* Keeps the units of this share, each going to the share that has least so far. */
static int deal(batch_job *job, const launcher_share *share) {
  HETAB_FREED double *loads = calloc(share->count, sizeof *loads);
  size_t kept = 0;
  if (!loads)
    return cli_fail("out of memory");
  for (size_t u = 0; u < job->unit_count; u++) {
    size_t least = 0;
    for (size_t s = 1; s < share->count; s++)
      least = loads[s] < loads[least] ? s : least;
    loads[least] += job->units[u].seconds + 1e-3;
    if (least + 1 == share->number)
      job->units[kept++] = job->units[u];
  }
  job->unit_count = kept;
  return -1;
}

/* Drops what is not wanted, and what is done; those that are done are marked. */
static void drop_done(batch_job *job, const batch_request *r) {
  size_t units = 0, items = 0, *left = job->items;
  HETAB_FREED size_t *all = malloc((job->item_count + 1) * sizeof *all);
  if (!all)
    return;
  memcpy(all, job->items, job->item_count * sizeof *all);
  for (size_t u = 0; u < job->unit_count; u++) {
    batch_unit unit = job->units[u];
    size_t first = items;
    for (size_t n = unit.first; n < unit.first + unit.count; n++) {
      batch_slot *slot = &job->slots[all[n]];
      if (!is_wanted(r, hetab_surface_name(hetab_scene_surface(job->scene, all[n]))))
        continue;
      if (hetab_batch_done(job->ctx, job->scene, job->plan, all[n], job->folder, job->verify,
                           &slot->result))
        slot->state = BATCH_KEPT;
      else
        left[items++] = all[n];
    }
    if (items > first)
      job->units[units++] = (batch_unit){first, items - first, unit.seconds};
  }
  job->unit_count = units;
  job->item_count = items;
}

static int check_only(const cli_command *self, const batch_request *r, const hetab_scene *scene) {
  for (size_t n = 0; n < r->only.count; n++) {
    size_t i = 0;
    while (i < hetab_scene_surface_count(scene) &&
           strcmp(hetab_surface_name(hetab_scene_surface(scene, i)), r->only.items[n]) != 0)
      i++;
    if (i == hetab_scene_surface_count(scene))
      return cli_usage(self, "--only %s: the scene has no such surface", r->only.items[n]);
  }
  return -1;
}

/* ---- what it says -------------------------------------------------------------------------- */

typedef struct batch_sums {
  size_t made, kept, failed;
  double bytes, table_bytes, seconds, worst, expected_seconds, expected_bytes;
  size_t misfits; /* tables whose error is above what was asked for */
} batch_sums;

static batch_sums sum_up(const batch_job *job) {
  batch_sums s = {0};
  for (size_t i = 0; i < job->plan->count; i++) {
    const batch_slot *slot = &job->slots[i];
    int state = slot->state;
    s.kept += state == BATCH_KEPT;
    s.failed += state == BATCH_FAILED;
    if (state == BATCH_MADE) {
      s.made++;
      s.seconds += slot->result.seconds;
      s.expected_seconds += job->plan->items[i].seconds;
    }
    if (state == BATCH_MADE || state == BATCH_KEPT) {
      s.bytes += slot->result.bytes;
      s.table_bytes += slot->result.table_bytes;
      s.expected_bytes += (double)job->plan->items[i].bytes;
      s.misfits += !slot->result.fits;
      s.worst = slot->result.error_l1 > s.worst ? slot->result.error_l1 : s.worst;
    }
  }
  return s;
}

static void print_sums(const batch_job *job, const batch_sums *s, double seconds, int json) {
  if (json) {
    cli_json_print(json_pack("{sI sI sI sf sf sf sf sf sf sf sI}", "made", (json_int_t)s->made,
                             "kept", (json_int_t)s->kept, "failed", (json_int_t)s->failed,
                             "seconds", seconds, "bytes", s->bytes, "table_bytes", s->table_bytes,
                             "planned_bytes", s->expected_bytes, "core_seconds", s->seconds,
                             "planned_core_seconds", s->expected_seconds, "error_l1", s->worst,
                             "misfits", (json_int_t)s->misfits));
    return;
  }
  printf(
      "%zu made, %zu were there, %zu failed; tables of %.2f MB (%.2f expected), %.2f with what is "
      "beside them; %.1f s of work (%.1f expected) in %.1f s\n",
      s->made, s->kept, s->failed, 1e-6 * s->table_bytes, 1e-6 * s->expected_bytes, 1e-6 * s->bytes,
      s->seconds, s->expected_seconds, seconds);
  if (s->worst > 0.0)
    printf("largest relative L1 error %s %% (%s %% asked for",
           hetab_two_digits(100.0 * s->worst).text,
           hetab_two_digits(100.0 * job->plan->asked_error).text);
  if (s->worst > 0.0 && job->plan->table_error > job->plan->asked_error)
    printf("; the budget leaves %s %%", hetab_two_digits(100.0 * job->plan->table_error).text);
  if (s->worst > 0.0)
    puts(")");
  if (s->misfits)
    printf("%zu tables do not keep that error: see %s/index.html\n", s->misfits, job->folder);
}

/* ---- the command --------------------------------------------------------------------------- */

static int all_done(const batch_job *job) {
  for (size_t i = 0; i < job->plan->count; i++)
    if (job->slots[i].state != BATCH_MADE && job->slots[i].state != BATCH_KEPT &&
        !hetab_batch_done(job->ctx, job->scene, job->plan, i, job->folder, 0, NULL))
      return 0;
  return 1;
}

static int has_overview(const batch_job *job) {
  HETAB_FREED char *path = NULL;
  struct stat about;
  return asprintf(&path, "%s/index.html", job->folder) >= 0 && stat(path, &about) == 0;
}

/* The overview is for whoever finishes last. */
static int finish(const batch_job *job, const batch_request *r, const batch_sums *sums) {
  if (!r->report && ((!sums->made && has_overview(job)) || !all_done(job)))
    return -1;
  return hetab_batch_finish(job->ctx, job->scene, job->plan, job->folder) == HETAB_OK
             ? -1
             : cli_fail_context(job->ctx);
}

static int run_batch(batch_job *job, const batch_request *r) {
  double start = hetab_seconds();
  make_units(job);
  int status = deal(job, &r->share);
  if (status >= 0)
    return status;
  drop_done(job, r);
  if (r->dry_run) {
    for (size_t n = 0; n < job->item_count; n++)
      puts(hetab_surface_name(hetab_scene_surface(job->scene, job->items[n])));
    return CLI_OK;
  }
  if (r->share.source[0] && !r->quiet)
    fprintf(stderr, "part %zu of %zu, from %s\n", r->share.number, r->share.count, r->share.source);
  if (!r->report)
    status = batch_run(job);
  batch_sums sums = sum_up(job);
  if (status < 0 && cli_signal())
    return cli_fail("stopped; what is done stays, and the same command goes on");
  if (status < 0)
    status = finish(job, r, &sums);
  if (status < 0 && (!r->quiet || r->json))
    print_sums(job, &sums, hetab_seconds() - start, r->json);
  return status >= 0 ? status : sums.failed ? CLI_FAILURE : CLI_OK;
}

/* The slots are shared by all processes; behind them is the number of the next unit. */
static int with_memory(batch_job *job, const batch_request *r) {
  size_t count = job->plan->count, size = count * sizeof *job->slots + sizeof(atomic_size_t);
  void *shared = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED)
    return cli_fail("out of memory");
  job->slots = shared;
  job->items = calloc(count + 1, sizeof *job->items);
  job->units = calloc(count + 1, sizeof *job->units);
  int status = job->items && job->units ? run_batch(job, r) : cli_fail("out of memory");
  free(job->items);
  free(job->units);
  munmap(shared, size);
  return status;
}

static int make_folder(const char *path) {
  struct stat about;
  if (mkdir(path, 0777) == 0)
    return -1;
  int why = errno;
  if (stat(path, &about) == 0 && S_ISDIR(about.st_mode))
    return -1;
  errno = why;
  return cli_fail("cannot make the folder %s: %m: give another -o", path);
}

static int run_job(const cli_command *self, const batch_request *r) {
  HETAB_ENDS(hetab_scene_end) hetab_scene *scene = NULL;
  HETAB_ENDS(hetab_plan_end) hetab_plan *plan = NULL;
  hetab_context *ctx; /* tables appear one by one, not together at the end */
  if (hetab_context_create(&ctx) != HETAB_OK)
    return cli_fail("out of memory");
  int status = hetab_scene_load(ctx, r->scene, &scene) == HETAB_OK ? check_only(self, r, scene)
                                                                   : cli_fail_context(ctx);
  const char *folder = r->folder || !scene ? r->folder : hetab_scene_output(scene);
  if (status < 0 && !folder)
    status = cli_usage(self, "no folder given: use -o DIR, or the scene's key output");
  double share_start = (double)(r->share.number - 1) / (double)r->share.count;
  if (status < 0)
    status = make_folder(folder);
  if (status < 0 && hetab_plan_open(ctx, scene, folder, share_start, &plan) != HETAB_OK)
    status = cli_fail_context(ctx);
  if (status < 0) {
    batch_job job = {.ctx = ctx,
                     .scene = scene,
                     .plan = plan,
                     .folder = folder,
                     .jobs = r->jobs              ? (int)r->jobs
                             : r->share.source[0] ? 1
                                                  : hetab_cpu_count(),
                     .verify = r->verify,
                     .quiet = r->quiet};
    status = with_memory(&job, r);
  }
  hetab_context_free(ctx);
  return status;
}

static int parse(const cli_command *self, int argc, char **argv, batch_request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "output", 'o', "DIR", "the folder of the tables, made if it is not there",
       &r->folder, 0, 0},
      {CLI_COUNT, "jobs", 'j', "N", "processes (the usable processors; 1 under a launcher)",
       &r->jobs, 1, 256},
      {CLI_TEXT, "shard", 0, "I/N", "do part I of N, from 1 on (what the launcher says, or all)",
       &r->shard, 0, 0},
      {CLI_LIST, "only", 0, "NAME", "only this surface; may be given several times", &r->only, 0,
       0},
      {CLI_FLAG, "verify", 0, NULL, "read the checksums of the files that are there", &r->verify, 0,
       0},
      {CLI_FLAG, "dry-run", 'n', NULL, "list what would be made", &r->dry_run, 0, 0},
      {CLI_FLAG, "report", 0, NULL, "make nothing but the overview, of what is there", &r->report,
       0, 0},
      CLI_QUIET(&r->quiet),
      {CLI_FLAG, "json", 0, NULL, "print the summary as JSON, as described above", &r->json, 0, 0},
      {0}};
  CLI_TRY(cli_parse_operand(self, options, argc, argv, "SCENE", &r->scene));
  if (r->shard && !launcher_parse(r->shard, &r->share))
    return cli_usage(self, "--shard '%s': give I/N, I from 1 to N", r->shard);
  if (!r->shard)
    return launcher_find(&r->share);
  snprintf(r->share.source, sizeof r->share.source, "--shard");
  return -1;
}

static int run(const cli_command *self, int argc, char **argv) {
  batch_request request = {0};
  int status = parse(self, argc, argv, &request);
  if (status < 0)
    status = run_job(self, &request);
  free(request.only.items);
  return status;
}

const cli_command cli_batch = {
    .name = "batch",
    .arguments = "SCENE.yml -o DIR",
    .summary = "make the tables that a scene needs, on all cores, as far as they are not there",
    .description =
        "Plans SCENE (see 'hetab plan') and makes each table that it needs in DIR: whole or "
        "absent, "
        "beside it NAME.json, its record, with parameters, checksums, and the errors measured. "
        "What "
        "is there and has not changed is not made again, so that the same command goes on after "
        "whatever ended it. A surface that fails is reported, and the rest goes on; exit status 1 "
        "tells. At the end: manifest.json, index.html with pictures and errors, and the renderer's "
        "scene.xml or scene.pbrt.\n\n"
        "On many machines with one folder: 'srun hetab batch ...', 'mpirun hetab batch ...', "
        "sbatch "
        "--array, or 'parallel hetab batch ... --shard {}/8 ::: 1 2 3 4 5 6 7 8'. Parts are dealt "
        "by "
        "expected seconds; who finishes last writes the overview.\n\n"
        "--json prints an object with made, kept, failed, seconds, bytes, table_bytes, "
        "planned_bytes, "
        "core_seconds, planned_core_seconds, error_l1 (the largest) and misfits, tables whose "
        "error "
        "is above what was asked for.",
    .run = run,
};
