/* The series of h and a whole point on one core of the host, beside the one table of h that takes
 * the series' place: nanoseconds each, and the largest error of the table where h > 1e-6 of its
 * peak. The nine surfaces are those of the renderers' tests. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/random.h"
#include "model/model.h"
#include "model/universal.h"

enum { COUNT = 4096, RUNS = 25 };

static const double SIGMA0_TAU_UM[][2] = {{0.72, 5.6}, {0.54, 6.5},  {0.42, 1.9},
                                          {0.17, 5.0}, {0.05, 60.0}, {0.02, 3.0},
                                          {5.0, 20.0}, {1.0, 1.0},   {0.02, 0.2}};
enum { SURFACES = sizeof SIGMA0_TAU_UM / sizeof *SIGMA0_TAU_UM };

typedef double (*ln_h_fn)(double g, double x);

/* Angles, and the two numbers of the series that they come to. */
typedef struct load {
  double theta_i[COUNT], theta_r[COUNT], phi[COUNT], g[COUNT], x[COUNT];
} load;

static double dd(const load *l, int i, double sigma0, double tau, ln_h_fn ln_h, load *keep) {
  const hetab_band band = {0.55, 1.44, 0.6, 0.0};
  double tau_2sigma = tau / (2.0 * sigma0);
  hetab_wave wave = hetab_wave_of(sigma0, tau, &band);
  hetab_direction in = hetab_direction_at(l->theta_i[i], tau_2sigma);
  hetab_direction out = hetab_direction_at(l->theta_r[i], tau_2sigma);
  hetab_pair pair = hetab_pair_of(&in, &out);
  double lateral2 = pair.d2 + pair.p * hetab_one_plus_cos(l->phi[i]);
  double cos2 = fmin(0.25 * (pair.mu2 + lateral2), 1.0);
  double g = wave.g * pair.mu2 * pair.ratio2, x = wave.x * lateral2;
  if (keep)
    keep->g[i] = g, keep->x[i] = x;
  return hetab_fresnel_at(cos2, band.n, band.k) * cos2 * cos2 * wave.amplitude * pair.shadow *
         exp(ln_h(g, x));
}

/* Pairs about the mirror direction, to 89.5 degrees. */
static void fill(load *l, double sigma0, double tau, uint64_t *random) {
  double width = fmin(1.0, 2.0 * sigma0 / tau + 0.55 / tau), most = 89.5 / 180.0 * M_PI;
  for (int i = 0; i < COUNT; i++) {
    l->theta_i[i] = most * hetab_random_unit(random);
    double away = 4.0 * width * (hetab_random_unit(random) - 0.5);
    l->theta_r[i] = fmin(most, fabs(l->theta_i[i] + away));
    l->phi[i] = M_PI + 4.0 * width * (hetab_random_unit(random) - 0.5);
    dd(l, i, sigma0, tau, hetab_universal_ln_h, l);
  }
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Nanoseconds of h, or of a point where there is a surface; the fastest of the runs. */
static double time_of(const load *l, const double *surface, ln_h_fn ln_h) {
  double best = INFINITY;
  volatile double sum = 0.0;
  for (int run = 0; run < RUNS; run++) {
    double start = seconds(), total = 0.0;
    for (int i = 0; i < COUNT; i++)
      total += surface ? dd(l, i, surface[0], surface[1], ln_h, NULL) : exp(ln_h(l->g[i], l->x[i]));
    sum = sum + total;
    best = fmin(best, seconds() - start);
  }
  return 1e9 * best / COUNT;
}

static double error_of(const load *l) {
  double worst = 0.0;
  for (int i = 0; i < COUNT; i++) {
    double ln_h = hetab_ln_h(l->g[i], l->x[i]);
    if (ln_h - hetab_ln_h(l->g[i], 0.0) > log(1e-6))
      worst = fmax(worst, fabs(expm1(hetab_universal_ln_h(l->g[i], l->x[i]) - ln_h)));
  }
  return worst;
}

int main(void) {
  static load l;
  uint64_t random = 5;
  puts("sigma0_um,tau_um,h_series_ns,h_table_ns,ratio,point_series_ns,point_table_ns,ratio,error");
  for (int s = 0; s < SURFACES; s++) {
    const double *surface = SIGMA0_TAU_UM[s];
    fill(&l, surface[0], surface[1], &random);
    double h[2] = {time_of(&l, NULL, hetab_ln_h), time_of(&l, NULL, hetab_universal_ln_h)};
    double p[2] = {time_of(&l, surface, hetab_ln_h), time_of(&l, surface, hetab_universal_ln_h)};
    printf("%g,%g,%.0f,%.0f,%.1f,%.0f,%.0f,%.1f,%.1e\n", surface[0], surface[1], h[0], h[1],
           h[0] / h[1], p[0], p[1], p[0] / p[1], error_of(&l));
  }
  return 0;
}
