/* Reading a surface from YAML; include/hetab/surface.h describes the keys. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "surface/surface_yaml.h"
#include "surface/surface_parts.h"
#include "core/text.h"
#include "surface/wavelengths.h"
#include "surface/yaml.h"

static const char *const surface_keys[] = {"name",
                                           "sigma0_um",
                                           "slope",
                                           "tau_um",
                                           "index",
                                           "extrapolate_index",
                                           "diffuse_brdf",
                                           "wavelengths_nm",
                                           "wavelengths_um",
                                           "diffuse_reflectance",
                                           "sigma0_bounds_um",
                                           "tau_bounds_um",
                                           "slope_bounds",
                                           NULL};
static const char *const index_keys[] = {"file", "n", "k", NULL};

/* ---- roughness ---- */

/* sigma0_um, or slope * tau_um. */
static hetab_status read_sigma0(hetab_yaml *file, const yaml_node_t *root, hetab_surface *surface) {
  yaml_node_t *slope_node = hetab_yaml_get(file, root, "slope"), *sigma0_node;
  if (!slope_node) {
    HETAB_TRY(hetab_yaml_require(file, root, "sigma0_um",
                                 "add sigma0_um (rms height, um), or slope (sigma0/tau)",
                                 &sigma0_node));
    return hetab_yaml_number(file, sigma0_node, "sigma0_um", &hetab_rule_length,
                             &surface->sigma0_um);
  }
  if (hetab_yaml_get(file, root, "sigma0_um"))
    return hetab_yaml_fail(file, slope_node, "slope", "given besides sigma0_um: keep one of them");
  double slope;
  HETAB_TRY(hetab_yaml_number(file, slope_node, "slope", &hetab_rule_slope, &slope));
  surface->sigma0_um = slope * surface->tau_um;
  hetab_status status = hetab_number_check(file->ctx, &hetab_rule_length, surface->sigma0_um);
  return status == HETAB_OK ? HETAB_OK : hetab_yaml_locate(file, status, slope_node, "slope");
}

/* [low, high] about the value; bounds stay 0 without the key. */
static hetab_status read_bounds(hetab_yaml *file, const yaml_node_t *root, const char *key,
                                const hetab_rule *rule, double value, double bounds[2]) {
  yaml_node_t *node = hetab_yaml_get(file, root, key);
  if (!node)
    return HETAB_OK;
  if (node->type != YAML_SEQUENCE_NODE)
    return hetab_yaml_fail(file, node, key, "not a list: give [LOW, HIGH]");
  HETAB_FREED double *values = NULL;
  size_t count;
  HETAB_TRY(hetab_yaml_numbers(file, node, key, rule, &values, &count));
  bool good = count == 2 && values[0] <= value && value <= values[1];
  if (good)
    memcpy(bounds, values, 2 * sizeof *bounds);
  return good ? HETAB_OK
              : hetab_yaml_fail(file, node, key,
                                "give [LOW, HIGH] with the value, %g, between them", value);
}

/* sigma0_bounds_um, or slope_bounds: the same, times tau. */
static hetab_status read_sigma0_bounds(hetab_yaml *file, const yaml_node_t *root,
                                       hetab_surface *surface) {
  double *bounds = surface->sigma0_bounds_um, tau = surface->tau_um;
  const yaml_node_t *slope = hetab_yaml_get(file, root, "slope_bounds");
  if (slope && hetab_yaml_get(file, root, "sigma0_bounds_um"))
    return hetab_yaml_fail(file, slope, "slope_bounds",
                           "given besides sigma0_bounds_um: keep one of them");
  HETAB_TRY(read_bounds(file, root, slope ? "slope_bounds" : "sigma0_bounds_um",
                        slope ? &hetab_rule_slope : &hetab_rule_length,
                        surface->sigma0_um / (slope ? tau : 1), bounds));
  for (int i = 0; i < 2 && slope; i++) /* a slope next to its bound is on it */
    bounds[i] = (i ? fmax : fmin)(bounds[i] * tau, surface->sigma0_um);
  return HETAB_OK;
}

