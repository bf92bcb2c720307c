#include "roughness/gaussian_filter.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <hetab/roughness.h>

/* The weights are below 1e-7 of their sum beyond one cut-off from the middle: so much padding keeps
 * the two ends of the scan apart. */
hetab_status hetab_gaussian_filter_create(hetab_context *ctx, size_t count, double spacing_um,
                                          double max_cutoff_um, hetab_gaussian_filter *filter) {
  *filter = (hetab_gaussian_filter){.spacing_um = spacing_um};
  size_t padding = (size_t)ceil(max_cutoff_um / spacing_um);
  HETAB_TRY(hetab_fft_create(ctx, count + padding, &filter->fft));
  filter->spectrum = hetab_alloc(ctx, filter->fft.size, sizeof *filter->spectrum);
  filter->work = hetab_alloc(ctx, filter->fft.size, sizeof *filter->work);
  if (filter->spectrum && filter->work)
    return HETAB_OK;
  hetab_gaussian_filter_free(filter);
  return HETAB_ERR_MEMORY;
}

void hetab_gaussian_filter_free(hetab_gaussian_filter *filter) {
  hetab_fft_free(&filter->fft);
  free(filter->spectrum);
  free(filter->work);
  *filter = (hetab_gaussian_filter){0};
}

void hetab_gaussian_filter_load(hetab_gaussian_filter *filter, const double *z_um, size_t count) {
  filter->count = count;
  memset(filter->spectrum, 0, filter->fft.size * sizeof *filter->spectrum);
  for (size_t i = 0; i < count; i++)
    if (!isnan(z_um[i]))
      filter->spectrum[i] = (hetab_complex){z_um[i], 1};
  hetab_fft_forward(&filter->fft, filter->spectrum);
}

/* Both parts are filtered at once, the weights being even; their quotient is the mean over the
 * weights that meet a height. */
void hetab_gaussian_filter_line(hetab_gaussian_filter *filter, double cutoff_um, double *line_um) {
  size_t size = filter->fft.size;
  double step = cutoff_um / ((double)size * filter->spacing_um);
  for (size_t i = 0; i < size; i++) {
    size_t bin = filter->fft.bins[i];
    double waves = step * (double)(bin <= size / 2 ? bin : size - bin);
    double transmission = exp2(-waves * waves);
    filter->work[i].re = transmission * filter->spectrum[i].re;
    filter->work[i].im = transmission * filter->spectrum[i].im;
  }
  hetab_fft_inverse(&filter->fft, filter->work);
  for (size_t i = 0; i < filter->count; i++)
    line_um[i] = filter->work[i].re / filter->work[i].im;
}

static size_t run_length(const double *z_um, size_t from, size_t count, bool missing) {
  size_t to = from;
  while (to < count && (isnan(z_um[to]) != 0) == missing)
    to++;
  return to - from;
}

/* Marks the heights of z[from .. to) that are not in its end zones. */
static void mark_stretch(const double *z_um, size_t from, size_t to, size_t zone,
                         unsigned char *evaluated) {
  for (size_t i = from + zone; i + zone < to; i++)
    if (!isnan(z_um[i]))
      evaluated[i] = 1;
}

void hetab_evaluated(const double *z_um, size_t count, double spacing_um, double cutoff_um,
                     unsigned char *evaluated) {
  /* A spacing that rounding made a little short takes no further height. */
  size_t zone = (size_t)ceil(0.5 * cutoff_um / spacing_um * (1 - 1e-6));
  double longest_gap = 0.1 * cutoff_um / spacing_um;
  memset(evaluated, 0, count);
  size_t start = run_length(z_um, 0, count, true), at = start;
  while (at < count) {
    size_t end = at + run_length(z_um, at, count, false);
    at = end + run_length(z_um, end, count, true);
    if (at < count && (cutoff_um <= 0 || (double)(at - end) <= longest_gap))
      continue;
    mark_stretch(z_um, start, end, zone, evaluated);
    start = at;
  }
}

hetab_status hetab_mean_line(hetab_context *ctx, const double *z_um, size_t count,
                             double spacing_um, double cutoff_um, double *line_um,
                             unsigned char *evaluated) {
  if (!(spacing_um > 0 && cutoff_um >= 10 * spacing_um && cutoff_um <= (double)count * spacing_um))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "a cut-off of %g um does not suit %zu heights %g um apart: give one between "
                      "10 spacings and the length of the scan",
                      cutoff_um, count, spacing_um);
  hetab_gaussian_filter filter;
  HETAB_TRY(hetab_gaussian_filter_create(ctx, count, spacing_um, cutoff_um, &filter));
  hetab_gaussian_filter_load(&filter, z_um, count);
  hetab_gaussian_filter_line(&filter, cutoff_um, line_um);
  hetab_evaluated(z_um, count, spacing_um, cutoff_um, evaluated);
  hetab_gaussian_filter_free(&filter);
  return HETAB_OK;
}
