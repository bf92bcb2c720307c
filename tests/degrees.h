/* Degrees where the library takes radians; a constant of constants. */
#ifndef HETAB_TESTS_DEGREES_H
#define HETAB_TESTS_DEGREES_H

#include <math.h>

#define DEG(degrees) ((degrees) / 180.0 * M_PI)

#endif
