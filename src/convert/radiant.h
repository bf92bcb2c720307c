/* Whether all values are finite and not negative, at a memory's speed. */
#ifndef HETAB_CONVERT_RADIANT_H
#define HETAB_CONVERT_RADIANT_H

#include <stdbool.h>
#include <stddef.h>

bool hetab_floats_radiant(const float *values, size_t count);
bool hetab_doubles_radiant(const double *values, size_t count, double most);

#endif
