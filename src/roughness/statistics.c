/* Standard errors: for a Gaussian process the covariances c_p, c_q estimated from n heights have
 *   n cov(c_p, c_q) = sum over all j of (c_j c_(j+p-q) + c_(j+p) c_(j-q))          (Bartlett)
 * sigma^2 is c_0; tau is where c = c_0 / e, so d tau = (d c_tau - d c_0 / e) / |c'(tau)|. */
#include "roughness/statistics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

hetab_status hetab_statistics_create(hetab_context *ctx, size_t count, double spacing_um,
                                     hetab_statistics *statistics) {
  *statistics = (hetab_statistics){.spacing_um = spacing_um};
  HETAB_TRY(hetab_fft_create(ctx, 2 * count, &statistics->fft));
  statistics->work = hetab_alloc(ctx, statistics->fft.size, sizeof *statistics->work);
  statistics->correlation = hetab_alloc(ctx, count, sizeof *statistics->correlation);
  if (statistics->work && statistics->correlation)
    return HETAB_OK;
  hetab_statistics_free(statistics);
  return HETAB_ERR_MEMORY;
}

void hetab_statistics_free(hetab_statistics *statistics) {
  hetab_fft_free(&statistics->fft);
  free(statistics->work);
  free(statistics->correlation);
  *statistics = (hetab_statistics){0};
}

/* ---- heights ------------------------------------------------------------------------------- */

typedef struct scan_view {
  const double *z_um, *line_um;
  const unsigned char *evaluated;
  size_t first, count; /* from the first evaluated height to the last */
} scan_view;

static double height(const scan_view *v, size_t i) {
  return v->line_um ? v->z_um[i] - v->line_um[i] : v->z_um[i];
}

static scan_view view_of(const double *z_um, const double *line_um, const unsigned char *evaluated,
                         size_t count) {
  scan_view v = {z_um, line_um, evaluated, 0, 0};
  while (v.first < count && !evaluated[v.first])
    v.first++;
  while (count > v.first && !evaluated[count - 1])
    count--;
  v.count = count - v.first;
  return v;
}

typedef struct moments {
  size_t points;
  double mean, sigma, skewness, kurtosis;
  double difference; /* mean square of the differences of neighbours */
} moments;

static moments moments_of(const scan_view *v) {
  moments m = {0};
  double second = 0, third = 0, fourth = 0, differences = 0;
  size_t pairs = 0;
  for (size_t i = v->first; i < v->first + v->count; i++)
    if (v->evaluated[i]) {
      m.mean += height(v, i);
      m.points++;
    }
  m.mean /= (double)m.points;
  for (size_t i = v->first; i < v->first + v->count; i++) {
    if (!v->evaluated[i])
      continue;
    double d = height(v, i) - m.mean, d2 = d * d;
    second += d2;
    third += d2 * d;
    fourth += d2 * d2;
    if (i > v->first && v->evaluated[i - 1]) {
      double step = height(v, i) - height(v, i - 1);
      differences += step * step;
      pairs++;
    }
  }
  double variance = second / (double)m.points;
  m.sigma = sqrt(variance);
  m.skewness = third / (double)m.points / (variance * m.sigma);
  m.kurtosis = fourth / (double)m.points / (variance * variance);
  m.difference = pairs ? differences / (double)pairs : (double)NAN;
  return m;
}

/* ---- autocorrelation ----------------------------------------------------------------------- */

/* The spectra of heights a and of their presence b, transformed together as a + ib, come apart by
 * a's and b's being real; their squares go back together. */
static void square_spectra(hetab_statistics *s) {
  const hetab_fft *fft = &s->fft;
  for (size_t i = 0; i < fft->size; i++) {
    size_t bin = fft->bins[i];
    if (bin > fft->size / 2)
      continue;
    size_t other = fft->bins[(fft->size - bin) % fft->size];
    hetab_complex p = s->work[i], q = s->work[other];
    double a_re = p.re + q.re, a_im = p.im - q.im, b_re = p.im + q.im, b_im = q.re - p.re;
    hetab_complex squares = {0.25 * (a_re * a_re + a_im * a_im),
                             0.25 * (b_re * b_re + b_im * b_im)};
    s->work[i] = s->work[other] = squares;
  }
}

/* Eq. 1. With missing heights the sum of each lag's pairs is scaled up to as many as there would
 * be. */
