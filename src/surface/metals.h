/* The built-in metals' data. */
#ifndef HETAB_SURFACE_METALS_H
#define HETAB_SURFACE_METALS_H

#include <hetab/index.h>

enum { HETAB_METAL_NODES = 31 };

typedef struct hetab_metal {
  const char *symbol, *name, *citation;
  double n[HETAB_METAL_NODES], k[HETAB_METAL_NODES]; /* at 400, 410, ... 700 nm */
} hetab_metal;

/* By symbol or name, in any case; NULL if there is none. */
const hetab_metal *hetab_metal_find(const char *symbol_or_name);

#endif