static hetab_status read_roughness(hetab_yaml *file, const yaml_node_t *root,
                                   hetab_surface *surface) {
  yaml_node_t *tau_node;
  HETAB_TRY(
      hetab_yaml_require(file, root, "tau_um", "add tau_um (correlation length, um)", &tau_node));
  HETAB_TRY(hetab_yaml_number(file, tau_node, "tau_um", &hetab_rule_length, &surface->tau_um));
  HETAB_TRY(read_sigma0(file, root, surface));
  HETAB_TRY(read_sigma0_bounds(file, root, surface));
  return read_bounds(file, root, "tau_bounds_um", &hetab_rule_length, surface->tau_um,
                     surface->tau_bounds_um);
}

/* ---- index ---- */

/* A path in a surface file is relative to that file's folder; free() it. */
static char *resolve_path(hetab_context *ctx, const char *surface_path, const char *path) {
  const char *slash = strrchr(surface_path, '/');
  int folder = *path == '/' || !slash ? 0 : (int)(slash - surface_path + 1);
  size_t size = (size_t)folder + strlen(path) + 1;
  char *resolved = hetab_alloc(ctx, size, 1);
  if (resolved)
    snprintf(resolved, size, "%.*s%s", folder, surface_path, path);
  return resolved;
}

static hetab_status read_index_file(hetab_yaml *file, const yaml_node_t *node,
                                    hetab_index **index) {
  const char *path;
  HETAB_TRY(hetab_yaml_text(file, node, "file", "the path of a .yml or .csv file", &path));
  char *resolved = resolve_path(file->ctx, file->path, path);
  HETAB_NEED(resolved);
  hetab_status status = hetab_index_load(file->ctx, resolved, index);
  free(resolved);
  /* Malformed data names its own file and line; a missing file is a mistake in this one. */
  return status == HETAB_ERR_IO ? hetab_yaml_locate(file, status, node, "file") : status;
}

static hetab_status read_index_constant(hetab_yaml *file, const yaml_node_t *mapping,
                                        hetab_index **index) {
  yaml_node_t *n_node, *k_node = hetab_yaml_get(file, mapping, "k");
  double n, k = 0;
  HETAB_TRY(hetab_yaml_require(file, mapping, "n", "give {n: N, k: K} or {file: PATH}", &n_node));
  HETAB_TRY(hetab_yaml_number(file, n_node, "n", &hetab_rule_n, &n));
  if (k_node)
    HETAB_TRY(hetab_yaml_number(file, k_node, "k", &hetab_rule_k, &k));
  return hetab_index_constant(file->ctx, n, k, index);
}

static hetab_status read_index_mapping(hetab_yaml *file, const yaml_node_t *mapping,
                                       hetab_index **index) {
  HETAB_TRY(hetab_yaml_check_keys(file, mapping, index_keys, true));
  yaml_node_t *path = hetab_yaml_get(file, mapping, "file");
  if (!path)
    return read_index_constant(file, mapping, index);
  if (hetab_yaml_get(file, mapping, "n") || hetab_yaml_get(file, mapping, "k"))
    return hetab_yaml_fail(file, path, "file", "given besides n or k: keep the file or the values");
  return read_index_file(file, path, index);
}

static hetab_status read_index_node(hetab_yaml *file, const yaml_node_t *node,
                                    hetab_index **index) {
  const char *wanted = "a metal such as Al, {file: PATH}, or {n: N, k: K}", *symbol;
  if (node->type == YAML_MAPPING_NODE)
    return read_index_mapping(file, node, index);
  HETAB_TRY(hetab_yaml_text(file, node, "index", wanted, &symbol));
  hetab_status status = hetab_index_metal(file->ctx, symbol, index);
  return status == HETAB_ERR_ARGUMENT ? hetab_yaml_locate(file, HETAB_ERR_PARSE, node, "index")
                                      : status;
}