static void correlate(hetab_statistics *s, const scan_view *v, double mean) {
  memset(s->work, 0, s->fft.size * sizeof *s->work);
  for (size_t i = 0; i < v->count; i++)
    if (v->evaluated[v->first + i])
      s->work[i] = (hetab_complex){height(v, v->first + i) - mean, 1};
  hetab_fft_forward(&s->fft, s->work);
  square_spectra(s);
  hetab_fft_inverse(&s->fft, s->work);
  double norm = s->work[0].re / round(s->work[0].im);
  s->lags = v->count;
  for (size_t k = 0; k < v->count; k++) {
    double pairs = round(s->work[k].im), share = 1 - (double)k / (double)v->count;
    s->correlation[k] = pairs > 0 ? s->work[k].re / pairs * share / norm : 0;
  }
}

/* tau in lags; 0: never, or the transforms stopped half-way. */
static double decay_lag(const hetab_statistics *s) {
  const double *c = s->correlation, level = exp(-1);
  for (size_t k = 1; k < s->lags && !hetab_stopping_at(s->fft.ctx, k - 1); k++)
    if (c[k] <= level)
      return (double)(k - 1) + (c[k - 1] - level) / (c[k - 1] - c[k]);
  return 0;
}

/* The autocorrelation at any whole lag, symmetric; 0 beyond `reach`, where there is only noise. */
static double at_lag(const hetab_statistics *s, long lag, long reach) {
  lag = labs(lag);
  return lag <= reach ? s->correlation[lag] : 0;
}

typedef struct lag_sums {
  double squares; /* of rho_j */
  double cubes, fourths;
  double shifted;  /* rho_j rho_(j+k) */
  double mirrored; /* rho_(j+k) rho_(j-k) */
  double slopes;   /* squares of the autocorrelation of first differences */
} lag_sums;

static lag_sums sum_lags(const hetab_statistics *s, long reach, long k) {
  lag_sums sums = {0};
  double curvature = 2 * (s->correlation[0] - s->correlation[1]);
  for (long j = -reach - k; j <= reach + k; j++) {
    double rho = at_lag(s, j, reach), square = rho * rho;
    double bend = 2 * rho - at_lag(s, j - 1, reach) - at_lag(s, j + 1, reach);
    sums.squares += square;
    sums.cubes += square * rho;
    sums.fourths += square * square;
    sums.shifted += rho * at_lag(s, j + k, reach);
    sums.mirrored += at_lag(s, j + k, reach) * at_lag(s, j - k, reach);
    if (labs(j) < reach && curvature > 0)
      sums.slopes += bend * bend / (curvature * curvature);
  }
  return sums;
}

/* How fast the autocorrelation falls at `lag`, per lag; over a few lags, for it may be noisy. */
static double fall_at(const hetab_statistics *s, double lag) {
  size_t reach = (size_t)(lag / 5) + 1, low = (size_t)lag, high = low + reach;
  if (high >= s->lags)
    high = s->lags - 1;
  low = low + 1 > reach ? low + 1 - reach : 0;
  return (s->correlation[low] - s->correlation[high]) / (double)(high - low);
}

static void set_errors(const hetab_statistics *s, double lag, size_t points,
                       hetab_scan_statistics *r) {
  double reach = fmin(6 * lag + 2, (double)(s->lags / 2)), n = (double)points;
  lag_sums sums = sum_lags(s, (long)reach, lround(lag));
  double v00 = 2 * sums.squares / n, v0k = 2 * sums.shifted / n;
  double vkk = (sums.squares + sums.mirrored) / n;
  double per_lag = 1 / fmax(fall_at(s, lag), 1e-12) / lag; /* d ln tau for a change of rho */
  double e = exp(-1), tau_variance = per_lag * per_lag * (vkk - 2 * e * v0k + e * e * v00);
  double mixed = 0.5 * per_lag * (v0k - e * v00); /* covariance of ln sigma and ln tau */
  r->sigma_um.error = r->sigma_um.value * 0.5 * sqrt(v00);
  r->tau_um.error = r->tau_um.value * sqrt(fmax(tau_variance, 0));
  r->slope.error = r->slope.value * sqrt(fmax(0.25 * v00 + tau_variance - 2 * mixed, 0));
  r->rms_slope.error = r->rms_slope.value * sqrt(0.5 * sums.slopes / n);
  r->skewness.error = sqrt(6 * fmax(sums.cubes, 1) / n);
  r->kurtosis.error = sqrt(24 * fmax(sums.fourths, 1) / n);
  r->independent = fmin(2 / v00, n);
}

