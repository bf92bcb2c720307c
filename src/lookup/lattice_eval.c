/* Evaluation, in blocks of pairs so that the compiler turns loops over a block, and over the
 * channels of a node, into vectors. The Makefile builds this file with -O3, without errno in
 * square roots, and with contraction; NaN is heeded. */
#include "lookup/lattice.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { BLOCK = HETAB_LATTICE_BLOCK, WIDE = 8 };

/* Where the pairs of a block lie: the lower corner of their cells, and the fractions within. */
typedef struct block {
  int32_t node[BLOCK]; /* number of the corner's node */
  float h[BLOCK], d[BLOCK], q[BLOCK];
  float above[BLOCK]; /* 1, or 0 below the horizon */
} block;

#define INLINE static inline __attribute__((always_inline))

/* NaN becomes 0. */
INLINE float limited(float x, float top) {
  x = x > 0 ? x : 0;
  return x < top ? x : top;
}

/* The cell of `x`, in cells, 0 to count - 1. */
INLINE int32_t cell_of(float x, int count) {
  int32_t cell = (int32_t)x;
  return cell < count - 2 ? cell : count - 2;
}

INLINE float fourth(float x) {
  return x * x * x * x;
}

INLINE float fraction(float x, float low, float high) {
  return limited((x - low) / (high - low), 1);
}

/* q^2 at node x of the axis. */
INLINE float q2_at(float x) {
  float rest = 1 - x * (1.0f / (HETAB_LATTICE_Q - 1)), q = 1 - rest * rest;
  return q * q;
}

typedef struct pairs {
  float i[3][BLOCK], o[3][BLOCK];
} pairs;

/* The fourth root of v or c^2 in cells of an axis. */
INLINE int32_t root_cell(float x, int count) {
  return cell_of(sqrtf(sqrtf(x)) * (float)(count - 1), count);
}

/* Of v / (1.005 - v), nearly the tangent's square, in which ln f is linear. */
INLINE float tangent2_fraction(float v, float low, float high) {
  return limited((v - low) * (1.005f - high) / ((high - low) * (1.005f - v)), 1);
}

/* In two loops, of which compilers make vectors. */
INLINE void locate(const pairs *p, int lanes, block *b) {
  const float scale_h = 1.0f / (HETAB_LATTICE_H - 1), scale_d = 1.0f / (HETAB_LATTICE_D - 1);
  float v[BLOCK], c2[BLOCK], q[BLOCK];
  for (int l = 0; l < lanes; l++) {
    float sx = p->i[0][l] + p->o[0][l], sy = p->i[1][l] + p->o[1][l];
    float sz = p->i[2][l] + p->o[2][l], lateral2 = sx * sx + sy * sy;
    float length2 = lateral2 + sz * sz, up = 0.5f * sz;
    v[l] = limited(lateral2 / length2, 1);
    c2[l] = limited(0.25f * length2, 1);
    float side = sqrtf(v[l] * (1 - c2[l])), tilt = 0.5f * fabsf(p->o[2][l] - p->i[2][l]);
    float most = side < up ? side : up;
    q[l] = limited(tilt / (most + 1e-20f), 1);
    b->above[l] = p->i[2][l] > 0 && p->o[2][l] > 0 ? 1 : 0;
  }
  for (int l = 0; l < lanes; l++) {
    int32_t k = cell_of((1 - sqrtf(1 - q[l])) * (HETAB_LATTICE_Q - 1), HETAB_LATTICE_Q);
    float fk = (float)k;
    int32_t h = root_cell(v[l], HETAB_LATTICE_H), d = root_cell(c2[l], HETAB_LATTICE_D);
    float fh = (float)h, fd = (float)d;
    b->h[l] = tangent2_fraction(v[l], fourth(fh * scale_h), fourth((fh + 1) * scale_h));
    b->d[l] = fraction(c2[l], fourth(fd * scale_d), fourth((fd + 1) * scale_d));
    b->q[l] = fraction(q[l] * q[l], q2_at(fk), q2_at(fk + 1));
    b->node[l] = (h * HETAB_LATTICE_D + d) * HETAB_LATTICE_Q + k;
  }
}

/* Vectors in name: where a compiler's loops do not become what the machine has. */
typedef uint16_t codes8 __attribute__((vector_size(16)));
typedef int32_t ints8 __attribute__((vector_size(32)));
typedef uint32_t bits8 __attribute__((vector_size(32)));
typedef float floats8 __attribute__((vector_size(32)));

