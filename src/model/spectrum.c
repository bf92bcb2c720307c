#include "model/spectrum.h"

#include <math.h>
#include <stdlib.h>

#include "model/universal.h"

enum {
  COUNT = HETAB_SPLINE_COUNT,
  CELLS = HETAB_SPLINE_CELLS,
  LANES = HETAB_SPECTRUM_LANES,
  NODES = 8,
  FRESNEL = 512 /* intervals over cos(theta_d) */
};

/* ln h at node k, of the reference wavelength's g and x, v = x / (1 + g):
 *   a[s][k] - v (1 + r[s][t][k]) - 2 ln(1 + g). */
struct hetab_spectrum {
  size_t bands, padded;
  double g, x; /* of the reference wavelength */
  float a[COUNT][NODES], r[COUNT][COUNT][NODES];
  float *interpolation; /* [NODES][padded], from nodes to wavelengths */
  float *ln_amplitude;  /* [padded] */
  float *diffuse;       /* [padded], 1/sr */
  float *fresnel;       /* [FRESNEL + 1][padded] */
};

/* ---- construction -------------------------------------------------------------------------- */

static double inverse_square(double lambda) {
  return 1.0 / (lambda * lambda);
}

/* Lagrange's polynomial of node k at t. */
static double lagrange(const double *node, int k, double t) {
  double value = 1.0;
  for (int i = 0; i < NODES; i++)
    if (i != k)
      value *= (t - node[i]) / (node[k] - node[i]);
  return value;
}

/* Chebyshev's nodes in 1 / lambda^2, over the reference's; a single wavelength is its own. */
static void place_nodes(const hetab_band *bands, size_t count, double reference, double *node) {
  double low = inverse_square(bands[count - 1].lambda_um) / reference;
  double high = fmax(inverse_square(bands[0].lambda_um) / reference, low * (1.0 + 1e-3));
  for (int k = 0; k < NODES; k++)
    node[k] = 0.5 * (low + high) + 0.5 * (high - low) * cos(M_PI * (k + 0.5) / NODES);
}

/* The places along s: g of the reference; at s = 1 one so large that h is its limit. */
static void fill_row(int i, const double *node, double *a, double (*r)[NODES]) {
  double g = hetab_universal_g(fmin(hetab_spline_place(i) / CELLS, 1.0 - 1e-9));
  for (int k = 0; k < NODES; k++) {
    double top = hetab_universal_ln_h(g * node[k], 0.0);
    a[k] = top + 2.0 * log1p(g);
    for (int j = 0; j < COUNT; j++) {
      double t = hetab_spline_place(j) / CELLS * HETAB_UNIVERSAL_MOST_T;
      double v = fmax(hetab_universal_v(t), 1e-6);
      r[j][k] = (top - hetab_universal_ln_h(g * node[k], v * (1.0 + g) * node[k])) / v - 1.0;
    }
  }
}

static hetab_status fill_ln_h(hetab_context *ctx, const double *node, hetab_spectrum *s) {
  double(*r)[COUNT][NODES] = hetab_alloc(ctx, COUNT, sizeof *r), a[COUNT][NODES];
  HETAB_NEED(r);
  for (int i = 0; i < COUNT; i++)
    fill_row(i, node, a[i], r[i]);
  hetab_spline_fit(a[0], NODES, NODES);
  hetab_spline_fit(r[0][0], COUNT * NODES, COUNT * NODES);
  for (int i = 0; i < COUNT; i++)
    hetab_spline_fit(r[i][0], NODES, NODES);
  for (int i = 0; i < COUNT; i++)
    for (int k = 0; k < NODES; k++) {
      s->a[i][k] = (float)a[i][k];
      for (int j = 0; j < COUNT; j++)
        s->r[i][j][k] = (float)r[i][j][k];
    }
  free(r);
  return HETAB_OK;
}

static void fill_band(const hetab_surface *surface, size_t b, const double *node, double reference,
                      hetab_spectrum *s) {
  const hetab_band *band = &hetab_surface_bands(surface)[b];
  hetab_wave wave =
      hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), band);
  for (int k = 0; k < NODES; k++)
    s->interpolation[(size_t)k * s->padded + b] =
        (float)lagrange(node, k, inverse_square(band->lambda_um) / reference);
  s->ln_amplitude[b] = (float)log(wave.amplitude);
  s->diffuse[b] = (float)wave.diffuse_brdf;
  for (size_t i = 0; i <= FRESNEL; i++) {
    double c = (double)i / FRESNEL;
    s->fresnel[i * s->padded + b] = (float)hetab_fresnel_at(c * c, band->n, band->k);
  }
}