static hetab_status read_index(hetab_yaml *file, const yaml_node_t *root, hetab_index **index) {
  yaml_node_t *node;
  HETAB_TRY(hetab_yaml_require(file, root, "index",
                               "add a metal such as Al, {file: PATH}, or {n: N, k: K}", &node));
  return read_index_node(file, node, index);
}

/* ---- diffuse part ---- */

static hetab_status read_diffuse(hetab_yaml *file, const yaml_node_t *root, size_t wavelengths,
                                 hetab_surface *surface) {
  yaml_node_t *brdf = hetab_yaml_get(file, root, "diffuse_brdf");
  yaml_node_t *reflectance = hetab_yaml_get(file, root, "diffuse_reflectance");
  const yaml_node_t *node = brdf ? brdf : reflectance;
  const char *key = brdf ? "diffuse_brdf" : "diffuse_reflectance";
  const hetab_rule *rule = brdf ? &hetab_rule_brdf : &hetab_rule_reflectance;
  if (!node)
    return HETAB_OK;
  if (brdf && reflectance)
    return hetab_yaml_fail(file, node, key,
                           "given besides diffuse_reflectance, which is pi times "
                           "as much: keep one of them");
  surface->diffuse_is_brdf = brdf != NULL;
  if (node->type != YAML_SEQUENCE_NODE)
    return hetab_yaml_number(file, node, key, rule, surface->diffuse);
  double *values;
  size_t count;
  HETAB_TRY(hetab_yaml_numbers(file, node, key, rule, &values, &count));
  free(surface->diffuse);
  surface->diffuse = values;
  surface->diffuse_count = count;
  return count == wavelengths
             ? HETAB_OK
             : hetab_yaml_fail(file, node, key,
                               "%zu values for %zu wavelengths: give one number, or one per "
                               "wavelength",
                               count, wavelengths);
}

/* ---- wavelengths ---- */

static hetab_status read_wavelength_list(hetab_yaml *file, const yaml_node_t *node, const char *key,
                                         double per_um, double **lambda_um, size_t *count) {
  double *values;
  HETAB_TRY(hetab_yaml_numbers(file, node, key, &hetab_rule_any, &values, count));
  for (size_t i = 0; i < *count; i++)
    values[i] /= per_um;
  hetab_status status = hetab_wavelengths_check(file->ctx, values, *count);
  if (status != HETAB_OK) {
    free(values);
    return hetab_yaml_locate(file, HETAB_ERR_PARSE, node, key);
  }
  *lambda_um = values;
  return HETAB_OK;
}

/* *where and *key are left at what the wavelengths came from: later messages name it. */
static hetab_status read_wavelengths(hetab_yaml *file, const yaml_node_t *root,
                                     const yaml_node_t **where, const char **key,
                                     double **lambda_um, size_t *count) {
  yaml_node_t *nm = hetab_yaml_get(file, root, "wavelengths_nm");
  yaml_node_t *um = hetab_yaml_get(file, root, "wavelengths_um");
  const yaml_node_t *node = um ? um : nm;
  double per_um = um ? 1 : 1000;
  *key = um ? "wavelengths_um" : "wavelengths_nm";
  *where = node ? node : root;
  if (nm && um)
    return hetab_yaml_fail(file, um, *key, "given besides wavelengths_nm: keep one of them");
  if (node && node->type == YAML_SEQUENCE_NODE)
    return read_wavelength_list(file, node, *key, per_um, lambda_um, count);
  const char *text = "400:700:10";
  if (node)
    HETAB_TRY(hetab_yaml_text(file, node, *key, "start:stop:step or a list", &text));
  if (hetab_wavelengths_parse(file->ctx, text, per_um, lambda_um, count) != HETAB_OK)
    return hetab_yaml_locate(file, HETAB_ERR_PARSE, *where, *key);
  return HETAB_OK;
}