/* 2^x within 2e-7, for |x| < 126. */
INLINE void exp2_of(floats8 *x) {
  floats8 shifted = *x + 12582912.0f, r = *x - (shifted - 12582912.0f);
  floats8 p = 1.54035303933816099e-4f * r + 1.33335581464284434e-3f;
  p = p * r + 9.61812910762847716e-3f;
  p = p * r + 5.55041086648215800e-2f;
  p = p * r + 2.40226506959100712e-1f;
  p = p * r + 6.93147180559945309e-1f;
  p = p * r + 1.0f;
  bits8 bits;
  memcpy(&bits, &shifted, sizeof bits);
  bits = (bits << 23) + 0x3f800000u;
  memcpy(&shifted, &bits, sizeof bits);
  *x = p * shifted;
}

/* Interpolated codes to values. */
INLINE void decode(const hetab_lattice *lattice, floats8 *codes) {
  floats8 value = lattice->low + lattice->step * *codes;
  exp2_of(&value);
  value -= lattice->floor;
  *codes = (floats8)((ints8)value & (ints8)(value > 0));
}

/* A cell's four edges along q: how far their first nodes are from the corner's, and weights. */
enum {
  EDGE_D = HETAB_LATTICE_Q,
  EDGE_H = HETAB_LATTICE_D * HETAB_LATTICE_Q,
};

INLINE void edge_weights(const block *b, int l, float weight[4]) {
  float h = b->h[l], d = b->d[l];
  weight[0] = (1 - h) * (1 - d);
  weight[1] = (1 - h) * d;
  weight[2] = h * (1 - d);
  weight[3] = h * d;
}

/* Asks for what a lane of the next block will read, if there is one: it comes while this block is
 * computed. */
INLINE void ask(const hetab_lattice *lattice, const block *next, int l) {
  static const int edge[4] = {0, EDGE_D, EDGE_H, EDGE_H + EDGE_D};
  for (int e = 0; next && e < 4; e++) {
    const uint16_t *node = lattice->codes + (size_t)(next->node[l] + edge[e]) * lattice->stride;
    __builtin_prefetch(node);
    if (lattice->stride > 4)
      __builtin_prefetch(node + lattice->stride);
  }
}

/* Codes of up to four channels: both ends of an edge in one load. */
INLINE void gather_few(const hetab_lattice *lattice, const block *b, const block *next, int lanes,
                       float *out) {
  for (int l = 0; l < lanes; l++) {
    ask(lattice, next, l);
    const uint16_t *corner = lattice->codes + (size_t)b->node[l] * 4;
    const uint16_t *edge[4] = {corner, corner + 4 * EDGE_D, corner + 4 * EDGE_H,
                               corner + 4 * (EDGE_H + EDGE_D)};
    float weight[4], ends[8];
    floats8 sum = {0};
    edge_weights(b, l, weight);
    for (int e = 0; e < 4; e++) {
      codes8 codes;
      memcpy(&codes, edge[e], sizeof codes);
      sum += weight[e] * __builtin_convertvector(__builtin_convertvector(codes, ints8), floats8);
    }
    memcpy(ends, &sum, sizeof ends);
    for (int c = 0; c < 4; c++)
      out[4 * l + c] = ends[c] + b->q[l] * (ends[c + 4] - ends[c]);
  }
}

static const int corners[8] = {0,      1,          EDGE_D,          EDGE_D + 1,
                               EDGE_H, EDGE_H + 1, EDGE_H + EDGE_D, EDGE_H + EDGE_D + 1};

/* Eight channels of one pair. */
INLINE void gather_wide(const uint16_t *corner, size_t stride, const float weight[8],
                        floats8 *out) {
  floats8 sum = {0};
  for (int n = 0; n < 8; n++) {
    codes8 codes;
    memcpy(&codes, corner + (size_t)corners[n] * stride, sizeof codes);
    sum += weight[n] * __builtin_convertvector(__builtin_convertvector(codes, ints8), floats8);
  }
  *out = sum;
}

