#include "plan/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "core/context.h"
#include "surface/surface_yaml.h"

enum { MOST_SURFACES = 100000, MOST_VALUES = 10000, MOST_NAME = 128 };

static const char *const scene_keys[] = {"surfaces",
                                         "sweep",
                                         "consumer",
                                         "table_error",
                                         "energy_error",
                                         "max_theta_i_deg",
                                         "max_theta_r_deg",
                                         "specular_cone_deg",
                                         "memory_mb",
                                         "output",
                                         NULL};
static const char *const sweep_keys[] = {"index",  "sigma0_um",           "slope",
                                         "tau_um", "diffuse_reflectance", NULL};
static const char *const range_keys[] = {"from", "to", "count", "spacing", NULL};

static const char *const consumers[] = {
    "mitsuba-rgb", "mitsuba-spectral", "pbrt", "merl", "hdf5", "exr", "lookup"};

const char *hetab_consumer_name(hetab_consumer consumer) {
  return consumers[consumer];
}

const char *hetab_scene_output(const hetab_scene *scene) {
  return scene->output;
}

/* At 1 degree the default grid's: 90 to 90 degrees. */
size_t hetab_scene_thetas(double most, double spacing_deg) {
  size_t count = (size_t)ceil(hetab_degrees(most) / spacing_deg - 1e-9);
  return count > 1 ? count : 2;
}

size_t hetab_scene_phis(double spacing_deg) {
  return (size_t)ceil(180.0 / spacing_deg - 1e-9) + 1;
}

double hetab_scene_entries(const hetab_scene *scene, double spacing_deg) {
  return (double)hetab_scene_thetas(scene->max_theta_i, spacing_deg) *
         (double)hetab_scene_thetas(scene->max_theta_r, spacing_deg) *
         (double)hetab_scene_phis(spacing_deg);
}

size_t hetab_scene_surface_count(const hetab_scene *scene) {
  return scene->count;
}

const hetab_surface *hetab_scene_surface(const hetab_scene *scene, size_t i) {
  return scene->surfaces[i];
}

hetab_consumer hetab_scene_consumer(const hetab_scene *scene) {
  return scene->consumer;
}

void hetab_scene_free(hetab_scene *scene) {
  if (!scene)
    return;
  for (size_t i = 0; i < scene->count; i++)
    hetab_surface_free(scene->surfaces[i]);
  free(scene->surfaces);
  free(scene->output);
  free(scene);
}

/* ---- surfaces ------------------------------------------------------------------------------ */

/* Surfaces name files: their names are letters, digits and -_.+ with one of the first two ahead. */
static bool names_a_file(const char *name) {
  static const char *const safe =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.+";
  return *name && *name != '.' && *name != '-' && strlen(name) <= MOST_NAME &&
         strspn(name, safe) == strlen(name);
}

/* Takes the surface, whatever the outcome. */
static hetab_status add_surface(hetab_yaml *file, const yaml_node_t *node, hetab_scene *scene,
                                hetab_surface *surface) {
  const char *name = hetab_surface_name(surface);
  hetab_status status = HETAB_OK;
  if (!names_a_file(name))
    status =
        hetab_yaml_fail(file, node, "surfaces",
                        "the name '%s' is to name a file: take letters, digits, - _ . +", name);
  else if (scene->count == MOST_SURFACES)
    status = hetab_yaml_fail(file, node, "surfaces", "more than %d surfaces: split the scene",
                             MOST_SURFACES);
  if (status == HETAB_OK && scene->count == scene->room) {
    size_t room = scene->room ? 2 * scene->room : 64;
    hetab_surface **more = realloc(scene->surfaces, room * sizeof(hetab_surface *));
    if (more) {
      scene->surfaces = more;
      scene->room = room;
    } else
      status = hetab_fail(file->ctx, HETAB_ERR_MEMORY, "out of memory");
  }
  if (status == HETAB_OK)
    scene->surfaces[scene->count++] = surface;
  else
    hetab_surface_free(surface);
  return status;
}

