/* RGL tables as files. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rgl/rgl_file.h"
#include "rgl/rgl_internal.h"
#include "rgl/tensor.h"

/* A field of ours, that other readers pass over. */
#define CONE "specular_cone_deg"

/* ---- writing ------------------------------------------------------------------------------- */

enum { MOST_WRITTEN = 11 };

typedef struct contents {
  hetab_tensor_field fields[MOST_WRITTEN];
  size_t count;
  uint8_t jacobian;
  float *wavelengths_nm;
} contents;

static void add(contents *c, const char *name, hetab_tensor_type type, const void *data,
                size_t ndim, const size_t *shape) {
  hetab_tensor_field *field = &c->fields[c->count++];
  *field = (hetab_tensor_field){.type = type, .ndim = ndim, .data = data};
  strcpy(field->name, name);
  memcpy(field->shape, shape, ndim * sizeof *shape);
}

static void add_map(contents *c, const char *name, const hetab_rgl_map *map) {
  add(c, name, HETAB_TENSOR_F32, map->nodes, 2, (size_t[]){map->height, map->width});
}

static void add_warp(contents *c, const char *name, const hetab_rgl *rgl, const hetab_warp *warp) {
  add(c, name, HETAB_TENSOR_F32, warp->data, 4,
      (size_t[]){rgl->phi_i_count, rgl->theta_i_count, warp->height, warp->width});
}

static hetab_status set_wavelengths(hetab_context *ctx, const hetab_rgl *rgl, contents *c) {
  c->wavelengths_nm = hetab_alloc(ctx, rgl->channels, sizeof *c->wavelengths_nm);
  HETAB_NEED(c->wavelengths_nm);
  for (size_t w = 0; w < rgl->channels; w++)
    c->wavelengths_nm[w] = (float)(1e3 * rgl->wavelengths_um[w]);
  add(c, "wavelengths", HETAB_TENSOR_F32, c->wavelengths_nm, 1, &rgl->channels);
  return HETAB_OK;
}

/* free() c->wavelengths_nm. */
static hetab_status contents_of(hetab_context *ctx, const hetab_rgl *rgl, contents *c) {
  size_t spectra[] = {rgl->phi_i_count, rgl->theta_i_count, rgl->channels, rgl->resolution,
                      rgl->resolution};
  *c = (contents){.jacobian = (uint8_t)rgl->jacobian};
  add(c, "description", HETAB_TENSOR_U8, rgl->description, 1, (size_t[]){strlen(rgl->description)});
  add(c, "jacobian", HETAB_TENSOR_U8, &c->jacobian, 1, (size_t[]){1});
  add(c, "phi_i", HETAB_TENSOR_F32, rgl->phi_i, 1, &rgl->phi_i_count);
  add(c, "theta_i", HETAB_TENSOR_F32, rgl->theta_i, 1, &rgl->theta_i_count);
  add_map(c, "ndf", &rgl->ndf);
  add_map(c, "sigma", &rgl->sigma);
  add_warp(c, "vndf", rgl, &rgl->vndf);
  add_warp(c, "luminance", rgl, &rgl->luminance);
  if (rgl->wavelengths_um)
    HETAB_TRY(set_wavelengths(ctx, rgl, c));
  if (rgl->specular_cone_deg > 0.0f)
    add(c, CONE, HETAB_TENSOR_F32, &rgl->specular_cone_deg, 1, (size_t[]){1});
  add(c, rgl->wavelengths_um ? "spectra" : "rgb", HETAB_TENSOR_F32, rgl->spectra, 5, spectra);
  return HETAB_OK;
}

hetab_status hetab_rgl_save(hetab_context *ctx, const hetab_rgl *rgl, const char *path,
                            int overwrite) {
  contents c;
  hetab_status status = contents_of(ctx, rgl, &c);
  if (status == HETAB_OK)
    status = hetab_tensor_save(ctx, path, overwrite, c.fields, c.count);
  free(c.wavelengths_nm);
  return status;
}

hetab_status hetab_rgl_bytes(hetab_context *ctx, const hetab_rgl *rgl, size_t *bytes) {
  contents c;
  hetab_status status = contents_of(ctx, rgl, &c);
  *bytes = status == HETAB_OK ? hetab_tensor_bytes(c.fields, c.count) : 0;
  free(c.wavelengths_nm);
  return status;
}

