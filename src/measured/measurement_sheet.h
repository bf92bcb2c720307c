/* What the readers of measurement files share: rows on their way to a hetab_measurements. */
#pragma once

#include <stdbool.h>
#include <hetab/measurements.h>

#include "core/csv.h"

typedef struct hetab_sheet {
  hetab_context *ctx;
  const char *path;
  hetab_csv csv;          /* of text */
  size_t first_line;      /* of its rows */
  const double *given_um; /* [given] wavelengths of columns that name none */
  size_t given;
  double *lambda_um; /* [wavelengths], ascending */
  size_t *column;    /* [wavelengths]: where the file's i-th wavelength goes */
  size_t wavelengths;
  hetab_directions *pairs;
  double *values; /* [count][wavelengths] */
  size_t count, capacity;
  hetab_measurements_skipped skipped;
} hetab_sheet;

/* Where a file gives both azimuths; radians, any sign: theta < 0 is the other side of the normal.
 */
typedef struct hetab_measured_angles {
  double theta_i, phi_i, theta_r, phi_r;
} hetab_measured_angles;

/* What red, green and blue are taken for. */
extern const double hetab_rgb_um[3];

/* The wavelengths in the file's order; sorted here. HETAB_ERR_PARSE for one that occurs twice, or
 * that must be in another unit. */
hetab_status hetab_sheet_begin(hetab_sheet *sheet, const double *lambda_um, size_t wavelengths);
/* values in the file's order of wavelengths. Counts what has to be left out; HETAB_ERR_PARSE for
 * angles that cannot be radians. */
hetab_status hetab_sheet_add(hetab_sheet *sheet, const hetab_measured_angles *angles,
                             const double *values);
/* HETAB_ERR_PARSE for a sheet without a value. */
hetab_status hetab_sheet_finish(hetab_sheet *sheet, hetab_measurements **out);
void hetab_sheet_clear(hetab_sheet *sheet);

/* HETAB_ERR_PARSE, "PATH:LINE: " before the message, or "PATH: " if the file is no text. */
hetab_status hetab_sheet_fail(hetab_sheet *sheet, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The readers. */
hetab_status hetab_measurements_read_brdf(hetab_sheet *sheet);
hetab_status hetab_measurements_read_astm(hetab_sheet *sheet);
hetab_status hetab_measurements_read_csv(hetab_sheet *sheet);
hetab_status hetab_measurements_read_merl(hetab_sheet *sheet);
hetab_status hetab_measurements_read_rgl(hetab_sheet *sheet);
hetab_status hetab_measurements_read_h5(hetab_sheet *sheet);
