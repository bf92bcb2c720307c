/* MERL tables: rows (theta_h, theta_d) of cells along phi_d, the spectrum summed into channels.
 *
 * Along such a row x, cos(theta_d), Fresnel and mu_i + mu_r are constant. The shadowing and the
 * effective roughness are not, but they do not depend on the wavelength: once a cell, shared by the
 * spectrum. What is left per cell and wavelength is h at one x and g = g_row / (1 + W): a short
 * polynomial of the atlas.
 *
 * In: waves[wavelength][HETAB_WAVE_REALS], frame[row][HETAB_FRAME_REALS], cosines
 * mu_i[row][stride] and mu_r[row][stride] (from the host: they cancel at the horizon), stride a
 * multiple of HETAB_VW. Out: channels[HETAB_CHANNELS][row][stride], sum over wavelengths of
 * weight * (dd + ud); -1 where a direction is below the horizon. A build may do the cells that the
 * atlas holds and another one those below it, which it adds: for the registers that the series
 * takes. */
#define HETAB_CL
#include "he_torrance.h"
#include "atlas.h"
#include "shadowing.h"
#include "tables.h"

/* Vectors of cells that a work-item carries through the spectrum at a time. Where neighbours share
 * a row, as on GPUs, loops over them are unrolled: an index at run time would put all of them in
 * memory. */
#define HETAB_BATCH 6
#if HETAB_ROW_ITEMS > 1
#define HETAB_FOR_CELLS(v, count)                                                                  \
  _Pragma("unroll") for (int v = 0; v < HETAB_BATCH; v++) if (v < (count))
#else
#define HETAB_FOR_CELLS(v, count) for (int v = 0; v < (count); v++)
#endif

/* Build option: what this build does. */
#ifndef HETAB_PARTS
#define HETAB_PARTS (HETAB_PART_ATLAS | HETAB_PART_SERIES)
#endif

typedef struct hetab_cells {
  int count;                              /* vectors in use */
  vreal ratio2[HETAB_BATCH];              /* 1 / (1 + W); 0 below the horizon */
  vreal sum[HETAB_CHANNELS][HETAB_BATCH]; /* over wavelengths of weight F amplitude h */
  real ratio2_min, ratio2_max;
} hetab_cells;

/* S_i S_r / (mu_i mu_r) / (1 + W) and the roughness ratio at one vector of cells. */
static inline vreal hetab_cell_shadow(vreal mu_i, vreal mu_r, real tau_2sigma, vreal *ratio2) {
  vreal i = fmax(mu_i, (vreal)RC(1e-12)), r = fmax(mu_r, (vreal)RC(1e-12));
  vreal s_i = sqrt((RC(1.0) - i) * (RC(1.0) + i)), s_r = sqrt((RC(1.0) - r) * (RC(1.0) + r));
  *ratio2 = hetab_roughness_ratio2(hetab_k(i, s_i, tau_2sigma) + hetab_k(r, s_r, tau_2sigma));
  return hetab_shadow_over_cos(i, s_i, tau_2sigma) * hetab_shadow_over_cos(r, s_r, tau_2sigma) *
         *ratio2;
}

static inline void hetab_cells_add(hetab_cells *cells, const hetab_wave *wave, int at,
                                   vreal value) {
#pragma unroll
  for (int c = 0; c < HETAB_CHANNELS; c++)
    cells->sum[c][at] += wave->weight[c] * value;
}

/* The cells whose g lies below the atlas. */
static inline void hetab_cells_by_series(hetab_cells *cells, const hetab_wave *wave, real g_row,
                                         real x, real factor, real g_below) {
  for (int v = 0; v < cells->count; v++) {
    vreal g = g_row * cells->ratio2[v];
    if (V_ANY(g < (vreal)g_below)) {
      vreal h = hetab_h(g, (vreal)x);
      hetab_cells_add(cells, wave, v, g < (vreal)g_below ? factor * h : (vreal)RC(0.0));
    }
  }
}

/* One wavelength: panel by panel, each cell is taken by the panel that holds its g. */
static inline void hetab_cells_by_atlas(hetab_cells *cells, const hetab_wave *wave,
                                        const hetab_atlas *atlas, hetab_two lateral2, real g_row,
                                        real factor, int lowest, int highest) {
  hetab_column column;
  for (int panel = max(lowest, 0); panel <= highest; panel++) {
    hetab_atlas_load_column(atlas, panel, wave->x, lateral2, &column);
    if (column.h_centre == RC(0.0))
      continue;
    real low = panel == lowest ? RC(0.0) : hetab_panel_start(atlas, panel);
    real high = panel == highest ? RC(1e30) : hetab_panel_start(atlas, panel + 1);
    HETAB_FOR_CELLS(v, cells->count) {
      vreal g = g_row * cells->ratio2[v];
      vreal value = factor * hetab_atlas_column_h(&column, g);
      if (lowest != highest)
        value = g >= (vreal)low && g < (vreal)high ? value : (vreal)RC(0.0);
      hetab_cells_add(cells, wave, v, value);
    }
  }
}

