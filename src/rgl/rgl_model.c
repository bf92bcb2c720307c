/* The model as a source of RGL tables, and the tables made of it. On the host, in double: what
 * depends on the directions is computed once for all wavelengths, and the series at a few of them,
 * ln h(g, x) being smooth in 1 / lambda^2, to which g and x are proportional: 12 nodes keep f to
 * some 1e-4 (tests/test_rgl.c). The reference that tables are judged by is not interpolated. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <pthread.h>
#include <unistd.h>

#include "model/colour.h"
#include "model/limits.h"
#include "model/model.h"
#include "rgl/rgl_internal.h"
#include "rgl/rgl_model.h"
#include "rgl/rgl_table.h"

enum { NODES = 12, MOST_WORKERS = 16, WORKER_PAIRS = 256 };

struct hetab_rgl_model {
  const hetab_surface *surface;
  double tau_2sigma;
  size_t bands, nodes;
  hetab_wave *waves, *node_waves; /* [bands], [nodes] */
  double *interpolation;          /* [bands][nodes], of ln h */
  double (*weights)[3];           /* to XYZ; NULL: the bands themselves */
  double *wavelengths_um;
  char description[256];
  size_t clamped; /* values of linear sRGB below 0, set to 0 */
  hetab_rgl_source source;
};

/* Some pairs, for one thread. */
typedef struct worker {
  const hetab_rgl_model *m;
  int exact; /* the series at every band */
  const hetab_rgl_pair *pairs;
  size_t count;
  double *values, *bands; /* [count][channels], [m->bands] */
  size_t clamped;
} worker;

/* ---- a pair's bands ------------------------------------------------------------------------ */

/* ln h at every band; 0 if some of it is too small to be interpolated. */
static int ln_h_bands(const hetab_rgl_model *m, double g, double x, double *out) {
  double node[NODES];
  for (size_t k = 0; k < m->nodes; k++) {
    node[k] = hetab_ln_h(m->node_waves[k].g * g, m->node_waves[k].x * x);
    if (!isfinite(node[k]))
      return 0;
  }
  for (size_t b = 0; b < m->bands; b++) {
    out[b] = 0.0;
    for (size_t k = 0; k < m->nodes; k++)
      out[b] += m->interpolation[b * m->nodes + k] * node[k];
  }
  return 1;
}

/* dd + ud of every band. */
static void pair_bands(const hetab_rgl_model *m, int exact, const hetab_rgl_pair *pair,
                       double *out) {
  hetab_direction in = hetab_direction_at(pair->theta_i, m->tau_2sigma);
  hetab_direction to = hetab_direction_at(pair->theta_r, m->tau_2sigma);
  hetab_pair p = hetab_pair_of(&in, &to);
  const hetab_band *bands = hetab_surface_bands(m->surface);
  double lateral2 = p.d2 + p.p * hetab_one_plus_cos(pair->phi), g = p.mu2 * p.ratio2;
  double cos2_d = fmin(0.25 * (p.mu2 + lateral2), 1.0);
  int smooth = !exact && ln_h_bands(m, g, lateral2, out);
  for (size_t b = 0; b < m->bands; b++) {
    const hetab_wave *wave = &m->waves[b];
    double ln_h = smooth ? out[b] : hetab_ln_h(wave->g * g, wave->x * lateral2);
    out[b] = hetab_fresnel_at(cos2_d, bands[b].n, bands[b].k) * cos2_d * cos2_d * wave->amplitude *
                 p.shadow * exp(ln_h) +
             wave->diffuse_brdf;
  }
}

/* Colours outside the gamut lose their negative parts, as in every file for renderers. */
static void bands_to_srgb(worker *w, double rgb[3]) {
  double xyz[3] = {0.0};
  for (size_t b = 0; b < w->m->bands; b++)
    for (int c = 0; c < 3; c++)
      xyz[c] += w->m->weights[b][c] * w->bands[b];
  hetab_xyz_to_srgb(xyz, rgb);
  for (int c = 0; c < 3; c++)
    if (rgb[c] < 0.0) {
      rgb[c] = 0.0;
      w->clamped++;
    }
}

static void *work(void *argument) {
  worker *w = argument;
  size_t channels = w->m->weights ? 3 : w->m->bands;
  for (size_t i = 0; i < w->count; i++) {
    pair_bands(w->m, w->exact, &w->pairs[i], w->bands);
    if (w->m->weights)
      bands_to_srgb(w, w->values + i * channels);
    else
      memcpy(w->values + i * channels, w->bands, channels * sizeof *w->bands);
  }
  return NULL;
}

