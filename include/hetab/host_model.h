/* The model on the host, in double: no device needed. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>
#include <hetab/types.h>

HETAB_BEGIN

/* Whether float is too little for the surface: n < 1 with k near 0 at some wavelength, where it is
 * off by up to 6e-3 around the critical angle (double: 3e-7). */
int hetab_wants_double(const hetab_surface *surface);

/* Are the point's numbers within what the model is evaluated for? HETAB_ERR_ARGUMENT naming the
 * field, its value and the range: "sigma0_um = 0: give a value from 1e-09 to 1e+06". */
hetab_status hetab_check_point(hetab_context *ctx, const hetab_point *point);

/* The range of one of its numbers, in the library's units: that at offsetof(hetab_point, ...). */
void hetab_point_limits(size_t offset, double *low, double *high);

/* The printed equations (Eqs. 6-25) in double on the calling thread, limits where they divide
 * zero by zero: the executable specification. No device needed. */
hetab_status hetab_evaluate_literal(hetab_context *ctx, const hetab_point *points, size_t count,
                                    hetab_value *values);

/* rho_s(theta_i, lambda), Eq. 10: out[band_count][count], theta_i[count], double, on the host.
 */
hetab_status hetab_specular_reflectance(hetab_context *ctx, const hetab_surface *surface,
                                        const double *theta_i, size_t count, double *out);

/* The same of any bands, such as those of hetab_surface_at(): out[band_count][count]. */
void hetab_specular_of_bands(const hetab_surface *surface, const hetab_band *bands,
                             size_t band_count, const double *theta_i, size_t count, double *out);

/* The share of the white-sky reflectance (a uniform sky's) that a table without the delta lacks: of
 * rho_s, over that of the polished material and the diffuse part, the mean over the bands. Within a
 * few per cent of the share of what the surface reflects, which loses or gains that much. */
double hetab_specular_share(const hetab_surface *surface);

HETAB_END