static hetab_status fill(hetab_context *ctx, const hetab_surface *surface, hetab_spectrum *s) {
  const hetab_band *bands = hetab_surface_bands(surface);
  double node[NODES], first = inverse_square(bands[0].lambda_um);
  s->bands = hetab_surface_band_count(surface);
  s->padded = (s->bands + LANES - 1) / LANES * LANES;
  s->interpolation = hetab_alloc(ctx, NODES * s->padded, sizeof(float));
  s->ln_amplitude = hetab_alloc(ctx, s->padded, sizeof(float));
  s->diffuse = hetab_alloc(ctx, s->padded, sizeof(float));
  s->fresnel = hetab_alloc(ctx, (FRESNEL + 1) * s->padded, sizeof(float));
  HETAB_NEED(s->interpolation && s->ln_amplitude && s->diffuse && s->fresnel);
  double reference = sqrt(first * inverse_square(bands[s->bands - 1].lambda_um));
  hetab_band middle = {.lambda_um = 1.0 / sqrt(reference), .n = 1.0};
  hetab_wave wave =
      hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), &middle);
  s->g = wave.g;
  s->x = wave.x;
  place_nodes(bands, s->bands, reference, node);
  for (size_t b = 0; b < s->bands; b++)
    fill_band(surface, b, node, reference, s);
  return fill_ln_h(ctx, node, s);
}

hetab_status hetab_spectrum_create(hetab_context *ctx, const hetab_surface *surface,
                                   hetab_spectrum **out) {
  hetab_status status = HETAB_ERR_MEMORY;
  *out = hetab_alloc(ctx, 1, sizeof **out);
  if (*out)
    status = fill(ctx, surface, *out);
  HETAB_MADE(hetab_spectrum, out, status);
}

void hetab_spectrum_free(hetab_spectrum *s) {
  if (!s)
    return;
  free(s->interpolation);
  free(s->ln_amplitude);
  free(s->diffuse);
  free(s->fresnel);
  free(s);
}

size_t hetab_spectrum_padded(const hetab_spectrum *s) {
  return s->padded;
}

/* ---- evaluation ---------------------------------------------------------------------------- */

static void ln_h_at_nodes(const hetab_spectrum *s, double g, double x, float node[NODES]) {
  double v = x / (1.0 + g), ws[4], wt[4];
  int i = hetab_spline_weights(hetab_universal_s(g) * CELLS, ws);
  int j = hetab_spline_weights(hetab_universal_part(v) * CELLS, wt);
  float a[NODES] = {0.0f}, r[NODES] = {0.0f}, level = (float)(-2.0 * log1p(g) - v);
  for (int ks = 0; ks < 4; ks++) {
    for (int k = 0; k < NODES; k++)
      a[k] += (float)ws[ks] * s->a[i + ks][k];
    for (int kt = 0; kt < 4; kt++) {
      float w = (float)(ws[ks] * wt[kt]);
      const float *from = s->r[i + ks][j + kt];
      for (int k = 0; k < NODES; k++)
        r[k] += w * from[k];
    }
  }
  for (int k = 0; k < NODES; k++)
    node[k] = a[k] - (float)v * r[k] + level;
}

void hetab_spectrum_eval(const hetab_spectrum *s, const hetab_pair *pair, double one_plus_cos,
                         float *values) {
  double lateral2 = pair->d2 + pair->p * one_plus_cos;
  double cos2 = fmin(0.25 * (pair->mu2 + lateral2), 1.0), place = sqrt(cos2) * FRESNEL;
  size_t row = place < FRESNEL - 1 ? (size_t)place : FRESNEL - 1;
  const float *low = s->fresnel + row * s->padded, *high = low + s->padded;
  float node[NODES], part = (float)(place - (double)row);
  float factor = (float)(cos2 * cos2 * pair->shadow);
  ln_h_at_nodes(s, s->g * pair->mu2 * pair->ratio2, s->x * lateral2, node);
  for (size_t b = 0; b < s->padded; b += LANES) {
    float ln[LANES];
    for (size_t l = 0; l < LANES; l++)
      ln[l] = s->ln_amplitude[b + l];
    for (size_t k = 0; k < NODES; k++)
      for (size_t l = 0; l < LANES; l++)
        ln[l] += s->interpolation[k * s->padded + b + l] * node[k];
    for (size_t l = 0; l < LANES; l++)
      ln[l] = expf(ln[l]);
    for (size_t l = 0; l < LANES; l++)
      values[b + l] =
          factor * ln[l] * (low[b + l] + part * (high[b + l] - low[b + l])) + s->diffuse[b + l];
  }
}
