#include "lookup/stencil.h"

#include <math.h>
#include <stdlib.h>

#include "lookup/lattice.h"

hetab_status hetab_stencil_axis_create(hetab_context *ctx, const double *nodes, size_t count,
                                       hetab_stencil_axis *axis) {
  int size = count < HETAB_STENCIL ? (int)count : HETAB_STENCIL;
  *axis = (hetab_stencil_axis){.count = count, .size = size, .nodes = nodes};
  if (count > 1)
    axis->per_node = (double)(count - 1) / (nodes[count - 1] - nodes[0]);
  axis->scale = hetab_alloc(ctx, count, (size_t)size * sizeof *axis->scale);
  HETAB_NEED(axis->scale);
  for (size_t first = 0; first + (size_t)size <= count; first++)
    for (int i = 0; i < size; i++) {
      double product = 1.0;
      for (int k = 0; k < size; k++)
        product *= k == i ? 1.0 : nodes[first + (size_t)i] - nodes[first + (size_t)k];
      axis->scale[first * (size_t)size + (size_t)i] = 1.0 / product;
    }
  return HETAB_OK;
}

void hetab_stencil_axis_clear(hetab_stencil_axis *axis) {
  free(axis->scale);
  *axis = (hetab_stencil_axis){0};
}

/* The last node not above x, 0 if there is none; at once where they are evenly spaced, else without
 * a branch that depends on x. */
static size_t below(const hetab_stencil_axis *axis, double x) {
  const double *nodes = axis->nodes;
  size_t count = axis->count, low = 0;
  double guess = (x - nodes[0]) * axis->per_node;
  if (guess >= 0.0 && guess < (double)(count - 1)) {
    size_t at = (size_t)guess;
    if (nodes[at] <= x && x < nodes[at + 1])
      return at;
  }
  for (size_t left = count; left > 1;) {
    size_t half = left / 2;
    low += nodes[low + half] <= x ? half : 0;
    left -= half;
  }
  return low;
}

static double within(const double *nodes, size_t count, double x) {
  if (count < 2)
    return nodes[0];
  double low = nodes[0] - (nodes[1] - nodes[0]);
  double high = nodes[count - 1] + (nodes[count - 1] - nodes[count - 2]);
  return fmin(fmax(x, low), high);
}

hetab_stencil hetab_stencil_at(const hetab_stencil_axis *axis, double x) {
  hetab_stencil s = {.count = axis->size};
  size_t before = below(axis, x), last = axis->count - (size_t)s.count;
  s.first = before > 0 ? before - 1 : 0;
  s.first = s.first < last ? s.first : last;
  x = within(axis->nodes, axis->count, x);
  const double *at = axis->nodes + s.first, *scale = axis->scale + s.first * (size_t)s.count;
  double after[HETAB_STENCIL + 1] = {1.0, 1.0, 1.0, 1.0, 1.0}, product = 1.0;
  for (int i = s.count - 1; i > 0; i--)
    after[i - 1] = after[i] * (x - at[i]);
  for (int i = 0; i < s.count; i++) {
    s.weight[i] = product * after[i] * scale[i];
    product *= x - at[i];
  }
  return s;
}

/* Below: faint enough to be 0 in every table. Above: no BRDF, and near what float holds. */
float hetab_log2_or_zero(double value) {
  return value > 1e-30 ? (float)log2(fmin(value, 1e30)) : HETAB_LATTICE_ZERO;
}
