/* Random profiles with a known autocorrelation, and what the process has behind the Gaussian
 * filter: nothing here uses the code under test. */
#ifndef HETAB_TESTS_PROFILE_SUPPORT_H
#define HETAB_TESTS_PROFILE_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

/* A Gaussian process with the autocorrelation sigma^2 exp(-(r / tau)^2). */
typedef struct profile_scale {
  double sigma_um, tau_um;
} profile_scale;

typedef struct profile_truth {
  double sigma_um, tau_um, slope, rms_slope; /* rms_slope: of first differences */
} profile_truth;

/* Random numbers, by their state: uniform in (0, 1), standard normal. */
double random_uniform(uint64_t *state);
double random_normal(uint64_t *state);

/* Adds a sample of the process to z_um[count]. */
void add_gaussian_profile(double *z_um, size_t count, double spacing_um, profile_scale scale,
                          uint64_t *state);
/* The same with sigma^2 exp(-r / tau). */
void add_exponential_profile(double *z_um, size_t count, double spacing_um, profile_scale scale,
                             uint64_t *state);

/* Of the sum of two processes behind the filter: their power spectra times (1 - transmission)^2,
 * by quadrature. cutoff_um 0: no filter. */
profile_truth filtered_truth(const profile_scale scales[2], double spacing_um, double cutoff_um);

/* The cut-off with the largest sigma / tau, to 1 %, between the two given. */
double largest_slope_cutoff(const profile_scale scales[2], double low_um, double high_um);

#endif
