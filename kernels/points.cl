/* The model at single points: a work-item takes HETAB_VW of them, columns are [...][stride], stride
 * a multiple of HETAB_VW.
 *   hetab_k_points  points of waves of their own: points[HETAB_POINT_REALS][stride],
 *                   results[HETAB_RESULT_REALS][stride]
 *   hetab_k_places  one surface's waves at every place: places[HETAB_PLACE_REALS][stride]; dd + ud
 *                   as values[wavelength][stride], a wavelength a work-item (dimension 1), or as
 *                   the channels that the waves' weights sum it into, values[channel][stride] */
#define HETAB_CL
#include "he_torrance.h"
#include "tables.h"

/* Of HETAB_VW points that start at `first`. */
static inline vreal hetab_column(__global const real *columns, int stride, size_t first, int c) {
  return V_LOAD(0, columns + (size_t)c * stride + first);
}

__kernel void hetab_k_points(__global const real *points, int stride, __global real *results) {
  size_t first = get_global_id(0) * HETAB_VW;
  if (first >= (size_t)stride)
    return;
  vreal wave_g = hetab_column(points, stride, first, HETAB_POINT_WAVE_G);
  vreal e1 = hetab_column(points, stride, first, HETAB_POINT_E1);
  vreal nk = hetab_column(points, stride, first, HETAB_POINT_NK);
  vreal mu2 = hetab_column(points, stride, first, HETAB_PLACE_MU2);
  vreal lateral2 = hetab_column(points, stride, first, HETAB_PLACE_LATERAL2);
  vreal amplitude = hetab_column(points, stride, first, HETAB_POINT_AMPLITUDE);
  vreal shadow = hetab_column(points, stride, first, HETAB_PLACE_SHADOW);

  vreal g = wave_g * mu2 * hetab_column(points, stride, first, HETAB_PLACE_RATIO2);
  vreal x = hetab_column(points, stride, first, HETAB_POINT_WAVE_X) * lateral2;
  vreal cos2_d = fmin(RC(0.25) * (mu2 + lateral2), (vreal)RC(1.0));
  vreal dd = hetab_dd(cos2_d, hetab_fresnel(cos2_d, e1, nk), amplitude * shadow, hetab_h(g, x));

  vreal mu_i = hetab_column(points, stride, first, HETAB_POINT_MU_I);
  vreal mu_i2 = mu_i * mu_i;
  vreal g_specular =
      wave_g * RC(4.0) * mu_i2 * hetab_column(points, stride, first, HETAB_POINT_SPECULAR_RATIO2);
  vreal specular =
      hetab_rho_s(hetab_fresnel(mu_i2, e1, nk),
                  hetab_column(points, stride, first, HETAB_POINT_SPECULAR_SHADOW2), g_specular);

  V_STORE(dd, 0, results + (size_t)HETAB_RESULT_DD * stride + first);
  V_STORE(specular, 0, results + (size_t)HETAB_RESULT_SPECULAR * stride + first);
  V_STORE(g, 0, results + (size_t)HETAB_RESULT_G * stride + first);
  V_STORE(x, 0, results + (size_t)HETAB_RESULT_X * stride + first);
}

/* One surface's places, by columns. */
typedef struct hetab_place {
  vreal mu2, lateral2, shadow, ratio2;
} hetab_place;

static inline vreal hetab_place_value(const hetab_place *place, const hetab_wave *wave) {
  vreal g = wave->g.hi * place->mu2 * place->ratio2;
  vreal x = wave->x.hi * place->lateral2;
  vreal cos2_d = fmin(RC(0.25) * (place->mu2 + place->lateral2), (vreal)RC(1.0));
  vreal fresnel = hetab_fresnel(cos2_d, (vreal)wave->e1, (vreal)wave->nk);
  return hetab_dd(cos2_d, fresnel, wave->amplitude * place->shadow, hetab_h(g, x)) +
         wave->diffuse_brdf;
}

__kernel void hetab_k_places(__global const real *waves, int wave_count, int to_channels,
                             __global const real *places, int stride, __global real *values) {
  size_t first = get_global_id(0) * HETAB_VW;
  if (first >= (size_t)stride)
    return;
  hetab_place place = {hetab_column(places, stride, first, HETAB_PLACE_MU2),
                       hetab_column(places, stride, first, HETAB_PLACE_LATERAL2),
                       hetab_column(places, stride, first, HETAB_PLACE_SHADOW),
                       hetab_column(places, stride, first, HETAB_PLACE_RATIO2)};
  if (!to_channels) {
    hetab_wave wave = hetab_wave_load(waves, get_global_id(1));
    V_STORE(hetab_place_value(&place, &wave), 0, values + get_global_id(1) * stride + first);
    return;
  }
  vreal x = RC(0.0), y = RC(0.0), z = RC(0.0);
  for (int w = 0; w < wave_count; w++) {
    hetab_wave wave = hetab_wave_load(waves, w);
    vreal value = hetab_place_value(&place, &wave);
    x += wave.weight[0] * value;
    y += wave.weight[1] * value;
    z += wave.weight[2] * value;
  }
  V_STORE(x, 0, values + first);
  V_STORE(y, 0, values + (size_t)stride + first);
  V_STORE(z, 0, values + (size_t)2 * stride + first);
}
