/* The density of half vectors that a table is laid out by, from the source's own values.
 *
 * For a microfacet lobe f cos(theta_i) cos(theta_r) is D(theta_m) times what changes slowly. Lobes
 * whose width depends on theta_d (those of smooth surfaces do) need room for the widest: the mean
 * over several theta_d, each normalised. */
#include <math.h>
#include <stdlib.h>

#include "model/model.h"
#include "rgl/rgl_table.h"

static const double theta_d_deg[] = {0.0, 30.0, 50.0, 65.0, 76.0, 82.0};
enum { THETA_D = sizeof theta_d_deg / sizeof *theta_d_deg };

/* The part of the mixture that is uniform, so that no direction is without nodes. */
static const double broad = 0.001;

/* The pair of half vector theta_h and difference (theta_d, 90 degrees): there both directions are
 * equally far from the normal, and above the horizon for any theta_h. */
static hetab_rgl_pair pair_of(double theta_h, double theta_d) {
  double z = cos(theta_h) * cos(theta_d), x = sin(theta_h) * cos(theta_d), y = sin(theta_d);
  double theta = atan2(hypot(x, y), z);
  return (hetab_rgl_pair){theta, theta, 2.0 * atan2(y, x)};
}

/* f cos cos, [THETA_D][count]. */
static hetab_status lobes(hetab_context *ctx, const hetab_rgl_source *source, const double *theta_m,
                          size_t count, double *out) {
  size_t total = THETA_D * count;
  hetab_rgl_pair *pairs = hetab_alloc(ctx, total, sizeof *pairs);
  double *values = hetab_alloc(ctx, total * source->channels, sizeof *values);
  hetab_status status;
  HETAB_GOTO(pairs && values ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t i = 0; i < total; i++)
    pairs[i] =
        pair_of(fmin(theta_m[i % count], M_PI_2 - 1e-3), hetab_radians(theta_d_deg[i / count]));
  HETAB_GOTO(source->values(ctx, source->user, pairs, total, values));
  for (size_t i = 0; i < total; i++) {
    double cosine = cos(pairs[i].theta_i);
    out[i] = cosine * cosine * hetab_rgl_luminance(source, values + i * source->channels, 1);
  }
done:
  free(pairs);
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

/* The width of a smooth surface's lobe grows as 1 / cos(theta_d): its wide parts need their share
 * of the nodes, for the narrow ones stand on top of them. */
static double share(size_t d) {
  return 1.0 / cos(hetab_radians(theta_d_deg[d]));
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
