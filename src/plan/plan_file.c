/* A plan kept in the batch's folder, under the key of what it was made of. */
#include <hetab/output_file.h>
#include <hetab/plan.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <jansson.h>

#include "core/context.h"
#include "plan/plan_key.h"
#include "plan/plan_make.h"
#include "plan/probe.h"
#include "plan/scene.h"

/* 0: there is none. */
static bool is_shape(json_int_t ndf, json_int_t vndf_theta, json_int_t vndf_phi) {
  return ndf == 0 ||
         (ndf > 1 && ndf <= HETAB_RGL_MOST_NDF && vndf_theta > 1 &&
          vndf_theta <= HETAB_RGL_MOST_NODES && vndf_phi > 1 && vndf_phi <= HETAB_RGL_MOST_NODES);
}

/* A density is two hexadecimal digits an incidence. */
static bool unpack_forecast(const json_t *json, hetab_rgl_forecast *out) {
  json_int_t ndf, vndf_theta, vndf_phi;
  const char *density;
  bool good =
      json_unpack((json_t *)json, "{sI sI sI sF ss}", "ndf", &ndf, "vndf_theta", &vndf_theta,
                  "vndf_phi", &vndf_phi, "soft", &out->shape.soft, "density", &density) == 0 &&
      is_shape(ndf, vndf_theta, vndf_phi) && strlen(density) == 2 * HETAB_RGL_PROBES;
  for (int k = 0; good && k < HETAB_RGL_PROBES; k++)
    good = sscanf(density + 2 * k, "%2hhx", &out->density[k]) == 1;
  if (!good)
    return false;
  out->shape.ndf = (size_t)ndf;
  out->shape.vndf_theta = (size_t)vndf_theta;
  out->shape.vndf_phi = (size_t)vndf_phi;
  return true;
}

static json_t *pack_forecast(const hetab_rgl_forecast *f) {
  char density[2 * HETAB_RGL_PROBES + 1];
  for (int k = 0; k < HETAB_RGL_PROBES; k++)
    snprintf(density + 2 * k, 3, "%02x", f->density[k]);
  return json_pack("{sI sI sI sf ss}", "ndf", (json_int_t)f->shape.ndf, "vndf_theta",
                   (json_int_t)f->shape.vndf_theta, "vndf_phi", (json_int_t)f->shape.vndf_phi,
                   "soft", f->shape.soft, "density", density);
}

static bool unpack_item(const json_t *json, size_t count, hetab_plan_item *item) {
  json_int_t kind, shares, delta, wavelengths, theta_i, resolution, bytes;
  if (json_unpack((json_t *)json, "{sI sI sI sb sF sF sF sI sF sI sI sF sI sF sF}", "kind", &kind,
                  "shares", &shares, "delta", &delta, "diffuse", &item->diffuse, "delta_share",
                  &item->delta_share, "energy_left_out", &item->energy_left_out, "plain_error",
                  &item->plain_error, "wavelengths", &wavelengths, "wavelength_error",
                  &item->wavelength_error, "theta_i", &theta_i, "resolution", &resolution,
                  "spacing_deg", &item->spacing_deg, "bytes", &bytes, "seconds", &item->seconds,
                  "error_l1", &item->error_l1) != 0)
    return false;
  item->kind = (hetab_plan_kind)kind;
  item->delta = (hetab_delta)delta;
  item->shares = (size_t)shares;
  item->wavelengths = (size_t)wavelengths;
  item->theta_i_count = (size_t)theta_i;
  item->resolution = (size_t)resolution;
  item->bytes = (size_t)bytes;
  return kind >= HETAB_PLAN_TABLE && kind <= HETAB_PLAN_PLAIN && delta >= 0 &&
         delta <= HETAB_DELTA_FOLDED && shares >= 0 && (size_t)shares < count;
}

static json_t *pack_item(const hetab_plan_item *item) {
  return json_pack("{sI sI sI sb sf sf sf sI sf sI sI sf sI sf sf}", "kind", (json_int_t)item->kind,
                   "shares", (json_int_t)item->shares, "delta", (json_int_t)item->delta, "diffuse",
                   item->diffuse, "delta_share", item->delta_share, "energy_left_out",
                   item->energy_left_out, "plain_error", item->plain_error, "wavelengths",
                   (json_int_t)item->wavelengths, "wavelength_error", item->wavelength_error,
                   "theta_i", (json_int_t)item->theta_i_count, "resolution",
                   (json_int_t)item->resolution, "spacing_deg", item->spacing_deg, "bytes",
                   (json_int_t)item->bytes, "seconds", item->seconds, "error_l1", item->error_l1);
}

