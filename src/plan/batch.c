#include <hetab/batch.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <hetab/output_file.h>
#include <hetab/tabulate_to.h>

#include "core/context.h"
#include "plan/plan_key.h"
#include "plan/record.h"
#include "plan/scene.h"
#include "plan/thumbnail.h"
#include "rgl/rgl_model.h"

/* One surface of the batch. */
typedef struct job {
  hetab_context *ctx;
  const hetab_scene *scene;
  const hetab_plan *plan;
  size_t i;
  const char *folder, *name, *ending;
  hetab_batch_result *result;
  json_t *files; /* of the record */
  char *thumbnail;
} job;

/* Of this process: what a plan's seconds of one core mean, whatever else the machine does. */
static double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool is_rgl(const job *j) {
  return j->scene->consumer <= HETAB_PBRT;
}

static hetab_rgl_bands rgl_bands(const job *j) {
  return j->scene->consumer == HETAB_MITSUBA_SPECTRAL ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB;
}

/* ---- tables -------------------------------------------------------------------------------- */

static hetab_status add_file(job *j, const char *ending) {
  json_t *file = hetab_record_file(j->ctx, j->folder, j->name, ending);
  if (!file)
    return hetab_fail(j->ctx, HETAB_ERR_IO, "cannot read '%s/%s%s', which was just written",
                      j->folder, j->name, ending);
  j->result->bytes += (double)json_integer_value(json_object_get(file, "bytes"));
  json_array_append_new(j->files, file);
  return HETAB_OK;
}

static hetab_status open_engine(job *j, hetab_engine **engine) {
  return is_rgl(j) || *engine ? HETAB_OK : hetab_engine_create(j->ctx, NULL, engine);
}

static void take_errors(job *j, const hetab_rgl_report *r) {
  j->result->error_l1 = r->error_l1;
  j->result->bias = r->bias;
  j->result->fits =
      r->error_l1 <= j->plan->table_error && fabs(r->bias) <= j->plan->table_error / 3.0;
}

static hetab_status write_table(job *j, hetab_engine **engine) {
  const hetab_plan_item *item = &j->plan->items[j->i];
  /* A budget is kept whatever the error: the plan's shape is the table's. */
  bool bound = j->plan->table_error > j->plan->asked_error;
  const hetab_rgl_options rgl = {.bands = rgl_bands(j),
                                 .table_error = bound ? 1.0 : j->plan->table_error,
                                 .theta_i_count = item->theta_i_count,
                                 .resolution = item->resolution};
  const hetab_tabulate_to_options options = {.rgl = &rgl, .overwrite = 1};
  hetab_output_report report;
  char *path = hetab_batch_path(j->ctx, j->folder, j->name, j->ending);
  hetab_status status = path ? open_engine(j, engine) : HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = hetab_tabulate_to(j->ctx, *engine, j->scene->surfaces[j->i],
                               (const char *const *)&path, 1, &options, &report);
  free(path);
  HETAB_TRY(status);
  if (is_rgl(j))
    take_errors(j, &report.rgl);
  HETAB_TRY(add_file(j, j->ending));
  return is_rgl(j) || j->scene->consumer == HETAB_CONSUMER_MERL ? add_file(j, ".specular.csv")
                                                                : HETAB_OK;
}

static hetab_status load_rgl(job *j, size_t of, hetab_rgl **rgl) {
  char *path =
      hetab_batch_path(j->ctx, j->folder, hetab_surface_name(j->scene->surfaces[of]), j->ending);
  hetab_status status = path ? hetab_rgl_load(j->ctx, path, rgl) : HETAB_ERR_MEMORY;
  free(path);
  return status;
}

static hetab_status draw(job *j, size_t of) {
  hetab_rgl *rgl;
  HETAB_TRY(load_rgl(j, of, &rgl));
  j->thumbnail = hetab_thumbnail(j->ctx, rgl);
  hetab_rgl_free(rgl);
  return j->thumbnail ? HETAB_OK : HETAB_ERR_MEMORY;
}

