#include "convert/radiant.h"

#include <float.h>

enum { BLOCK = 1024 }; /* a fixed count is what compilers vectorise */

/* NaN fails both comparisons. */
bool hetab_floats_radiant(const float *values, size_t count) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0.0f) | !(values[i] <= FLT_MAX);
  return !bad;
}

bool hetab_doubles_radiant(const double *values, size_t count, double most) {
  int bad = 0;
  for (; count >= BLOCK; count -= BLOCK, values += BLOCK)
    for (int i = 0; i < BLOCK; i++)
      bad |= !(values[i] >= 0.0) | !(values[i] <= most);
  for (size_t i = 0; i < count; i++)
    bad |= !(values[i] >= 0.0) | !(values[i] <= most);
  return !bad;
}
