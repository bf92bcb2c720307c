/* The He-Torrance reflectance model, whole, in one header for C99 and C++. Written by hetab @VERSION@.
 *
 * @ERROR@
 *
 *   ht_surface s = {sigma0_um, tau_um, lambda_um, n, k, diffuse_reflectance};
 *   float f = ht_brdf(s, ix, iy, iz, ox, oy, oz);
 *
 * The functions take all parameters; the surface that this file was made for, and n and k of the
 * built-in metals at 400, 410 ... 700 nm, as JSON:
@data.json@ */
#ifndef HE_TORRANCE_H
#define HE_TORRANCE_H

#include <math.h>
#include <stdbool.h>

/* Coefficients of cubic B-splines: row 0 of A over s, the others of r over s and t. */
static const float ht_table[@COUNT@ * (@COUNT@ + 1)] = {
@TABLE_NUMBERS@};

#define HT_FN static inline
#define HT_CONST static const
#define HT_INT(x) ((int)(x))
#define ht_sqrt sqrtf
#define ht_exp expf
#define ht_log logf
#define ht_cos cosf
#define ht_sin sinf
#define ht_floor floorf
#define ht_abs fabsf
#define ht_min fminf
#define ht_max fmaxf

typedef struct ht_four {
  float x, y, z, w;
} ht_four;
typedef struct ht_spline ht_spline;
typedef struct ht_direction ht_direction;
typedef struct ht_surface ht_surface;
typedef struct ht_pair ht_pair;
typedef struct ht_lobes ht_lobes;

static inline ht_four ht_run(int row, int column) {
  const float *first = ht_table + row * @COUNT@ + column;
  ht_four run = {first[0], first[1], first[2], first[3]};
  return run;
}

@model.inc@
#endif
