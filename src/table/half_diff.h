/* The frame of MERL tables. */
#ifndef HETAB_TABLE_HALF_DIFF_H
#define HETAB_TABLE_HALF_DIFF_H

/* Half and difference angles as the reference reader finds them: the light's direction, turned so
 * that the half vector becomes the pole. Radians; phi_d in [-pi, pi]. */
typedef struct hetab_half_diff {
  double theta_h, theta_d, phi_d;
} hetab_half_diff;

hetab_half_diff hetab_half_diff_of(double theta_i, double theta_r, double phi);

#endif
