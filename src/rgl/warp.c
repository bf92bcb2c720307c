#include "rgl/warp.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- construction -------------------------------------------------------------------------- */

/* Running integrals of one slice, cells of size 1; the integral of the whole. */
static double integrate_slice(const float *data, size_t width, size_t height, float *conditional,
                              float *marginal) {
  double rows = 0.0;
  for (size_t y = 0; y < height; y++) {
    const float *row = data + y * width;
    double sum = 0.0;
    conditional[y * width] = 0.0f;
    for (size_t x = 1; x < width; x++) {
      sum += 0.5 * ((double)row[x - 1] + (double)row[x]);
      conditional[y * width + x] = (float)sum;
    }
  }
  marginal[0] = 0.0f;
  for (size_t y = 1; y < height; y++) {
    rows += 0.5 * ((double)conditional[y * width - 1] + (double)conditional[(y + 1) * width - 1]);
    marginal[y] = (float)rows;
  }
  return rows;
}

static void scale(float *values, size_t count, float factor) {
  for (size_t i = 0; i < count; i++)
    values[i] *= factor;
}

/* 0 if the slice's integral is 0, infinite, or so small that 1 / integral is. */
static int normalise_slice(hetab_warp *warp, size_t slice) {
  size_t count = warp->width * warp->height;
  float *data = warp->data + slice * count, *conditional = warp->conditional + slice * count;
  float *marginal = warp->marginal + slice * warp->height;
  double total = integrate_slice(data, warp->width, warp->height, conditional, marginal);
  if (!(total >= 2.0 * (double)FLT_MIN && total <= (double)FLT_MAX))
    return 0;
  float factor = 1.0f / marginal[warp->height - 1];
  scale(data, count, factor);
  scale(conditional, count, factor);
  scale(marginal, warp->height, factor);
  return 1;
}

hetab_status hetab_warp_create(hetab_context *ctx, const float *data, size_t width, size_t height,
                               size_t slices, int uniform, size_t *bad_slice, hetab_warp *out) {
  size_t nodes = width * height, count = nodes * slices;
  *out = (hetab_warp){.width = width, .height = height, .slices = slices};
  out->data = hetab_alloc(ctx, count, sizeof(float));
  out->conditional = hetab_alloc(ctx, count, sizeof(float));
  out->marginal = hetab_alloc(ctx, height * slices, sizeof(float));
  HETAB_NEED(out->data && out->conditional && out->marginal);
  memcpy(out->data, data, count * sizeof(float));
  for (size_t slice = 0; slice < slices; slice++) {
    int good = normalise_slice(out, slice);
    if (!good && uniform) {
      for (size_t i = 0; i < nodes; i++)
        out->data[slice * nodes + i] = 1.0f;
      good = normalise_slice(out, slice);
    }
    if (!good) {
      *bad_slice = slice;
      return HETAB_ERR_RANGE;
    }
  }
  return HETAB_OK;
}

void hetab_warp_clear(hetab_warp *warp) {
  free(warp->data);
  free(warp->conditional);
  free(warp->marginal);
  *warp = (hetab_warp){0};
}

/* ---- cells --------------------------------------------------------------------------------- */

static size_t cell_of(float position, size_t nodes) {
  size_t cell = (size_t)position;
  return cell < nodes - 2 ? cell : nodes - 2;
}

static float clamp_unit(float u) {
  return u > 0.0f ? (u < 1.0f ? u : 1.0f) : 0.0f; /* NaN: 0 */
}

hetab_cell hetab_cell_at(size_t width, size_t height, const float u[2]) {
  float x = clamp_unit(u[0]) * (float)(width - 1), y = clamp_unit(u[1]) * (float)(height - 1);
  hetab_cell cell = {.x = cell_of(x, width), .y = cell_of(y, height)};
  cell.tx = x - (float)cell.x;
  cell.ty = y - (float)cell.y;
  return cell;
}

float hetab_cell_value(const hetab_cell *cell, const float *nodes, size_t width) {
  const float *at = nodes + cell->y * width + cell->x;
  float low = (1.0f - cell->tx) * at[0] + cell->tx * at[1];
  float high = (1.0f - cell->tx) * at[width] + cell->tx * at[width + 1];
  return (1.0f - cell->ty) * low + cell->ty * high;
}

/* ---- reading ------------------------------------------------------------------------------- */

/* One number of every slice, blended. stride: numbers of a slice. */
static float blended(const float *values, const hetab_blend *blend, size_t stride, size_t i) {
  float sum = 0.0f;
  for (size_t k = 0; k < blend->count; k++)
    sum += blend->weight[k] * values[blend->slice[k] * stride + i];
  return sum;
}

