/* The model as a source of RGL tables, and the tables made of it, on the host and on all cores: in
 * float with the universal table of the series (model/spectrum.h) where a sample says that this
 * keeps far below the table's error, else with the series in double. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/each.h"
#include "core/option_size.h"
#include "core/random.h"
#include "model/colour.h"
#include "model/fold.h"
#include "model/limits.h"
#include "model/spectrum.h"
#include "rgl/rgl_internal.h"
#include "rgl/rgl_model.h"
#include "rgl/rgl_table.h"

enum { BLOCK = 64 }; /* pairs, of up to 4096 bands: half a second at most */

struct hetab_rgl_model {
  const hetab_surface *surface;
  double tau_2sigma;
  size_t bands;
  hetab_spectrum *spectrum; /* NULL: the series */
  hetab_wave *waves;        /* [bands] */
  hetab_fold *fold;         /* NULL: the delta is left out */
  double (*weights)[3];     /* to linear sRGB; NULL: the bands themselves */
  double *wavelengths_um;
  char description[320];
  size_t clamped; /* values of linear sRGB below 0, set to 0 */
  hetab_rgl_source source;
};

typedef struct worker {
  const hetab_rgl_model *m;
  const hetab_spectrum *spectrum; /* NULL: the series */
  float *bands;                   /* [padded] */
  double *exact;                  /* [m->bands] */
  size_t clamped;
} worker;

typedef struct evaluation {
  const hetab_directions *pairs;
  size_t count;
  double *values; /* [count][channels] */
  worker workers[HETAB_MOST_WORKERS];
} evaluation;

/* ---- a pair's bands ------------------------------------------------------------------------ */

/* dd + ud of every band, by the series. */
static void series_bands(const hetab_rgl_model *m, const hetab_pair *p, double one_plus_cos,
                         double *out) {
  const hetab_band *bands = hetab_surface_bands(m->surface);
  double lateral2 = p->d2 + p->p * one_plus_cos, g = p->mu2 * p->ratio2;
  double cos2_d = fmin(0.25 * (p->mu2 + lateral2), 1.0);
  for (size_t b = 0; b < m->bands; b++) {
    const hetab_wave *wave = &m->waves[b];
    out[b] = hetab_fresnel_at(cos2_d, bands[b].n, bands[b].k) * cos2_d * cos2_d * wave->amplitude *
                 p->shadow * exp(hetab_ln_h(wave->g * g, wave->x * lateral2)) +
             wave->diffuse_brdf;
  }
}

static void pair_bands(worker *w, const hetab_pair *pair, double one_plus_cos) {
  if (!w->spectrum) {
    series_bands(w->m, pair, one_plus_cos, w->exact);
    return;
  }
  hetab_spectrum_eval(w->spectrum, pair, one_plus_cos, w->bands);
  for (size_t b = 0; b < w->m->bands; b++)
    w->exact[b] = (double)w->bands[b];
}

/* Colours outside the gamut lose their negative parts, as in every file for renderers. */
static void bands_to_srgb(worker *w, double rgb[3]) {
  rgb[0] = rgb[1] = rgb[2] = 0.0;
  for (size_t b = 0; b < w->m->bands; b++)
    for (int c = 0; c < 3; c++)
      rgb[c] += w->m->weights[b][c] * w->exact[b];
  for (int c = 0; c < 3; c++)
    if (rgb[c] < 0.0) {
      rgb[c] = 0.0;
      w->clamped++;
    }
}

/* The sum over channels of rho_s. */
static double model_specular(void *user, double theta_i) {
  hetab_rgl_model *m = user;
  hetab_direction in = hetab_direction_at(theta_i, m->tau_2sigma);
  double sum = 0.0;
  for (size_t b = 0; b < m->bands; b++) {
    const double *weight = m->weights ? m->weights[b] : NULL;
    sum += hetab_specular(&in, &m->waves[b]) * (weight ? weight[0] + weight[1] + weight[2] : 1.0);
  }
  return sum;
}

static void work(void *user, size_t block, int thread) {
  evaluation *e = user;
  worker *w = &e->workers[thread];
  size_t channels = w->m->source.channels, first = block * BLOCK;
  size_t end = first + BLOCK < e->count ? first + BLOCK : e->count;
  hetab_direction in = hetab_direction_at(0.0, w->m->tau_2sigma);
  for (size_t i = first; i < end; i++) {
    const hetab_directions *pair = &e->pairs[i];
    if (pair->theta_i != in.theta) /* slices have one */
      in = hetab_direction_at(pair->theta_i, w->m->tau_2sigma);
    hetab_direction to = hetab_direction_at(pair->theta_r, w->m->tau_2sigma);
    hetab_pair p = hetab_pair_of(&in, &to);
    double one_plus_cos = hetab_one_plus_cos(pair->phi);
    pair_bands(w, &p, one_plus_cos);
    if (w->m->fold)
      hetab_fold_add(w->m->fold, pair->theta_i, pair->theta_r, hetab_sin2_h(&p, one_plus_cos),
                     w->exact);
    if (w->m->weights)
      bands_to_srgb(w, e->values + i * channels);
    else
      memcpy(e->values + i * channels, w->exact, channels * sizeof *w->exact);
  }
}

