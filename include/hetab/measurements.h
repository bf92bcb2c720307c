/* Measured BRDFs: lists of direction pairs with a value for each wavelength. */
#pragma once

#include <stddef.h>
#include <hetab/types.h>

HETAB_BEGIN

/* Threads: once made, they do not change and may be shared. */
typedef struct hetab_measurements hetab_measurements;

/* By extension, else by content (what comes through a pipe is text):
 *   .brdf    Cornell gonioreflectometer text: '#' comments, how many wavelengths, the wavelengths
 *            in nm, then rows theta_i phi_i theta_s phi_s (radians) and a BRDF per wavelength
 *   .astm    ASTM E1392 style: header lines of which VARS names the columns (theta_i, phi_i,
 *            theta_s, phi_s in radians; values by wavelength, "550nm" or "0.55um") and NUM_POINTS
 *            counts the rows; comma-separated rows
 *   .csv     a value a row: columns wavelength_nm (or lambda_nm, wavelength_um, lambda_um),
 *            theta_i_deg, theta_r_deg (or theta_s_deg), phi_deg (or phi_i_deg and phi_r_deg), f (or
 *            brdf, or total as `hetab eval` writes it), angles also as _rad; others are passed over
 *   .binary  MERL: theta_i 0:80:10, theta_r 0:85:2.5, phi 0:180:15 degrees, linear between the
 *            cells' centres (3579 pairs); three channels taken for 0.61, 0.55, 0.46 um
 *   .h5      ours: at most 10 x 28 x 13 nodes evenly out of the table's theta_i, theta_r, phi, ends
 *            included; the specular delta is not in them
 * Both azimuths as in the file, their difference 180 degrees in the mirror direction; a negative
 * polar angle is the other side of the normal. Wavelengths are sorted. "nan", "inf" and an empty
 * field are missing values. Text files up to 256 MiB, tables up to 1 GiB per wavelength. Name: the
 * file's, without folder and extension.
 * HETAB_ERR_PARSE or HETAB_ERR_IO, with file, line and remedy: malformed, truncated, without a
 * usable value, or in a wrong unit (wavelengths outside 0.01 to 100 um; radians beyond pi; degrees
 * none of which exceeds 2 pi; values above 1e12 / sr), or more than 2 GiB of values. */
hetab_status hetab_measurements_load(hetab_context *ctx, const char *path,
                                     hetab_measurements **out);
/* From memory: values[count][wavelengths], 1/sr, at most 1e12 in size; NaN marks a value that is
 * missing.
 */
hetab_status hetab_measurements_create(hetab_context *ctx, const double *lambda_um,
                                       size_t wavelengths, const hetab_directions *pairs,
                                       size_t count, const double *values,
                                       hetab_measurements **out);
/* Likewise, where the columns of values may name no wavelength: they are at lambda_um[count] then.
 */
hetab_status hetab_measurements_load_at(hetab_context *ctx, const char *path,
                                        const double *lambda_um, size_t count,
                                        hetab_measurements **out);
void hetab_measurements_free(hetab_measurements *measurements);

const char *hetab_measurements_name(const hetab_measurements *measurements);
size_t hetab_measurements_wavelength_count(const hetab_measurements *measurements);
const double *hetab_measurements_lambda_um(const hetab_measurements *measurements);
size_t hetab_measurements_pair_count(const hetab_measurements *measurements);
const hetab_directions *hetab_measurements_pairs(const hetab_measurements *measurements);
/* [count][wavelengths] */
const double *hetab_measurements_values(const hetab_measurements *measurements);

/* What was left out while reading, and why; and what is strange but kept. */
typedef struct hetab_measurements_skipped {
  size_t below_horizon; /* rows with a direction at or below it */
  size_t negative;      /* values below 0, as noise about a weak signal is: they are kept */
  size_t not_finite;
} hetab_measurements_skipped;
hetab_measurements_skipped hetab_measurements_skipped_of(const hetab_measurements *measurements);

HETAB_END