static void set_misfits(const hetab_statistics *s, double lag, hetab_scan_statistics *r) {
  double gaussian = 0, exponential = 0;
  size_t last = (size_t)fmax(1.5 * lag, 2), count = 0;
  for (size_t k = 1; k <= last && k < s->lags; k++, count++) {
    double ratio = (double)k / lag, g = s->correlation[k] - exp(-ratio * ratio),
           e = s->correlation[k] - exp(-ratio);
    gaussian += g * g;
    exponential += e * e;
  }
  r->misfit_gaussian = sqrt(gaussian / (double)count);
  r->misfit_exponential = sqrt(exponential / (double)count);
}

/* ---- all ----------------------------------------------------------------------------------- */

/* What rounding leaves of a constant is no roughness. */
static bool has_roughness(const scan_view *v, const moments *m) {
  double largest = 0;
  for (size_t i = v->first; i < v->first + v->count; i++)
    if (v->evaluated[i])
      largest = fmax(largest, fabs(v->z_um[i]));
  return m->sigma > 1e-12 * largest && m->sigma > 1e-15;
}

bool hetab_sigma_tau(hetab_statistics *s, const double *z_um, const double *line_um,
                     const unsigned char *evaluated, size_t count, double *sigma_um,
                     double *tau_um) {
  scan_view v = view_of(z_um, line_um, evaluated, count);
  moments m = moments_of(&v);
  if (m.points < HETAB_LEAST_POINTS || !has_roughness(&v, &m))
    return false;
  correlate(s, &v, m.mean);
  double lag = decay_lag(s);
  *sigma_um = m.sigma;
  *tau_um = lag * s->spacing_um;
  return lag > 0;
}

bool hetab_statistics_of(hetab_statistics *s, const double *z_um, const double *line_um,
                         const unsigned char *evaluated, size_t count,
                         hetab_scan_statistics *result) {
  scan_view v = view_of(z_um, line_um, evaluated, count);
  moments m = moments_of(&v);
  if (m.points < HETAB_LEAST_POINTS || !has_roughness(&v, &m))
    return false;
  correlate(s, &v, m.mean);
  double lag = decay_lag(s), tau = lag * s->spacing_um;
  if (!(lag > 0))
    return false;
  result->points = m.points;
  result->length_um = (double)m.points * s->spacing_um;
  result->sigma_um.value = m.sigma;
  result->tau_um.value = tau;
  result->slope.value = m.sigma / tau;
  result->rms_slope.value = sqrt(m.difference) / s->spacing_um;
  result->skewness.value = m.skewness;
  result->kurtosis.value = m.kurtosis;
  set_errors(s, lag, m.points, result);
  set_misfits(s, lag, result);
  return true;
}

/* ---- distribution of heights --------------------------------------------------------------- */

enum { FINE_BINS = 20 * HETAB_HISTOGRAM_BINS };

double hetab_histogram_add(const double *z_um, const double *line_um,
                           const unsigned char *evaluated, size_t count, double *density) {
  scan_view v = view_of(z_um, line_um, evaluated, count);
  moments m = moments_of(&v);
  unsigned fine[FINE_BINS] = {0};
  for (size_t i = v.first; i < v.first + v.count; i++)
    if (evaluated[i]) {
      double at = ((height(&v, i) - m.mean) / m.sigma + 5) / 10 * FINE_BINS;
      fine[(int)fmax(0, fmin(FINE_BINS - 1, at))]++;
    }
  double below = 0, distance = 0, scale = HETAB_HISTOGRAM_BINS / (10.0 * (double)m.points);
  for (int i = 0; i < FINE_BINS; i++) {
    below += fine[i] / (double)m.points;
    double edge = -5 + 10.0 * (i + 1) / FINE_BINS;
    distance = fmax(distance, fabs(below - 0.5 * erfc(-edge * M_SQRT1_2)));
    density[i * HETAB_HISTOGRAM_BINS / FINE_BINS] += fine[i] * scale;
  }
  return distance;
}
