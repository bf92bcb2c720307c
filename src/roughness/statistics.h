/* The statistics of one scan, with their standard errors. */
#pragma once

#include <hetab/roughness.h>
#include <stdbool.h>
#include "roughness/fft.h"

enum { HETAB_LEAST_POINTS = 32 }; /* of a scan that is worth statistics */

typedef struct hetab_statistics {
  hetab_fft fft; /* of at least twice the heights */
  double spacing_um;
  hetab_complex *work;
  double *correlation; /* [lags] of the last scan */
  size_t lags;
} hetab_statistics;

/* For scans of up to `count` heights. */
hetab_status hetab_statistics_create(hetab_context *ctx, size_t count, double spacing_um,
                                     hetab_statistics *statistics);
void hetab_statistics_free(hetab_statistics *statistics);

/* Of the heights z_um[count] less line_um (NULL: none) where evaluated. false: fewer than
 * HETAB_LEAST_POINTS, all equal, or an autocorrelation that never falls to 1/e. What `result` says
 * of its scan is left alone. */
bool hetab_statistics_of(hetab_statistics *statistics, const double *z_um, const double *line_um,
                         const unsigned char *evaluated, size_t count,
                         hetab_scan_statistics *result);

/* sigma and tau alone; as above. */
bool hetab_sigma_tau(hetab_statistics *statistics, const double *z_um, const double *line_um,
                     const unsigned char *evaluated, size_t count, double *sigma_um,
                     double *tau_um);

/* Adds the scan's density of z / sigma to density[HETAB_HISTOGRAM_BINS]; what is beyond 5 sigma
 * counts with the last bins. Returns the distance from the normal distribution, at bin edges. */
double hetab_histogram_add(const double *z_um, const double *line_um,
                           const unsigned char *evaluated, size_t count, double *density);
