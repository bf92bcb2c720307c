/* The model at all wavelengths of a surface at once, in float: for tables whose own error is far
 * larger. Built of the universal table of h (model/universal.h): ln h is smooth in 1 / lambda^2, to
 * which g and x are proportional, and is tabulated at a few nodes of it; Fresnel's reflectance is
 * interpolated in cos(theta_d).
 *
 * Against the literal equations, 400 to 700 nm: 2e-5 in relative L1, 3e-3 of any value above 1e-3
 * / sr (tests/test_rgl.c). Whoever tabulates other materials or wider ranges compares. */
#pragma once

#include "core/context.h"
#include "model/model.h"

typedef struct hetab_spectrum hetab_spectrum;

hetab_status hetab_spectrum_create(hetab_context *ctx, const hetab_surface *surface,
                                   hetab_spectrum **out);
void hetab_spectrum_free(hetab_spectrum *spectrum); /* NULL is fine */

/* The wavelengths, rounded up to the HETAB_SPECTRUM_LANES that are computed together. */
enum { HETAB_SPECTRUM_LANES = 8 };
size_t hetab_spectrum_padded(const hetab_spectrum *spectrum);

/* dd + ud in 1/sr at every wavelength of the surface; values[padded], whose padding is 0.
 * Thread-safe. */
void hetab_spectrum_eval(const hetab_spectrum *spectrum, const hetab_pair *pair,
                         double one_plus_cos, float *values);