static hetab_status evaluate(hetab_context *ctx, hetab_rgl_model *m, const hetab_spectrum *spectrum,
                             const hetab_directions *pairs, size_t count, double *values) {
  size_t number = (size_t)hetab_worker_count();
  size_t padded = spectrum ? hetab_spectrum_padded(spectrum) : 0;
  evaluation e = {.pairs = pairs, .count = count, .values = values};
  double *exact = hetab_alloc(ctx, number * m->bands, sizeof *exact);
  float *bands = hetab_alloc(ctx, number * padded + 1, sizeof *bands);
  hetab_status status = exact && bands ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t i = 0; i < number && status == HETAB_OK; i++)
    e.workers[i] = (worker){
        .m = m, .spectrum = spectrum, .bands = bands + i * padded, .exact = exact + i * m->bands};
  if (status == HETAB_OK)
    status = hetab_each_within(ctx, (count + BLOCK - 1) / BLOCK, work, &e);
  for (size_t i = 0; i < number && status == HETAB_OK; i++)
    m->clamped += e.workers[i].clamped;
  free(exact);
  free(bands);
  return status;
}

static hetab_status model_values(hetab_context *ctx, void *user, const hetab_directions *pairs,
                                 size_t count, double *values) {
  hetab_rgl_model *m = user;
  return evaluate(ctx, m, m->spectrum, pairs, count, values);
}

/* ---- construction -------------------------------------------------------------------------- */

/* The share of the light that float and interpolation misplace, over `count` pairs, most of them
 * about the mirror direction. */
static hetab_status spectrum_error(hetab_context *ctx, hetab_rgl_model *m, size_t count,
                                   double *error) {
  hetab_directions *pairs = hetab_alloc(ctx, count, sizeof *pairs);
  size_t numbers = count * m->source.channels;
  double *values = hetab_alloc(ctx, 2 * numbers, sizeof *values), sum = 0.0;
  uint64_t state = 1;
  hetab_status status;
  HETAB_GOTO(pairs && values ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t i = 0; i < count; i++) {
    double theta = hetab_radians(85.0) * hetab_random_unit(&state);
    double away = i % 4 ? 0.3 * hetab_random_unit(&state) - 0.15 : M_PI * hetab_random_unit(&state);
    double theta_r = fmin(fabs(theta + away), M_PI - fabs(theta + away));
    pairs[i] = (hetab_directions){theta, fmin(theta_r, 1.55), M_PI + away};
  }
  HETAB_GOTO(evaluate(ctx, m, m->spectrum, pairs, count, values));
  HETAB_GOTO(evaluate(ctx, m, NULL, pairs, count, values + numbers));
  *error = 0.0;
  for (size_t i = 0; i < numbers; i++) {
    double cosine = cos(pairs[i / m->source.channels].theta_r);
    *error += cosine * fabs(values[i] - values[numbers + i]);
    sum += cosine * values[numbers + i];
  }
  *error = sum > 0.0 ? *error / sum : 0.0;
done:
  free(pairs);
  free(values);
  return status;
}

/* The series in place of the spectrum where that could show. The same for every table of a
 * surface, so that asking for less never changes its values. */
static hetab_status check_spectrum(hetab_context *ctx, hetab_rgl_model *m) {
  const double allowed = 1e-4;
  double error;
  HETAB_TRY(spectrum_error(ctx, m, 128, &error));
  m->clamped = 0;
  if (error <= allowed)
    return HETAB_OK;
  hetab_spectrum_free(m->spectrum);
  m->spectrum = NULL;
  return HETAB_OK;
}

static hetab_status model_allocate(hetab_context *ctx, int rgb, hetab_rgl_model *m) {
  m->bands = hetab_surface_band_count(m->surface);
  m->waves = hetab_alloc(ctx, m->bands, sizeof *m->waves);
  m->wavelengths_um = hetab_alloc(ctx, m->bands, sizeof *m->wavelengths_um);
  m->weights = rgb ? hetab_alloc(ctx, m->bands, sizeof *m->weights) : NULL;
  return m->waves && m->wavelengths_um && (m->weights || !rgb) ? HETAB_OK : HETAB_ERR_MEMORY;
}

