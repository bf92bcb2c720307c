#include "engine/sample.h"

#include <math.h>
#include <stdlib.h>

#include "core/number.h"
#include "core/random.h"

static int by_position(const void *a, const void *b) {
  uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return x < y ? -1 : x > y;
}

hetab_status hetab_sample_create(hetab_context *ctx, size_t count, uint64_t total, unsigned seed,
                                 hetab_sample *sample) {
  uint64_t state = seed;
  *sample = (hetab_sample){.count = count};
  sample->positions = hetab_alloc(ctx, count, sizeof *sample->positions);
  sample->relative = hetab_alloc(ctx, count, sizeof *sample->relative);
  if (!sample->positions || !sample->relative) {
    hetab_sample_clear(sample);
    return HETAB_ERR_MEMORY;
  }
  for (size_t i = 0; i < count; i++)
    sample->positions[i] = hetab_random(&state) % total;
  qsort(sample->positions, count, sizeof *sample->positions, by_position);
  return HETAB_OK;
}

void hetab_sample_clear(hetab_sample *sample) {
  free(sample->positions);
  free(sample->relative);
  *sample = (hetab_sample){0};
}

size_t hetab_sample_from(const hetab_sample *sample, uint64_t position) {
  size_t low = 0, high = sample->count;
  while (low < high) {
    size_t middle = low + (high - low) / 2;
    if (sample->positions[middle] < position)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

void hetab_sample_add(hetab_sample *sample, double value, double reference) {
  hetab_error_stats *s = &sample->stats;
  s->samples++;
  if (!isfinite(value) || value < 0.0) {
    s->bad++;
  } else if (reference >= HETAB_FLOOR_PER_SR) {
    double relative = fabs(value - reference) / reference;
    sample->relative[s->compared++] = relative;
    s->max_rel = fmax(s->max_rel, relative);
  } else {
    s->max_abs_below = fmax(s->max_abs_below, fabs(value - reference));
  }
}

hetab_error_stats hetab_sample_finish(hetab_sample *sample) {
  hetab_error_stats *s = &sample->stats;
  if (s->compared) {
    hetab_sort(sample->relative, s->compared);
    s->p99_rel = sample->relative[(size_t)(0.99 * (double)(s->compared - 1))];
    /* Summed in order of size: slabs come in any order, and reports are to be the same each time.
     */
    for (size_t i = 0; i < s->compared; i++)
      s->rms_rel += sample->relative[i] * sample->relative[i];
    s->rms_rel = sqrt(s->rms_rel / (double)s->compared);
  }
  return *s;
}