/* A path in a scene is relative to the scene's folder; free() it. */
static char *beside_scene(const hetab_yaml *file, const char *name) {
  const char *slash = strrchr(file->path, '/'), *dot = strrchr(name, '.');
  bool path = strchr(name, '/') || (dot && (!strcmp(dot, ".yml") || !strcmp(dot, ".yaml")));
  int folder = !path || *name == '/' || !slash ? 0 : (int)(slash + 1 - file->path);
  char *joined;
  return asprintf(&joined, "%.*s%s", folder, file->path, name) < 0 ? NULL : joined;
}

static hetab_status open_named(hetab_yaml *file, const yaml_node_t *node, hetab_surface **out) {
  const char *name;
  HETAB_TRY(hetab_yaml_text(file, node, "surfaces", "names, files or {sigma0_um: ...}", &name));
  HETAB_FREED char *path = beside_scene(file, name);
  if (!path)
    return hetab_fail(file->ctx, HETAB_ERR_MEMORY, "out of memory");
  hetab_status status = hetab_surface_open(file->ctx, path, out);
  return status == HETAB_ERR_IO || status == HETAB_ERR_ARGUMENT
             ? hetab_yaml_locate(file, status, node, "surfaces")
             : status;
}

static hetab_status read_surfaces(hetab_yaml *file, const yaml_node_t *list, hetab_scene *scene) {
  if (list->type != YAML_SEQUENCE_NODE)
    return hetab_yaml_fail(file, list, "surfaces", "not a list: give [BBQAL1, mine.yml]");
  for (const yaml_node_item_t *i = list->data.sequence.items.start;
       i < list->data.sequence.items.top; i++) {
    yaml_node_t *node = yaml_document_get_node(&file->document, *i);
    char name[32];
    hetab_surface *surface;
    snprintf(name, sizeof name, "surface%zu", scene->count + 1);
    HETAB_TRY(node->type == YAML_MAPPING_NODE ? hetab_surface_of_mapping(file, node, name, &surface)
                                              : open_named(file, node, &surface));
    HETAB_TRY(add_surface(file, node, scene, surface));
  }
  return HETAB_OK;
}

/* ---- the sweep ----------------------------------------------------------------------------- */

typedef struct values {
  double *at;
  size_t count;
} values;

static hetab_status read_range(hetab_yaml *file, const yaml_node_t *node, const char *key,
                               const hetab_rule *rule, values *out) {
  const char *remedy = "give {from: A, to: B, count: N}", *spacing = "linear";
  yaml_node_t *from_node, *to_node, *count_node, *spacing_node;
  double from, to, count;
  HETAB_TRY(hetab_yaml_check_keys(file, node, range_keys, true));
  HETAB_TRY(hetab_yaml_require(file, node, "from", remedy, &from_node));
  HETAB_TRY(hetab_yaml_require(file, node, "to", remedy, &to_node));
  HETAB_TRY(hetab_yaml_require(file, node, "count", remedy, &count_node));
  HETAB_TRY(hetab_yaml_number(file, from_node, "from", rule, &from));
  HETAB_TRY(hetab_yaml_number(file, to_node, "to", rule, &to));
  HETAB_TRY(hetab_yaml_number(file, count_node, "count", &hetab_rule_any, &count));
  if ((spacing_node = hetab_yaml_get(file, node, "spacing")))
    HETAB_TRY(hetab_yaml_text(file, spacing_node, "spacing", "linear or log", &spacing));
  bool log_spaced = strcmp(spacing, "log") == 0;
  if (!log_spaced && strcmp(spacing, "linear") != 0)
    return hetab_yaml_fail(file, spacing_node, "spacing", "'%s': give linear or log", spacing);
  if (!(count >= 2 && count <= MOST_VALUES && count == floor(count)) || !(from < to) ||
      (log_spaced && !(from > 0)))
    return hetab_yaml_fail(file, node, key,
                           "give from < to and a whole count from 2 to %d; log needs from > 0",
                           MOST_VALUES);
  out->count = (size_t)count;
  out->at = hetab_alloc(file->ctx, out->count, sizeof *out->at);
  for (size_t i = 0; out->at && i < out->count; i++) {
    double t = (double)i / (count - 1);
    out->at[i] = log_spaced ? from * pow(to / from, t) : from + t * (to - from);
  }
  return out->at ? HETAB_OK : HETAB_ERR_MEMORY;
}

