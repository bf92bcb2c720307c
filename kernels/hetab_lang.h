/* The dialect in which the physics is written: one source for OpenCL C and for the C host.
 *
 * The includer declares what it is, it is never guessed:
 *   HETAB_CL    OpenCL: `real` is float or double by HETAB_REAL_BITS (32 or 64) and `vreal` a
 * vector of HETAB_VW of them (1, 2, 4, 8, 16), both build options chosen from the device HETAB_HOST
 * C: `real` and `vreal` are double
 *
 * Rules: literals as RC(0.5); conditions as `mask ? yes : no`, which selects lane by lane in OpenCL
 * and needs both sides to be vreal; loops that end by data ask V_ANY(mask). No pointers without an
 * address space, no globals, no recursion. */
#ifndef HETAB_LANG_H
#define HETAB_LANG_H

#if defined(HETAB_CL) == defined(HETAB_HOST)
#error "hetab_lang.h: define exactly one of HETAB_CL and HETAB_HOST before including the physics"
#endif

#define HETAB_CAT_(a, b) a##b
#define HETAB_CAT(a, b) HETAB_CAT_(a, b)

#ifdef HETAB_CL

#if HETAB_REAL_BITS == 64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#define RC(x) x
#define HETAB_REAL double
#define HETAB_INT long
#else
typedef float real;
#define RC(x) HETAB_CAT(x, f)
#define HETAB_REAL float
#define HETAB_INT int
#endif

#if HETAB_VW == 1
typedef real vreal;
#define V_ANY(mask) (mask)
#define V_LOAD(i, p) ((p)[i])
#define V_STORE(v, i, p) ((p)[i] = (v))
#define V_BITS(v) HETAB_CAT(as_, HETAB_INT)(v)
#define V_FROM_BITS(v) HETAB_CAT(as_, HETAB_REAL)(v)
#define V_FIRST(v) (v)
#else
typedef HETAB_CAT(HETAB_REAL, HETAB_VW) vreal;
#define V_ANY(mask) any(mask)
#define V_LOAD(i, p) HETAB_CAT(vload, HETAB_VW)(i, p)
#define V_STORE(v, i, p) HETAB_CAT(vstore, HETAB_VW)(v, i, p)
#define V_BITS(v) HETAB_CAT(as_, HETAB_CAT(HETAB_INT, HETAB_VW))(v)
#define V_FROM_BITS(v) HETAB_CAT(as_, HETAB_CAT(HETAB_REAL, HETAB_VW))(v)
#define V_FIRST(v) ((v).s0)
#endif

/* Kernels over rows: HETAB_ROW_ITEMS neighbouring work-items (a build option: 1 on CPUs, a group on
 * GPUs, so that neighbours store neighbours) share a row. */
#ifndef HETAB_ROW_ITEMS
#define HETAB_ROW_ITEMS 1
#endif
static inline int hetab_row_number(void) {
  return (int)(get_global_id(0) / HETAB_ROW_ITEMS);
}
static inline int hetab_row_item(void) {
  return (int)(get_global_id(0) % HETAB_ROW_ITEMS);
}

/* The least and the largest lane, and the sum of all. */
#define HETAB_REDUCE_1(f, v) (v)
#define HETAB_REDUCE_2(f, v) f((v).s0, (v).s1)
#define HETAB_REDUCE_4(f, v) HETAB_REDUCE_2(f, f((v).lo, (v).hi))
#define HETAB_REDUCE_8(f, v) HETAB_REDUCE_4(f, f((v).lo, (v).hi))
#define HETAB_REDUCE_16(f, v) HETAB_REDUCE_8(f, f((v).lo, (v).hi))
static inline real hetab_lane_min(vreal v) {
  return HETAB_CAT(HETAB_REDUCE_, HETAB_VW)(fmin, v);
}
static inline real hetab_lane_max(vreal v) {
  return HETAB_CAT(HETAB_REDUCE_, HETAB_VW)(fmax, v);
}
#define HETAB_ADD(a, b) ((a) + (b))
static inline real hetab_lane_sum(vreal v) {
  return HETAB_CAT(HETAB_REDUCE_, HETAB_VW)(HETAB_ADD, v);
}

#else /* HETAB_HOST */

#include <math.h>
#include <string.h>

#define HETAB_REAL_BITS 64
#define HETAB_VW 1
typedef double real;
typedef double vreal;
#define RC(x) x
#define V_ANY(mask) (mask)

static inline double rsqrt(double x) {
  return 1.0 / sqrt(x);
}
static inline long as_long(double x) {
  long bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

#endif

#define RC_PI RC(3.14159265358979323846)
#define RC_SQRT_PI RC(1.77245385090551602730)

#endif
