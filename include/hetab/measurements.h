/* Measured BRDFs: lists of direction pairs with a value for each wavelength. */
#ifndef HETAB_MEASUREMENTS_H
#define HETAB_MEASUREMENTS_H

#include <stddef.h>
#include <hetab/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Radians; phi is the viewer's azimuth minus the light's, folded to [0, pi]. */
typedef struct hetab_pair_of_directions {
  double theta_i, theta_r, phi;
} hetab_pair_of_directions;

typedef struct hetab_measurements hetab_measurements;

/* By content and name: Cornell gonioreflectometer text (.brdf), ASTM E1392 style (.astm), CSV with
 * the columns wavelength_nm (or lambda_um), theta_i_deg, theta_r_deg, phi_deg, f; MERL (.binary:
 * three channels at the given wavelengths, 0.61, 0.55, 0.46 um unless set); HDF5 of ours.
 * Failures name file and line. */
hetab_status hetab_measurements_load(hetab_context *ctx, const char *path,
                                     hetab_measurements **out);
/* From memory: values[count][wavelengths], 1/sr; NaN marks a value that is missing. */
hetab_status hetab_measurements_create(hetab_context *ctx, const double *lambda_um,
                                       size_t wavelengths, const hetab_pair_of_directions *pairs,
                                       size_t count, const double *values,
                                       hetab_measurements **out);
void hetab_measurements_free(hetab_measurements *measurements);

const char *hetab_measurements_name(const hetab_measurements *measurements);
size_t hetab_measurements_wavelengths(const hetab_measurements *measurements);
const double *hetab_measurements_lambda_um(const hetab_measurements *measurements);
size_t hetab_measurements_count(const hetab_measurements *measurements);
const hetab_pair_of_directions *hetab_measurements_pairs(const hetab_measurements *measurements);
/* [count][wavelengths] */
const double *hetab_measurements_values(const hetab_measurements *measurements);

/* What was left out while reading, and why. */
typedef struct hetab_measurements_skipped {
  size_t below_horizon; /* rows with a direction at or below it */
  size_t negative;      /* values below 0: missing (NaN) in values */
  size_t not_finite;
} hetab_measurements_skipped;
hetab_measurements_skipped hetab_measurements_skipped_of(const hetab_measurements *measurements);

#ifdef __cplusplus
}
#endif
#endif
