/* The form in which tables are evaluated: ln f over half and difference vectors, on a lattice that
 * follows the lobe and ends at the horizon.
 *
 * A reciprocal, isotropic and mirror-symmetric BRDF is a function of three numbers that cost no
 * trigonometry, with s = wi + wo:
 *   v = sin^2(theta_h) = (s.x^2 + s.y^2) / s.s
 *   c = cos(theta_d)   = |s| / 2
 *   q = |wo.z - wi.z| / 2 over its largest value at that v and c, the smaller of sin(theta_h)
 *       sin(theta_d) (phi_d = 0) and cos(theta_h) cos(theta_d) (one direction on the horizon)
 * Every point of the unit cube is a pair of directions above the horizon: no cell needs a mask. In
 * the half vector's frame lobes keep their place at every incidence. ln f is linear in v for a
 * Gaussian lobe, in v / (1 - v) for the wide ones of slopes, and even in c and q about their ends,
 * so it is interpolated linearly in v / (1.005 - v), c^2 and q^2 between nodes that crowd where the
 * lobe and the grazing angles are:
 *   v = (h / (HETAB_LATTICE_H - 1))^4, c = (d / (HETAB_LATTICE_D - 1))^2,
 *   1 - q = (1 - k / (HETAB_LATTICE_Q - 1))^2
 * Values are log2 f in 16 bits over 46 octaves below the largest one: steps of 4.9e-4. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/context.h"
#include "table/band_places.h"

/* Nodes along v, c and q. A third fewer each doubles the error, more gain little up to 75 degrees;
 * with three channels all of it stays in a core's second cache. */
enum {
  HETAB_LATTICE_H = 112,
  HETAB_LATTICE_D = 80,
  HETAB_LATTICE_Q = 21,
  HETAB_LATTICE_NODES = HETAB_LATTICE_H * HETAB_LATTICE_D * HETAB_LATTICE_Q,
  HETAB_LATTICE_BLOCK = 16 /* evaluations at once */
};

typedef struct hetab_lattice {
  size_t channels;
  size_t stride;   /* hetab_lattice_stride() */
  float low, step; /* log2 f = low + step * code */
  float floor;     /* f of code 0; taken off, so that 0 stays 0 */
  uint16_t *codes; /* [h][d][q][stride] */
} hetab_lattice;

/* A pair of directions. */
typedef struct hetab_lattice_place {
  double sin2_h, cos_d;
  double mu_low, mu_high; /* the cosines of the two directions */
} hetab_lattice_place;

/* log2 of every channel at a place; HETAB_LATTICE_ZERO where it is 0. */
#define HETAB_LATTICE_ZERO (-1e4f)
typedef void (*hetab_lattice_source)(const void *user, const hetab_lattice_place *place,
                                     float *log2_values);

/* Of a node: a multiple of 4, above 4 channels of 16. */
size_t hetab_lattice_stride(size_t channels);

/* The source is given room for hetab_lattice_stride(channels) numbers. */
hetab_status hetab_lattice_create(hetab_context *ctx, size_t channels, hetab_lattice_source source,
                                  const void *user, hetab_lattice *lattice);
void hetab_lattice_clear(hetab_lattice *lattice);

/* value[count][channels] of wi[count][3], wo[count][3], 1/sr; 0 below the horizon. */
void hetab_lattice_eval(const hetab_lattice *lattice, size_t count, const float *wi,
                        const float *wo, float *value);
/* The same at places[count], whose values stand at value[i * width]. */
void hetab_lattice_eval_places(const hetab_lattice *lattice, size_t count, const float *wi,
                               const float *wo, const hetab_band_places *places, size_t width,
                               float *value);
