#include "lookup/stencil.h"

#include <math.h>

#include "lookup/lattice.h"

/* The last node not above x, 0 if there is none. */
static size_t below(const double *nodes, size_t count, double x) {
  size_t low = 0, high = count;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (nodes[middle] <= x)
      low = middle;
    else
      high = middle;
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

hetab_stencil hetab_stencil_at(const double *nodes, size_t count, double x) {
  hetab_stencil s = {.count = count < HETAB_STENCIL ? (int)count : HETAB_STENCIL};
  size_t before = below(nodes, count, x), last = count - (size_t)s.count;
  s.first = before > 0 ? before - 1 : 0;
  s.first = s.first < last ? s.first : last;
  x = within(nodes, count, x);
  const double *at = nodes + s.first;
  for (int i = 0; i < s.count; i++) {
    s.weight[i] = 1;
    for (int k = 0; k < s.count; k++)
      if (k != i)
        s.weight[i] *= (x - at[k]) / (at[i] - at[k]);
  }
  return s;
}

/* Below: faint enough to be 0 in every table. Above: no BRDF, and near what float holds. */
float hetab_log2_or_zero(double value) {
  return value > 1e-30 ? (float)log2(fmin(value, 1e30)) : HETAB_LATTICE_ZERO;
}