static size_t worker_count(size_t pairs) {
  long cores = sysconf(_SC_NPROCESSORS_ONLN);
  size_t most = cores > 1 ? (size_t)cores : 1, useful = pairs / WORKER_PAIRS + 1;
  most = most < MOST_WORKERS ? most : MOST_WORKERS;
  return useful < most ? useful : most;
}

/* The first share is the calling thread's; so is what no thread could be had for. */
static void run_workers(worker *workers, size_t count) {
  pthread_t threads[MOST_WORKERS];
  int started[MOST_WORKERS] = {0};
  for (size_t i = 1; i < count; i++)
    started[i] = pthread_create(&threads[i], NULL, work, &workers[i]) == 0;
  for (size_t i = 0; i < count; i++)
    if (!started[i])
      work(&workers[i]);
  for (size_t i = 1; i < count; i++)
    if (started[i])
      pthread_join(threads[i], NULL);
}

static hetab_status evaluate(hetab_context *ctx, hetab_rgl_model *m, int exact,
                             const hetab_rgl_pair *pairs, size_t count, double *values) {
  size_t number = worker_count(count), channels = m->weights ? 3 : m->bands;
  worker workers[MOST_WORKERS];
  double *bands = hetab_alloc(ctx, number * m->bands, sizeof *bands);
  if (!bands)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < number; i++) {
    size_t first = count * i / number, end = count * (i + 1) / number;
    workers[i] = (worker){.m = m,
                          .exact = exact,
                          .pairs = pairs + first,
                          .count = end - first,
                          .values = values + first * channels,
                          .bands = bands + i * m->bands};
  }
  run_workers(workers, number);
  for (size_t i = 0; i < number; i++)
    m->clamped += workers[i].clamped;
  free(bands);
  return HETAB_OK;
}

static hetab_status model_values(hetab_context *ctx, void *user, const hetab_rgl_pair *pairs,
                                 size_t count, double *values) {
  return evaluate(ctx, user, 0, pairs, count, values);
}

static hetab_status model_reference(hetab_context *ctx, void *user, const hetab_rgl_pair *pairs,
                                    size_t count, double *values) {
  return evaluate(ctx, user, 1, pairs, count, values);
}

/* ---- construction -------------------------------------------------------------------------- */

static double inverse_square(double lambda) {
  return 1.0 / (lambda * lambda);
}

/* Lagrange's polynomials of node k at t. */
static double lagrange(const double *node, size_t count, size_t k, double t) {
  double value = 1.0;
  for (size_t i = 0; i < count; i++)
    if (i != k)
      value *= (t - node[i]) / (node[k] - node[i]);
  return value;
}

/* Chebyshev's nodes in 1 / lambda^2 for many bands; the bands themselves for few. */
static void place_nodes(hetab_rgl_model *m) {
  const hetab_band *bands = hetab_surface_bands(m->surface);
  double sigma0 = hetab_surface_sigma0_um(m->surface), tau = hetab_surface_tau_um(m->surface);
  double low = inverse_square(bands[m->bands - 1].lambda_um), t[NODES];
  double high = inverse_square(bands[0].lambda_um);
  for (size_t k = 0; k < m->nodes; k++) {
    double place = cos(M_PI * ((double)k + 0.5) / (double)m->nodes);
    t[k] = m->nodes < m->bands ? 0.5 * (low + high) + 0.5 * (high - low) * place
                               : inverse_square(bands[k].lambda_um);
    hetab_band band = {.lambda_um = 1.0 / sqrt(t[k]), .n = 1.0};
    m->node_waves[k] = hetab_wave_of(sigma0, tau, &band);
  }
  for (size_t b = 0; b < m->bands; b++) {
    m->waves[b] = hetab_wave_of(sigma0, tau, &bands[b]);
    m->wavelengths_um[b] = bands[b].lambda_um;
    for (size_t k = 0; k < m->nodes; k++)
      m->interpolation[b * m->nodes + k] =
          lagrange(t, m->nodes, k, inverse_square(bands[b].lambda_um));
  }
}

static hetab_status model_allocate(hetab_context *ctx, int rgb, hetab_rgl_model *m) {
  m->bands = hetab_surface_band_count(m->surface);
  m->nodes = m->bands < NODES ? m->bands : NODES;
  m->waves = hetab_alloc(ctx, m->bands, sizeof *m->waves);
  m->node_waves = hetab_alloc(ctx, m->nodes, sizeof *m->node_waves);
  m->interpolation = hetab_alloc(ctx, m->bands * m->nodes, sizeof *m->interpolation);
  m->wavelengths_um = hetab_alloc(ctx, m->bands, sizeof *m->wavelengths_um);
  m->weights = rgb ? hetab_alloc(ctx, m->bands, sizeof *m->weights) : NULL;
  return m->waves && m->node_waves && m->interpolation && m->wavelengths_um && (m->weights || !rgb)
             ? HETAB_OK
             : HETAB_ERR_MEMORY;
}

