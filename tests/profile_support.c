#include "profile_support.h"

#include <math.h>
#include <stdlib.h>

double random_uniform(uint64_t *state) { /* splitmix64 */
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return ((double)((z ^ z >> 31) >> 11) + 0.5) / 9007199254740992.0;
}

double random_normal(uint64_t *state) {
  double radius = sqrt(-2 * log(random_uniform(state)));
  return radius * cos(2 * M_PI * random_uniform(state));
}

/* Gaussian bumps exp(-2 (x / tau)^2) with normal heights on nodes a quarter of tau apart: by
 * Poisson summation the autocorrelation is the Gaussian's to 1e-15, wherever the nodes are. */
void add_gaussian_profile(double *z_um, size_t count, double spacing_um, profile_scale scale,
                          uint64_t *state) {
  long step = (long)fmax(1, floor(scale.tau_um / 4 / spacing_um));
  long reach = (long)ceil(3 * scale.tau_um / spacing_um);
  double *bump = malloc((size_t)(2 * reach + 1) * sizeof *bump), squares = 0;
  for (long i = -reach; i <= reach; i++) {
    double x = (double)i * spacing_um / scale.tau_um;
    bump[i + reach] = exp(-2 * x * x);
    squares += bump[i + reach] * bump[i + reach];
  }
  double height = scale.sigma_um / sqrt(squares / (double)step);
  for (long node = -reach; node < (long)count + reach; node += step) {
    double normal = height * random_normal(state);
    long from = node - reach < 0 ? 0 : node - reach;
    long to = node + reach < (long)count ? node + reach : (long)count - 1;
    for (long i = from; i <= to; i++)
      z_um[i] += normal * bump[i - node + reach];
  }
  free(bump);
}

void add_exponential_profile(double *z_um, size_t count, double spacing_um, profile_scale scale,
                             uint64_t *state) {
  double keep = exp(-spacing_um / scale.tau_um), value = random_normal(state);
  for (size_t i = 0; i < count; i++) {
    z_um[i] += scale.sigma_um * value;
    value = keep * value + sqrt(1 - keep * keep) * random_normal(state);
  }
}

/* Of one process, exp(-(r / tau)^2) <-> sqrt(pi) tau exp(-(pi tau f)^2): the trapezoidal rule over
 * f, which for such spectra converges faster than any power. */
static double filtered_one(profile_scale scale, double cutoff_um, double r_um) {
  enum { STEPS = 200 };
  double last = 2.2 / scale.tau_um, sum = 0, step = last / STEPS;
  for (int i = -STEPS; i <= STEPS; i++) {
    double f = i * step, arc = M_PI * scale.tau_um * f, waves = cutoff_um * f;
    double kept = cutoff_um > 0 ? 1 - pow(0.5, waves * waves) : 1;
    sum += sqrt(M_PI) * scale.tau_um * exp(-arc * arc) * kept * kept * cos(2 * M_PI * f * r_um);
  }
  return scale.sigma_um * scale.sigma_um * sum * step;
}

static double filtered(const profile_scale scales[2], double cutoff_um, double r_um) {
  return filtered_one(scales[0], cutoff_um, r_um) + filtered_one(scales[1], cutoff_um, r_um);
}

profile_truth filtered_truth(const profile_scale scales[2], double spacing_um, double cutoff_um) {
  double variance = filtered(scales, cutoff_um, 0), level = variance * exp(-1);
  double low = 0, high = 0.1 * scales[0].tau_um;
  while (filtered(scales, cutoff_um, high) > level)
    high *= 1.3;
  for (int i = 0; i < 30; i++) {
    double middle = 0.5 * (low + high);
    *(filtered(scales, cutoff_um, middle) > level ? &low : &high) = middle;
  }
  double difference = 2 * (variance - filtered(scales, cutoff_um, spacing_um));
  return (profile_truth){sqrt(variance), low, sqrt(variance) / low, sqrt(difference) / spacing_um};
}

double largest_slope_cutoff(const profile_scale scales[2], double low_um, double high_um) {
  double best = low_um, most = 0;
  for (double cutoff = low_um; cutoff <= high_um; cutoff *= 1.01) {
    double slope = filtered_truth(scales, 0.1, cutoff).slope;
    if (slope > most) {
      most = slope;
      best = cutoff;
    }
  }
  return best;
}
