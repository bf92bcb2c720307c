/* The ISO 16610-21 Gaussian profile filter of one scan, at as many cut-offs as wanted. */
#ifndef HETAB_ROUGHNESS_GAUSSIAN_FILTER_H
#define HETAB_ROUGHNESS_GAUSSIAN_FILTER_H

#include <stdbool.h>
#include "roughness/fft.h"

typedef struct hetab_gaussian_filter {
  hetab_fft fft;
  double spacing_um;
  size_t count;            /* of the scan's heights */
  hetab_complex *spectrum; /* of heights (real part) and of where there are any (imaginary) */
  hetab_complex *work;
} hetab_gaussian_filter;

/* For scans of up to `count` heights and cut-offs up to max_cutoff_um. */
hetab_status hetab_gaussian_filter_create(hetab_context *ctx, size_t count, double spacing_um,
                                          double max_cutoff_um, hetab_gaussian_filter *filter);
void hetab_gaussian_filter_free(hetab_gaussian_filter *filter);

/* The scan that the next mean lines are of; NaN: missing. */
void hetab_gaussian_filter_load(hetab_gaussian_filter *filter, const double *z_um, size_t count);

/* Mean line where the scan has a height, and across gaps that the weights reach over. */
void hetab_gaussian_filter_line(hetab_gaussian_filter *filter, double cutoff_um, double *line_um);

/* Which heights are evaluated: not missing, and further than half a cut-off from the ends and from
 * gaps longer than a tenth of the cut-off. */
void hetab_evaluated(const double *z_um, size_t count, double spacing_um, double cutoff_um,
                     unsigned char *evaluated);

#endif
