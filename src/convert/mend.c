#include "convert/mend.h"

#include <math.h>
#include <stdlib.h>

#include "engine/sample.h"

enum {
  CHANNELS = HETAB_MERL_CHANNELS,
  H = HETAB_MERL_THETA_H,
  D = HETAB_MERL_THETA_D,
  P = HETAB_MERL_PHI_D
};

static int has_value(const hetab_merl *merl, size_t cell) {
  for (int c = 0; c < CHANNELS; c++) {
    double value = hetab_merl_channel_const(merl, c)[cell];
    if (!(value >= 0 && value < 1e12))
      return 0;
  }
  return 1;
}

size_t hetab_merl_holes(const hetab_merl *merl) {
  size_t holes = 0;
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    hetab_merl_pair pair;
    holes += hetab_merl_pair_of(hetab_merl_middle(cell), &pair) && !has_value(merl, cell);
  }
  return holes;
}

/* The neighbours of a cell, at most 6; phi_d goes round (reciprocity). */
static int neighbours(size_t cell, size_t out[6]) {
  size_t h = cell / (D * P), d = cell / P % D, p = cell % P;
  int count = 0;
  if (h > 0)
    out[count++] = cell - D * P;
  if (h < H - 1)
    out[count++] = cell + D * P;
  if (d > 0)
    out[count++] = cell - P;
  if (d < D - 1)
    out[count++] = cell + P;
  out[count++] = p > 0 ? cell - 1 : cell + P - 1;
  out[count++] = p < P - 1 ? cell + 1 : cell - (P - 1);
  return count;
}

typedef struct mending {
  hetab_merl *merl;
  unsigned char *known; /* has a value, of the file or of an earlier ring */
  size_t *ring, *next;  /* cells without one */
  size_t ring_count;
  double *values; /* [ring][CHANNELS] */
} mending;

/* Black is no neighbour's geometric mean: it stands for a value far below the others. */
static const double BLACK = HETAB_FLOOR_PER_SR;

static int mean_of_neighbours(const mending *m, size_t cell, double values[CHANNELS]) {
  size_t around[6];
  int count = neighbours(cell, around), known = 0;
  double sum[CHANNELS] = {0};
  for (int i = 0; i < count; i++)
    if (m->known[around[i]]) {
      known++;
      for (int c = 0; c < CHANNELS; c++)
        sum[c] += log(fmax(hetab_merl_channel_const(m->merl, c)[around[i]], BLACK));
    }
  for (int c = 0; c < CHANNELS && known; c++)
    values[c] = exp(sum[c] / known);
  return known;
}

/* One ring; what is filled in it serves the next one alone. */
static void fill_ring(mending *m) {
  size_t left = 0, filled = 0;
  for (size_t i = 0; i < m->ring_count; i++) {
    size_t cell = m->ring[i];
    if (mean_of_neighbours(m, cell, m->values + filled * CHANNELS))
      m->next[filled++] = cell;
    else
      m->ring[left++] = cell;
  }
  for (size_t i = 0; i < filled; i++) {
    m->known[m->next[i]] = 1;
    for (int c = 0; c < CHANNELS; c++)
      hetab_merl_channel(m->merl, c)[m->next[i]] = m->values[i * CHANNELS + (size_t)c];
  }
  m->ring_count = left;
}

hetab_status hetab_merl_mend(hetab_context *ctx, const char *path, hetab_merl *merl) {
  mending m = {.merl = merl};
  hetab_status status = HETAB_OK;
  m.known = hetab_alloc(ctx, HETAB_MERL_CELLS, 1);
  m.ring = hetab_alloc(ctx, HETAB_MERL_CELLS, sizeof *m.ring);
  m.next = hetab_alloc(ctx, HETAB_MERL_CELLS, sizeof *m.next);
  m.values = hetab_alloc(ctx, HETAB_MERL_CELLS, CHANNELS * sizeof *m.values);
  if (!m.known || !m.ring || !m.next || !m.values)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++)
    if (!(m.known[cell] = (unsigned char)has_value(merl, cell)))
      m.ring[m.ring_count++] = cell;
  if (m.ring_count == HETAB_MERL_CELLS)
    HETAB_GOTO(hetab_fail(ctx, HETAB_ERR_PARSE,
                          "'%s' has no valid cell: every one is negative or not a number", path));
  while (m.ring_count)
    fill_ring(&m);
done:
  free(m.known);
  free(m.ring);
  free(m.next);
  free(m.values);
  return status;
}