INLINE void eval_few(const hetab_lattice *lattice, const block *b, const block *next, int lanes,
                     size_t count, float *value) {
  size_t channels = lattice->channels;
  union {
    float each[BLOCK * 4];
    floats8 eight[BLOCK / 2];
  } all = {{0}};
  gather_few(lattice, b, next, lanes, all.each);
  for (int l = 0; l < lanes; l += 2)
    decode(lattice, &all.eight[l / 2]);
  for (size_t l = 0; l < count; l++)
    for (size_t c = 0; c < channels; c++)
      value[l * channels + c] = b->above[l] * all.each[4 * l + c];
}

INLINE void corner_weights(const block *b, int l, float weight[8]) {
  float edge[4];
  edge_weights(b, l, edge);
  for (int e = 0; e < 4; e++) {
    weight[2 * e] = edge[e] * (1 - b->q[l]);
    weight[2 * e + 1] = edge[e] * b->q[l];
  }
}

/* All channels of one pair. With `room` for a whole vector more they may end in rubbish. */
INLINE void eval_row(const hetab_lattice *lattice, const block *b, int l, int room, float *value) {
  size_t channels = lattice->channels, stride = lattice->stride;
  const uint16_t *corner = lattice->codes + (size_t)b->node[l] * stride;
  float weight[8];
  floats8 wide;
  corner_weights(b, l, weight);
  for (size_t first = 0; first < channels; first += WIDE) {
    gather_wide(corner + first, stride, weight, &wide);
    decode(lattice, &wide);
    wide *= b->above[l];
    if (room || channels - first >= WIDE)
      memcpy(value + first, &wide, sizeof wide);
    else
      memcpy(value + first, &wide, (channels - first) * sizeof(float));
  }
}

enum { LOW_SHIFT = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? 0 : 16, GROUP = 4 };

/* A channel's code, and the next one's, in one load. */
INLINE int32_t pair_at(const uint16_t *codes, uint32_t channel) {
  int32_t pair;
  memcpy(&pair, codes + channel, sizeof pair);
  return pair;
}

/* Four places of one pair of directions, two nodes at once. */
INLINE void gather_places(const hetab_lattice *lattice, const uint16_t *corner,
                          const float weight[8], const uint32_t *at, const float *fraction,
                          floats8 *out) {
  floats8 low = {0}, high = {0};
  for (int n = 0; n < 8; n += 2) {
    const uint16_t *a = corner + (size_t)corners[n] * lattice->stride, *b = a + lattice->stride;
    float v = weight[n], w = weight[n + 1];
    ints8 pair = {pair_at(a, at[0]), pair_at(a, at[1]), pair_at(a, at[2]), pair_at(a, at[3]),
                  pair_at(b, at[0]), pair_at(b, at[1]), pair_at(b, at[2]), pair_at(b, at[3])};
    floats8 weights = {v, v, v, v, w, w, w, w};
    low += weights * __builtin_convertvector((pair >> LOW_SHIFT) & 0xffff, floats8);
    high += weights * __builtin_convertvector((pair >> (16 - LOW_SHIFT)) & 0xffff, floats8);
  }
  floats8 ends;
  for (int j = 0; j < GROUP; j++) {
    ends[j] = low[j] + low[j + GROUP];
    ends[j + GROUP] = high[j] + high[j + GROUP];
  }
  decode(lattice, &ends);
  for (int j = 0; j < GROUP; j++)
    ends[j] += fraction[j] * (ends[j + GROUP] - ends[j]);
  *out = ends;
}

INLINE void eval_places(const hetab_lattice *lattice, const block *b, int l,
                        const hetab_band_places *places, float *value) {
  const uint16_t *corner = lattice->codes + (size_t)b->node[l] * lattice->stride;
  float weight[8];
  corner_weights(b, l, weight);
  for (size_t first = 0; first < places->count; first += GROUP) {
    floats8 four;
    gather_places(lattice, corner, weight, places->first + first, places->fraction + first, &four);
    four *= b->above[l];
    memcpy(value + first, &four,
           (places->count - first < GROUP ? places->count - first : GROUP) * sizeof *value);
  }
}

/* The next row overwrites what is too much of a row. */
INLINE void eval_wide(const hetab_lattice *lattice, const block *b, const block *next, size_t count,
                      float *value) {
  for (size_t l = 0; l < count; l++) {
    ask(lattice, next, (int)l);
    eval_row(lattice, b, (int)l, l + 1 < count, value + l * lattice->channels);
  }
}