static hetab_status fold_in(hetab_context *ctx, double cone, hetab_rgl_model *m) {
  if (!(cone > 0.0))
    return HETAB_OK;
  HETAB_TRY(hetab_fold_check(ctx, cone, hetab_rgl_u_to_theta(2.0 / (HETAB_RGL_MOST_NODES - 1)),
                             "an RGL table's finest nodes"));
  m->source.specular = NULL;
  m->source.specular_cone_deg = hetab_degrees(cone);
  return hetab_fold_create(ctx, m->surface, hetab_surface_bands(m->surface), m->bands, cone,
                           &m->fold);
}

static void describe(double cone, hetab_rgl_model *m) {
  char delta[80] = "without the specular delta";
  if (cone > 0.0)
    snprintf(delta, sizeof delta, "the specular delta folded in as a lobe of %g degrees",
             hetab_degrees(cone));
  snprintf(m->description, sizeof m->description,
           "%.100s: sigma0 %g um, tau %g um; He-Torrance model, dd + ud, %s; hetab %s",
           hetab_surface_name(m->surface), hetab_surface_sigma0_um(m->surface),
           hetab_surface_tau_um(m->surface), delta, hetab_version());
}

static hetab_status model_fill(hetab_context *ctx, const hetab_surface *surface,
                               const hetab_rgl_options *options, hetab_rgl_model *m) {
  int rgb = options->bands == HETAB_RGL_RGB;
  double sigma0 = hetab_surface_sigma0_um(surface), tau = hetab_surface_tau_um(surface);
  m->surface = surface;
  m->tau_2sigma = tau / (2.0 * sigma0);
  HETAB_TRY(hetab_check_surface(ctx, surface));
  HETAB_TRY(model_allocate(ctx, rgb, m));
  for (size_t b = 0; b < m->bands; b++) {
    m->waves[b] = hetab_wave_of(sigma0, tau, &hetab_surface_bands(surface)[b]);
    m->wavelengths_um[b] = hetab_surface_bands(surface)[b].lambda_um;
  }
  describe(options->specular_cone, m);
  m->source = (hetab_rgl_source){.channels = rgb ? 3 : m->bands,
                                 .wavelengths_um = rgb ? NULL : m->wavelengths_um,
                                 .description = m->description,
                                 .values = model_values,
                                 .specular = model_specular,
                                 .user = m};
  if (rgb)
    HETAB_TRY(hetab_srgb_weights(ctx, m->wavelengths_um, m->bands, m->weights));
  HETAB_TRY(hetab_spectrum_create(ctx, surface, &m->spectrum));
  HETAB_TRY(check_spectrum(ctx, m));
  return fold_in(ctx, options->specular_cone, m);
}

hetab_status hetab_rgl_model_create(hetab_context *ctx, const hetab_surface *surface,
                                    const hetab_rgl_options *options, hetab_rgl_model **out) {
  *out = hetab_alloc(ctx, 1, sizeof **out);
  if (!*out)
    return HETAB_ERR_MEMORY;
  hetab_status status = model_fill(ctx, surface, options, *out);
  if (status != HETAB_OK) {
    hetab_rgl_model_free(*out);
    *out = NULL;
  }
  return status;
}

void hetab_rgl_model_free(hetab_rgl_model *m) {
  if (!m)
    return;
  hetab_spectrum_free(m->spectrum);
  free(m->waves);
  free(m->weights);
  free(m->wavelengths_um);
  hetab_fold_free(m->fold);
  free(m);
}

const hetab_rgl_source *hetab_rgl_model_source(const hetab_rgl_model *m) {
  return &m->source;
}

/* ---- tables of it -------------------------------------------------------------------------- */

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
  HETAB_OPTIONS(ctx, hetab_rgl_options, o, options);
  hetab_rgl_report own;
  hetab_rgl_model *m;
  hetab_status status;
  report = report ? report : &own;
  *out = NULL;
  HETAB_TRY(check_bands(ctx, surface, o.bands));
  HETAB_TRY(hetab_rgl_model_create(ctx, surface, &o, &m));
  HETAB_GOTO(hetab_rgl_build(ctx, &m->source, &o, out, report));
  if (m->clamped) { /* in any of the tables that were tried: count those of this one */
    m->clamped = 0;
    HETAB_GOTO(hetab_rgl_fill(ctx, &m->source, *out));
  }
  report->clamped = m->clamped;
done:
  hetab_rgl_model_free(m);
  if (status != HETAB_OK) {
    hetab_rgl_free(*out);
    *out = NULL;
  }
  return status;
}