/* NULL if the file does not hold the plan of that key, whatever else it holds. */
static hetab_plan *unpack(const json_t *json, const char *key, size_t count) {
  const char *found;
  json_t *items;
  hetab_plan *plan = calloc(1, sizeof *plan);
  bool good = plan && json_unpack((json_t *)json, "{ss so sF sF sF sF sF sF sF}", "key", &found,
                                  "items", &items, "table_error", &plan->table_error, "asked_error",
                                  &plan->asked_error, "memory_bytes", &plan->memory_bytes, "bytes",
                                  &plan->bytes, "seconds", &plan->seconds, "dense_bytes",
                                  &plan->dense_bytes, "dense_seconds", &plan->dense_seconds) == 0;
  good = good && strcmp(found, key) == 0 && json_array_size(items) == count;
  if (good) {
    plan->count = count;
    plan->items = calloc(count ? count : 1, sizeof *plan->items);
    plan->forecasts = calloc(count ? count : 1, sizeof *plan->forecasts);
    good = plan->items && plan->forecasts;
  }
  for (size_t i = 0; good && i < count; i++) {
    const json_t *item = json_array_get(items, i);
    good = unpack_item(item, count, &plan->items[i]) &&
           unpack_forecast(json_object_get(item, "forecast"), &plan->forecasts[i]);
  }
  if (good)
    return plan;
  hetab_plan_free(plan);
  return NULL;
}

static hetab_status save(hetab_context *ctx, const hetab_plan *plan, const char *key,
                         const char *path) {
  json_t *items = json_array();
  for (size_t i = 0; i < plan->count; i++) {
    json_t *item = pack_item(&plan->items[i]);
    json_object_set_new(item, "forecast", pack_forecast(&plan->forecasts[i]));
    json_array_append_new(items, item);
  }
  json_t *json =
      json_pack("{ss so sf sf sf sf sf sf sf}", "key", key, "items", items, "table_error",
                plan->table_error, "asked_error", plan->asked_error, "memory_bytes",
                plan->memory_bytes, "bytes", plan->bytes, "seconds", plan->seconds, "dense_bytes",
                plan->dense_bytes, "dense_seconds", plan->dense_seconds);
  char *text = json ? json_dumps(json, JSON_COMPACT) : NULL;
  hetab_status status = text ? hetab_text_save(ctx, path, text, strlen(text), 0)
                             : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", path);
  free(text);
  json_decref(json);
  return status;
}

/* NULL if there is none of that key; what is no such plan is removed. */
static hetab_plan *load(const hetab_scene *scene, const char *key, const char *path) {
  json_t *json = json_load_file(path, 0, NULL);
  hetab_plan *plan = json ? unpack(json, key, scene->count) : NULL;
  json_decref(json);
  if (!plan)
    unlink(path);
  return plan;
}

/* The first plan that is there is everybody's: two that differed would deal surfaces differently.
 */
static hetab_status make(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                         double share_start, const char *key, const char *path, hetab_plan **out) {
  HETAB_TRY(hetab_plan_make(ctx, scene, folder, share_start, out));
  hetab_status status = save(ctx, *out, key, path);
  if (status == HETAB_ERR_EXISTS) {
    hetab_plan_free(*out);
    *out = load(scene, key, path);
    status = *out ? HETAB_OK
                  : hetab_fail(ctx, HETAB_ERR_IO,
                               "'%s' changes: is another scene's batch in this "
                               "folder? Give each its own",
                               path);
  }
  if (status == HETAB_OK)
    hetab_probe_forget(folder);
  return status;
}

hetab_status hetab_plan_open(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share_start, hetab_plan **out) {
  char key[HETAB_KEY], *path;
  *out = NULL;
  HETAB_TRY(hetab_scene_key(ctx, scene, key));
  if (asprintf(&path, "%s/plan.json", folder) < 0)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  *out = load(scene, key, path);
  hetab_status status = *out ? HETAB_OK : make(ctx, scene, folder, share_start, key, path, out);
  free(path);
  if (status != HETAB_OK) {
    hetab_plan_free(*out);
    *out = NULL;
  }
  return status;
}
