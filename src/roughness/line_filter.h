/* The mean lines of one scan, at as many cut-offs as wanted, by the filters of hetab_filter. */
#pragma once

#include <stdbool.h>
#include <hetab/roughness.h>
#include "roughness/fft.h"

typedef struct hetab_line_filter {
  hetab_filter kind;
  hetab_fft fft;
  double spacing_um;
  const double *z_um;      /* of the scan at hand */
  size_t count;            /* of the scan's heights */
  hetab_complex *spectrum; /* of heights (real part) and of where there are any (imaginary) */
  hetab_complex *work;
  double *sizes; /* of residuals, for their median */
} hetab_line_filter;

/* For scans of up to `count` heights and cut-offs up to max_cutoff_um. */
hetab_status hetab_line_filter_create(hetab_context *ctx, hetab_filter kind, size_t count,
                                      double spacing_um, double max_cutoff_um,
                                      hetab_line_filter *filter);
void hetab_line_filter_free(hetab_line_filter *filter);

/* The scan that the next mean lines are of, which has to stay; NaN: missing. */
void hetab_line_filter_load(hetab_line_filter *filter, const double *z_um, size_t count);

/* Mean line where the scan has a height, and across gaps that the weights reach over. */
void hetab_line_filter_line(hetab_line_filter *filter, double cutoff_um, double *line_um);

/* Which heights are evaluated: not missing, and further than half a cut-off from the ends and from
 * gaps longer than a tenth of the cut-off. */
void hetab_evaluated(const double *z_um, size_t count, double spacing_um, double cutoff_um,
                     unsigned char *evaluated);
