#include "rgl/rgl_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/model.h"

double hetab_rgl_luminance(const hetab_rgl_source *source, const double *values, size_t stride) {
  double sum = 0.0;
  if (!source->wavelengths_um)
    return 0.2126 * values[0] + 0.7152 * values[stride] + 0.0722 * values[2 * stride];
  for (size_t c = 0; c < source->channels; c++)
    sum += values[c * stride];
  return sum / (double)source->channels;
}

/* ---- the density of half vectors ----------------------------------------------------------- */

/* For a microfacet lobe f cos(theta_i) cos(theta_r) is D(theta_m) times what changes slowly. Lobes
 * whose width depends on theta_d (those of smooth surfaces do) need room for the widest: the mean
 * over several theta_d, each normalised. */
static const double theta_d_deg[] = {0.0, 30.0, 50.0, 65.0, 76.0, 82.0};
enum { THETA_D = sizeof theta_d_deg / sizeof *theta_d_deg };

/* The part of the mixture that is uniform, so that no direction is without nodes. */
static const double broad = 0.001;

static double node_theta(size_t i, size_t count) {
  return hetab_rgl_u_to_theta((double)i / (double)(count - 1));
}

/* The pair of half vector theta_h and difference (theta_d, 90 degrees): there both directions are
 * equally far from the normal, and above the horizon for any theta_h. */
static hetab_directions pair_of(double theta_h, double theta_d) {
  double z = cos(theta_h) * cos(theta_d), x = sin(theta_h) * cos(theta_d), y = sin(theta_d);
  double theta = atan2(hypot(x, y), z);
  return (hetab_directions){theta, theta, 2.0 * atan2(y, x)};
}

/* f cos cos, [THETA_D][count]. */
static hetab_status lobes(hetab_context *ctx, const hetab_rgl_source *source, const double *theta_m,
                          size_t count, double *out) {
  size_t total = THETA_D * count;
  hetab_directions *pairs = hetab_alloc(ctx, total, sizeof *pairs);
  double *values = hetab_alloc(ctx, total * source->channels, sizeof *values);
  hetab_status status;
  HETAB_GOTO(pairs && values ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t i = 0; i < total; i++)
    pairs[i] =
        pair_of(fmin(theta_m[i % count], M_PI_2 - 1e-3), hetab_radians(theta_d_deg[i / count]));
  HETAB_GOTO(source->values(ctx, source->user, pairs, total, values));
  for (size_t i = 0; i < total; i++) {
    double cosine = cos(pairs[i].theta_i);
    out[i] = cosine * cosine * hetab_rgl_luminance(source, values + i * source->channels, 1);
  }
done:
  free(pairs);
  free(values);
  return status;
}

/* The integral of D cos over the hemisphere, trapezoidal. */
static double projected(const double *theta, const double *density, size_t count) {
  double sum = 0.0;
  for (size_t i = 1; i < count; i++) {
    double a = density[i - 1] * sin(2.0 * theta[i - 1]), b = density[i] * sin(2.0 * theta[i]);
    sum += 0.5 * M_PI * (a + b) * (theta[i] - theta[i - 1]);
  }
  return sum;
}

/* The width of a smooth surface's lobe grows as 1 / cos(theta_d): its wide parts need their share
 * of the nodes, for the narrow ones stand on top of them. */
static double share(size_t d) {
  return 1.0 / cos(hetab_radians(theta_d_deg[d]));
}

hetab_status hetab_rgl_lobe_from_data(hetab_context *ctx, const hetab_rgl_source *source,
                                      size_t count, double *density) {
  double theta_m[HETAB_RGL_MOST_NDF];
  double *lobe = hetab_alloc(ctx, THETA_D * count, sizeof *lobe), shares = 0.0;
  hetab_status status = HETAB_ERR_MEMORY;
  if (!lobe)
    return status;
  for (size_t i = 0; i < count; i++)
    theta_m[i] = node_theta(i, count);
  HETAB_GOTO(lobes(ctx, source, theta_m, count, lobe));
  for (size_t i = 0; i < count; i++)
    density[i] = broad / M_PI;
  for (size_t d = 0; d < THETA_D; d++)
    shares += share(d);
  for (size_t d = 0; d < THETA_D; d++) {
    double whole = projected(theta_m, lobe + d * count, count);
    for (size_t i = 0; i < count && whole > 0.0; i++)
      density[i] += (1.0 - broad) * share(d) / shares * lobe[d * count + i] / whole;
  }
done:
  free(lobe);
  return status;
}