hetab_status hetab_rgl_shape_bytes(hetab_context *ctx, const hetab_rgl_source *source,
                                   const hetab_rgl_shape *shape, size_t *bytes) {
  const hetab_rgl_map lobe = {.width = shape->ndf, .height = 2};
  const hetab_rgl sizes = {.description = (char *)(source->description ? source->description : ""),
                           .phi_i_count = 1,
                           .theta_i_count = shape->theta_i,
                           .ndf = lobe,
                           .sigma = lobe,
                           .vndf = {.width = shape->vndf_phi, .height = shape->vndf_theta},
                           .luminance = {.width = shape->resolution, .height = shape->resolution},
                           .channels = source->channels,
                           .resolution = shape->resolution,
                           .wavelengths_um = (double *)source->wavelengths_um};
  return hetab_rgl_bytes(ctx, &sizes, bytes);
}

/* ---- reading ------------------------------------------------------------------------------- */

static const float SHORTEST_NM = 10.0f;    /* less is a wavelength in um */
static const float NEGATIVE_SHARE = 1e-3f; /* of the largest spectrum: noise about 0 */

typedef struct reader {
  hetab_context *ctx;
  const char *path;
  hetab_tensor_file file;
  hetab_rgl *rgl;
} reader;

#define BAD(r, ...) hetab_fail((r)->ctx, HETAB_ERR_PARSE, __VA_ARGS__)

/* A field of this type with ndim dimensions, none of them 0. */
static hetab_status get(const reader *r, const char *name, hetab_tensor_type type, size_t ndim,
                        const hetab_tensor_field **out) {
  const hetab_tensor_field *field = *out = hetab_tensor_find(&r->file, name);
  if (!field)
    return BAD(r, "'%s' has no field %s: it is no RGL table", r->path, name);
  if (field->type != type)
    return BAD(r, "'%s', field %s holds %s in place of %s", r->path, name,
               hetab_tensor_type_name(field->type), hetab_tensor_type_name(type));
  if (field->ndim != ndim)
    return BAD(r, "'%s', field %s has %zu dimensions in place of %zu", r->path, name, field->ndim,
               ndim);
  for (size_t d = 0; d < ndim; d++)
    if (field->shape[d] == 0)
      return BAD(r, "'%s', field %s is empty", r->path, name);
  return HETAB_OK;
}

static hetab_status check_extent(const reader *r, const hetab_tensor_field *field, size_t d,
                                 size_t expected) {
  if (field->shape[d] == expected)
    return HETAB_OK;
  return BAD(r, "'%s', field %s: dimension %zu is %zu in place of %zu", r->path, field->name, d,
             field->shape[d], expected);
}

static hetab_status check_nodes(const reader *r, const hetab_tensor_field *field, size_t d) {
  if (field->shape[d] >= 2)
    return HETAB_OK;
  return BAD(r, "'%s', field %s: dimension %zu is 1; tables have 2 nodes or more", r->path,
             field->name, d);
}

/* A copy of the numbers, finite and at least `least`. */
static hetab_status copy_floats(const reader *r, const hetab_tensor_field *field, float least,
                                float **out) {
  size_t count = hetab_tensor_elements(field);
  *out = hetab_alloc(r->ctx, count, sizeof **out);
  HETAB_NEED(*out);
  memcpy(*out, field->data, count * sizeof **out);
  for (size_t i = 0; i < count; i++)
    if (!(isfinite((*out)[i]) && (*out)[i] >= least))
      return BAD(r, "'%s', field %s: number %zu is %g; finite numbers%s are needed", r->path,
                 field->name, i, (double)(*out)[i], least >= 0.0f ? " >= 0" : "");
  return HETAB_OK;
}

static hetab_status check_ascending(const reader *r, const char *name, const float *values,
                                    size_t count) {
  for (size_t i = 1; i < count; i++)
    if (!(values[i] > values[i - 1]))
      return BAD(r, "'%s', field %s: number %zu, %g, is not above the one before it", r->path, name,
                 i, (double)values[i]);
  return HETAB_OK;
}

static hetab_status read_incidences(reader *r) {
  const hetab_tensor_field *theta, *phi;
  hetab_rgl *rgl = r->rgl;
  HETAB_TRY(get(r, "theta_i", HETAB_TENSOR_F32, 1, &theta));
  HETAB_TRY(get(r, "phi_i", HETAB_TENSOR_F32, 1, &phi));
  if (phi->shape[0] > 2)
    return hetab_fail(r->ctx, HETAB_ERR_UNSUPPORTED,
                      "'%s' is anisotropic (%zu azimuths in phi_i); only isotropic tables are read",
                      r->path, phi->shape[0]);
  rgl->theta_i_count = theta->shape[0];
  rgl->phi_i_count = phi->shape[0];
  HETAB_TRY(copy_floats(r, theta, 0.0f, &rgl->theta_i));
  HETAB_TRY(copy_floats(r, phi, -INFINITY, &rgl->phi_i));
  HETAB_TRY(check_ascending(r, "theta_i", rgl->theta_i, rgl->theta_i_count));
  HETAB_TRY(check_ascending(r, "phi_i", rgl->phi_i, rgl->phi_i_count));
  if (rgl->theta_i[rgl->theta_i_count - 1] > 1.5709f)
    return BAD(r, "'%s', field theta_i ends at %g: radians up to pi / 2 are needed", r->path,
               (double)rgl->theta_i[rgl->theta_i_count - 1]);
  return HETAB_OK;
}