INLINE void eval_paths(const hetab_lattice *lattice, const block *b, const block *next,
                       size_t count, const hetab_band_places *places, size_t width, float *value) {
  for (size_t l = 0; l < count; l++) {
    ask(lattice, next, (int)l);
    eval_places(lattice, b, (int)l, &places[l], value + l * width);
  }
}

/* Lanes without a pair repeat the last one. */
INLINE void load(size_t count, int lanes, const float (*wi)[3], const float (*wo)[3], pairs *p) {
  for (size_t l = 0; l < (size_t)lanes; l++) {
    size_t from = l < count ? l : count - 1;
    for (int a = 0; a < 3; a++) {
      p->i[a][l] = wi[from][a];
      p->o[a][l] = wo[from][a];
    }
  }
}

INLINE void locate_some(size_t count, int lanes, const float (*wi)[3], const float (*wo)[3],
                        block *b) {
  pairs p;
  load(count < BLOCK ? count : BLOCK, lanes, wi, wo, &p);
  locate(&p, lanes, b);
}

INLINE void eval_block(const hetab_lattice *lattice, const block *b, const block *next,
                       size_t count, int lanes, const hetab_band_places *places, size_t width,
                       float *value) {
  if (places)
    eval_paths(lattice, b, next, count, places, width, value);
  else if (lattice->stride == 4)
    eval_few(lattice, b, next, lanes, count, value);
  else
    eval_wide(lattice, b, next, count, value);
}

INLINE void eval_all(const hetab_lattice *lattice, size_t count, const float (*wi)[3],
                     const float (*wo)[3], const hetab_band_places *places, size_t width,
                     float *value) {
  block both[2];
  if (count == 1) {
    locate_some(1, 1, wi, wo, both);
    eval_block(lattice, both, NULL, 1, 1, places, width, value);
    return;
  }
  for (size_t first = 0; first < count; first += BLOCK) {
    block *b = &both[first / BLOCK % 2], *next = &both[1 - first / BLOCK % 2];
    size_t left = count - first;
    if (first == 0)
      locate_some(left, BLOCK, wi, wo, b);
    if (left > BLOCK)
      locate_some(left - BLOCK, BLOCK, wi + first + BLOCK, wo + first + BLOCK, next);
    eval_block(lattice, b, left > BLOCK ? next : NULL, left < BLOCK ? left : BLOCK, BLOCK,
               places ? places + first : NULL, width, value + first * width);
  }
}

#if defined(__x86_64__)
#define WITH_AVX2 __attribute__((target("arch=x86-64-v3")))
WITH_AVX2 static void eval_avx2(const hetab_lattice *lattice, size_t count, const float (*wi)[3],
                                const float (*wo)[3], float *value) {
  eval_all(lattice, count, wi, wo, NULL, lattice->channels, value);
}

WITH_AVX2 static void eval_places_avx2(const hetab_lattice *lattice, size_t count,
                                       const float (*wi)[3], const float (*wo)[3],
                                       const hetab_band_places *places, size_t width,
                                       float *value) {
  eval_all(lattice, count, wi, wo, places, width, value);
}

static bool has_avx2(void) {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi2");
}
#else
#define eval_avx2(lattice, count, wi, wo, value)                                                   \
  eval_all(lattice, count, wi, wo, NULL, lattice->channels, value)
#define eval_places_avx2 eval_all
#define has_avx2() false
#endif

/* 31 channels gain 1.6 times from AVX2, three a little; neither gains more from AVX-512. */
void hetab_lattice_eval(const hetab_lattice *lattice, size_t count, const float *wi,
                        const float *wo, float *value) {
  const float(*i)[3] = (const float(*)[3])wi, (*o)[3] = (const float(*)[3])wo;
  if (has_avx2())
    eval_avx2(lattice, count, i, o, value);
  else
    eval_all(lattice, count, i, o, NULL, lattice->channels, value);
}

void hetab_lattice_eval_places(const hetab_lattice *lattice, size_t count, const float *wi,
                               const float *wo, const hetab_band_places *places, size_t width,
                               float *value) {
  const float(*i)[3] = (const float(*)[3])wi, (*o)[3] = (const float(*)[3])wo;
  if (has_avx2())
    eval_places_avx2(lattice, count, i, o, places, width, value);
  else
    eval_all(lattice, count, i, o, places, width, value);
}