/* ---- allocation ---------------------------------------------------------------------------- */

static hetab_status new_map(hetab_context *ctx, size_t width, hetab_rgl_map *map) {
  *map = (hetab_rgl_map){.width = width, .height = 2};
  map->nodes = hetab_alloc(ctx, 2 * width, sizeof(float));
  return map->nodes ? HETAB_OK : HETAB_ERR_MEMORY;
}

static hetab_status copy_texts(hetab_context *ctx, const hetab_rgl_source *source, hetab_rgl *rgl) {
  const char *text = source->description ? source->description : "";
  rgl->description = hetab_alloc(ctx, strlen(text) + 1, 1);
  if (!rgl->description)
    return HETAB_ERR_MEMORY;
  strcpy(rgl->description, text);
  rgl->channels = source->channels;
  rgl->specular_cone_deg = (float)source->specular_cone_deg;
  if (!source->wavelengths_um)
    return HETAB_OK;
  rgl->wavelengths_um = hetab_alloc(ctx, source->channels, sizeof(double));
  if (!rgl->wavelengths_um)
    return HETAB_ERR_MEMORY;
  memcpy(rgl->wavelengths_um, source->wavelengths_um, source->channels * sizeof(double));
  return HETAB_OK;
}

static hetab_status allocate(hetab_context *ctx, const hetab_rgl_source *source,
                             const hetab_rgl_shape *shape, const double *theta_i, hetab_rgl *rgl) {
  size_t nodes = shape->resolution * shape->resolution;
  HETAB_TRY(copy_texts(ctx, source, rgl));
  HETAB_TRY(new_map(ctx, shape->ndf, &rgl->ndf));
  HETAB_TRY(new_map(ctx, shape->ndf, &rgl->sigma));
  rgl->jacobian = 1;
  rgl->phi_i_count = 1;
  rgl->theta_i_count = shape->theta_i;
  rgl->resolution = shape->resolution;
  rgl->phi_i = hetab_alloc(ctx, 1, sizeof(float));
  rgl->theta_i = hetab_alloc(ctx, shape->theta_i, sizeof(float));
  rgl->spectra = hetab_alloc(ctx, shape->theta_i * source->channels * nodes, sizeof(float));
  if (!rgl->phi_i || !rgl->theta_i || !rgl->spectra)
    return HETAB_ERR_MEMORY;
  for (size_t k = 0; k < shape->theta_i; k++)
    rgl->theta_i[k] = (float)theta_i[k];
  return HETAB_OK;
}

/* ---- ndf, sigma and vndf ------------------------------------------------------------------- */

static void set_both_rows(hetab_rgl_map *map, size_t x, double value) {
  map->nodes[x] = map->nodes[map->width + x] = (float)value;
}

/* A share of the lobe's root gives the foot of a narrow lobe upon a wide one its nodes. */
static void fill_ndf(const double *lobe, double soft, hetab_rgl_map *ndf) {
  double theta[HETAB_RGL_MOST_NDF], root[HETAB_RGL_MOST_NDF], density[HETAB_RGL_MOST_NDF];
  double most = 0.0;
  for (size_t x = 0; x < ndf->width; x++) {
    theta[x] = node_theta(x, ndf->width);
    root[x] = sqrt(lobe[x]);
  }
  double whole = projected(theta, lobe, ndf->width), roots = projected(theta, root, ndf->width);
  for (size_t x = 0; x < ndf->width; x++) {
    density[x] = (1.0 - soft) * lobe[x] / whole + soft * root[x] / roots;
    most = fmax(most, density[x]);
  }
  for (size_t x = 0; x < ndf->width; x++)
    set_both_rows(ndf, x, fmax(density[x], 1e-6 * most));
}

