/* dOmega_r = 4 (i.h) dOmega_h: over half vectors every cell of theta_h is met, however narrow, and
 * within a row of theta_h the places run smoothly through theta_d and phi_d. */
#include "audit/merl_energy.h"

#include <math.h>
#include <string.h>

#include "audit/merl_read.h"

enum { CHANNELS = 3, FIRST_PER_ROW = 1, FIRST_AZIMUTHS = 120, MOST_PER_ROW = 8 };

typedef struct light {
  const hetab_merl *merl;
  hetab_reading lookup;
  double s, c; /* sine and cosine of theta_i */
} light;

static double theta_h_at(double h) {
  double u = h / HETAB_MERL_THETA_H;
  return u * u * M_PI_2;
}

/* One half vector's share, per unit of its solid angle. */
static void add_half_vector(const light *l, double h, double sin_h, double cos_h, double phi_h,
                            double sum[CHANNELS]) {
  double cos_p = cos(phi_h), sin_p = sin(phi_h), turned = l->s * cos_p;
  double i_h = turned * sin_h + l->c * cos_h, mu_r = 2 * i_h * cos_h - l->c;
  double rgb[CHANNELS];
  if (i_h <= 0 || mu_r <= 0)
    return;
  double theta_d = acos(fmin(i_h, 1));
  double phi_d = atan2(-l->s * sin_p, turned * cos_h - l->c * sin_h);
  hetab_merl_place place = {h, HETAB_MERL_THETA_D * theta_d / M_PI_2,
                            HETAB_MERL_PHI_D * phi_d / M_PI};
  hetab_merl_read(l->merl, l->lookup, place, rgb);
  for (int c = 0; c < CHANNELS; c++)
    sum[c] += 4 * i_h * mu_r * rgb[c];
}

/* The rule with so many rings in a row of theta_h, and half vectors on a ring. */
static void integrate(const light *l, int per_row, int azimuths, double rho[CHANNELS]) {
  memset(rho, 0, CHANNELS * sizeof *rho);
  for (int ring = 0; ring < HETAB_MERL_THETA_H * per_row; ring++) {
    double h = (ring + 0.5) / per_row;
    double theta = theta_h_at(h), sum[CHANNELS] = {0};
    double area =
        cos(theta_h_at((double)ring / per_row)) - cos(theta_h_at((double)(ring + 1) / per_row));
    double start = ring % 2 ? 0.25 : 0.75; /* rings out of step: no cell edge falls in line */
    for (int a = 0; a < azimuths; a++)
      add_half_vector(l, h, sin(theta), cos(theta), 2 * M_PI * (a + start) / azimuths, sum);
    for (int c = 0; c < CHANNELS; c++)
      rho[c] += sum[c] * area * 2 * M_PI / azimuths;
  }
}

void hetab_merl_energy(const hetab_merl *merl, hetab_reading lookup, double theta_i,
                       double tolerance, double rho[3], double error[3]) {
  light l = {merl, lookup, sin(theta_i), cos(theta_i)};
  double coarse[CHANNELS];
  int per_row = FIRST_PER_ROW, azimuths = FIRST_AZIMUTHS, good = 0;
  integrate(&l, per_row, azimuths, rho);
  while (!good && per_row < MOST_PER_ROW) {
    per_row *= 2;
    azimuths *= 2;
    memcpy(coarse, rho, sizeof coarse);
    integrate(&l, per_row, azimuths, rho);
    good = 1;
    for (int c = 0; c < CHANNELS; c++) {
      error[c] = fabs(rho[c] - coarse[c]);
      good &= error[c] <= tolerance;
    }
  }
}
