#include "roughness/two_scales.h"

#include <math.h>
#include <nlopt.h>

/* The filter's weights are a Gaussian of variance s^2 = alpha^2 cutoff^2 / (2 pi), alpha^2 = ln 2 /
 * pi; convolved with exp(-(r/tau)^2) they give a Gaussian again. Of c, the small-scale part keeps
 * c - 2 w * c + w * w * c. */
static double filtered_correlation(const hetab_two_scales *s, double variance_um2, double r_um) {
  double sum = 0;
  for (int i = 0; i < 2; i++) {
    double tau2 = s->tau_um[i] * s->tau_um[i], sigma2 = s->sigma_um[i] * s->sigma_um[i];
    double once = tau2 + 2 * variance_um2, twice = tau2 + 4 * variance_um2, r2 = r_um * r_um;
    sum += sigma2 * (exp(-r2 / tau2) - 2 * sqrt(tau2 / once) * exp(-r2 / once) +
                     sqrt(tau2 / twice) * exp(-r2 / twice));
  }
  return sum;
}

void hetab_two_scales_filtered(const hetab_two_scales *s, double cutoff_um, double *sigma_um,
                               double *tau_um) {
  double variance = M_LN2 / M_PI * cutoff_um * cutoff_um / (2 * M_PI);
  double most = filtered_correlation(s, variance, 0), level = most * exp(-1);
  double low = 0, high = 0.5 * s->tau_um[0];
  for (int i = 0; i < 60 && filtered_correlation(s, variance, high) > level; i++)
    high *= 2;
  for (int i = 0; i < 40; i++) {
    double middle = 0.5 * (low + high);
    if (filtered_correlation(s, variance, middle) > level)
      low = middle;
    else
      high = middle;
  }
  *sigma_um = sqrt(fmax(most, 0));
  *tau_um = 0.5 * (low + high);
}

typedef struct fit_data {
  const double *cutoff_um, *sigma_um, *tau_um;
  size_t count;
} fit_data;

static hetab_two_scales scales_at(const double *logs) {
  return (hetab_two_scales){{exp(logs[0]), exp(logs[2])}, {exp(logs[1]), exp(logs[3])}};
}

/* The weighted mean square of the differences. */
static double mean_square(const fit_data *d, const hetab_two_scales *s) {
  double sum = 0, weights = 0;
  for (size_t i = 0; i < d->count; i++) {
    double sigma, tau;
    hetab_two_scales_filtered(s, d->cutoff_um[i], &sigma, &tau);
    double a = log(fmax(sigma, 1e-300) / d->sigma_um[i]), b = log(tau / d->tau_um[i]);
    sum += 0.5 * (a * a + b * b) / d->cutoff_um[i];
    weights += 1 / d->cutoff_um[i];
  }
  return isfinite(sum) ? sum / weights : 1e300;
}

static double objective(unsigned n, const double *logs, double *gradient, void *user) {
  (void)n, (void)gradient;
  hetab_two_scales s = scales_at(logs);
  return mean_square(user, &s);
}

/* From one start; *least: the objective. */
static hetab_status fit_from(hetab_context *ctx, fit_data *data, double longest_um,
                             hetab_two_scales *scales, double *least) {
  double sigma = log(scales->sigma_um[0]), tau = log(scales->tau_um[0]);
  double logs[4] = {sigma, tau, log(scales->sigma_um[1]), log(scales->tau_um[1])};
  double low[4] = {sigma - 2, tau - 2, sigma - 9, tau + 1};
  double high[4] = {sigma + 2, tau + 2, sigma + 9, fmax(log(20 * longest_um), tau + 3)};
  for (int i = 0; i < 4; i++)
    logs[i] = fmin(fmax(logs[i], low[i]), high[i]);
  nlopt_opt opt = nlopt_create(NLOPT_LN_SBPLX, 4);
  if (!opt)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the fit of two scales");
  nlopt_set_min_objective(opt, objective, data);
  nlopt_set_lower_bounds(opt, low);
  nlopt_set_upper_bounds(opt, high);
  nlopt_set_xtol_abs1(opt, 1e-4);
  nlopt_set_maxeval(opt, 3000);
  nlopt_optimize(opt, logs, least); /* the best so far is in logs, however it ended */
  nlopt_destroy(opt);
  *scales = scales_at(logs);
  return HETAB_OK;
}

/* Where the large scale is far beyond the cut-offs, only sigma / tau^2 of it matters, and the way
 * to it may be long: it starts once near and once far. */
hetab_status hetab_two_scales_fit(hetab_context *ctx, const double *cutoff_um,
                                  const double *sigma_um, const double *tau_um, size_t count,
                                  double longest_um, hetab_two_scales *scales, double *misfit) {
  static const double factors[] = {1, 4};
  fit_data data = {cutoff_um, sigma_um, tau_um, count};
  const hetab_two_scales start = *scales;
  double best = HUGE_VAL;
  for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
    hetab_two_scales trial = start;
    double least = HUGE_VAL;
    trial.tau_um[1] *= factors[i];
    HETAB_TRY(fit_from(ctx, &data, longest_um, &trial, &least));
    if (least < best) {
      best = least;
      *scales = trial;
    }
  }
  *misfit = sqrt(best);
  return HETAB_OK;
}
