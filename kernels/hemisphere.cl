/* The hemisphere of viewers: f_dd times the weights of a quadrature, summed along rays.
 *
 * One work-item takes one ray (dimension 0) at one wavelength (dimension 1), HETAB_VW nodes at a
 * time. It stores the sums over the first and the second half of the ray's nodes apart: the first
 * one doubled is the coarser rule. The host made the nodes, in double (src/model/hemisphere.h), and
 * adds up rays.
 *
 * Buffers: waves[wavelength][HETAB_WAVE_REALS], rays[ray][HETAB_RAY_INTS],
 * nodes[HETAB_NODE_REALS][stride], sums[result][HETAB_SUM_REALS]; half of a ray's nodes is a
 * multiple of 16. */
#define HETAB_CL
#include "he_torrance.h"
#include "tables.h"

/* f_dd times the weights of the nodes [first, first + count). */
static inline real hetab_ray_sum(const hetab_wave *wave, __global const real *nodes, int stride,
                                 int first, int count) {
  vreal sum = RC(0.0);
  for (int i = first; i < first + count; i += HETAB_VW) {
    __global const real *at = nodes + i;
    vreal cos2_d = V_LOAD(0, at + (size_t)HETAB_NODE_COS2_D * stride);
    vreal x = wave->x.hi * V_LOAD(0, at + (size_t)HETAB_NODE_LATERAL2 * stride);
    vreal g = wave->g.hi * V_LOAD(0, at + (size_t)HETAB_NODE_G * stride);
    vreal weight = V_LOAD(0, at + (size_t)HETAB_NODE_WEIGHT * stride);
    vreal fresnel = hetab_fresnel(cos2_d, (vreal)wave->e1, (vreal)wave->nk);
    sum += hetab_dd(cos2_d, fresnel, (vreal)wave->amplitude * weight, hetab_h(g, x));
  }
  return hetab_lane_sum(sum);
}

__kernel void hetab_k_hemisphere(__global const real *waves, __global const int *rays,
                                 int ray_count, __global const real *nodes, int stride,
                                 __global real *sums, int first_ray) {
  int r = first_ray + (int)get_global_id(0), w = get_global_id(1);
  __global const int *ray = rays + r * HETAB_RAY_INTS;
  if (r >= ray_count || w >= ray[HETAB_RAY_WAVES])
    return;
  hetab_wave wave = hetab_wave_load(waves, ray[HETAB_RAY_FIRST_WAVE] + w);
  int first = ray[HETAB_RAY_FIRST_NODE], count = ray[HETAB_RAY_NODES] / 2;
  __global real *out = sums + (ray[HETAB_RAY_FIRST_SUM] + w) * HETAB_SUM_REALS;
  out[HETAB_SUM_FIRST] = hetab_ray_sum(&wave, nodes, stride, first, count);
  out[HETAB_SUM_SECOND] = hetab_ray_sum(&wave, nodes, stride, first + count, count);
}
