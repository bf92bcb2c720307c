/* The rows of the tables that the host computes in double and the kernels read. The host writes
 * them with these same constants.
 *
 * Quantities marked "two" stand as a pair: the nearest real and what it leaves out (0 in the double
 * build). Products of them, less a number near by, keep a float's full precision without fp64. */
#ifndef HETAB_TABLES_H
#define HETAB_TABLES_H

/* One wavelength: g (two) and x (two) of the wave, its amplitude, e1, nk (kernels/fresnel.h),
 * diffuse BRDF, three channel weights, how many coefficients Fresnel's fit has (0: no fit, SHORT,
 * FIT), and the fit: coefficients of a, then of m (kernels/fresnel.h).
 */
#define HETAB_FRESNEL_FIT 6
#define HETAB_FRESNEL_SHORT 4
#define HETAB_WAVE_WEIGHTS 8 /* where the weights start */
#define HETAB_WAVE_REALS (12 + 2 * HETAB_FRESNEL_FIT)
/* One (theta_i, theta_r): mu2 ratio2 (two), d2 (two), p, mu2, shadow; src/model/model.h says what
 * they are. */
#define HETAB_PAIR_REALS 7
/* One point: wave g, x, amplitude; e1, nk; mu2, lateral2, shadow, ratio2; mu_i, specular shadow
 * S_i^2, specular ratio2. */
#define HETAB_POINT_REALS 12
/* One result: dd, specular, g, x. */
#define HETAB_RESULT_REALS 4
/* One (theta_h, theta_d): lateral2 = |q_i + q_r|^2 (two), mu2. */
#define HETAB_FRAME_REALS 3
#define HETAB_CHANNELS 3
/* One node of a hemisphere: cos^2(theta_d), lateral2 = rho^2, g over the wave's, weight;
 * src/model/hemisphere.h says what they are. */
#define HETAB_NODE_REALS 4
/* One ray of them, as integers: first node, nodes, first wavelength, wavelengths, first result. */
#define HETAB_RAY_INTS 5
/* One result of a ray: the sums over the first and the second half of its nodes. */
#define HETAB_SUM_REALS 2
/* One panel of the atlas: first segment, segments, centre of g, 1/half width of g, end of x, start
 * of g. */
#define HETAB_PANEL_REALS 6
/* One segment: start of x, centre of x, 1/half width of x, h at its centre. */
#define HETAB_SEGMENT_REALS 4

#ifdef HETAB_CL
typedef struct hetab_two {
  real hi, lo;
} hetab_two;

/* a b - c, where c is near a b: the product's rounding error is recovered by one fma. */
static inline real hetab_product_less(hetab_two a, hetab_two b, real c) {
#pragma OPENCL FP_CONTRACT OFF
  real p = a.hi * b.hi;
  real rest = fma(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi);
  return (p - c) + rest;
}

typedef struct hetab_wave {
  hetab_two g, x;
  real amplitude;
  real e1, nk;
  real diffuse_brdf;
  real weight[HETAB_CHANNELS];
  int fitted; /* coefficients of fresnel_fit, 0: none */
  __global const real *fresnel_fit;
} hetab_wave;

static inline hetab_wave hetab_wave_load(__global const real *waves, int wavelength) {
  __global const real *w = waves + wavelength * HETAB_WAVE_REALS;
  hetab_wave wave = {{w[0], w[1]}, {w[2], w[3]},        w[4],       w[5],  w[6],
                     w[7],         {w[8], w[9], w[10]}, (int)w[11], w + 12};
  return wave;
}
#endif

#endif