/* The integral over azimuths of max(0, wi . m): a cosine of amplitude a about b. */
static double facing(double a, double b) {
  if (b >= a)
    return 2.0 * M_PI * b;
  double end = acos(-b / a);
  return 2.0 * (end * b + sqrt((a - b) * (a + b)));
}

static float ndf_at(const hetab_rgl_map *ndf, double u_theta) {
  float u[2] = {(float)u_theta, 0.0f};
  hetab_cell cell = hetab_cell_at(ndf->width, ndf->height, u);
  return hetab_cell_value(&cell, ndf->nodes, ndf->width);
}

enum { GAUSS = 3, MOST_FACETS = GAUSS * (HETAB_RGL_MOST_NDF - 1) };
typedef struct facet {
  double sine, cosine, weight;
} facet;

/* Of the stored ndf: Gauss's rule of three nodes in every cell. */
static size_t place_facets(const hetab_rgl_map *ndf, facet *out) {
  static const double place[GAUSS] = {0.1127016653792583, 0.5, 0.8872983346207417};
  static const double weight[GAUSS] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double step = 1.0 / (double)(ndf->width - 1);
  for (size_t i = 0; i < GAUSS * (ndf->width - 1); i++) {
    size_t x = i / GAUSS, g = i % GAUSS;
    double u = ((double)x + place[g]) * step, theta = hetab_rgl_u_to_theta(u);
    double density =
        (1.0 - place[g]) * (double)ndf->nodes[x] + place[g] * (double)ndf->nodes[x + 1];
    out[i] = (facet){sin(theta), cos(theta), weight[g] * density * sin(theta) * M_PI * u * step};
  }
  return GAUSS * (ndf->width - 1);
}

static void fill_sigma(hetab_rgl *rgl) {
  facet facets[MOST_FACETS];
  size_t count = place_facets(&rgl->ndf, facets);
  for (size_t x = 0; x < rgl->sigma.width; x++) {
    double theta_i = node_theta(x, rgl->sigma.width), sum = 0.0;
    double sine = sin(theta_i), cosine = cos(theta_i);
    for (size_t i = 0; i < count; i++)
      sum += facets[i].weight * facing(sine * facets[i].sine, cosine * facets[i].cosine);
    set_both_rows(&rgl->sigma, x, sum);
  }
}

static void vndf_slice(const hetab_rgl *rgl, double theta_i, const hetab_rgl_shape *shape,
                       float *out) {
  for (size_t y = 0; y < shape->vndf_phi; y++)
    for (size_t x = 0; x < shape->vndf_theta; x++) {
      double u = (double)x / (double)(shape->vndf_theta - 1), theta = hetab_rgl_u_to_theta(u);
      double phi = (2.0 * (double)y / (double)(shape->vndf_phi - 1) - 1.0) * M_PI;
      double cosine = sin(theta_i) * sin(theta) * cos(phi) + cos(theta_i) * cos(theta);
      double density = (double)ndf_at(&rgl->ndf, u) * fmax(cosine, 0.0);
      out[y * shape->vndf_theta + x] = (float)(density * 2.0 * M_PI * M_PI * u * sin(theta));
    }
}

static hetab_status fill_vndf(hetab_context *ctx, const hetab_rgl_shape *shape,
                              const double *theta_i, hetab_rgl *rgl) {
  size_t nodes = shape->vndf_theta * shape->vndf_phi, bad;
  float *data = hetab_alloc(ctx, nodes * shape->theta_i, sizeof *data);
  if (!data)
    return HETAB_ERR_MEMORY;
  for (size_t k = 0; k < shape->theta_i; k++)
    vndf_slice(rgl, theta_i[k], shape, data + k * nodes);
  hetab_status status = hetab_warp_create(ctx, data, shape->vndf_theta, shape->vndf_phi,
                                          shape->theta_i, 0, &bad, &rgl->vndf);
  free(data);
  if (status == HETAB_ERR_RANGE)
    return hetab_fail(ctx, status, "the density of half vectors at theta_i = %g degrees is zero",
                      theta_i[bad] * 180.0 / M_PI);
  return status;
}

