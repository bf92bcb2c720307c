/* The frame of MERL tables: half and difference angles, and the cells over them. */
#pragma once

#include <hetab/merl.h>

enum { HETAB_MERL_CHANNELS = 3 };

/* Half and difference angles as the reference reader finds them: the light's direction, turned so
 * that the half vector becomes the pole. Radians; phi_d in [-pi, pi]. */
typedef struct hetab_half_diff {
  double theta_h, theta_d, phi_d;
} hetab_half_diff;

hetab_half_diff hetab_half_diff_of(double theta_i, double theta_r, double phi);

/* The directions of half and difference angles, light first, and their cosines without
 * cancellation at the horizon; 0 if either is not above it. */
typedef struct hetab_merl_pair {
  hetab_directions at;
  double mu_i, mu_r;
} hetab_merl_pair;
int hetab_merl_pair_of(hetab_half_diff angles, hetab_merl_pair *pair);

/* A place in the table, in cells, fractions included: cell h, d, p reaches from its own number to
 * the next. Between places and angles, either way. */
typedef struct hetab_merl_place {
  double h, d, p;
} hetab_merl_place;
hetab_half_diff hetab_merl_angles(hetab_merl_place place);
hetab_merl_place hetab_merl_place_of(hetab_half_diff angles);

/* The angles in the middle of a cell, where `hetab tabulate` evaluates it. */
hetab_half_diff hetab_merl_middle(size_t cell);

/* What is in a table at a place, by either rule. What is marked invalid, and what is no number, is
 * 0: renderers draw it black; between the centres of cells it leaves its weight to the others. The
 * return value says whether every channel had a number. */
void hetab_merl_read_truncated(const hetab_merl *merl, hetab_merl_place place, double rgb[3]);
int hetab_merl_read_interpolated(const hetab_merl *merl, hetab_merl_place place, double rgb[3]);