/* What another surface's table is for this one. */
static hetab_status measure_shared(job *j) {
  hetab_rgl_report report = {0};
  hetab_rgl *rgl = NULL;
  hetab_rgl_model *model = NULL;
  const hetab_rgl_options options = {.bands = rgl_bands(j)};
  hetab_status status = load_rgl(j, j->plan->items[j->i].shares, &rgl);
  if (status == HETAB_OK)
    status = hetab_rgl_model_create(j->ctx, j->scene->surfaces[j->i], &options, &model);
  if (status == HETAB_OK)
    status = hetab_rgl_measure(j->ctx, hetab_rgl_model_source(model), rgl, &report);
  take_errors(j, &report);
  hetab_rgl_model_free(model);
  hetab_rgl_free(rgl);
  return status;
}

/* ---- records ------------------------------------------------------------------------------- */

static json_t *planned(const hetab_plan_item *item) {
  return json_pack("{sI sf sf sf}", "bytes", (json_int_t)item->bytes, "seconds", item->seconds,
                   "error_l1", item->error_l1, "energy_left_out", item->energy_left_out);
}

static json_t *record(const job *j, const char *key) {
  static const char *const kinds[] = {"table", "shared", "mirror", "plain"};
  const hetab_plan_item *item = &j->plan->items[j->i];
  const hetab_surface *s = j->scene->surfaces[j->i];
  size_t of = json_array_size(j->files) ? j->i : item->shares;
  char *yaml = NULL;
  if (hetab_surface_yaml(j->ctx, s, &yaml) != HETAB_OK)
    return NULL;
  json_t *json = json_pack(
      "{ss ss ss ss ss ss sO sf sf sf sf sb so ss ss*}", "surface", j->name, "what",
      kinds[item->kind], "table_of", hetab_surface_name(j->scene->surfaces[of]), "consumer",
      hetab_consumer_name(j->scene->consumer), "key", key, "version", hetab_version(), "files",
      j->files, "bytes", j->result->bytes, "seconds", j->result->seconds, "error_l1",
      j->result->error_l1, "bias", j->result->bias, "fits", j->result->fits, "planned",
      planned(item), "yaml", yaml, "thumbnail", j->thumbnail);
  free(yaml);
  return json;
}

static hetab_status make(job *j, hetab_engine **engine) {
  const hetab_plan_item *item = &j->plan->items[j->i];
  bool shared = item->kind == HETAB_PLAN_SHARED;
  double start = cpu_seconds();
  char key[HETAB_KEY];
  HETAB_TRY(hetab_item_key(j->ctx, j->scene, j->plan, j->i, key));
  j->result->fits = 1;
  if (shared && is_rgl(j))
    HETAB_TRY(measure_shared(j));
  if (item->kind == HETAB_PLAN_TABLE || !j->result->fits) {
    shared = false;
    HETAB_TRY(write_table(j, engine));
  }
  if (is_rgl(j) && (item->kind == HETAB_PLAN_TABLE || item->kind == HETAB_PLAN_SHARED))
    HETAB_TRY(draw(j, shared ? item->shares : j->i));
  j->result->seconds = cpu_seconds() - start;
  return hetab_record_save(j->ctx, j->scene, j->i, j->folder, record(j, key));
}

hetab_status hetab_batch_make(hetab_context *ctx, hetab_engine **engine, const hetab_scene *scene,
                              const hetab_plan *plan, size_t i, const char *folder,
                              hetab_batch_result *result) {
  job j = {.ctx = ctx,
           .scene = scene,
           .plan = plan,
           .i = i,
           .folder = folder,
           .name = hetab_surface_name(scene->surfaces[i]),
           .ending = hetab_batch_ending(scene->consumer),
           .result = result,
           .files = json_array()};
  *result = (hetab_batch_result){0};
  hetab_status status = j.files ? make(&j, engine) : HETAB_ERR_MEMORY;
  json_decref(j.files);
  free(j.thumbnail);
  return status;
}
