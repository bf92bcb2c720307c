/* The model at single points: one work-item takes HETAB_VW of them.
 * In: points[HETAB_POINT_REALS][stride], out: results[HETAB_RESULT_REALS][stride], stride a
 * multiple of HETAB_VW. */
#define HETAB_CL
#include "he_torrance.h"
#include "tables.h"

__kernel void hetab_k_points(__global const real *points, int stride, __global real *results) {
  size_t first = get_global_id(0) * HETAB_VW;
  if (first >= (size_t)stride)
    return;
  vreal in[HETAB_POINT_REALS];
  for (int i = 0; i < HETAB_POINT_REALS; i++)
    in[i] = V_LOAD(0, points + (size_t)i * stride + first);
  vreal wave_g = in[0], wave_x = in[1], amplitude = in[2], e1 = in[3], nk = in[4];
  vreal mu2 = in[5], lateral2 = in[6], shadow = in[7], ratio2 = in[8];
  vreal mu_i = in[9], specular_shadow = in[10], specular_ratio2 = in[11];

  vreal g = wave_g * mu2 * ratio2;
  vreal x = wave_x * lateral2;
  vreal cos2_d = fmin(RC(0.25) * (mu2 + lateral2), (vreal)RC(1.0));
  vreal dd = hetab_dd(cos2_d, hetab_fresnel(cos2_d, e1, nk), amplitude * shadow, hetab_h(g, x));
  vreal mu_i2 = mu_i * mu_i;
  vreal g_specular = wave_g * RC(4.0) * mu_i2 * specular_ratio2;
  vreal specular = hetab_fresnel(mu_i2, e1, nk) * specular_shadow * exp(-g_specular);

  V_STORE(dd, 0, results + first);
  V_STORE(specular, 0, results + (size_t)stride + first);
  V_STORE(g, 0, results + (size_t)2 * stride + first);
  V_STORE(x, 0, results + (size_t)3 * stride + first);
}