static hetab_status read_map(reader *r, const char *name, int positive, hetab_rgl_map *map) {
  const hetab_tensor_field *field;
  HETAB_TRY(get(r, name, HETAB_TENSOR_F32, 2, &field));
  HETAB_TRY(check_nodes(r, field, 0));
  HETAB_TRY(check_nodes(r, field, 1));
  map->height = field->shape[0];
  map->width = field->shape[1];
  HETAB_TRY(copy_floats(r, field, 0.0f, &map->nodes));
  for (size_t i = 0; positive && i < map->height * map->width; i++)
    if (!(map->nodes[i] > 0.0f))
      return BAD(r, "'%s', field %s: number %zu is 0; readers divide by it", r->path, name, i);
  return HETAB_OK;
}

static hetab_status read_warp(reader *r, const char *name, int uniform, hetab_warp *warp) {
  const hetab_tensor_field *field;
  const hetab_rgl *rgl = r->rgl;
  float *data = NULL;
  size_t bad = 0;
  hetab_status status;
  HETAB_TRY(get(r, name, HETAB_TENSOR_F32, 4, &field));
  HETAB_TRY(check_extent(r, field, 0, rgl->phi_i_count));
  HETAB_TRY(check_extent(r, field, 1, rgl->theta_i_count));
  HETAB_TRY(check_nodes(r, field, 2));
  HETAB_TRY(check_nodes(r, field, 3));
  HETAB_GOTO(copy_floats(r, field, 0.0f, &data));
  HETAB_GOTO(hetab_warp_create(r->ctx, data, field->shape[3], field->shape[2],
                               rgl->phi_i_count * rgl->theta_i_count, uniform, &bad, warp));
done:
  free(data);
  if (status == HETAB_ERR_RANGE)
    return BAD(r, "'%s', field %s: slice %zu integrates to 0 or to infinity; it is no density",
               r->path, name, bad);
  return status;
}

static hetab_status read_wavelengths(reader *r) {
  const hetab_tensor_field *field;
  HETAB_FREED float *nm = NULL;
  hetab_rgl *rgl = r->rgl;
  HETAB_TRY(get(r, "wavelengths", HETAB_TENSOR_F32, 1, &field));
  rgl->channels = field->shape[0];
  if (rgl->channels > HETAB_RGL_MOST_WAVELENGTHS)
    return BAD(r, "'%s', field wavelengths: %zu of them; at most %d are read", r->path,
               rgl->channels, HETAB_RGL_MOST_WAVELENGTHS);
  HETAB_TRY(copy_floats(r, field, 0.0f, &nm));
  HETAB_TRY(check_ascending(r, "wavelengths", nm, rgl->channels));
  if (nm[0] < SHORTEST_NM)
    HETAB_TRY(BAD(r, "'%s', field wavelengths: %g nm is below 10 nm; write nm, not um", r->path,
                  (double)nm[0]));
  rgl->wavelengths_um = hetab_alloc(r->ctx, rgl->channels, sizeof *rgl->wavelengths_um);
  HETAB_NEED(rgl->wavelengths_um);
  for (size_t w = 0; w < rgl->channels; w++)
    rgl->wavelengths_um[w] = 1e-3 * (double)nm[w];
  return HETAB_OK;
}

/* The largest that f cos(theta_o) can be over a spectrum. */
static float largest_factor(const hetab_rgl *rgl) {
  float most = 0.0f, least = INFINITY;
  if (!rgl->jacobian)
    return 1.0f;
  for (size_t i = 0; i < rgl->ndf.width * rgl->ndf.height; i++)
    most = fmaxf(most, rgl->ndf.nodes[i]);
  for (size_t i = 0; i < rgl->sigma.width * rgl->sigma.height; i++)
    least = fminf(least, rgl->sigma.nodes[i]);
  return most / (4.0f * least);
}

/* Fits of measurements go a little below 0, which the look-up has as 0; values further down, and
 * those that overflow once they are turned into a BRDF, are damage. */
