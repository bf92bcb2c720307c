#include "lookup/lattice.h"

#include <math.h>
#include <stdlib.h>

#include "core/each.h"

/* What is smaller than the largest value by this many octaves counts as 0. The lowest logarithm is
 * a whole number, so that its power is exactly the floor. */
static const float octaves = 46;
static const float largest_code = 65535;

/* The lattice ends where cosines are 0, of which no table knows a limit: its last nodes stand a
 * little inside. */
static hetab_lattice_place place_of(size_t h, size_t d, size_t k) {
  double u = (double)h / (HETAB_LATTICE_H - 1), w = (double)d / (HETAB_LATTICE_D - 1);
  double rest = 1 - (double)k / (HETAB_LATTICE_Q - 1);
  double v = fmin(u * u * u * u, 1 - 1e-6), c = fmax(w * w, 1e-3);
  double up = sqrt(1 - v) * c, side = sqrt(v * (1 - c * c));
  double tilt = (1 - rest * rest) * fmin(side, up);
  return (hetab_lattice_place){v, c, up - tilt, up + tilt};
}

enum { PLANE = HETAB_LATTICE_D * HETAB_LATTICE_Q };

static size_t node_of(size_t h, size_t d, size_t k) {
  return h * PLANE + d * HETAB_LATTICE_Q + k;
}

typedef struct filling {
  hetab_lattice_source source;
  const void *user;
  hetab_lattice *lattice;
  float *logs; /* as the lattice's codes */
  float top[HETAB_LATTICE_D];
} filling;

/* Along theta_h neighbours read what is near in a dense table. */
static void fill(void *user, size_t d, int worker) {
  filling *f = user;
  (void)worker;
  f->top[d] = HETAB_LATTICE_ZERO;
  for (size_t n = 0; n < HETAB_LATTICE_Q * HETAB_LATTICE_H; n++) {
    size_t h = n % HETAB_LATTICE_H, k = n / HETAB_LATTICE_H;
    hetab_lattice_place place = place_of(h, d, k);
    float *logs = f->logs + node_of(h, d, k) * f->lattice->stride;
    f->source(f->user, &place, logs);
    for (size_t c = 0; c < f->lattice->channels; c++)
      f->top[d] = logs[c] > f->top[d] ? logs[c] : f->top[d];
  }
}

static void encode(void *user, size_t h, int worker) {
  const filling *f = user;
  const hetab_lattice *lattice = f->lattice;
  size_t first = h * PLANE * lattice->stride;
  (void)worker;
  for (size_t i = first; i < first + PLANE * lattice->stride; i++) {
    float code = (f->logs[i] - lattice->low) / lattice->step;
    code = code > 0 ? code : 0;
    lattice->codes[i] = (uint16_t)(int)((code < largest_code ? code : largest_code) + 0.5f);
  }
}

static hetab_status fill_and_encode(hetab_context *ctx, filling *f) {
  hetab_lattice *lattice = f->lattice;
  float top = -70;
  HETAB_TRY(hetab_each(ctx, HETAB_LATTICE_D, fill, f));
  for (size_t d = 0; d < HETAB_LATTICE_D; d++)
    top = fmaxf(top, ceilf(f->top[d]));
  lattice->low = top - octaves;
  lattice->step = octaves / largest_code;
  lattice->floor = exp2f(lattice->low);
  return hetab_each(ctx, HETAB_LATTICE_H, encode, f);
}

size_t hetab_lattice_stride(size_t channels) {
  return channels <= 4 ? 4 : (channels + 15) / 16 * 16;
}

hetab_status hetab_lattice_create(hetab_context *ctx, size_t channels, hetab_lattice_source source,
                                  const void *user, hetab_lattice *lattice) {
  size_t stride = hetab_lattice_stride(channels);
  *lattice = (hetab_lattice){.channels = channels, .stride = stride};
  filling f = {.source = source, .user = user, .lattice = lattice};
  f.logs = hetab_alloc(ctx, HETAB_LATTICE_NODES, stride * sizeof *f.logs);
  lattice->codes = hetab_alloc(ctx, HETAB_LATTICE_NODES, stride * sizeof *lattice->codes);
  hetab_status status = f.logs && lattice->codes ? fill_and_encode(ctx, &f) : HETAB_ERR_MEMORY;
  free(f.logs);
  return status;
}

void hetab_lattice_clear(hetab_lattice *lattice) {
  free(lattice->codes);
  *lattice = (hetab_lattice){0};
}