/* A number, a list, or a range. */
static hetab_status read_values(hetab_yaml *file, const yaml_node_t *node, const char *key,
                                const hetab_rule *rule, values *out) {
  if (node->type == YAML_MAPPING_NODE)
    return read_range(file, node, key, rule, out);
  if (node->type == YAML_SEQUENCE_NODE) {
    HETAB_TRY(hetab_yaml_numbers(file, node, key, rule, &out->at, &out->count));
    return out->count ? HETAB_OK : hetab_yaml_fail(file, node, key, "an empty list: give values");
  }
  out->count = 1;
  out->at = hetab_alloc(file->ctx, 1, sizeof *out->at);
  return out->at ? hetab_yaml_number(file, node, key, rule, out->at) : HETAB_ERR_MEMORY;
}

typedef struct sweep {
  values height, tau, diffuse;
  bool slopes; /* heights are slopes */
} sweep;

static hetab_status read_sweep_values(hetab_yaml *file, const yaml_node_t *node, sweep *s) {
  yaml_node_t *slope = hetab_yaml_get(file, node, "slope"), *sigma0, *tau;
  yaml_node_t *diffuse = hetab_yaml_get(file, node, "diffuse_reflectance");
  s->slopes = slope != NULL;
  if (slope && hetab_yaml_get(file, node, "sigma0_um"))
    return hetab_yaml_fail(file, slope, "slope", "given besides sigma0_um: keep one of them");
  if (slope)
    HETAB_TRY(read_values(file, slope, "slope", &hetab_rule_slope, &s->height));
  else {
    HETAB_TRY(hetab_yaml_require(file, node, "sigma0_um", "add a list or a range, um", &sigma0));
    HETAB_TRY(read_values(file, sigma0, "sigma0_um", &hetab_rule_length, &s->height));
  }
  HETAB_TRY(hetab_yaml_require(file, node, "tau_um", "add a list or a range, um", &tau));
  HETAB_TRY(read_values(file, tau, "tau_um", &hetab_rule_length, &s->tau));
  if (diffuse)
    return read_values(file, diffuse, "diffuse_reflectance", &hetab_rule_reflectance, &s->diffuse);
  s->diffuse.count = 1;
  s->diffuse.at = hetab_alloc(file->ctx, 1, sizeof *s->diffuse.at);
  return s->diffuse.at ? HETAB_OK : HETAB_ERR_MEMORY;
}

static hetab_status add_values(hetab_yaml *file, const yaml_node_t *index, size_t number,
                               const sweep *s, hetab_scene *scene) {
  const char *metal =
      index->type == YAML_SCALAR_NODE ? (const char *)index->data.scalar.value : NULL;
  for (size_t h = 0; h < s->height.count; h++)
    for (size_t t = 0; t < s->tau.count; t++)
      for (size_t d = 0; d < s->diffuse.count; d++) {
        double tau = s->tau.at[t], sigma0 = s->height.at[h] * (s->slopes ? tau : 1.0);
        hetab_surface_values v = {sigma0, tau, s->diffuse.at[d], index};
        char name[MOST_NAME], tail[32] = "";
        hetab_surface *surface;
        if (s->diffuse.count > 1)
          snprintf(tail, sizeof tail, "_a%.4g", v.diffuse_reflectance);
        if (metal)
          snprintf(name, sizeof name, "%s_s%.4g_t%.4g%s", metal, sigma0, tau, tail);
        else
          snprintf(name, sizeof name, "index%zu_s%.4g_t%.4g%s", number, sigma0, tau, tail);
        HETAB_TRY(hetab_surface_of_values(file, name, &v, &surface));
        HETAB_TRY(add_surface(file, index, scene, surface));
      }
  return HETAB_OK;
}