static hetab_status check_spectra(reader *r, const char *name) {
  hetab_rgl *rgl = r->rgl;
  size_t count =
      rgl->phi_i_count * rgl->theta_i_count * rgl->channels * rgl->resolution * rgl->resolution;
  float largest = 0.0f;
  for (size_t i = 0; i < count; i++)
    largest = fmaxf(largest, rgl->spectra[i]);
  if (!isfinite(largest * largest_factor(rgl)))
    return BAD(r, "'%s', field %s: %g overflows with the ndf and sigma of the file", r->path, name,
               (double)largest);
  for (size_t i = 0; i < count; i++) {
    if (rgl->spectra[i] < -NEGATIVE_SHARE * largest)
      return BAD(r, "'%s', field %s: number %zu is %g; reflectances are not negative", r->path,
                 name, i, (double)rgl->spectra[i]);
    rgl->negative += rgl->spectra[i] < 0.0f;
    rgl->spectra[i] = fmaxf(rgl->spectra[i], 0.0f);
  }
  return HETAB_OK;
}

static hetab_status read_spectra(reader *r) {
  int spectral = hetab_tensor_find(&r->file, "wavelengths") != NULL;
  const hetab_tensor_field *field;
  hetab_rgl *rgl = r->rgl;
  rgl->channels = 3;
  if (spectral)
    HETAB_TRY(read_wavelengths(r));
  HETAB_TRY(get(r, spectral ? "spectra" : "rgb", HETAB_TENSOR_F32, 5, &field));
  HETAB_TRY(check_extent(r, field, 0, rgl->phi_i_count));
  HETAB_TRY(check_extent(r, field, 1, rgl->theta_i_count));
  HETAB_TRY(check_extent(r, field, 2, rgl->channels));
  HETAB_TRY(check_nodes(r, field, 3));
  HETAB_TRY(check_extent(r, field, 4, field->shape[3]));
  rgl->resolution = field->shape[3];
  if (rgl->luminance.width != rgl->resolution || rgl->luminance.height != rgl->resolution)
    return BAD(r, "'%s': luminance has %zu x %zu nodes, %s %zu x %zu; they have to agree", r->path,
               rgl->luminance.height, rgl->luminance.width, field->name, rgl->resolution,
               rgl->resolution);
  HETAB_TRY(copy_floats(r, field, -INFINITY, &rgl->spectra));
  return check_spectra(r, field->name);
}

static hetab_status read_texts(reader *r) {
  const hetab_tensor_field *description, *jacobian;
  HETAB_TRY(get(r, "jacobian", HETAB_TENSOR_U8, 1, &jacobian));
  HETAB_TRY(check_extent(r, jacobian, 0, 1));
  r->rgl->jacobian = *(const uint8_t *)jacobian->data != 0;
  description = hetab_tensor_find(&r->file, "description");
  size_t length =
      description && description->type == HETAB_TENSOR_U8 ? hetab_tensor_elements(description) : 0;
  r->rgl->description = hetab_alloc(r->ctx, length + 1, 1);
  HETAB_NEED(r->rgl->description);
  if (length)
    memcpy(r->rgl->description, description->data, length);
  const hetab_tensor_field *cone = hetab_tensor_find(&r->file, CONE);
  if (!cone)
    return HETAB_OK;
  HETAB_TRY(get(r, CONE, HETAB_TENSOR_F32, 1, &cone));
  HETAB_TRY(check_extent(r, cone, 0, 1));
  memcpy(&r->rgl->specular_cone_deg, cone->data, sizeof(float));
  if (r->rgl->specular_cone_deg > 0.0f && r->rgl->specular_cone_deg <= 90.0f)
    return HETAB_OK;
  return BAD(r, "'%s', field %s is %g: degrees up to 90 are needed", r->path, CONE,
             (double)r->rgl->specular_cone_deg);
}

static hetab_status read_all(reader *r) {
  HETAB_TRY(read_texts(r));
  HETAB_TRY(read_incidences(r));
  HETAB_TRY(read_map(r, "ndf", 0, &r->rgl->ndf));
  HETAB_TRY(read_map(r, "sigma", 1, &r->rgl->sigma));
  HETAB_TRY(read_warp(r, "vndf", 0, &r->rgl->vndf));
  HETAB_TRY(read_warp(r, "luminance", 1, &r->rgl->luminance));
  return read_spectra(r);
}

hetab_status hetab_rgl_load(hetab_context *ctx, const char *path, hetab_rgl **out) {
  reader r = {.ctx = ctx, .path = path};
  hetab_status status;
  *out = NULL;
  HETAB_TRY(hetab_tensor_load(ctx, path, &r.file));
  r.rgl = hetab_alloc(ctx, 1, sizeof *r.rgl);
  HETAB_GOTO(r.rgl ? HETAB_OK : HETAB_ERR_MEMORY);
  HETAB_GOTO(read_all(&r));
done:
  hetab_tensor_clear(&r.file);
  if (status == HETAB_OK)
    *out = r.rgl;
  else
    hetab_rgl_free(r.rgl);
  return status;
}
