/* The rows of the tables that the host computes in double and the kernels read. The host writes
 * them with these same constants.
 *
 * Quantities marked "two" stand as a pair: the nearest real and what it leaves out (0 in the double
 * build). Products of them, less a number near by, keep a float's full precision without fp64. */
#ifndef HETAB_TABLES_H
#define HETAB_TABLES_H

#define HETAB_FRESNEL_FIT 6
#define HETAB_FRESNEL_SHORT 4
#define HETAB_CHANNELS 3
#define HETAB_PEAK_CHAINS 12 /* of multiply-adds, kernels/peak.cl */

/* One wavelength: of the wave (src/model/model.h) g, x, amplitude, e1, nk and diffuse BRDF, what it
 * adds to each channel, and a fit of Fresnel's equations (kernels/fresnel.h): how many coefficients
 * it has (0: there is none, SHORT, FIT), those of a, those of the modulus. */
enum {
  HETAB_WAVE_G,                    /* two */
  HETAB_WAVE_X = HETAB_WAVE_G + 2, /* two */
  HETAB_WAVE_AMPLITUDE = HETAB_WAVE_X + 2,
  HETAB_WAVE_E1,
  HETAB_WAVE_NK,
  HETAB_WAVE_DIFFUSE,
  HETAB_WAVE_WEIGHTS,
  HETAB_WAVE_FITTED = HETAB_WAVE_WEIGHTS + HETAB_CHANNELS,
  HETAB_WAVE_FIT,
  HETAB_WAVE_REALS = HETAB_WAVE_FIT + 2 * HETAB_FRESNEL_FIT
};

/* One (theta_i, theta_r): hetab_pair of src/model/model.h, g over the wave's in place of ratio2. */
enum {
  HETAB_PAIR_G,                     /* mu2 ratio2, two */
  HETAB_PAIR_D2 = HETAB_PAIR_G + 2, /* two */
  HETAB_PAIR_P = HETAB_PAIR_D2 + 2,
  HETAB_PAIR_MU2,
  HETAB_PAIR_SHADOW,
  HETAB_PAIR_REALS
};

/* One pair of directions, phi included: lateral2 = |q_i + q_r|^2, the rest as in hetab_pair. */
enum {
  HETAB_PLACE_MU2,
  HETAB_PLACE_LATERAL2,
  HETAB_PLACE_SHADOW,
  HETAB_PLACE_RATIO2,
  HETAB_PLACE_REALS
};

/* One point: a place, its wave, and for rho_s mu_i, S_i^2 and ratio2 of the mirror direction. */
enum {
  HETAB_POINT_WAVE_G = HETAB_PLACE_REALS,
  HETAB_POINT_WAVE_X,
  HETAB_POINT_AMPLITUDE,
  HETAB_POINT_E1,
  HETAB_POINT_NK,
  HETAB_POINT_MU_I,
  HETAB_POINT_SPECULAR_SHADOW2,
  HETAB_POINT_SPECULAR_RATIO2,
  HETAB_POINT_REALS
};
enum { HETAB_RESULT_DD, HETAB_RESULT_SPECULAR, HETAB_RESULT_G, HETAB_RESULT_X, HETAB_RESULT_REALS };

/* What a build of kernels/half_diff.cl does; what does the series alone adds to the rest. */
#define HETAB_PART_ATLAS 1
#define HETAB_PART_SERIES 2
/* One (theta_h, theta_d). */
enum { HETAB_FRAME_LATERAL2 /* two */, HETAB_FRAME_MU2 = 2, HETAB_FRAME_REALS };

/* One node of a hemisphere: cos^2(theta_d), lateral2, g over the wave's, weight
 * (src/model/hemisphere.h). */
enum { HETAB_NODE_COS2_D, HETAB_NODE_LATERAL2, HETAB_NODE_G, HETAB_NODE_WEIGHT, HETAB_NODE_REALS };
/* One ray of them, as integers; wavelengths and results from the first one on. */
enum {
  HETAB_RAY_FIRST_NODE,
  HETAB_RAY_NODES,
  HETAB_RAY_FIRST_WAVE,
  HETAB_RAY_WAVES,
  HETAB_RAY_FIRST_SUM,
  HETAB_RAY_INTS
};
/* One result of a ray: the sums over the first and the second half of its nodes. */
enum { HETAB_SUM_FIRST, HETAB_SUM_SECOND, HETAB_SUM_REALS };

/* One panel of the atlas. */
enum {
  HETAB_PANEL_FIRST, /* segment */
  HETAB_PANEL_COUNT, /* of segments */
  HETAB_PANEL_CENTRE,
  HETAB_PANEL_SCALE, /* u = (g - centre) scale */
  HETAB_PANEL_X_END,
  HETAB_PANEL_START, /* of g */
  HETAB_PANEL_REALS
};
/* One segment of x. */
enum {
  HETAB_SEGMENT_START,
  HETAB_SEGMENT_CENTRE,
  HETAB_SEGMENT_SCALE, /* t = (x - centre) scale */
  HETAB_SEGMENT_H,     /* at its centre */
  HETAB_SEGMENT_REALS
};

#ifdef HETAB_LANG_H
/* Panels start at 2^e and 1.5 2^e: twice the exponent of g > 0, with a float's bias, plus the first
 * bit of its mantissa. */
static inline int hetab_panel_number(real g) {
#if HETAB_REAL_BITS == 64
  return (int)(as_long(g) >> 51) - 2 * (1023 - 127);
#else
  return as_int(g) >> 22;
#endif
}
#endif

#ifdef HETAB_CL
typedef struct hetab_two {
  real hi, lo;
} hetab_two;

static inline hetab_two hetab_two_at(__global const real *two) {
  hetab_two value = {two[0], two[1]};
  return value;
}

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
  hetab_wave wave = {hetab_two_at(w + HETAB_WAVE_G),
                     hetab_two_at(w + HETAB_WAVE_X),
                     w[HETAB_WAVE_AMPLITUDE],
                     w[HETAB_WAVE_E1],
                     w[HETAB_WAVE_NK],
                     w[HETAB_WAVE_DIFFUSE],
                     {w[HETAB_WAVE_WEIGHTS], w[HETAB_WAVE_WEIGHTS + 1], w[HETAB_WAVE_WEIGHTS + 2]},
                     (int)w[HETAB_WAVE_FITTED],
                     w + HETAB_WAVE_FIT};
  return wave;
}
#endif

#endif