static hetab_status model_fill(hetab_context *ctx, const hetab_surface *surface, int rgb,
                               hetab_rgl_model *m) {
  double sigma0 = hetab_surface_sigma0_um(surface), tau = hetab_surface_tau_um(surface);
  m->surface = surface;
  m->tau_2sigma = tau / (2.0 * sigma0);
  HETAB_TRY(hetab_check_surface(ctx, surface));
  HETAB_TRY(model_allocate(ctx, rgb, m));
  place_nodes(m);
  snprintf(m->description, sizeof m->description,
           "%.100s: sigma0 %g um, tau %g um; He-Torrance model, dd + ud, without the specular "
           "delta; hetab %s",
           hetab_surface_name(surface), sigma0, tau, hetab_version());
  m->source = (hetab_rgl_source){.channels = rgb ? 3 : m->bands,
                                 .wavelengths_um = rgb ? NULL : m->wavelengths_um,
                                 .description = m->description,
                                 .values = model_values,
                                 .reference = model_reference,
                                 .user = m};
  return rgb ? hetab_xyz_weights(ctx, m->wavelengths_um, m->bands, m->weights) : HETAB_OK;
}

hetab_status hetab_rgl_model_create(hetab_context *ctx, const hetab_surface *surface,
                                    hetab_rgl_bands bands, hetab_rgl_model **out) {
  *out = hetab_alloc(ctx, 1, sizeof **out);
  if (!*out)
    return HETAB_ERR_MEMORY;
  hetab_status status = model_fill(ctx, surface, bands == HETAB_RGL_RGB, *out);
  if (status != HETAB_OK) {
    hetab_rgl_model_free(*out);
    *out = NULL;
  }
  return status;
}

void hetab_rgl_model_free(hetab_rgl_model *m) {
  if (!m)
    return;
  free(m->waves);
  free(m->node_waves);
  free(m->interpolation);
  free(m->weights);
  free(m->wavelengths_um);
  free(m);
}

const hetab_rgl_source *hetab_rgl_model_source(const hetab_rgl_model *m) {
  return &m->source;
}

/* ---- tables of it -------------------------------------------------------------------------- */

static hetab_status too_coarse(hetab_context *ctx, const hetab_surface *surface,
                               const hetab_rgl_report *report) {
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "surface '%s' as an RGL table: the error is %.2g even at %zu incidences and "
                    "%zu x %zu nodes; allow a table error of %.2g, or use another format",
                    hetab_surface_name(surface), report->error_l1, report->theta_i_count,
                    report->resolution, report->resolution, 1.1 * report->error_l1);
}

static hetab_status check_bands(hetab_context *ctx, const hetab_surface *surface,
                                hetab_rgl_bands bands) {
  size_t count = hetab_surface_band_count(surface);
  if (bands == HETAB_RGL_RGB || count <= HETAB_RGL_MOST_WAVELENGTHS)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "%zu wavelengths in an RGL table: at most %d can be read back; choose fewer",
                    count, HETAB_RGL_MOST_WAVELENGTHS);
}

hetab_status hetab_tabulate_rgl(hetab_context *ctx, const hetab_surface *surface,
                                const hetab_rgl_options *options, hetab_rgl **out,
                                hetab_rgl_report *report) {
  hetab_rgl_options o = options ? *options : (hetab_rgl_options){0};
  hetab_rgl_report own;
  hetab_rgl_model *m;
  hetab_status status;
  report = report ? report : &own;
  *out = NULL;
  HETAB_TRY(check_bands(ctx, surface, o.bands));
  HETAB_TRY(hetab_rgl_model_create(ctx, surface, o.bands, &m));
  HETAB_GOTO(hetab_rgl_build(ctx, &m->source, &o, out, report));
  if (m->clamped) { /* in any of the tables that were tried: count those of this one */
    m->clamped = 0;
    HETAB_GOTO(hetab_rgl_fill(ctx, &m->source, *out));
  }
  report->clamped = m->clamped;
  if (report->error_l1 > report->target)
    status = too_coarse(ctx, surface, report);
done:
  hetab_rgl_model_free(m);
  if (status != HETAB_OK) {
    hetab_rgl_free(*out);
    *out = NULL;
  }
  return status;
}
