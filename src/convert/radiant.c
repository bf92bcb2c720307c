#include "convert/radiant.h"

#include <float.h>

#include "core/context.h"

enum { BLOCK = 1024 }; /* a fixed count is what compilers vectorise */

/* NaN fails both comparisons. */
static bool floats_radiant(const float *values, size_t count) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  return !bad;
}

static bool doubles_radiant(const double *values, size_t count, double most) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0.0) | !(values[i] <= most);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0.0) | !(values[i] <= most);
  return !bad;
}

bool hetab_radiant(const void *values, size_t count, hetab_precision precision, bool as_floats) {
  return precision == HETAB_FLOAT
             ? floats_radiant(values, count)
             : doubles_radiant(values, count, as_floats ? (double)FLT_MAX : DBL_MAX);
}

hetab_status hetab_report_radiant(hetab_context *ctx, const hetab_report *report) {
  if (!report->error.bad)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_DEVICE,
                    "%zu of %zu sampled entries are NaN, infinite or negative: nothing written; "
                    "please report this",
                    report->error.bad, report->error.samples);
}
