#include "plan/probe.h"

#include <dirent.h>
#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <hetab/output_file.h>

#include "core/context.h"
#include "core/cpus.h"
#include "core/each.h"
#include "core/md5.h"
#include "plan/fixed_error.h"
#include "plan/plan_key.h"
#include "plan/scene.h"
#include "rgl/rgl_model.h"

/* A part is a file that is synced: of a large scene's surfaces at least 8, but not too few for all
 * cores. */
enum { PART = 8, FEW_CHUNKS = 64, MOST_CHUNKS = 1000 };

/* ---- one surface --------------------------------------------------------------------------- */

static double thread_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A table's bytes go with the wavelengths, and with the error that they leave to its shape to the
 * power of -3/2. The least of several that fall with the error falls with it, too. */
void hetab_choose_wavelengths(const hetab_plan_counts *counts, double table_error,
                              hetab_plan_item *item) {
  double least = HUGE_VAL;
  item->wavelengths = 3;
  item->wavelength_error = 0.0;
  for (size_t c = 0; c < counts->choices; c++) {
    double left = table_error - counts->error[c],
           bytes = (double)counts->count[c] * pow(left, -1.5);
    if (left <= 0.5 * table_error || !(bytes < least))
      continue;
    least = bytes;
    item->wavelengths = counts->count[c];
    item->wavelength_error = counts->error[c];
  }
}

static hetab_status forecast(hetab_context *ctx, const hetab_surface *surface,
                             const hetab_rgl_options *options, hetab_probe *out) {
  double start = thread_seconds();
  hetab_rgl_model *model;
  HETAB_TRY(hetab_rgl_model_create(ctx, surface, options, &model));
  out->fixed = thread_seconds() - start;
  const hetab_rgl_source *source = hetab_rgl_model_source(model);
  snprintf(out->description, sizeof out->description, "%s",
           source->description ? source->description : "");
  hetab_status status = hetab_rgl_forecast_make(ctx, source, &out->forecast);
  hetab_rgl_model_free(model);
  out->seconds = thread_seconds() - start - out->fixed;
  return status;
}

/* Spectra are tried at the wavelengths that they will have. */
static hetab_status probe_rgl(hetab_context *ctx, const hetab_scene *scene,
                              const hetab_surface *surface, hetab_plan_item *item,
                              hetab_probe *out) {
  const hetab_rgl_options options = {
      .bands = hetab_wanted_bands(scene),
      .specular_cone = item->delta == HETAB_DELTA_FOLDED ? scene->specular_cone : 0.0};
  hetab_surface *thinned;
  if (options.bands == HETAB_RGL_RGB)
    return forecast(ctx, surface, &options, out);
  HETAB_TRY(hetab_plan_count_errors(ctx, scene, surface, &out->counts));
  hetab_choose_wavelengths(&out->counts, scene->table_error, item);
  HETAB_TRY(hetab_plan_thinned(ctx, surface, item->wavelengths, &thinned));
  hetab_status status = forecast(ctx, thinned, &options, out);
  hetab_surface_free(thinned);
  return status;
}

static hetab_status probe_fixed(hetab_context *ctx, const hetab_scene *scene,
                                const hetab_surface *surface, const hetab_plan_item *item,
                                hetab_probe *out) {
  double start = thread_seconds();
  hetab_status status = hetab_fixed_error(ctx, scene, surface, item, 1, &out->error_l1);
  out->fixed = thread_seconds() - start;
  return status;
}

static hetab_status probe(hetab_context *ctx, const hetab_scene *scene, size_t i,
                          hetab_plan_item *item, hetab_probe *out) {
  const hetab_surface *surface = scene->surfaces[i];
  item->shares = i;
  HETAB_TRY(hetab_plan_terms(ctx, scene, surface, item));
  if (item->kind != HETAB_PLAN_TABLE)
    return HETAB_OK;
  item->spacing_deg = 1.0;
  return hetab_wants_rgl(scene) ? probe_rgl(ctx, scene, surface, item, out)
                                : probe_fixed(ctx, scene, surface, item, out);
}

/* ---- chunks -------------------------------------------------------------------------------- */

typedef struct job {
  const hetab_scene *scene;
  const char *folder;
  hetab_plan_item *items;
  hetab_probe *probes;
  char key[HETAB_KEY];
  size_t chunk, chunks, start; /* the first to do */
  hetab_context *contexts[HETAB_MOST_WORKERS];
  atomic_bool failed;
  hetab_status status; /* of the first that failed */
  char message[sizeof((hetab_context *)0)->message];
} job;

/* A chunk's items and probes as they lie in memory, then the sum of them with the scene's key:
 * of this version, on machines that lay them out alike; others do it anew. */
static size_t part_bytes(size_t count) {
  return count * (sizeof(hetab_plan_item) + sizeof(hetab_probe)) + HETAB_KEY;
}

static char *part_path(const job *j, size_t chunk) {
  char *path;
  return asprintf(&path, "%s/plan.parts/%.8s-%zu", j->folder, j->key, chunk) < 0 ? NULL : path;
}

