/* The renderer's own rough conductor in a surface's place. */
#ifndef HETAB_PLAN_PLAIN_H
#define HETAB_PLAN_PLAIN_H

#include <hetab/surface.h>

/* Relative L1 between Beckmann's microfacet BRDF with alpha = 2 sigma0 / tau, Smith's separable
 * shadowing and the surface's n, k (what renderers call a rough conductor) and dd + ud, the worst
 * of three wavelengths and the incidences 0, 30, 60 degrees. The delta is not in it. */
double hetab_plain_error(const hetab_surface *surface);

#endif
