#include <hetab/batch.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <hetab/tabulate_to.h>

#include "core/angle.h"
#include "core/context.h"
#include "model/colour.h"
#include "plan/fixed_error.h"
#include "plan/plan_key.h"
#include "plan/record.h"
#include "plan/scene.h"
#include "plan/terms.h"
#include "plan/thumbnail.h"
#include "rgl/rgl_model.h"
#include "table/specular.h"

/* What the sums of the audit may be off by. */
static const double ENERGY_ERROR = 0.005;

/* A table that is within the bias asked for, at every incidence, reflects what the model does: more
 * than falls on it is the model's own. */
static const char *verdict(const hetab_batch_result *r) {
  return !r->fits ? "fail" : r->energy > 1.0 + ENERGY_ERROR ? "model" : "pass";
}

/* One surface of the batch. */
typedef struct job {
  hetab_context *ctx;
  const hetab_scene *scene;
  const hetab_plan *plan;
  size_t i;
  hetab_rgl_forecast forecast;
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

/* ---- tables -------------------------------------------------------------------------------- */

static hetab_status add_file(job *j, const char *ending) {
  json_t *file = hetab_record_file(j->ctx, j->folder, j->name, ending);
  if (!file)
    return hetab_fail(j->ctx, HETAB_ERR_IO, "cannot read '%s/%s%s', which was just written",
                      j->folder, j->name, ending);
  double bytes = (double)json_integer_value(json_object_get(file, "bytes"));
  j->result->table_bytes = j->result->bytes > 0.0 ? j->result->table_bytes : bytes;
  j->result->bytes += bytes;
  json_array_append_new(j->files, file);
  return HETAB_OK;
}

static hetab_status open_engine(job *j, hetab_engine **engine) {
  return hetab_wants_rgl(j->scene) || *engine ? HETAB_OK
                                              : hetab_engine_create(j->ctx, NULL, engine);
}

/* The wavelengths that the table has not are an error, too. */
static void take_errors(job *j, const hetab_rgl_report *r, const hetab_plan_item *table) {
  double asked = j->plan->table_error;
  j->result->error_l1 = r->error_l1 + table->wavelength_error;
  j->result->bias = r->bias;
  j->result->fits = j->result->error_l1 <= asked && fabs(r->bias) <= asked / 3.0;
}

/* A budget is kept whatever the error: shapes and sharing are the plan's. */
static bool is_bound(const job *j) {
  return j->plan->table_error > j->plan->asked_error;
}

/* The surface as the table has it, and what is asked of the table. */
static hetab_status prepare_rgl(job *j, const hetab_plan_item *table, hetab_surface **thinned,
                                hetab_rgl_options *options) {
  const hetab_surface *surface = j->scene->surfaces[j->i];
  bool spectral = hetab_wanted_bands(j->scene) == HETAB_RGL_SPECTRAL;
  j->forecast = j->plan->forecasts[table - j->plan->items];
  j->forecast.shape.theta_i = table->theta_i_count;
  j->forecast.shape.resolution = table->resolution;
  *options = (hetab_rgl_options){
      .bands = hetab_wanted_bands(j->scene),
      .table_error = is_bound(j) ? 1.0 : j->plan->table_error - table->wavelength_error,
      .specular_cone = table->delta == HETAB_DELTA_FOLDED ? j->scene->specular_cone : 0.0,
      .forecast = table->resolution && j->forecast.shape.ndf ? &j->forecast : NULL};
  return hetab_plan_thinned(
      j->ctx, surface, spectral ? table->wavelengths : hetab_surface_band_count(surface), thinned);
}

static hetab_status make_grid(job *j, hetab_grid **grid) {
  char axis[64];
  double spacing = j->plan->items[j->i].spacing_deg;
  HETAB_TRY(hetab_grid_create(j->ctx, grid));
  for (hetab_axis a = HETAB_THETA_I; a <= HETAB_THETA_R; a++) {
    double most = a == HETAB_THETA_I ? j->scene->max_theta_i : j->scene->max_theta_r;
    snprintf(axis, sizeof axis, "0:%.10g:%zu", hetab_degrees(most),
             hetab_scene_thetas(most, spacing));
    HETAB_TRY(hetab_grid_set_axis(j->ctx, *grid, a, axis));
  }
  snprintf(axis, sizeof axis, "0:180:%zu", hetab_scene_phis(spacing));
  return hetab_grid_set_axis(j->ctx, *grid, HETAB_PHI, axis);
}

static hetab_status write_file(job *j, hetab_engine *engine, const char *path,
                               hetab_output_report *report) {
  const hetab_plan_item *item = &j->plan->items[j->i];
  bool folded = item->delta == HETAB_DELTA_FOLDED;
  hetab_rgl_options rgl;
  const hetab_merl_options merl = {.specular_cone = folded ? j->scene->specular_cone : 0.0};
  hetab_surface *surface = NULL;
  hetab_grid *grid = NULL;
  hetab_status status = prepare_rgl(j, item, &surface, &rgl);
  if (status == HETAB_OK)
    status = make_grid(j, &grid);
  hetab_exr_options exr = {.element = hetab_wanted_element(j->plan->table_error)};
  const hetab_tabulate_to_options options = {
      .rgl = &rgl, .merl = &merl, .grid = grid, .exr = &exr, .overwrite = 1};
  if (status == HETAB_OK)
    status = hetab_tabulate_to(j->ctx, engine, surface, &path, 1, &options, report);
  if (status == HETAB_OK && report->saturated) { /* a lobe above 65504 / sr */
    exr.element = HETAB_EXR_FLOAT;
    status = hetab_tabulate_to(j->ctx, engine, surface, &path, 1, &options, report);
  }
  hetab_grid_free(grid);
  hetab_surface_free(surface);
  return status;
}

/* The file's numbers are the model's, far within the error of reading between them. */
static hetab_status measure_fixed(job *j, const hetab_plan_item *item) {
  HETAB_TRY(
      hetab_fixed_error(j->ctx, j->scene, j->scene->surfaces[j->i], item, 2, &j->result->error_l1));
  j->result->fits = j->result->error_l1 <= j->plan->table_error;
  return HETAB_OK;
}

static hetab_status write_table(job *j, hetab_engine **engine) {
  const hetab_plan_item *item = &j->plan->items[j->i];
  hetab_output_report report;
  char *path = hetab_batch_path(j->ctx, j->folder, j->name, j->ending);
  hetab_status status = path ? open_engine(j, engine) : HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = write_file(j, *engine, path, &report);
  free(path);
  HETAB_TRY(status);
  if (hetab_wants_rgl(j->scene))
    take_errors(j, &report.rgl, item);
  else
    HETAB_TRY(measure_fixed(j, item));
  HETAB_TRY(add_file(j, j->ending));
  bool beside = hetab_wants_rgl(j->scene) || j->scene->consumer == HETAB_CONSUMER_MERL;
  return beside && item->delta != HETAB_DELTA_FOLDED ? add_file(j, ".specular.csv") : HETAB_OK;
}

static hetab_status load_rgl(job *j, size_t of, hetab_rgl **rgl) {
  char *path =
      hetab_batch_path(j->ctx, j->folder, hetab_surface_name(j->scene->surfaces[of]), j->ending);
  hetab_status status = path ? hetab_rgl_load(j->ctx, path, rgl) : HETAB_ERR_MEMORY;
  free(path);
  return status;
}

/* What another surface's table is for this one. */
static hetab_status measure_shared(job *j) {
  const hetab_plan_item *table = &j->plan->items[j->plan->items[j->i].shares];
  hetab_rgl_report report = {0};
  hetab_rgl *rgl = NULL;
  hetab_rgl_model *model = NULL;
  hetab_surface *surface = NULL;
  hetab_rgl_options options;
  hetab_status status = load_rgl(j, j->plan->items[j->i].shares, &rgl);
  if (status == HETAB_OK)
    status = prepare_rgl(j, table, &surface, &options);
  if (status == HETAB_OK)
    status = hetab_rgl_model_create(j->ctx, surface, &options, &model);
  if (status == HETAB_OK)
    status = hetab_rgl_measure(j->ctx, hetab_rgl_model_source(model), rgl, &report);
  take_errors(j, &report, table);
  hetab_rgl_model_free(model);
  hetab_surface_free(surface);
  hetab_rgl_free(rgl);
  return status;
}

/* ---- the audit and the picture ------------------------------------------------------------- */

/* value[channels]: what the table reflects, by its own sampler. */
static void reflectance(const hetab_rgl *rgl, const float wi[3], size_t channels, float *f,
                        float *value) {
  enum { SIDE = 24 };
  for (size_t c = 0; c < channels; c++)
    value[c] = 0.0f;
  for (int n = 0; n < SIDE * SIDE; n++) {
    const float u[2] = {((float)(n % SIDE) + 0.5f) / SIDE, ((float)(n / SIDE) + 0.5f) / SIDE};
    float wo[3], density = hetab_rgl_sample(rgl, wi, u, wo);
    if (!(density > 0.0f))
      continue;
    hetab_rgl_eval(rgl, wi, wo, f);
    for (size_t c = 0; c < channels; c++)
      value[c] += f[c] * wo[2] / (density * SIDE * SIDE);
  }
}

/* The largest of what a table and the delta beside it reflect, 0 to 80 degrees: the luminance of
 * linear sRGB, else of any wavelength. */
static void audit_energy(job *j, const hetab_rgl *rgl, const hetab_specular_table *delta,
                         float *f) {
  enum { STEPS = 9 };
  size_t channels = hetab_rgl_channel_count(rgl);
  float *value = f + channels, *rho_s = value + channels;
  for (int t = 0; t < STEPS; t++) {
    double theta = hetab_radians(80.0 * t / (STEPS - 1));
    const float wi[3] = {(float)sin(theta), 0.0f, (float)cos(theta)};
    reflectance(rgl, wi, channels, f, value);
    if (delta->count)
      hetab_specular_at(delta, wi[2], NULL, rho_s);
    for (size_t c = 0; c < channels && delta->count; c++)
      value[c] += rho_s[c];
    for (size_t c = 0; c < channels; c++) {
      bool spectral = hetab_rgl_wavelengths_um(rgl) != NULL;
      double energy = spectral ? (double)value[c] : hetab_luminance(value);
      j->result->energy = fmax(j->result->energy, energy);
    }
  }
}

static hetab_status audit_and_draw(job *j, size_t of) {
  hetab_rgl *rgl;
  hetab_specular_table delta = {0};
  HETAB_TRY(load_rgl(j, of, &rgl));
  char *path =
      hetab_batch_path(j->ctx, j->folder, hetab_surface_name(j->scene->surfaces[of]), j->ending);
  float *numbers = hetab_alloc(j->ctx, 3 * hetab_rgl_channel_count(rgl), sizeof *numbers);
  hetab_status status = path && numbers ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = hetab_specular_beside(j->ctx, path, hetab_rgl_channel_count(rgl),
                                   hetab_rgl_wavelengths_um(rgl), &delta);
  if (status == HETAB_OK) {
    audit_energy(j, rgl, &delta, numbers);
    j->thumbnail = hetab_thumbnail(j->ctx, rgl);
    status = j->thumbnail ? HETAB_OK : HETAB_ERR_MEMORY;
  }
  hetab_specular_clear(&delta);
  hetab_rgl_free(rgl);
  free(numbers);
  free(path);
  return status;
}

/* ---- records ------------------------------------------------------------------------------- */

static json_t *planned(const hetab_plan_item *item) {
  static const char *const deltas[] = {"left out", "beside", "material", "folded"};
  return json_pack("{sI sf sf sf ss sI}", "bytes", (json_int_t)item->bytes, "seconds",
                   item->seconds, "error_l1", item->error_l1, "energy_left_out",
                   item->energy_left_out, "delta",
                   item->kind >= HETAB_PLAN_MIRROR ? "" : deltas[item->delta], "wavelengths",
                   (json_int_t)item->wavelengths);
}

static json_t *record(const job *j, const char *key) {
  static const char *const kinds[] = {"table", "shared", "mirror", "plain"};
  const hetab_plan_item *item = &j->plan->items[j->i];
  const hetab_surface *s = j->scene->surfaces[j->i];
  size_t of = json_array_size(j->files) ? j->i : item->shares;
  char *yaml = NULL;
  if (hetab_surface_yaml(j->ctx, s, &yaml) != HETAB_OK)
    return NULL;
  json_t *json =
      json_pack("{ss ss ss ss ss ss sO sf sf sf sf sf ss sb so ss ss*}", "surface", j->name, "what",
                kinds[item->kind], "table_of", hetab_surface_name(j->scene->surfaces[of]),
                "consumer", hetab_consumer_name(j->scene->consumer), "key", key, "version",
                hetab_version(), "files", j->files, "bytes", j->result->bytes, "seconds",
                j->result->seconds, "error_l1", j->result->error_l1, "bias", j->result->bias,
                "energy", j->result->energy, "verdict", verdict(j->result), "fits", j->result->fits,
                "planned", planned(item), "yaml", yaml, "thumbnail", j->thumbnail);
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
  if (shared && hetab_wants_rgl(j->scene))
    HETAB_TRY(measure_shared(j));
  if (item->kind == HETAB_PLAN_TABLE || (!j->result->fits && !is_bound(j))) {
    shared = false;
    HETAB_TRY(write_table(j, engine));
  }
  if (hetab_wants_rgl(j->scene) &&
      (item->kind == HETAB_PLAN_TABLE || item->kind == HETAB_PLAN_SHARED))
    HETAB_TRY(audit_and_draw(j, shared ? item->shares : j->i));
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
