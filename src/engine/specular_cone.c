#include "engine/specular_cone.h"

#include <math.h>

#include <hetab/merl.h>

int hetab_specular_cone_rows(double cone) {
  if (!(cone > 0.0))
    return 0;
  /* row i ends at theta_h = ((i + 1) / 90)^2 90 degrees */
  double rows = ceil(HETAB_MERL_THETA_H * sqrt(fmin(cone / M_PI_2, 1.0)) - 1e-9);
  return rows < 1.0 ? 1 : (int)rows;
}

double hetab_specular_cone_lobe(double theta, int rows) {
  enum { RINGS = 64, SPOKES = 128 };
  double u = (double)rows / HETAB_MERL_THETA_H;
  double cap = 1.0 - cos(u * u * M_PI_2), sum = 0.0; /* solid angle of the cone / 2 pi */
  for (int ring = 0; ring < RINGS; ring++) {
    double c = 1.0 - cap * (ring + 0.5) / RINGS, s = sqrt(1.0 - c * c);
    for (int spoke = 0; spoke < SPOKES; spoke++) {
      double i_h = cos(theta) * c + sin(theta) * s * cos(M_PI * (spoke + 0.5) / SPOKES);
      double mu_r = 2.0 * i_h * c - cos(theta);
      if (i_h > 0.0 && mu_r > 0.0)
        sum += 4.0 * i_h * mu_r;
    }
  }
  return sum > 0.0 ? RINGS * SPOKES / (sum * 2.0 * M_PI * cap) : 0.0;
}
