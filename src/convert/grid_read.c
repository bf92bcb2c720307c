#include "convert/grid_read.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "core/random.h"
#include "model/model.h"

/* ---- a reader ------------------------------------------------------------------------------ */

typedef struct between {
  double node[2], weight[2];
} between;

static between between_at(const hetab_grid *grid, hetab_axis axis, double x) {
  const double *nodes = hetab_grid_radians(grid, axis);
  size_t low = 0, high = hetab_grid_count(grid, axis) - 1;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (nodes[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  double t = high > low ? (x - nodes[low]) / (nodes[high] - nodes[low]) : 0.0;
  t = fmin(fmax(t, 0.0), 1.0);
  return (between){{nodes[low], nodes[high]}, {1.0 - t, t}};
}

hetab_status hetab_grid_read(hetab_context *ctx, const hetab_grid *grid, hetab_rgl_values_fn values,
                             void *user, size_t channels, const hetab_directions *pair,
                             double *corners, double *value) {
  hetab_directions nodes[8];
  double weight[8];
  between i = between_at(grid, HETAB_THETA_I, pair->theta_i);
  between r = between_at(grid, HETAB_THETA_R, pair->theta_r);
  double turn = fabs(remainder(pair->phi, 2.0 * M_PI));
  between p = between_at(grid, HETAB_PHI, turn);
  for (int n = 0; n < 8; n++) {
    nodes[n] = (hetab_directions){i.node[n & 1], r.node[n >> 1 & 1], p.node[n >> 2]};
    weight[n] = i.weight[n & 1] * r.weight[n >> 1 & 1] * p.weight[n >> 2];
  }
  HETAB_TRY(values(ctx, user, nodes, 8, corners));
  for (size_t c = 0; c < channels; c++) {
    value[c] = 0.0;
    for (size_t n = 0; n < 8; n++)
      value[c] += weight[n] * corners[n * channels + c];
  }
  return HETAB_OK;
}

/* ---- a surface's table --------------------------------------------------------------------- */

/* The first, the middle and the last wavelength stand for all. */
enum { BANDS = 3, PAIRS = 1200 };
static const double STEEPEST = 80.0 * M_PI / 180.0;

typedef struct surface_values {
  double tau_2sigma;
  hetab_band band[BANDS];
  hetab_wave wave[BANDS];
} surface_values;

static hetab_status values_of(hetab_context *ctx, void *user, const hetab_directions *pairs,
                              size_t count, double *values) {
  const surface_values *s = user;
  (void)ctx;
  for (size_t n = 0; n < count; n++) {
    hetab_direction in = hetab_direction_at(pairs[n].theta_i, s->tau_2sigma);
    hetab_direction to = hetab_direction_at(pairs[n].theta_r, s->tau_2sigma);
    hetab_pair p = hetab_pair_of(&in, &to);
    double lateral2 = p.d2 + p.p * hetab_one_plus_cos(pairs[n].phi), g = p.mu2 * p.ratio2;
    double cos2_d = fmin(0.25 * (p.mu2 + lateral2), 1.0);
    bool grazing = !(in.mu > 0.0 && to.mu > 0.0); /* where tables hold the limit, 0 */
    for (int b = 0; b < BANDS; b++) {
      const hetab_wave *w = &s->wave[b];
      double dd = grazing
                      ? 0.0
                      : hetab_fresnel_at(cos2_d, s->band[b].n, s->band[b].k) * cos2_d * cos2_d *
                            w->amplitude * p.shadow * exp(hetab_ln_h(w->g * g, w->x * lateral2));
      values[n * BANDS + (size_t)b] = dd + w->diffuse_brdf;
    }
  }
  return HETAB_OK;
}

/* The lobe's standard deviation in direction cosines. */
static double lobe_of(const hetab_wave *w, double mu) {
  return sqrt(fmax(4.0 * w->g * mu * mu, 1.0) / (2.0 * w->x));
}

/* Half of the directions fill the hemisphere, half the lobe's surroundings. */
static double draw(const surface_values *s, double theta_i, uint64_t *random, int near,
                   hetab_directions *pair) {
  double wide = fmin(4.0 * lobe_of(&s->wave[BANDS / 2], cos(theta_i)), 1.0), si = sin(theta_i);
  double x = 2.0 * hetab_random_unit(random) - 1.0, y = 2.0 * hetab_random_unit(random) - 1.0;
  if (near) {
    x = wide * x - si;
    y *= wide;
  }
  bool inside = fabs(x + si) < wide && fabs(y) < wide;
  *pair = (hetab_directions){theta_i, asin(fmin(hypot(x, y), 1.0)), atan2(y, x)};
  return hypot(x, y) < 1.0 ? 1.0 / (0.25 + (inside ? 0.25 / (wide * wide) : 0.0)) : 0.0;
}

static hetab_status measure(hetab_context *ctx, surface_values *s, const hetab_grid *grid,
                            double *error_l1) {
  double absolute = 0.0, sum = 0.0;
  uint64_t random = 1;
  for (int n = 0; n < PAIRS; n++) {
    hetab_directions pair;
    double found[BANDS], exact[BANDS], corners[8 * BANDS];
    double theta_i = (n + hetab_random_unit(&random)) / PAIRS * STEEPEST;
    double weight = draw(s, theta_i, &random, n & 1, &pair);
    if (!(weight > 0.0))
      continue;
    HETAB_TRY(values_of(ctx, s, &pair, 1, exact));
    HETAB_TRY(hetab_grid_read(ctx, grid, values_of, s, BANDS, &pair, corners, found));
    for (int b = 0; b < BANDS; b++) {
      absolute += weight * fabs(found[b] - exact[b]);
      sum += weight * exact[b];
    }
  }
  *error_l1 = sum > 0.0 ? absolute / sum : 0.0;
  return HETAB_OK;
}

static double widest_step(const hetab_grid *grid, hetab_axis axis) {
  const double *deg = hetab_grid_deg(grid, axis);
  double step = 0.0;
  for (size_t i = 1; i < hetab_grid_count(grid, axis); i++)
    step = fmax(step, deg[i] - deg[i - 1]);
  return step;
}

/* theta_r is narrowest where the light falls straight, phi where the lobe stands low. */
static void compare_widths(const surface_values *s, const hetab_grid *grid,
                           hetab_grid_report *report) {
  double theta = HUGE_VAL, phi = HUGE_VAL;
  for (int b = 0; b < BANDS; b++)
    for (double deg = 0.0; deg <= 75.0; deg += 5.0) {
      double mu = cos(hetab_radians(deg)), lobe = lobe_of(&s->wave[b], mu);
      theta = fmin(theta, lobe / mu);
      phi = deg > 0.0 ? fmin(phi, lobe / sin(hetab_radians(deg))) : phi;
    }
  report->lobe_deg = theta * 180.0 / M_PI;
  report->step_deg = fmax(widest_step(grid, HETAB_THETA_I), widest_step(grid, HETAB_THETA_R));
  /* a linear reader loses about a tenth of (step / width)^2 */
  report->theta_count = (size_t)ceil(M_PI_2 / (0.65 * theta)) + 1;
  report->phi_count = (size_t)ceil(M_PI / (0.65 * phi)) + 1;
}

hetab_status hetab_grid_try(hetab_context *ctx, const hetab_surface *surface,
                            const hetab_grid *grid, hetab_grid_report *report) {
  const hetab_band *bands = hetab_surface_bands(surface);
  size_t last = hetab_surface_band_count(surface) - 1;
  surface_values s = {.tau_2sigma = hetab_tau_2sigma(surface)};
  for (size_t b = 0; b < BANDS; b++) {
    s.band[b] = bands[b * last / (BANDS - 1)];
    s.wave[b] =
        hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), &s.band[b]);
  }
  compare_widths(&s, grid, report);
  return measure(ctx, &s, grid, &report->error_l1);
}
