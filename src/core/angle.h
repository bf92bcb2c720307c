/* Degrees of files and people, radians of everything else. 90 and 180 degrees are exactly pi/2 and
 * pi; within a degree of them the result is the nearest double (tests/test_literal.c). Even so a
 * double near pi/2 has its cosine to 1e-16 absolute only: to 6e-10 of it at 90 - 1e-5 degrees. */
#pragma once

#include <math.h>

static inline double hetab_radians(double deg) {
  const double rest_of_pi_2 = 6.123233995736766e-17;
  double quarters = round(deg / 90.0), beside = deg - 90.0 * quarters;
  if (beside == 0.0 || fabs(beside) > 1.0)
    return deg / 180.0 * M_PI;
  return quarters * M_PI_2 + (beside / 180.0 * M_PI + quarters * rest_of_pi_2);
}

static inline double hetab_degrees(double radians) {
  return radians / M_PI * 180.0;
}
