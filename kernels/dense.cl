/* Dense tables: entry [theta_r][phi] of the rows (theta_i, theta_r) of one wavelength.
 *
 * One work-item takes HETAB_VW neighbouring entries of a row at a time and strides through the row
 * with its HETAB_ROW_ITEMS - 1 neighbours. Rows (theta_i, theta_r) and (theta_r, theta_i) are
 * equal: where a slab holds both, one is computed and stored twice. Two methods and a limit:
 *   hetab_k_dense_rows    polynomials of the atlas (default)
 *   hetab_k_dense_series  the constant-cost series at every entry
 *   hetab_k_dense_store   writes and does nothing else: the ceiling of the device's memory
 *
 * Buffers: rows[row][2], the numbers of a pair (and row of the slab) and of its mirror image or -1;
 * waves[wavelength][HETAB_WAVE_REALS], pairs[theta_i][theta_r][HETAB_PAIR_REALS],
 * one_plus_cos[phi], falling, padded with its last value to a multiple of HETAB_VW. */
#define HETAB_CL
#include "he_torrance.h"
#include "atlas.h"
#include "tables.h"

#if HETAB_ROW_ITEMS > 1 && HETAB_VW > 1
#error "dense.cl: vectors go with one work-item a row"
#endif

/* A row's constants, from one pair and one wavelength. */
typedef struct hetab_row {
  hetab_wave wave;
  hetab_two mu2_ratio2; /* g over the wave's */
  hetab_row_x x;
  real amplitude; /* of the wave, times shadow */
  real mu2;
  __global real *out,
      *mirror; /* where the row goes, twice the same if it is its own mirror image */
} hetab_row;

static inline hetab_row hetab_row_of(__global const real *waves, int wavelength,
                                     __global const real *pairs, __global const int *numbers,
                                     __global real *out, int phi_count) {
  hetab_row row;
  __global const real *pair = pairs + (size_t)numbers[0] * HETAB_PAIR_REALS;
  row.out = out + (size_t)numbers[0] * phi_count;
  row.mirror = numbers[1] < 0 ? row.out : out + (size_t)numbers[1] * phi_count;
  row.wave = hetab_wave_load(waves, wavelength);
  row.mu2_ratio2 = hetab_two_at(pair + HETAB_PAIR_G);
  row.x.wave_x = row.wave.x;
  row.x.d2 = hetab_two_at(pair + HETAB_PAIR_D2);
  row.x.p = pair[HETAB_PAIR_P];
  row.mu2 = pair[HETAB_PAIR_MU2];
  row.amplitude = row.wave.amplitude * pair[HETAB_PAIR_SHADOW];
  return row;
}

/* |q_i + q_r|^2 */
static inline vreal hetab_row_lateral2(const hetab_row *row, vreal one_plus_cos) {
  return row->x.d2.hi + row->x.p * one_plus_cos;
}

/* dd + ud of one vector of entries, given its h. */
static inline vreal hetab_row_value(const hetab_row *row, vreal lateral2, vreal h) {
  vreal cos2_d = RC(0.25) * (row->mu2 + lateral2);
  vreal fresnel = row->wave.fitted
                      ? hetab_fresnel_fitted(cos2_d, row->wave.fresnel_fit, row->wave.fitted)
                      : hetab_fresnel(cos2_d, (vreal)row->wave.e1, (vreal)row->wave.nk);
  return hetab_dd(cos2_d, fresnel, (vreal)row->amplitude, h) + row->wave.diffuse_brdf;
}

/* Rows need not be whole vectors: the first one starts at 0 and the second where the rest is whole,
 * writing over what the first one stored there. (Vectors go with one work-item a row.) Rows shorter
 * than a vector are stored one by one. */
static inline void hetab_store(vreal value, __global real *out, int entry, int phi_count) {
#if HETAB_VW > 1
  if (phi_count < HETAB_VW) {
    real part[HETAB_VW];
    V_STORE(value, 0, part);
    for (int i = 0; i < phi_count; i++)
      out[i] = part[i];
    return;
  }
#endif
  V_STORE(value, 0, out + entry);
}

static inline void hetab_row_store(const hetab_row *row, vreal value, int entry, int phi_count) {
  hetab_store(value, row->out, entry, phi_count);
  if (row->mirror != row->out)
    hetab_store(value, row->mirror, entry, phi_count);
}

/* How many entries of the vector that starts at `entry` are its own; the next one starts there. */
static inline int hetab_row_own(int entry, int phi_count) {
  int rest = phi_count % HETAB_VW;
  return entry == 0 && rest > 0 && phi_count > HETAB_VW ? rest : HETAB_VW;
}