static void seal(const job *j, unsigned char *bytes, size_t size, char digest[HETAB_KEY]) {
  memcpy(bytes + size - HETAB_KEY, j->key, HETAB_KEY);
  hetab_md5(bytes, size, digest);
}

static bool load_part(const job *j, size_t chunk, size_t first, size_t count) {
  size_t size = part_bytes(count), items = count * sizeof *j->items;
  char *path = part_path(j, chunk), digest[HETAB_KEY], found[HETAB_KEY];
  unsigned char *bytes = malloc(size + 1);
  FILE *file = path && bytes ? fopen(path, "rb") : NULL;
  bool good = file && fread(bytes, 1, size + 1, file) == size;
  if (good) {
    memcpy(found, bytes + size - HETAB_KEY, HETAB_KEY);
    seal(j, bytes, size, digest);
    good = memcmp(found, digest, HETAB_KEY) == 0;
  }
  if (good) {
    memcpy(j->items + first, bytes, items);
    memcpy(j->probes + first, bytes + items, count * sizeof *j->probes);
  }
  if (file)
    fclose(file);
  free(bytes);
  free(path);
  return good;
}

/* A part that cannot be written is no failure: it is only done again. */
static void save_part(hetab_context *ctx, const job *j, size_t chunk, size_t first, size_t count) {
  size_t size = part_bytes(count), items = count * sizeof *j->items;
  char *path = part_path(j, chunk), digest[HETAB_KEY];
  unsigned char *bytes = calloc(size, 1);
  if (path && bytes) {
    memcpy(bytes, j->items + first, items);
    memcpy(bytes + items, j->probes + first, count * sizeof *j->probes);
    seal(j, bytes, size, digest);
    memcpy(bytes + size - HETAB_KEY, digest, HETAB_KEY);
    (void)hetab_text_save(ctx, path, (char *)bytes, size, 1);
  }
  free(bytes);
  free(path);
}

static hetab_status do_chunk(hetab_context *ctx, const job *j, size_t chunk) {
  size_t first = chunk * j->chunk, left = j->scene->count - first;
  size_t count = left < j->chunk ? left : j->chunk;
  if (j->folder && load_part(j, chunk, first, count))
    return HETAB_OK;
  for (size_t i = first; i < first + count; i++) {
    hetab_status status = probe(ctx, j->scene, i, &j->items[i], &j->probes[i]);
    if (status != HETAB_OK) {
      char why[sizeof ctx->message];
      memcpy(why, ctx->message, sizeof why);
      return hetab_fail(ctx, status, "%s: %s", hetab_surface_name(j->scene->surfaces[i]), why);
    }
  }
  if (j->folder)
    save_part(ctx, j, chunk, first, count);
  return HETAB_OK;
}

/* Seconds are those of one core. */
static void work(void *user, size_t i, int worker) {
  job *j = user;
  hetab_context **ctx = &j->contexts[worker];
  if (atomic_load(&j->failed))
    return;
  int before = hetab_cpu_limit(1);
  hetab_status status = *ctx ? HETAB_OK : hetab_context_create(ctx);
  if (status == HETAB_OK)
    status = do_chunk(*ctx, j, (j->start + i) % j->chunks);
  hetab_cpu_limit(before);
  if (status == HETAB_OK || atomic_exchange(&j->failed, true))
    return;
  j->status = status;
  snprintf(j->message, sizeof j->message, "%s", *ctx ? (*ctx)->message : "out of memory");
}

hetab_status hetab_probe_all(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share, hetab_plan_item *items, hetab_probe *probes) {
  size_t few = scene->count / FEW_CHUNKS + 1, least = few < PART ? few : PART;
  job j = {.scene = scene,
           .folder = folder,
           .items = items,
           .probes = probes,
           .chunk = scene->count / MOST_CHUNKS};
  char *parts = NULL;
  HETAB_TRY(hetab_scene_key(ctx, scene, j.key));
  j.chunk = j.chunk > least ? j.chunk : least;
  j.chunks = (scene->count + j.chunk - 1) / j.chunk;
  j.start = (size_t)(share * (double)j.chunks);
  if (folder && asprintf(&parts, "%s/plan.parts", folder) >= 0)
    mkdir(parts, 0777);
  free(parts);
  hetab_status status = hetab_each(ctx, j.chunks, work, &j);
  for (int i = 0; i < HETAB_MOST_WORKERS; i++)
    hetab_context_free(j.contexts[i]);
  return j.status != HETAB_OK ? hetab_fail(ctx, j.status, "%s", j.message) : status;
}

void hetab_probe_forget(const char *folder) {
  char *parts;
  if (asprintf(&parts, "%s/plan.parts", folder) < 0)
    return;
  DIR *dir = opendir(parts);
  for (struct dirent *entry; dir && (entry = readdir(dir));)
    if (entry->d_name[0] != '.')
      unlinkat(dirfd(dir), entry->d_name, 0);
  if (dir)
    closedir(dir);
  rmdir(parts);
  free(parts);
}
