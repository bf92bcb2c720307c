/* The integral of f cos(theta_r) over the hemisphere of viewers as a sum over nodes, in double.
 *
 * cos(theta_r) dOmega is the area element of the unit disc of lateral direction cosines q, and x of
 * the series depends only on the distance rho from the mirror point (-sin_i, 0). So: rays from the
 * mirror point to the rim, and nodes along each. With c the half length of a ray's chord,
 *
 *   across rays  dpsi = c du: psi is Jacobi's amplitude of u with modulus sin_i, c = dn(u). At
 *                grazing, where rays across the short side and along the long one meet in a hair's
 *                breadth of psi, u spreads them out: the trapezoidal rule in u converges
 *                exponentially, with a step that does not depend on theta_i;
 *   along a ray  drho = mu_r dalpha: alpha turns about the middle of the chord, mu_r = c
 * sin(alpha). No square root is left at the rim; what is left there, a logarithm from the effective
 * roughness, and the lobe at the mirror point are met by a map that crowds nodes at both ends
 * (hetab_crowd), and the trapezoidal rule again.
 *
 * Every distance is a product: nothing cancels at the mirror point, at the rim or at grazing. */
#pragma once

#include "model/model.h"

enum { HETAB_HEMISPHERE_PANELS = 3 };

/* One incidence. */
typedef struct hetab_hemisphere {
  hetab_direction in; /* mu > 0 */
  double tau_2sigma;
  double reach;  /* rho where rays end, if the rim is farther: f is negligible beyond */
  double period; /* of u: psi = pi */
  double kink;   /* cos^2(theta_d) where |F|^2 has its kink; 0: it is smooth */
  size_t panels; /* of u, between the rays at which something happens at the kink */
  double cut[HETAB_HEMISPHERE_PANELS + 1]; /* their ends */
} hetab_hemisphere;

/* theta_i in radians, [0, pi/2). The reach is the whole disc. */
hetab_hemisphere hetab_hemisphere_at(double theta_i, double tau_2sigma);

/* The reach that a wave needs for what is left out to be `negligible` times the integral, or less:
 * there h has fallen by that much, and by what other factors may have grown from the mirror point.
 */
double hetab_hemisphere_reach(const hetab_hemisphere *at, const hetab_wave *wave,
                              double negligible);

/* Total reflection: with n < 1 and k near 0, |F|^2 has a kink at the critical angle, where no rule
 * for smooth functions converges fast, nor says so. cos^2(theta_d) there, or 0. */
double hetab_hemisphere_kink(const hetab_band *band);

/* From now on rays are cut where they meet the kink, and panels of rays where one touches it or
 * meets it at the rim. */
void hetab_hemisphere_split(hetab_hemisphere *at, double kink);

/* A rule has `rays` + 1 rays, number 0 .. rays, over the half disc, and `nodes` nodes along each;
 * rays a multiple of twice the panels, nodes a multiple of 32 (their halves are whole vectors). The
 * even rays are the rule with half as many rays; the first half of each ray's nodes is the rule
 * with half as many nodes.
 */
typedef struct hetab_node {
  double cos2_d;   /* cos^2(theta_d) */
  double lateral2; /* rho^2 = x / wave.x */
  double g;        /* g / wave.g */
  double weight;   /* of the rule and dq, times S S / (mu mu) / (1 + W) */
} hetab_node;

/* The nodes of one ray, out[nodes]. */
void hetab_hemisphere_ray(const hetab_hemisphere *at, size_t ray, size_t rays, size_t nodes,
                          hetab_node *out);

/* A map of [0, 1] to itself for the trapezoidal rule of integrands that are not smooth at the ends:
 * t to w, with 1 - w and dw/dt. */
typedef struct hetab_crowded {
  double w, rest, slope;
} hetab_crowded;
hetab_crowded hetab_crowd(double t);

/* The relative error of such a rule, from its relative difference from the rule of half the size:
 * twice that, in case the two agree by luck; less where the difference is so small that both are
 * converging, faster than any power (QUADPACK's exponent and constant). */
double hetab_rule_error(double difference);