static inline void hetab_row_by_series(const hetab_row *row, __global const real *one_plus_cos,
                                       int phi_count) {
  vreal g = (vreal)(row->wave.g.hi * row->mu2_ratio2.hi);
  for (int e = hetab_row_item() * HETAB_VW; e < phi_count;
       e += HETAB_ROW_ITEMS * hetab_row_own(e, phi_count)) {
    vreal lateral2 = hetab_row_lateral2(row, V_LOAD(0, one_plus_cos + e));
    vreal h = hetab_h(g, row->wave.x.hi * lateral2);
    hetab_row_store(row, hetab_row_value(row, lateral2, h), e, phi_count);
  }
}

/* x at one entry. */
static inline real hetab_row_x_at(const hetab_row *row, real one_plus_cos) {
  return row->wave.x.hi * (row->x.d2.hi + row->x.p * one_plus_cos);
}

/* A row that lies beyond the end of the atlas everywhere. */
static inline void hetab_row_fill(const hetab_row *row, int phi_count) {
  vreal value = (vreal)row->wave.diffuse_brdf;
  for (int e = hetab_row_item() * HETAB_VW; e < phi_count;
       e += HETAB_ROW_ITEMS * hetab_row_own(e, phi_count))
    hetab_row_store(row, value, e, phi_count);
}

#if HETAB_ROW_ITEMS > 1
/* The group along the row forms the polynomials of some segments at a time, together: entries are
 * few, and each would form what its neighbours need too. */
#define HETAB_GROUP_SEGMENTS 16