hetab_status hetab_rgl_new(hetab_context *ctx, const hetab_rgl_source *source,
                           const hetab_rgl_shape *shape, const double *lobe, const double *theta_i,
                           hetab_rgl **out) {
  hetab_status status;
  hetab_rgl *rgl = *out = hetab_alloc(ctx, 1, sizeof *rgl);
  if (!rgl)
    return HETAB_ERR_MEMORY;
  HETAB_GOTO(allocate(ctx, source, shape, theta_i, rgl));
  fill_ndf(lobe, shape->soft, &rgl->ndf);
  fill_sigma(rgl);
  HETAB_GOTO(fill_vndf(ctx, shape, theta_i, rgl));
  return HETAB_OK;
done:
  hetab_rgl_free(rgl);
  *out = NULL;
  return status;
}

/* ---- spectra ------------------------------------------------------------------------------- */

/* Nodes of half a slice, the other half being its mirror image, that lead above the horizon. */
typedef struct plan {
  size_t count;
  hetab_directions *pairs;
  double *factor; /* from f to spectra */
  size_t *node;
  double *values; /* [count][channels] */
} plan;

static hetab_status plan_create(hetab_context *ctx, size_t most, size_t channels, plan *p) {
  *p = (plan){0};
  p->pairs = hetab_alloc(ctx, most, sizeof *p->pairs);
  p->factor = hetab_alloc(ctx, most, sizeof *p->factor);
  p->node = hetab_alloc(ctx, most, sizeof *p->node);
  p->values = hetab_alloc(ctx, most * channels, sizeof *p->values);
  return p->pairs && p->factor && p->node && p->values ? HETAB_OK : HETAB_ERR_MEMORY;
}

static void plan_clear(plan *p) {
  free(p->pairs);
  free(p->factor);
  free(p->node);
  free(p->values);
}

