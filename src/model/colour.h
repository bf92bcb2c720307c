/* Spectra to linear sRGB: CIE 1931 2-degree observer, D65, 400-700 nm at 10 nm. */
#pragma once

#include <stddef.h>

#include "core/context.h"

/* Weights such that X, Y, Z = sum_w weight[w][0..2] spectrum[w], for samples at lambda_um[count],
 * ascending: the 31 bands' weights, each split linearly between its neighbouring samples. All
 * >= 0; a spectrum of 1 gives Y = 1 to 1e-14, D65's white (0.950470, 1, 1.088830) to 1e-5, and
 * linear sRGB (1, 1, 1) to 1e-13 (tests/test_colour.c). HETAB_ERR_RANGE unless the samples reach
 * from 400 to 700 nm in steps of at most 10 nm. */
hetab_status hetab_xyz_weights(hetab_context *ctx, const double *lambda_um, size_t count,
                               double (*weights)[3]);

/* XYZ to linear sRGB (Rec. 709 primaries, D65); components may leave [0, 1]. */
void hetab_xyz_to_srgb(const double xyz[3], double rgb[3]);

/* The same weights for linear sRGB itself; some are < 0. */
hetab_status hetab_srgb_weights(hetab_context *ctx, const double *lambda_um, size_t count,
                                double (*weights)[3]);

/* Of linear sRGB; of one wavelength, which is in all three, that. */
double hetab_luminance(const float rgb[3]);