static inline void hetab_form_segments(const hetab_row *row, const hetab_atlas *atlas, int first,
                                       int count, real u, __local hetab_segment *shared) {
  barrier(CLK_LOCAL_MEM_FENCE); /* the last ones have been read */
  for (int i = hetab_row_item(); i < count * HETAB_ATLAS_X_PAD; i += HETAB_ROW_ITEMS) {
    int s = i / HETAB_ATLAS_X_PAD, j = i % HETAB_ATLAS_X_PAD;
    hetab_atlas_coefficients(atlas, first + s, j, u, shared + s);
    if (j == 0)
      hetab_atlas_head(atlas, first + s, &row->x, shared + s);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

/* The entries whose x lies in [low, high), in the `count` segments that are shared. */
static inline void hetab_row_by_segments(const hetab_row *row, const __local hetab_segment *shared,
                                         int count, real low, real high, real x_end,
                                         __global const real *one_plus_cos, int phi_count) {
  for (int e = hetab_row_item(); e < phi_count; e += HETAB_ROW_ITEMS) {
    real q = one_plus_cos[e];
    real lateral2 = hetab_row_lateral2(row, q), x = row->wave.x.hi * lateral2;
    if (x < low || x >= high)
      continue;
    int s = count - 1;
    while (s > 0 && x < shared[s].start)
      s--;
    real h = x < x_end ? hetab_atlas_h(shared + s, q) : RC(0.0);
    hetab_row_store(row, hetab_row_value(row, lateral2, h), e, phi_count);
  }
}

static inline void hetab_row_by_atlas(const hetab_row *row, const hetab_atlas *atlas, int panel,
                                      __global const real *one_plus_cos, int phi_count,
                                      __local hetab_segment *shared) {
  __global const real *head = atlas->panels + panel * HETAB_PANEL_REALS;
  const int first = (int)head[HETAB_PANEL_FIRST];
  real u = hetab_product_less(row->wave.g, row->mu2_ratio2, head[HETAB_PANEL_CENTRE]) *
           head[HETAB_PANEL_SCALE];
  real x_end = head[HETAB_PANEL_X_END];
  real most = hetab_row_x_at(row, one_plus_cos[0]);
  real least = hetab_row_x_at(row, one_plus_cos[phi_count - 1]);
  if (least >= x_end) {
    hetab_row_fill(row, phi_count);
    return;
  }
  int end = first + (int)head[HETAB_PANEL_COUNT];
  while (end > first + 1 && most < hetab_segment_start(atlas, end - 1))
    end--;
  for (real high = INFINITY;;) {
    int begin = max(first, end - HETAB_GROUP_SEGMENTS);
    real low = begin == first ? RC(0.0) : hetab_segment_start(atlas, begin);
    hetab_form_segments(row, atlas, begin, end - begin, u, shared);
    hetab_row_by_segments(row, shared, end - begin, low, high, x_end, one_plus_cos, phi_count);
    if (least >= low)
      return;
    high = low;
    end = begin;
  }
}
#define HETAB_ROW_GROUP __attribute__((reqd_work_group_size(HETAB_ROW_ITEMS, 1, 1)))
#else
#define HETAB_ROW_GROUP
#define HETAB_GROUP_SEGMENTS 1

/* x falls along the row: segments are entered from above, each loaded once. Entries of the first
 * block that lie beyond x_end get the value there, which is too small to matter. */
static inline void hetab_row_by_atlas(const hetab_row *row, const hetab_atlas *atlas, int panel,
                                      __global const real *one_plus_cos, int phi_count,
                                      hetab_segment *s) {
  __global const real *head = atlas->panels + panel * HETAB_PANEL_REALS;
  const int first = (int)head[HETAB_PANEL_FIRST], none = first + (int)head[HETAB_PANEL_COUNT];
  int at = none, own;
  real u = hetab_product_less(row->wave.g, row->mu2_ratio2, head[HETAB_PANEL_CENTRE]) *
           head[HETAB_PANEL_SCALE];
  real x_end = head[HETAB_PANEL_X_END];
  if (hetab_row_x_at(row, one_plus_cos[phi_count - 1]) >= x_end) {
    hetab_row_fill(row, phi_count);
    return;
  }
  s->start = x_end; /* no segment yet */
  for (int e = 0; e < phi_count; e += own) {
    own = hetab_row_own(e, phi_count);
    vreal q = V_LOAD(0, one_plus_cos + e);
    vreal value = (vreal)row->wave.diffuse_brdf;
    real x_last = hetab_row_x_at(row, one_plus_cos[e + own - 1]);
    if (x_last < x_end) {
      vreal lateral2 = hetab_row_lateral2(row, q);
      vreal h = RC(0.0);
      if (at < none)
        h = hetab_atlas_h(s, q);
      while (at > first && x_last < s->start) {
        vreal above = row->wave.x.hi * lateral2 - s->start;
        hetab_atlas_head(atlas, --at, &row->x, s);
        for (int i = 0; i < HETAB_SEGMENT_VECTORS; i++)
          hetab_atlas_coefficients(atlas, at, i, u, s);
        h = above < (vreal)RC(0.0) ? hetab_atlas_h(s, q) : h;
      }
      value = hetab_row_value(row, lateral2, h);
    }
    hetab_row_store(row, value, e, phi_count);
  }
}
#endif

/* Rows below the atlas's range of g (src/engine/dense.c says which) are left to the series. */
HETAB_ROW_GROUP
__kernel void hetab_k_dense_rows(__global const int *rows, int row_count,
                                 __global const real *waves, int wavelength,
                                 __global const real *pairs, __global const real *one_plus_cos,
                                 int phi_count, __global real *out, __global const real *panels,
                                 __global const real *segments, __global const real *coefficients,
                                 int panel_count, int first_panel) {
  HETAB_SEGMENT_SPACE hetab_segment work[HETAB_GROUP_SEGMENTS];
  int r = hetab_row_number();
  if (r >= row_count)
    return;
  hetab_atlas atlas = {panels, segments, coefficients, panel_count, first_panel};
  hetab_row row = hetab_row_of(waves, wavelength, pairs, rows + 2 * r, out, phi_count);
  int panel = hetab_atlas_panel(&atlas, row.wave.g.hi * row.mu2_ratio2.hi);
  if (panel >= 0)
    hetab_row_by_atlas(&row, &atlas, panel, one_plus_cos, phi_count, work);
}

/* Rows whose g is below g_end; infinity: all. */
__kernel void hetab_k_dense_series(__global const int *rows, int row_count,
                                   __global const real *waves, int wavelength,
                                   __global const real *pairs, __global const real *one_plus_cos,
                                   int phi_count, __global real *out, real g_end) {
  int r = hetab_row_number();
  if (r >= row_count)
    return;
  hetab_row row = hetab_row_of(waves, wavelength, pairs, rows + 2 * r, out, phi_count);
  if (row.wave.g.hi * row.mu2_ratio2.hi < g_end)
    hetab_row_by_series(&row, one_plus_cos, phi_count);
}

__kernel void hetab_k_dense_store(int row_count, int phi_count, __global real *out) {
  int r = hetab_row_number();
  if (r >= row_count)
    return;
  out += (size_t)r * phi_count;
  for (int e = hetab_row_item() * HETAB_VW; e < phi_count;
       e += HETAB_ROW_ITEMS * hetab_row_own(e, phi_count))
    hetab_store((vreal)RC(1.0), out, e, phi_count);
}
