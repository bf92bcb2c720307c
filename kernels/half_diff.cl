/* MERL tables: rows (theta_h, theta_d) of cells along phi_d, the spectrum summed into channels.
 *
 * Along such a row x, cos(theta_d), Fresnel and mu_i + mu_r are constant; the shadowing and the
 * effective roughness are not, but they do not depend on the wavelength: they are computed once a
 * cell and shared by the spectrum.
 *
 * In: waves[wavelength][HETAB_WAVE_REALS], frame[row][HETAB_FRAME_REALS], cosines
 * mu_i[row][stride] and mu_r[row][stride] (from the host: they cancel at the horizon), stride a
 * multiple of HETAB_VW. Out: channels[HETAB_CHANNELS][row][stride], sum over wavelengths of
 * weight * (dd + ud); -1 where a direction is below the horizon. */
#define HETAB_CL
#include "he_torrance.h"
#include "shadowing.h"
#include "tables.h"

/* What every wavelength shares at HETAB_VW cells of a row. */
typedef struct hetab_cells {
  vreal shadow, ratio2; /* as in HETAB_PAIR_REALS */
  real mu2, lateral2, cos2_d;
} hetab_cells;

static inline hetab_cells hetab_cells_of(vreal mu_i, vreal mu_r, __global const real *frame,
                                         real tau_2sigma) {
  hetab_cells c;
  vreal i = fmax(mu_i, (vreal)RC(1e-12)), r = fmax(mu_r, (vreal)RC(1e-12));
  vreal s_i = sqrt((RC(1.0) - i) * (RC(1.0) + i)), s_r = sqrt((RC(1.0) - r) * (RC(1.0) + r));
  c.ratio2 = hetab_roughness_ratio2(hetab_k(i, s_i, tau_2sigma) + hetab_k(r, s_r, tau_2sigma));
  c.shadow = hetab_shadow_over_cos(i, s_i, tau_2sigma) *
             hetab_shadow_over_cos(r, s_r, tau_2sigma) * c.ratio2;
  c.lateral2 = frame[0];
  c.mu2 = frame[1];
  c.cos2_d = fmin(RC(0.25) * (c.mu2 + c.lateral2), RC(1.0));
  return c;
}

static inline vreal hetab_cells_value(const hetab_cells *c, const hetab_wave *wave) {
  vreal fresnel = hetab_fresnel((vreal)c->cos2_d, (vreal)wave->n, (vreal)wave->k);
  vreal h = hetab_h(wave->g.hi * c->mu2 * c->ratio2, (vreal)(wave->x.hi * c->lateral2));
  return hetab_dd((vreal)c->cos2_d, fresnel, (vreal)wave->amplitude, c->shadow, h) +
         wave->diffuse_brdf;
}

__kernel void hetab_k_half_diff(__global const real *waves, int wavelength_count, real tau_2sigma,
                                __global const real *frame, __global const real *mu_i,
                                __global const real *mu_r, int row_count, int stride,
                                __global real *channels) {
  int r = get_global_id(1);
  if (r >= row_count)
    return;
  size_t start = (size_t)r * stride, plane = (size_t)row_count * stride;
  size_t cosine = (size_t)r * stride;
  for (int e = get_local_id(0) * HETAB_VW; e < stride; e += get_local_size(0) * HETAB_VW) {
    vreal i = V_LOAD(0, mu_i + cosine + e), o = V_LOAD(0, mu_r + cosine + e);
    vreal lowest = fmin(i, o);
    vreal sum[HETAB_CHANNELS] = {RC(0.0), RC(0.0), RC(0.0)};
    if (V_ANY(lowest > (vreal)RC(0.0))) {
      hetab_cells cells =
          hetab_cells_of(i, o, frame + (size_t)r * HETAB_FRAME_REALS, tau_2sigma);
      for (int w = 0; w < wavelength_count; w++) {
        hetab_wave wave = hetab_wave_load(waves, w);
        vreal value = hetab_cells_value(&cells, &wave);
        for (int c = 0; c < HETAB_CHANNELS; c++)
          sum[c] += wave.weight[c] * value;
      }
    }
    for (int c = 0; c < HETAB_CHANNELS; c++) {
      vreal value = lowest > (vreal)RC(0.0) ? sum[c] : (vreal)RC(-1.0);
      V_STORE(value, 0, channels + c * plane + start + e);
    }
  }
}