/* The viewer that half vector u_m mirrors the light to; 0 below the horizon. */
static int reflect(double theta_i, const float u_m[2], hetab_directions *pair) {
  double theta = hetab_rgl_u_to_theta((double)u_m[0]), phi = (2.0 * (double)u_m[1] - 1.0) * M_PI;
  double m[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
  double wi[3] = {sin(theta_i), 0.0, cos(theta_i)}, wo[3];
  double along = 2.0 * (wi[0] * m[0] + wi[2] * m[2]);
  for (int c = 0; c < 3; c++)
    wo[c] = along * m[c] - wi[c];
  *pair = (hetab_directions){theta_i, atan2(hypot(wo[0], wo[1]), wo[2]), atan2(wo[1], wo[0])};
  return along > 0.0 && wo[2] > 0.0 && pair->theta_r < M_PI_2;
}

float hetab_rgl_column_place(size_t x, size_t n) {
  float last = (float)(n - 1);
  return x == n - 1 ? 1.0f - 0.25f / last : (float)x / last;
}

static void plan_node(const hetab_rgl *rgl, const hetab_blend *blend, double theta_i, double sigma,
                      size_t x, size_t y, plan *p) {
  size_t n = rgl->resolution;
  float s[2] = {hetab_rgl_column_place(x, n), (float)y / (float)(n - 1)}, u_m[2];
  hetab_warp_sample(&rgl->vndf, blend, s, u_m);
  if (!reflect(theta_i, u_m, &p->pairs[p->count]))
    return;
  p->factor[p->count] =
      cos(p->pairs[p->count].theta_r) * 4.0 * sigma / (double)ndf_at(&rgl->ndf, (double)u_m[0]);
  p->node[p->count++] = y * n + x;
}

static void scatter(const plan *p, size_t channels, size_t n, double *out) {
  for (size_t i = 0; i < p->count; i++)
    for (size_t c = 0; c < channels; c++) {
      size_t x = p->node[i] % n, y = p->node[i] / n;
      double value = p->values[i * channels + c] * p->factor[i];
      out[c * n * n + y * n + x] = out[c * n * n + (n - 1 - y) * n + x] = value;
    }
}

hetab_status hetab_rgl_spectra_at(hetab_context *ctx, const hetab_rgl_source *source,
                                  const hetab_rgl *rgl, const hetab_blend *blend, double theta_i,
                                  double *out) {
  size_t n = rgl->resolution, rows = (n + 1) / 2;
  float u_wi[2] = {hetab_rgl_theta_to_u((float)theta_i), 0.0f};
  hetab_cell at = hetab_cell_at(rgl->sigma.width, rgl->sigma.height, u_wi);
  double sigma = (double)hetab_cell_value(&at, rgl->sigma.nodes, rgl->sigma.width);
  hetab_status status;
  plan p;
  memset(out, 0, source->channels * n * n * sizeof *out);
  HETAB_GOTO(plan_create(ctx, rows * n, source->channels, &p));
  for (size_t y = 0; y < rows; y++)
    for (size_t x = 0; x < n; x++)
      plan_node(rgl, blend, theta_i, sigma, x, y, &p);
  HETAB_GOTO(source->values(ctx, source->user, p.pairs, p.count, p.values));
  scatter(&p, source->channels, n, out);
done:
  plan_clear(&p);
  return status;
}

/* ---- luminance ----------------------------------------------------------------------------- */

/* What samplers draw nodes by: at least a thousandth of the slice's mean. */
static void luminance_slice(const hetab_rgl_source *source, const double *spectra, size_t nodes,
                            float *out) {
  double mean = 0.0;
  for (size_t i = 0; i < nodes; i++) {
    double luminance = hetab_rgl_luminance(source, spectra + i, nodes);
    out[i] = (float)luminance;
    mean += luminance / (double)nodes;
  }
  for (size_t i = 0; i < nodes; i++)
    out[i] = fmaxf(out[i], (float)(1e-3 * mean));
}

double hetab_rgl_slice_theta(const hetab_rgl *rgl, size_t k) {
  double theta = (double)rgl->theta_i[k], before;
  if (k == 0 || k + 1 < rgl->theta_i_count)
    return theta;
  before = (double)rgl->theta_i[k - 1];
  return theta - 0.25 * (theta - before);
}

/* values[channels][resolution][resolution]: what goes into slice k. Nothing that may be drawn
 * weighs 0 there: a renderer's chi-square test would leave it out of its samples, not of the
 * density. */
static hetab_status fill_slice(hetab_context *ctx, const hetab_rgl_source *source, hetab_rgl *rgl,
                               size_t k, double *values) {
  size_t count = source->channels * rgl->resolution * rgl->resolution;
  hetab_blend own = {1, {k}, {1.0f}};
  HETAB_TRY(hetab_rgl_spectra_at(ctx, source, rgl, &own, hetab_rgl_slice_theta(rgl, k), values));
  for (size_t i = 0; i < count; i++)
    rgl->spectra[k * count + i] = fmaxf((float)values[i], 1e-30f);
  return HETAB_OK;
}

hetab_status hetab_rgl_fill_about(hetab_context *ctx, const hetab_rgl_source *source,
                                  hetab_rgl *rgl, double theta_i) {
  hetab_blend blend = hetab_rgl_blend(rgl, (float)theta_i, 0.0f);
  double *slice =
      hetab_alloc(ctx, source->channels, rgl->resolution * rgl->resolution * sizeof *slice);
  hetab_status status = slice ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t k = 0; k < blend.count && status == HETAB_OK; k++)
    status = fill_slice(ctx, source, rgl, blend.slice[k], slice);
  free(slice);
  return status;
}

hetab_status hetab_rgl_fill(hetab_context *ctx, const hetab_rgl_source *source, hetab_rgl *rgl) {
  size_t n = rgl->resolution, nodes = n * n, bad, values = source->channels * nodes;
  hetab_status status;
  double *slice = hetab_alloc(ctx, values, sizeof *slice);
  float *luminance = hetab_alloc(ctx, rgl->theta_i_count * nodes, sizeof *luminance);
  HETAB_GOTO(slice && luminance ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t k = 0; k < rgl->theta_i_count; k++) {
    HETAB_GOTO(fill_slice(ctx, source, rgl, k, slice));
    luminance_slice(source, slice, nodes, luminance + k * nodes);
  }
  hetab_warp_clear(&rgl->luminance);
  HETAB_GOTO(hetab_warp_create(ctx, luminance, n, n, rgl->theta_i_count, 1, &bad, &rgl->luminance));
done:
  free(slice);
  free(luminance);
  return status;
}
