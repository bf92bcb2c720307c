#include "lookup/lattice.h"

#include <math.h>
#include <stdlib.h>

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

static float fill(hetab_lattice_source source, const void *user, size_t channels, size_t stride,
                  float *logs) {
  float top = HETAB_LATTICE_ZERO;
  for (size_t h = 0; h < HETAB_LATTICE_H; h++)
    for (size_t d = 0; d < HETAB_LATTICE_D; d++)
      for (size_t k = 0; k < HETAB_LATTICE_Q; k++, logs += stride) {
        hetab_lattice_place place = place_of(h, d, k);
        source(user, &place, logs);
        for (size_t c = 0; c < channels; c++)
          top = fmaxf(top, logs[c]);
      }
  return top;
}

static void encode(const float *logs, float top, hetab_lattice *lattice) {
  size_t count = HETAB_LATTICE_NODES * lattice->stride;
  lattice->low = fmaxf(ceilf(top), -70) - octaves;
  lattice->step = octaves / largest_code;
  lattice->floor = exp2f(lattice->low);
  for (size_t i = 0; i < count; i++) {
    float code = (logs[i] - lattice->low) / lattice->step;
    lattice->codes[i] = (uint16_t)(fminf(fmaxf(code, 0), largest_code) + 0.5f);
  }
}

size_t hetab_lattice_stride(size_t channels) {
  return channels <= 4 ? 4 : (channels + 15) / 16 * 16;
}

hetab_status hetab_lattice_create(hetab_context *ctx, size_t channels, hetab_lattice_source source,
                                  const void *user, hetab_lattice *lattice) {
  size_t stride = hetab_lattice_stride(channels);
  *lattice = (hetab_lattice){.channels = channels, .stride = stride};
  float *logs = hetab_alloc(ctx, HETAB_LATTICE_NODES, stride * sizeof *logs);
  if (logs)
    lattice->codes = hetab_alloc(ctx, HETAB_LATTICE_NODES, stride * sizeof *lattice->codes);
  if (lattice->codes)
    encode(logs, fill(source, user, channels, stride, logs), lattice);
  free(logs);
  return lattice->codes ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_lattice_clear(hetab_lattice *lattice) {
  free(lattice->codes);
  *lattice = (hetab_lattice){0};
}
