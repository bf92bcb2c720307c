/* Reading RGL tables as the renderers do. m is the half vector; u_m its place in the unit square,
 * the azimuth relative to the light's; s the uniform point that the vndf's warp takes to u_m. Then
 *   f cos(theta_o) = spectra(s) ndf(u_m) / (4 sigma(u_wi)). */
#include "core/angle.h"
#include "rgl/rgl_internal.h"
#include "rgl/rgl_look.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float pi = 3.14159265358979323846f;

float hetab_rgl_theta_to_u(float theta) {
  return sqrtf(theta * (2.0f / pi));
}

double hetab_rgl_u_to_theta(double u) {
  return M_PI_2 * u * u;
}

float hetab_rgl_elevation(const float w[3]) {
  float half = 0.5f * sqrtf(w[0] * w[0] + w[1] * w[1] + (w[2] - 1.0f) * (w[2] - 1.0f));
  return 2.0f * asinf(half < 1.0f ? half : 1.0f);
}

/* ---- blends -------------------------------------------------------------------------------- */

/* The interval of ascending values[count] around x: its start, and the weight of its end. */
static size_t bracket(const float *values, size_t count, float x, float *weight) {
  size_t low = 0, high = count - 1;
  *weight = 0.0f;
  if (count == 1)
    return 0;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (values[middle] < x)
      low = middle;
    else
      high = middle;
  }
  float t = (x - values[low]) / (values[high] - values[low]);
  *weight = t > 0.0f ? (t < 1.0f ? t : 1.0f) : 0.0f;
  return low;
}

static void blend_add(hetab_blend *blend, size_t slice, float weight) {
  if (weight > 0.0f) {
    blend->slice[blend->count] = slice;
    blend->weight[blend->count++] = weight;
  }
}

hetab_blend hetab_rgl_blend(const hetab_rgl *rgl, float theta_i, float phi_i) {
  hetab_blend blend = {0};
  float w_theta, w_phi;
  size_t k = bracket(rgl->theta_i, rgl->theta_i_count, theta_i, &w_theta);
  size_t p = bracket(rgl->phi_i, rgl->phi_i_count, phi_i, &w_phi) * rgl->theta_i_count;
  blend_add(&blend, p + k, (1.0f - w_phi) * (1.0f - w_theta));
  blend_add(&blend, p + k + 1, (1.0f - w_phi) * w_theta);
  blend_add(&blend, p + rgl->theta_i_count + k, w_phi * (1.0f - w_theta));
  blend_add(&blend, p + rgl->theta_i_count + k + 1, w_phi * w_theta);
  return blend;
}

/* ---- a pair of directions ------------------------------------------------------------------ */

/* What eval, sample and pdf know of the incidence. */
typedef struct incidence {
  float theta, phi;
  hetab_blend blend;
} incidence;

static incidence incidence_of(const hetab_rgl *rgl, const float wi[3]) {
  incidence in = {.theta = hetab_rgl_elevation(wi), .phi = atan2f(wi[1], wi[0])};
  in.blend = hetab_rgl_blend(rgl, in.theta, in.phi);
  return in;
}