static inline void hetab_cells_spectrum(hetab_cells *cells, __global const real *waves,
                                        int wavelength_count, __global const real *frame,
                                        const hetab_atlas *atlas) {
  hetab_two lateral2 = hetab_two_at(frame + HETAB_FRAME_LATERAL2);
  real mu2 = frame[HETAB_FRAME_MU2];
  real cos2_d = fmin(RC(0.25) * (mu2 + lateral2.hi), RC(1.0));
  /* without an atlas (the series method) every cell takes the series */
  real g_below = atlas->panel_count > 0 ? hetab_panel_start(atlas, 0) : INFINITY;
  for (int w = 0; w < wavelength_count; w++) {
    hetab_wave wave = hetab_wave_load(waves, w);
    real fresnel = V_FIRST(hetab_fresnel((vreal)cos2_d, (vreal)wave.e1, (vreal)wave.nk));
    real factor =
        V_FIRST(hetab_dd((vreal)cos2_d, (vreal)fresnel, (vreal)wave.amplitude, (vreal)RC(1.0)));
    real g_row = wave.g.hi * mu2;
    int highest = hetab_atlas_panel(atlas, g_row * cells->ratio2_max);
    int lowest = hetab_atlas_panel(atlas, g_row * cells->ratio2_min);
    if ((HETAB_PARTS & HETAB_PART_ATLAS) && highest >= 0)
      hetab_cells_by_atlas(cells, &wave, atlas, lateral2, g_row, factor, lowest, highest);
    if ((HETAB_PARTS & HETAB_PART_SERIES) && lowest < 0)
      hetab_cells_by_series(cells, &wave, g_row, wave.x.hi * lateral2.hi, factor, g_below);
  }
}

__kernel void hetab_k_half_diff(__global const real *waves, int wavelength_count, real tau_2sigma,
                                real diffuse0, real diffuse1, real diffuse2,
                                __global const real *frame, __global const real *mu_i,
                                __global const real *mu_r, int row_count, int stride,
                                __global const real *panels, __global const real *segments,
                                __global const real *coefficients, int panel_count, int first_panel,
                                __global real *channels) {
  int r = hetab_row_number();
  if (r >= row_count)
    return;
  hetab_atlas atlas = {panels, segments, coefficients, panel_count, first_panel};
  const real diffuse[HETAB_CHANNELS] = {diffuse0, diffuse1, diffuse2};
  size_t start = (size_t)r * stride, plane = (size_t)row_count * stride;
  int step = HETAB_ROW_ITEMS * HETAB_VW;
  for (int e = hetab_row_item() * HETAB_VW; e < stride; e += HETAB_BATCH * step) {
    hetab_cells cells;
    vreal shadow[HETAB_BATCH], lowest_mu[HETAB_BATCH];
    cells.count = min(HETAB_BATCH, (stride - e + step - 1) / step);
    cells.ratio2_min = RC(1.0);
    cells.ratio2_max = RC(0.0);
    HETAB_FOR_CELLS(v, cells.count) {
      size_t at = start + e + v * step;
      vreal i = V_LOAD(0, mu_i + at), o = V_LOAD(0, mu_r + at);
      lowest_mu[v] = fmin(i, o);
      shadow[v] = cells.ratio2[v] = RC(0.0);
      for (int c = 0; c < HETAB_CHANNELS; c++)
        cells.sum[c][v] = RC(0.0);
      if (V_ANY(lowest_mu[v] > (vreal)RC(0.0))) {
        shadow[v] = hetab_cell_shadow(i, o, tau_2sigma, &cells.ratio2[v]);
        cells.ratio2[v] = lowest_mu[v] > (vreal)RC(0.0) ? cells.ratio2[v] : (vreal)RC(0.0);
        vreal above = lowest_mu[v] > (vreal)RC(0.0) ? cells.ratio2[v] : (vreal)RC(1.0);
        cells.ratio2_min = fmin(cells.ratio2_min, hetab_lane_min(above));
        cells.ratio2_max = fmax(cells.ratio2_max, hetab_lane_max(cells.ratio2[v]));
      }
    }
    if (cells.ratio2_max > RC(0.0))
      hetab_cells_spectrum(&cells, waves, wavelength_count, frame + (size_t)r * HETAB_FRAME_REALS,
                           &atlas);
    HETAB_FOR_CELLS(v, cells.count) {
      for (int c = 0; c < HETAB_CHANNELS; c++) {
        __global real *to = channels + c * plane + start + e + v * step;
        vreal rest = HETAB_PARTS == HETAB_PART_SERIES ? V_LOAD(0, to) : (vreal)diffuse[c];
        vreal value = shadow[v] * cells.sum[c][v] + rest;
        value = lowest_mu[v] > (vreal)RC(0.0) ? value : (vreal)RC(-1.0);
        V_STORE(value, 0, to);
      }
    }
  }
}
