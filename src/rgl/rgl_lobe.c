/* The density of half vectors that a table is laid out by, from the source's own values.
 *
 * For a microfacet lobe f cos(theta_i) cos(theta_r) is D(theta_m) times what changes slowly. Lobes
 * whose width depends on theta_d (those of smooth surfaces do) need room for the widest: the mean
 * over several theta_d, each normalised. */
#include <math.h>
#include <stdlib.h>

#include "model/model.h"
#include "rgl/rgl_table.h"

static const double theta_d_deg[] = {0.0, 30.0, 50.0, 65.0, 76.0};
static const double phi_d_deg[] = {45.0, 90.0};
/* The part of the mixture that is uniform, so that no direction is without nodes. */
static const double broad = 0.001;
enum {
  THETA_D = sizeof theta_d_deg / sizeof *theta_d_deg,
  PHI_D = sizeof phi_d_deg / sizeof *phi_d_deg
};

/* The pair of half vector theta_h and difference (theta_d, phi_d); the product of its cosines, 0
 * if it is not above the horizon. */
static double pair_of(double theta_h, double theta_d, double phi_d, hetab_rgl_pair *pair) {
  double a = cos(theta_h) * cos(theta_d), b = sin(theta_h) * sin(theta_d) * cos(phi_d);
  double mu_i = a - b, mu_r = a + b;
  double x = sin(theta_h) * cos(theta_d), dx = cos(theta_h) * sin(theta_d) * cos(phi_d);
  double dy = sin(theta_d) * sin(phi_d);
  double i[2] = {x + dx, dy}, r[2] = {x - dx, -dy};
  *pair = (hetab_rgl_pair){atan2(hypot(i[0], i[1]), mu_i), atan2(hypot(r[0], r[1]), mu_r),
                           atan2(i[0] * r[1] - i[1] * r[0], i[0] * r[0] + i[1] * r[1])};
  return mu_i > 1e-6 && mu_r > 1e-6 ? mu_i * mu_r : 0.0;
}

/* The mean over phi_d of f cos cos, [THETA_D][count]. */
static hetab_status lobes(hetab_context *ctx, const hetab_rgl_source *source, const double *theta_m,
                          size_t count, double *out) {
  size_t total = (size_t)THETA_D * PHI_D * count, filled = 0;
  hetab_rgl_pair *pairs = hetab_alloc(ctx, total, sizeof *pairs);
  double *weight = hetab_alloc(ctx, total, sizeof *weight);
  double *values = hetab_alloc(ctx, total * source->channels, sizeof *values);
  hetab_status status = HETAB_ERR_MEMORY;
  if (!pairs || !weight || !values)
    goto done;
  for (size_t d = 0; d < THETA_D; d++)
    for (size_t i = 0; i < count; i++)
      for (size_t p = 0; p < PHI_D; p++, filled++) {
        double theta_h = fmin(theta_m[i], M_PI_2 - 1e-3);
        weight[filled] = pair_of(theta_h, hetab_radians(theta_d_deg[d]),
                                 hetab_radians(phi_d_deg[p]), &pairs[filled]);
        if (weight[filled] == 0.0)
          pairs[filled] = (hetab_rgl_pair){0};
      }
  HETAB_GOTO(source->values(ctx, source->user, pairs, total, values));
  for (size_t k = 0; k < THETA_D * count; k++) {
    double sum = 0.0, valid = 0.0;
    for (size_t p = k * PHI_D; p < (k + 1) * PHI_D; p++) {
      sum += weight[p] * hetab_rgl_luminance(source, values + p * source->channels);
      valid += weight[p] > 0.0;
    }
    out[k] = valid > 0.0 ? sum / valid : 0.0;
  }
done:
  free(pairs);
  free(weight);
  free(values);
  return status;
}

/* The integral of D cos over the hemisphere, trapezoidal. */
static double projected(const double *theta, const double *density, size_t count) {
  double sum = 0.0;
  for (size_t i = 1; i < count; i++) {
    double a = density[i - 1] * sin(2.0 * theta[i - 1]), b = density[i] * sin(2.0 * theta[i]);
    sum += 0.5 * M_PI * (a + b) * (theta[i] - theta[i - 1]);
  }
  return sum;
}

/* The width of a smooth surface's lobe grows as 1 / cos(theta_d); its wide parts need their share
 * of the nodes most, for the narrow ones stand on top of them. */
static double share(size_t d) {
  double cosine = cos(hetab_radians(theta_d_deg[d]));
  return 1.0 / (cosine * cosine);
}

hetab_status hetab_rgl_lobe_from_data(hetab_context *ctx, const hetab_rgl_source *source,
                                      const double *theta_m, size_t count, double *density) {
  double *lobe = hetab_alloc(ctx, THETA_D * count, sizeof *lobe), shares = 0.0;
  hetab_status status = HETAB_ERR_MEMORY;
  if (!lobe)
    return status;
  HETAB_GOTO(lobes(ctx, source, theta_m, count, lobe));
  for (size_t i = 0; i < count; i++)
    density[i] = broad / M_PI;
  for (size_t d = 0; d < THETA_D; d++)
    shares += share(d);
  for (size_t d = 0; d < THETA_D; d++) {
    double whole = projected(theta_m, lobe + d * count, count);
    for (size_t i = 0; i < count && whole > 0.0; i++)
      density[i] += (1.0 - broad) * share(d) / shares * lobe[d * count + i] / whole;
  }
done:
  free(lobe);
  return status;
}