static hetab_status read_bands(hetab_yaml *file, const yaml_node_t *root, hetab_surface *surface) {
  const yaml_node_t *where;
  const char *key;
  HETAB_FREED double *lambda_um = NULL;
  size_t count;
  HETAB_TRY(read_wavelengths(file, root, &where, &key, &lambda_um, &count));
  hetab_status status = read_diffuse(file, root, count, surface);
  if (status == HETAB_OK) {
    status = hetab_surface_sample(file->ctx, surface, lambda_um, count);
    if (status != HETAB_OK)
      hetab_yaml_locate(file, status, where, key);
  }
  return status;
}

/* ---- the file ---- */

static hetab_status read_extrapolate(hetab_yaml *file, const yaml_node_t *root,
                                     hetab_surface *surface) {
  yaml_node_t *node = hetab_yaml_get(file, root, "extrapolate_index");
  return node ? hetab_yaml_bool(file, node, "extrapolate_index", &surface->extrapolate) : HETAB_OK;
}

static hetab_status fill_surface(hetab_yaml *file, const yaml_node_t *root,
                                 hetab_surface *surface) {
  HETAB_TRY(read_roughness(file, root, surface));
  HETAB_TRY(read_extrapolate(file, root, surface));
  HETAB_TRY(read_index(file, root, &surface->index));
  return read_bands(file, root, surface);
}

hetab_status hetab_surface_of_mapping(hetab_yaml *file, const yaml_node_t *mapping,
                                      const char *name, hetab_surface **out) {
  yaml_node_t *node = hetab_yaml_get(file, mapping, "name");
  hetab_surface *surface;
  *out = NULL;
  HETAB_TRY(hetab_yaml_check_keys(file, mapping, surface_keys, true));
  if (node)
    HETAB_TRY(hetab_yaml_text(file, node, "name", "a name", &name));
  HETAB_TRY(hetab_surface_new(file->ctx, name, &surface));
  *out = surface;
  HETAB_MADE(hetab_surface, out, fill_surface(file, mapping, surface));
}

hetab_status hetab_surface_of_values(hetab_yaml *file, const char *name,
                                     const hetab_surface_values *values, hetab_surface **out) {
  double *lambda_um;
  size_t count;
  hetab_surface *surface;
  *out = NULL;
  HETAB_TRY(hetab_surface_new(file->ctx, name, &surface));
  surface->sigma0_um = values->sigma0_um;
  surface->tau_um = values->tau_um;
  surface->diffuse[0] = values->diffuse_reflectance;
  hetab_status status = read_index_node(file, values->index, &surface->index);
  if (status == HETAB_OK)
    status = hetab_wavelengths_parse(file->ctx, "400:700:10", 1000, &lambda_um, &count);
  if (status == HETAB_OK) {
    status = hetab_surface_sample(file->ctx, surface, lambda_um, count);
    free(lambda_um);
    if (status != HETAB_OK)
      hetab_yaml_locate(file, status, values->index, "index");
  }
  *out = surface;
  HETAB_MADE(hetab_surface, out, status);
}

/* The file's own name without folder and extension; free() it. */
static char *stem_of(const char *path) {
  const char *slash = strrchr(path, '/');
  char *stem = strdup(slash ? slash + 1 : path);
  if (stem && hetab_has_extension(stem, hetab_yaml_extensions))
    *strrchr(stem, '.') = '\0';
  return stem;
}

hetab_status hetab_surface_load(hetab_context *ctx, const char *path, hetab_surface **out) {
  *out = NULL;
  hetab_yaml file;
  HETAB_TRY(hetab_yaml_open(ctx, path, &file));
  char *stem = stem_of(path);
  hetab_status status = stem ? hetab_surface_of_mapping(&file, hetab_yaml_root(&file), stem, out)
                             : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  free(stem);
  hetab_yaml_close(&file);
  return status;
}