static hetab_status add_sweep(hetab_yaml *file, const yaml_node_t *node, const sweep *s,
                              hetab_scene *scene) {
  yaml_node_t *index;
  size_t number = 0;
  HETAB_TRY(hetab_yaml_require(file, node, "index", "add a metal, or a list of indices", &index));
  if (index->type != YAML_SEQUENCE_NODE)
    return add_values(file, index, 1, s, scene);
  for (const yaml_node_item_t *i = index->data.sequence.items.start;
       i < index->data.sequence.items.top; i++)
    HETAB_TRY(add_values(file, yaml_document_get_node(&file->document, *i), ++number, s, scene));
  return HETAB_OK;
}

static hetab_status read_sweep(hetab_yaml *file, const yaml_node_t *node, hetab_scene *scene) {
  sweep s = {0};
  if (node->type != YAML_MAPPING_NODE)
    return hetab_yaml_fail(file, node, "sweep", "no keys: give {index: ..., sigma0_um: ...}");
  HETAB_TRY(hetab_yaml_check_keys(file, node, sweep_keys, true));
  hetab_status status = read_sweep_values(file, node, &s);
  if (status == HETAB_OK)
    status = add_sweep(file, node, &s, scene);
  free(s.height.at);
  free(s.tau.at);
  free(s.diffuse.at);
  return status;
}

/* ---- the scene ----------------------------------------------------------------------------- */

static hetab_status read_consumer(hetab_yaml *file, hetab_consumer *out) {
  yaml_node_t *node;
  const char *text;
  HETAB_TRY(hetab_yaml_require(file, hetab_yaml_root(file), "consumer",
                               "add mitsuba-rgb, mitsuba-spectral, pbrt, merl, hdf5, exr or lookup",
                               &node));
  HETAB_TRY(hetab_yaml_text(file, node, "consumer", "a renderer", &text));
  for (size_t i = 0; i < sizeof consumers / sizeof *consumers; i++)
    if (strcmp(text, consumers[i]) == 0) {
      *out = (hetab_consumer)i;
      return HETAB_OK;
    }
  return hetab_yaml_fail(
      file, node, "consumer",
      "'%s': give mitsuba-rgb, mitsuba-spectral, pbrt, merl, hdf5, exr or lookup", text);
}

/* Keeps *value without the key. */
static hetab_status read_limit(hetab_yaml *file, const char *key, double least, double most,
                               double *value) {
  yaml_node_t *node = hetab_yaml_get(file, hetab_yaml_root(file), key);
  if (!node)
    return HETAB_OK;
  HETAB_TRY(hetab_yaml_number(file, node, key, &hetab_rule_any, value));
  return *value >= least && *value <= most
             ? HETAB_OK
             : hetab_yaml_fail(file, node, key, "%g: give %g to %g", *value, least, most);
}

static hetab_status read_output(hetab_yaml *file, hetab_scene *scene) {
  yaml_node_t *node = hetab_yaml_get(file, hetab_yaml_root(file), "output");
  const char *folder;
  if (!node)
    return HETAB_OK;
  HETAB_TRY(hetab_yaml_text(file, node, "output", "a folder", &folder));
  if (!*folder)
    return hetab_yaml_fail(file, node, "output", "empty: name a folder");
  scene->output = strdup(folder);
  return scene->output ? HETAB_OK : hetab_fail(file->ctx, HETAB_ERR_MEMORY, "out of memory");
}