/* Along the row between rows y and y + 1, at ty: the densities at both ends of cell x. */
static void row_ends(const hetab_warp *warp, const hetab_blend *blend, size_t x, size_t y, float ty,
                     float ends[2]) {
  size_t stride = warp->width * warp->height, i = y * warp->width + x;
  for (size_t k = 0; k < 2; k++)
    ends[k] = (1.0f - ty) * blended(warp->data, blend, stride, i + k) +
              ty * blended(warp->data, blend, stride, i + k + warp->width);
}

/* The running integral along that row at node x. */
static float row_integral(const hetab_warp *warp, const hetab_blend *blend, size_t x, size_t y,
                          float ty) {
  size_t stride = warp->width * warp->height, i = y * warp->width + x;
  return (1.0f - ty) * blended(warp->conditional, blend, stride, i) +
         ty * blended(warp->conditional, blend, stride, i + warp->width);
}

static float whole_row(const hetab_warp *warp, const hetab_blend *blend, size_t y) {
  return blended(warp->conditional, blend, warp->width * warp->height, (y + 1) * warp->width - 1);
}

static float rows_below(const hetab_warp *warp, const hetab_blend *blend, size_t y) {
  return blended(warp->marginal, blend, warp->height, y);
}

static float cells(const hetab_warp *warp) {
  return (float)(warp->width - 1) * (float)(warp->height - 1);
}

float hetab_warp_density(const hetab_warp *warp, const hetab_blend *blend, const float u[2]) {
  hetab_cell at = hetab_cell_at(warp->width, warp->height, u);
  float ends[2];
  row_ends(warp, blend, at.x, at.y, at.ty, ends);
  return ((1.0f - at.tx) * ends[0] + at.tx * ends[1]) * cells(warp);
}

float hetab_warp_invert(const hetab_warp *warp, const hetab_blend *blend, const float u[2],
                        float s[2]) {
  hetab_cell at = hetab_cell_at(warp->width, warp->height, u);
  float ends[2], low = whole_row(warp, blend, at.y), high = whole_row(warp, blend, at.y + 1);
  row_ends(warp, blend, at.x, at.y, at.ty, ends);
  float along = row_integral(warp, blend, at.x, at.y, at.ty) +
                at.tx * (ends[0] + 0.5f * at.tx * (ends[1] - ends[0]));
  float whole = (1.0f - at.ty) * low + at.ty * high;
  s[0] = whole > 0.0f ? along / whole : 0.0f;
  s[1] = rows_below(warp, blend, at.y) + at.ty * (low + 0.5f * at.ty * (high - low));
  return ((1.0f - at.tx) * ends[0] + at.tx * ends[1]) * cells(warp);
}

/* Where in a cell of densities a, b at its ends the running integral is `rest`: the root of
 * t (a + t (b - a) / 2) = rest that has no cancellation. */
static float linear_root(float a, float b, float rest) {
  float square = a * a + 2.0f * rest * (b - a);
  float below = a + sqrtf(square > 0.0f ? square : 0.0f);
  float t = below > 0.0f ? 2.0f * rest / below : 0.0f;
  return t > 0.0f ? (t < 1.0f ? t : 1.0f) : 0.0f;
}

/* The last row whose running integral is below s, with what is left of s. */
static size_t find_row(const hetab_warp *warp, const hetab_blend *blend, float *s) {
  size_t low = 0, high = warp->height - 1;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (rows_below(warp, blend, middle) < *s)
      low = middle;
    else
      high = middle;
  }
  *s -= rows_below(warp, blend, low);
  return low;
}

static size_t find_column(const hetab_warp *warp, const hetab_blend *blend, size_t y, float ty,
                          float *s) {
  size_t low = 0, high = warp->width - 1;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (row_integral(warp, blend, middle, y, ty) < *s)
      low = middle;
    else
      high = middle;
  }
  *s -= row_integral(warp, blend, low, y, ty);
  return low;
}

float hetab_warp_sample(const hetab_warp *warp, const hetab_blend *blend, const float s[2],
                        float u[2]) {
  const float least = 0x1p-24f, most = 1.0f - 0x1p-24f; /* away from what has no inverse */
  float sx = s[0] > least ? (s[0] < most ? s[0] : most) : least;
  float sy = s[1] > least ? (s[1] < most ? s[1] : most) : least;
  float ends[2];
  size_t y = find_row(warp, blend, &sy);
  float low = whole_row(warp, blend, y), high = whole_row(warp, blend, y + 1);
  float ty = linear_root(low, high, sy);
  sx *= (1.0f - ty) * low + ty * high;
  size_t x = find_column(warp, blend, y, ty, &sx);
  row_ends(warp, blend, x, y, ty, ends);
  float tx = linear_root(ends[0], ends[1], sx);
  u[0] = ((float)x + tx) / (float)(warp->width - 1);
  u[1] = ((float)y + ty) / (float)(warp->height - 1);
  return ((1.0f - tx) * ends[0] + tx * ends[1]) * cells(warp);
}