static float dot(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* 0 if there is none: directions that are opposite to float's last digit. */
static int half_vector(const float wi[3], const float wo[3], float m[3]) {
  for (int c = 0; c < 3; c++)
    m[c] = wi[c] + wo[c];
  float length = sqrtf(dot(m, m));
  for (int c = 0; c < 3; c++)
    m[c] /= length;
  return length > 0.0f;
}

static void place_of(const float m[3], float phi_i, float u[2]) {
  float turn = (atan2f(m[1], m[0]) - phi_i + pi) * (0.5f / pi);
  u[0] = hetab_rgl_theta_to_u(hetab_rgl_elevation(m));
  u[1] = turn - floorf(turn);
}

/* |d(directions of wo) / du_m|. */
static float jacobian(const float wi[3], const float m[3], float u_theta) {
  float sine = sqrtf(m[0] * m[0] + m[1] * m[1]);
  float area = 2.0f * pi * pi * u_theta * sine;
  return (area > 1e-6f ? area : 1e-6f) * 4.0f * dot(wi, m);
}

static float map_value(const hetab_rgl_map *map, const float u[2]) {
  hetab_cell cell = hetab_cell_at(map->width, map->height, u);
  return hetab_cell_value(&cell, map->nodes, map->width);
}

/* ---- the public functions ------------------------------------------------------------------ */

size_t hetab_rgl_channel_count(const hetab_rgl *rgl) {
  return rgl->channels;
}

const double *hetab_rgl_wavelengths_um(const hetab_rgl *rgl) {
  return rgl->wavelengths_um;
}

size_t hetab_rgl_negative(const hetab_rgl *rgl) {
  return rgl->negative;
}

double hetab_rgl_specular_cone(const hetab_rgl *rgl) {
  return hetab_radians((double)rgl->specular_cone_deg);
}

static float spectrum_at(const hetab_rgl *rgl, const hetab_blend *blend, const hetab_cell *cell,
                         size_t channel) {
  size_t nodes = rgl->resolution * rgl->resolution;
  float sum = 0.0f;
  for (size_t k = 0; k < blend->count; k++) {
    const float *slice = rgl->spectra + (blend->slice[k] * rgl->channels + channel) * nodes;
    sum += blend->weight[k] * hetab_cell_value(cell, slice, rgl->resolution);
  }
  return sum;
}

/* A pair of directions by the table's maps. */
typedef struct place {
  incidence in;
  float m[3], u_m[2], s[2];
  float density; /* of the vndf at u_m */
} place;

static int place_pair(const hetab_rgl *rgl, const float wi[3], const float wo[3], place *p) {
  if (!(wi[2] > 0.0f && wo[2] > 0.0f && half_vector(wi, wo, p->m)))
    return 0;
  p->in = incidence_of(rgl, wi);
  place_of(p->m, p->in.phi, p->u_m);
  p->density = hetab_warp_invert(&rgl->vndf, &p->in.blend, p->u_m, p->s);
  return 1;
}

static float factor_of(const hetab_rgl *rgl, const place *p) {
  if (!rgl->jacobian)
    return 1.0f;
  float u_wi[2] = {hetab_rgl_theta_to_u(p->in.theta), (p->in.phi + pi) * (0.5f / pi)};
  return fminf(map_value(&rgl->ndf, p->u_m) / (4.0f * map_value(&rgl->sigma, u_wi)), FLT_MAX);
}

float hetab_rgl_place(const hetab_rgl *rgl, const float wi[3], const float wo[3],
                      hetab_blend *blend, hetab_cell *cell) {
  place p;
  if (!place_pair(rgl, wi, wo, &p))
    return 0.0f;
  *blend = p.in.blend;
  *cell = hetab_cell_at(rgl->resolution, rgl->resolution, p.s);
  return factor_of(rgl, &p);
}

static void values_of(const hetab_rgl *rgl, const place *p, float mu,
                      const hetab_band_places *places, float *value) {
  hetab_cell cell = hetab_cell_at(rgl->resolution, rgl->resolution, p->s);
  float factor = fminf(fminf(1.0f / mu, FLT_MAX) * factor_of(rgl, p), FLT_MAX);
  size_t count = places ? places->count : rgl->channels;
  for (size_t i = 0; i < count; i++) {
    size_t first = places ? places->first[i] : i;
    float at = spectrum_at(rgl, &p->in.blend, &cell, first);
    if (places && places->fraction[i] > 0.0f)
      at += places->fraction[i] * (spectrum_at(rgl, &p->in.blend, &cell, first + 1) - at);
    value[i] = factor > 0.0f ? fminf(factor * at, FLT_MAX) : 0.0f;
  }
}

void hetab_rgl_look(const hetab_rgl *rgl, const float wi[3], const float wo[3],
                    const hetab_band_places *places, float *value, float *pdf) {
  place p;
  int found = place_pair(rgl, wi, wo, &p);
  if (value && found)
    values_of(rgl, &p, wo[2], places, value);
  else if (value)
    memset(value, 0, (places ? places->count : rgl->channels) * sizeof *value);
  if (pdf && found)
    *pdf = fminf(p.density * hetab_warp_density(&rgl->luminance, &p.in.blend, p.s) /
                     jacobian(wi, p.m, p.u_m[0]),
                 FLT_MAX);
  else if (pdf)
    *pdf = 0.0f;
}

void hetab_rgl_eval(const hetab_rgl *rgl, const float wi[3], const float wo[3], float *value) {
  hetab_rgl_look(rgl, wi, wo, NULL, value, NULL);
}

float hetab_rgl_pdf(const hetab_rgl *rgl, const float wi[3], const float wo[3]) {
  float pdf;
  hetab_rgl_look(rgl, wi, wo, NULL, NULL, &pdf);
  return pdf;
}

float hetab_rgl_sample(const hetab_rgl *rgl, const float wi[3], const float u[2], float wo[3]) {
  float turned[2] = {u[1], u[0]}, s[2], u_m[2]; /* the first number chooses the row */
  wo[0] = wo[1] = wo[2] = 0.0f;
  if (!(wi[2] > 0.0f))
    return 0.0f;
  incidence in = incidence_of(rgl, wi);
  float density = hetab_warp_sample(&rgl->luminance, &in.blend, turned, s);
  density *= hetab_warp_sample(&rgl->vndf, &in.blend, s, u_m);
  float theta = 0.5f * pi * u_m[0] * u_m[0], phi = (2.0f * u_m[1] - 1.0f) * pi + in.phi;
  float m[3] = {sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)};
  float along = 2.0f * dot(wi, m);
  for (int c = 0; c < 3; c++)
    wo[c] = along * m[c] - wi[c];
  if (!(wo[2] > 0.0f && along > 0.0f))
    return 0.0f;
  return fminf(density / jacobian(wi, m, u_m[0]), FLT_MAX);
}

void hetab_rgl_free(hetab_rgl *rgl) {
  if (!rgl)
    return;
  free(rgl->description);
  free(rgl->phi_i);
  free(rgl->theta_i);
  free(rgl->ndf.nodes);
  free(rgl->sigma.nodes);
  hetab_warp_clear(&rgl->vndf);
  hetab_warp_clear(&rgl->luminance);
  free(rgl->wavelengths_um);
  free(rgl->spectra);
  free(rgl);
}