static int by_name(const void *a, const void *b) {
  return strcmp(hetab_surface_name(*(hetab_surface *const *)a),
                hetab_surface_name(*(hetab_surface *const *)b));
}

static hetab_status check_names(hetab_yaml *file, const hetab_scene *scene) {
  size_t count = scene->count;
  hetab_surface **sorted = hetab_alloc(file->ctx, count, sizeof(hetab_surface *));
  hetab_status status = sorted ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK && count) {
    memcpy(sorted, scene->surfaces, count * sizeof(hetab_surface *));
    qsort(sorted, count, sizeof *sorted, by_name);
  }
  for (size_t i = 1; i < count && status == HETAB_OK; i++)
    if (by_name(&sorted[i - 1], &sorted[i]) == 0)
      status =
          hetab_fail(file->ctx, HETAB_ERR_PARSE,
                     "%s: two surfaces are named %s: give one another name; a sweep's values have "
                     "to differ in their first four digits",
                     file->path, hetab_surface_name(sorted[i]));
  free(sorted);
  return status;
}

static hetab_status read_scene(hetab_yaml *file, hetab_scene *scene) {
  yaml_node_t *root = hetab_yaml_root(file);
  yaml_node_t *surfaces = hetab_yaml_get(file, root, "surfaces");
  yaml_node_t *swept = hetab_yaml_get(file, root, "sweep");
  double theta_i_deg = 90.0, theta_r_deg = 90.0, megabytes = 0.0, cone_deg;
  if (hetab_yaml_get(file, root, "tau_um") || hetab_yaml_get(file, root, "preset"))
    return hetab_fail(file->ctx, HETAB_ERR_PARSE,
                      "%s: this is a surface; a scene has the key surfaces: [FILE, ...]",
                      file->path);
  HETAB_TRY(hetab_yaml_check_keys(file, root, scene_keys, true));
  HETAB_TRY(read_consumer(file, &scene->consumer));
  HETAB_TRY(read_limit(file, "table_error", 1e-4, 0.3, &scene->table_error));
  HETAB_TRY(read_limit(file, "energy_error", 1e-6, 1, &scene->energy_error));
  cone_deg = scene->consumer == HETAB_PBRT || scene->consumer == HETAB_CONSUMER_MERL ? 4.0 : 0.0;
  HETAB_TRY(read_limit(file, "max_theta_i_deg", 1, 90, &theta_i_deg));
  HETAB_TRY(read_limit(file, "max_theta_r_deg", 1, 90, &theta_r_deg));
  HETAB_TRY(read_limit(file, "specular_cone_deg", 0, 30, &cone_deg));
  HETAB_TRY(read_limit(file, "memory_mb", 1e-3, 1e9, &megabytes));
  scene->max_theta_i = hetab_radians(theta_i_deg);
  scene->max_theta_r = hetab_radians(theta_r_deg);
  scene->specular_cone = hetab_radians(cone_deg);
  scene->memory_bytes = 1e6 * megabytes;
  HETAB_TRY(read_output(file, scene));
  if (!surfaces && !swept)
    return hetab_yaml_fail(file, root, "surfaces", "neither surfaces nor a sweep: give one");
  if (surfaces)
    HETAB_TRY(read_surfaces(file, surfaces, scene));
  if (swept)
    HETAB_TRY(read_sweep(file, swept, scene));
  return check_names(file, scene);
}

hetab_status hetab_scene_load(hetab_context *ctx, const char *path, hetab_scene **out) {
  hetab_yaml file;
  *out = NULL;
  HETAB_TRY(hetab_yaml_open(ctx, path, &file));
  hetab_scene *scene = hetab_alloc(ctx, 1, sizeof *scene);
  hetab_status status = scene ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK) {
    scene->table_error = 0.01;
    scene->energy_error = 0.003;
    status = read_scene(&file, scene);
  }
  hetab_yaml_close(&file);
  *out = scene;
  HETAB_MADE(hetab_scene, out, status);
}
