/* The built-in metals' data. */
#pragma once

#include <hetab/index.h>

typedef struct hetab_metal {
  const char *symbol, *name, *citation;
  size_t count;
  const double *rows; /* [count][3]: wavelength in um, n, k */
} hetab_metal;

/* By symbol or name, in any case; NULL if there is none. */
const hetab_metal *hetab_metal_find(const char *symbol_or_name);
