#include "rgl/rgl_smooth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rgl/rgl_internal.h"
#include "rgl/rgl_table.h"

static float node_cosine(const hetab_rgl *rgl, const hetab_blend *own, double theta_i, size_t x,
                         size_t y) {
  float last = (float)(rgl->resolution - 1), u_m[2];
  float s[2] = {hetab_rgl_column_place(x, rgl->resolution), (float)y / last};
  hetab_warp_sample(&rgl->vndf, own, s, u_m);
  double theta = hetab_rgl_u_to_theta((double)u_m[0]), phi = (2.0 * (double)u_m[1] - 1.0) * M_PI;
  double along = sin(theta_i) * sin(theta) * cos(phi) + cos(theta_i) * cos(theta);
  return (float)(2.0 * along * cos(theta) - cos(theta_i));
}

hetab_status hetab_rgl_smooth_create(hetab_context *ctx, const hetab_rgl *rgl,
                                     hetab_rgl_smooth *out) {
  size_t n = rgl->resolution, slices = rgl->phi_i_count * rgl->theta_i_count;
  *out = (hetab_rgl_smooth){.rgl = rgl};
  out->cosine = hetab_alloc(ctx, slices * n * n, sizeof *out->cosine);
  HETAB_NEED(out->cosine);
  for (size_t k = 0; k < slices; k++) {
    hetab_blend own = {1, {k}, {1.0f}};
    double theta_i = hetab_rgl_slice_theta(rgl, k % rgl->theta_i_count);
    for (size_t y = 0; y < n; y++)
      for (size_t x = 0; x < n; x++)
        out->cosine[(k * n + y) * n + x] = node_cosine(rgl, &own, theta_i, x, y);
  }
  return HETAB_OK;
}

void hetab_rgl_smooth_clear(hetab_rgl_smooth *smooth) {
  free(smooth->cosine);
  *smooth = (hetab_rgl_smooth){0};
}

/* The nodes about a place, of every slice: where they are, and what they weigh, over the cosine. */
typedef struct nodes {
  size_t count, at[16];
  float lowest; /* cosine */
  float weight[16];
} nodes;

/* Nodes this near the horizon are left out: they stand for what is on either side of it. Where all
 * are this far above it, the readers' rule is the better one. */
static const float least_cosine = 0.01f, steep_cosine = 0.3f;

static void find_nodes(const hetab_rgl_smooth *s, const hetab_blend *blend, const hetab_cell *cell,
                       nodes *out) {
  size_t n = s->rgl->resolution;
  float whole = 0.0f;
  out->count = 0;
  out->lowest = 1.0f;
  for (size_t k = 0; k < blend->count; k++)
    for (size_t corner = 0; corner < 4; corner++) {
      size_t x = cell->x + (corner & 1), y = cell->y + (corner >> 1);
      size_t at = (y * n + x), slice = blend->slice[k];
      float wx = corner & 1 ? cell->tx : 1.0f - cell->tx;
      float weight = blend->weight[k] * wx * (corner >> 1 ? cell->ty : 1.0f - cell->ty);
      float cosine = s->cosine[slice * n * n + at];
      out->lowest = fminf(out->lowest, cosine);
      if (!(cosine > least_cosine))
        continue;
      whole += weight;
      out->at[out->count] = slice * s->rgl->channels * n * n + at;
      out->weight[out->count++] = weight / cosine;
    }
  for (size_t i = 0; i < out->count; i++)
    out->weight[i] = whole > 0.0f ? out->weight[i] / whole : 0.0f;
}

void hetab_rgl_smooth_eval(const hetab_rgl_smooth *s, const float wi[3], const float wo[3],
                           float *value) {
  const hetab_rgl *rgl = s->rgl;
  size_t stride = rgl->resolution * rgl->resolution;
  hetab_blend blend;
  hetab_cell cell;
  nodes nodes;
  memset(value, 0, rgl->channels * sizeof *value);
  float factor = hetab_rgl_place(rgl, wi, wo, &blend, &cell);
  if (!(factor > 0.0f))
    return;
  find_nodes(s, &blend, &cell, &nodes);
  if (!nodes.count && wo[2] < 0.5f) { /* all of it is at the horizon: what is a little higher */
    float length = sqrtf(1.0f + 0.1f * wo[2] + 0.0025f);
    const float higher[3] = {wo[0] / length, wo[1] / length, (wo[2] + 0.05f) / length};
    hetab_rgl_smooth_eval(s, wi, higher, value);
    return;
  }
  if (nodes.lowest > steep_cosine) {
    hetab_rgl_eval(rgl, wi, wo, value);
    return;
  }
  for (size_t c = 0; c < rgl->channels; c++)
    for (size_t i = 0; i < nodes.count; i++)
      value[c] += factor * nodes.weight[i] * rgl->spectra[nodes.at[i] + c * stride];
}
