/* Degrees of files and people, radians of everything else. 90 and 180 degrees are exactly pi/2 and
 * pi, and whole degrees come back as they were. */
#ifndef HETAB_CORE_ANGLE_H
#define HETAB_CORE_ANGLE_H

#include <math.h>

static inline double hetab_radians(double deg) {
  return deg / 180.0 * M_PI;
}

static inline double hetab_degrees(double radians) {
  return radians / M_PI * 180.0;
}

#endif
