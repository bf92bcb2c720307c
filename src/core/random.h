/* Random numbers by a fixed generator: the same seed gives the same sequence everywhere. */
#pragma once

#include <stdint.h>

/* splitmix64: the next of a sequence, and the same as a double in [0, 1). Any state will do. */
uint64_t hetab_random(uint64_t *state);
double hetab_random_unit(uint64_t *state);
