#include "roughness/line_filter.h"
#include "core/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ISO 16610-31: residuals beyond 4.4478 times their median size count for nothing. */
static const double BEYOND = 4.4478, SETTLED = 1e-4;
static const double LEAST_TRUST = 1e-6; /* a pit wider than the cut-off has a line, too */
enum { MOST_ROUNDS = 50 };

const char *hetab_filter_name(hetab_filter filter) {
  static const char *const names[] = {"Gaussian", "robust Gaussian", "Fourier", "moving average"};
  return names[filter];
}

/* The weights are below 1e-7 of their sum beyond one cut-off from the middle: so much padding keeps
 * the two ends of the scan apart. */
hetab_status hetab_line_filter_create(hetab_context *ctx, hetab_filter kind, size_t count,
                                      double spacing_um, double max_cutoff_um,
                                      hetab_line_filter *filter) {
  *filter = (hetab_line_filter){.kind = kind, .spacing_um = spacing_um};
  size_t padding = (size_t)ceil(max_cutoff_um / spacing_um);
  HETAB_TRY(hetab_fft_create(ctx, count + padding, &filter->fft));
  filter->spectrum = hetab_alloc(ctx, filter->fft.size, sizeof *filter->spectrum);
  filter->work = hetab_alloc(ctx, filter->fft.size, sizeof *filter->work);
  filter->sizes = hetab_alloc(ctx, count, sizeof *filter->sizes);
  if (filter->spectrum && filter->work && filter->sizes)
    return HETAB_OK;
  hetab_line_filter_free(filter);
  return HETAB_ERR_MEMORY;
}

void hetab_line_filter_free(hetab_line_filter *filter) {
  hetab_fft_free(&filter->fft);
  free(filter->spectrum);
  free(filter->work);
  free(filter->sizes);
  *filter = (hetab_line_filter){0};
}

/* Tukey's weight of a residual. */
static double trust(double residual, double beyond) {
  double part = 1 - residual * residual / (beyond * beyond);
  return part > 0 ? fmax(part * part, LEAST_TRUST) : LEAST_TRUST;
}

/* line_um: what the heights' weights follow from; NULL: all are 1. */
static void transform(hetab_line_filter *filter, const double *line_um, double beyond) {
  memset(filter->spectrum, 0, filter->fft.size * sizeof *filter->spectrum);
  for (size_t i = 0; i < filter->count; i++)
    if (!isnan(filter->z_um[i])) {
      double w = line_um ? trust(filter->z_um[i] - line_um[i], beyond) : 1;
      filter->spectrum[i] = (hetab_complex){w * filter->z_um[i], w};
    }
  hetab_fft_forward(&filter->fft, filter->spectrum);
}

void hetab_line_filter_load(hetab_line_filter *filter, const double *z_um, size_t count) {
  filter->count = count;
  filter->z_um = z_um;
  transform(filter, NULL, 0);
}

/* Of the mean line, at a bin of the spectrum; width: the cut-off in spacings. */
static double transmission(hetab_filter kind, double width, double turn) {
  double waves = width * turn;
  switch (kind) {
  case HETAB_FILTER_FOURIER:
    return waves <= 1;
  case HETAB_FILTER_AVERAGE:
    return turn > 0 ? sin(M_PI * waves) / (width * sin(M_PI * turn)) : 1;
  default:
    return exp2(-waves * waves);
  }
}

/* Both parts are filtered at once, the weights being even; their quotient is the mean over the
 * weights that meet a height. */
static void weighted_line(hetab_line_filter *filter, double cutoff_um, double *line_um) {
  size_t size = filter->fft.size;
  for (size_t i = 0; i < size; i++) {
    size_t bin = filter->fft.bins[i];
    double turn = (double)(bin <= size / 2 ? bin : size - bin) / (double)size;
    double part = transmission(filter->kind, cutoff_um / filter->spacing_um, turn);
    filter->work[i].re = part * filter->spectrum[i].re;
    filter->work[i].im = part * filter->spectrum[i].im;
  }
  hetab_fft_inverse(&filter->fft, filter->work);
  for (size_t i = 0; i < filter->count; i++)
    line_um[i] = filter->work[i].re / filter->work[i].im;
}

static double median_residual(const hetab_line_filter *filter, const double *line_um) {
  size_t count = 0;
  for (size_t i = 0; i < filter->count; i++)
    if (!isnan(filter->z_um[i]))
      filter->sizes[count++] = fabs(filter->z_um[i] - line_um[i]);
  hetab_sort(filter->sizes, count);
  return count ? filter->sizes[count / 2] : 0;
}

/* Weights follow the residuals, until their median settles. */
static void robust_line(hetab_line_filter *filter, double cutoff_um, double *line_um) {
  double before = 0;
  for (int round = 0; round < MOST_ROUNDS && !hetab_stopping(filter->fft.ctx); round++) {
    double median = median_residual(filter, line_um);
    if (!(fabs(median - before) > SETTLED * median))
      break;
    transform(filter, line_um, BEYOND * median);
    weighted_line(filter, cutoff_um, line_um);
    before = median;
  }
  transform(filter, NULL, 0); /* as it was loaded */
}

void hetab_line_filter_line(hetab_line_filter *filter, double cutoff_um, double *line_um) {
  weighted_line(filter, cutoff_um, line_um);
  if (filter->kind == HETAB_FILTER_ROBUST)
    robust_line(filter, cutoff_um, line_um);
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

hetab_status hetab_mean_line(hetab_context *ctx, hetab_filter kind, const double *z_um,
                             size_t count, double spacing_um, double cutoff_um, double *line_um,
                             unsigned char *evaluated) {
  if (!(spacing_um > 0 && cutoff_um >= 10 * spacing_um && cutoff_um <= (double)count * spacing_um))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "a cut-off of %g um does not suit %zu heights %g um apart: give one between "
                      "10 spacings and the length of the scan",
                      cutoff_um, count, spacing_um);
  hetab_line_filter filter;
  HETAB_TRY(hetab_line_filter_create(ctx, kind, count, spacing_um, cutoff_um, &filter));
  hetab_line_filter_load(&filter, z_um, count);
  hetab_line_filter_line(&filter, cutoff_um, line_um);
  hetab_evaluated(z_um, count, spacing_um, cutoff_um, evaluated);
  hetab_line_filter_free(&filter);
  return HETAB_OK;
}
