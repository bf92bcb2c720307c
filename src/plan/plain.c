#include "plan/plain.h"

#include <math.h>

#include "core/angle.h"
#include "model/model.h"

enum { RADII = 12, TURNS = 16 };

typedef struct vector {
  double x, y, z;
} vector;

static double smith(double alpha, double cosine) {
  double tangent = sqrt(fmax(1.0 - cosine * cosine, 0.0)) / cosine;
  if (tangent < 1e-9)
    return 1.0;
  double a = 1.0 / (alpha * tangent);
  return 2.0 / (1.0 + erf(a) + exp(-a * a) / (a * sqrt(M_PI)));
}

/* The half vector of slopes that Beckmann draws, stratified, and its density times 4 i.m: of wo. */
static vector half_vector(double alpha, int radius, int turn, double *density) {
  double tan2 = -alpha * alpha * log1p(-(radius + 0.5) / RADII), phi = 2.0 * M_PI * turn / TURNS;
  double cosine = 1.0 / sqrt(1.0 + tan2), sine = sqrt(tan2) * cosine;
  *density = exp(-tan2 / (alpha * alpha)) / (M_PI * alpha * alpha * pow(cosine, 3));
  return (vector){sine * cos(phi), sine * sin(phi), cosine};
}

static double model_at(const hetab_surface *surface, const hetab_band *band, double theta_i,
                       const vector *o) {
  double tau_2sigma = hetab_tau_2sigma(surface);
  hetab_direction i = hetab_direction_at(theta_i, tau_2sigma);
  hetab_direction r = hetab_direction_at(acos(fmin(o->z, 1.0)), tau_2sigma);
  hetab_pair p = hetab_pair_of(&i, &r);
  hetab_wave wave =
      hetab_wave_of(hetab_surface_sigma0_um(surface), hetab_surface_tau_um(surface), band);
  double lateral2 = p.d2 + p.p * hetab_one_plus_cos(atan2(o->y, o->x));
  double cos2_d = fmin(0.25 * (p.mu2 + lateral2), 1.0);
  return hetab_fresnel_at(cos2_d, band->n, band->k) * cos2_d * cos2_d * wave.amplitude * p.shadow *
             exp(hetab_ln_h(wave.g * p.mu2 * p.ratio2, wave.x * lateral2)) +
         wave.diffuse_brdf;
}

static double error_at(const hetab_surface *surface, const hetab_band *band, double theta_i) {
  double alpha = 1.0 / hetab_tau_2sigma(surface), sums[2] = {0};
  const vector in = {sin(theta_i), 0.0, cos(theta_i)};
  for (int radius = 0; radius < RADII; radius++)
    for (int turn = 0; turn < TURNS; turn++) {
      double density;
      vector m = half_vector(alpha, radius, turn, &density);
      double im = in.x * m.x + in.z * m.z;
      vector o = {2.0 * im * m.x - in.x, 2.0 * im * m.y, 2.0 * im * m.z - in.z};
      if (!(im > 0.0) || !(o.z > 1e-6))
        continue;
      double beckmann = hetab_fresnel_at(im * im, band->n, band->k) * density / m.z *
                        smith(alpha, in.z) * smith(alpha, o.z) / (4.0 * in.z * o.z);
      double model = model_at(surface, band, theta_i, &o), weight = o.z * 4.0 * im / density;
      sums[0] += weight * fabs(beckmann - model);
      sums[1] += weight * model;
    }
  return sums[1] > 0.0 ? sums[0] / sums[1] : 1.0;
}

double hetab_plain_error(const hetab_surface *surface) {
  static const double theta_deg[] = {0.0, 30.0, 60.0};
  size_t count = hetab_surface_band_count(surface);
  const hetab_band *bands = hetab_surface_bands(surface);
  double worst = 0.0;
  for (int b = 0; b < 3; b++)
    for (int t = 0; t < 3; t++)
      worst = fmax(worst, error_at(surface, &bands[(size_t)b * (count - 1) / 2],
                                   hetab_radians(theta_deg[t])));
  return worst;
}
