/* HDF5 tables into memory, one theta_i after the other: a node's channels side by side. */
#include "lookup/dense_source.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "core/each.h"
#include "table/h5_rows.h"

static const double MOST_BYTES = 16.0 * (1 << 30);
static const float MOST_BRDF = 1e30f, LEAST_BRDF = 1e-30f; /* outside: damage; black */
/* What is smaller than a row's largest value by that many octaves is as good as 0: cubics through
 * it need a number that is not much less. */
static const float OCTAVES = 50, LARGEST_CODE = 65535;

enum { CHUNK = 64 }; /* nodes that change places together */

typedef struct loading {
  hetab_context *ctx;
  hetab_h5_table *table;
  const char *path;
  hetab_dense_source *dense;
  size_t plane, step;              /* nodes of a theta_i; theta_i that are read together */
  float *rows[HETAB_MOST_WORKERS]; /* [channel][step][plane] */
  pthread_mutex_t mutex;           /* of HDF5 and the context */
  hetab_status status;
} loading;

/* ---- one incidence ------------------------------------------------------------------------- */

#define INLINE static inline __attribute__((always_inline))

/* log2 within 2e-7 of numbers that are neither 0 nor tiny. */
INLINE float log2_of(float x) {
  const float half_root = 0.70710678f;
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  int32_t exponent = (int32_t)(bits >> 23) - 126;
  bits = (bits & 0x7fffff) | 0x3f000000;
  memcpy(&x, &bits, sizeof x);
  int32_t small = x < half_root;
  float e = (float)(exponent - small), y = (small ? x + x : x) - 1, z = y * y;
  float p = 7.0376836292e-2f * y - 1.1514610310e-1f;
  p = p * y + 1.1676998740e-1f;
  p = p * y - 1.2420140846e-1f;
  p = p * y + 1.4249322787e-1f;
  p = p * y - 1.6668057665e-1f;
  p = p * y + 2.0000714765e-1f;
  p = p * y - 2.4999993993e-1f;
  p = p * y + 3.3333331174e-1f;
  return e + 1.44269504f * (y - 0.5f * z + y * z * p);
}

/* The largest; NaN if one of them is no BRDF. */
INLINE float largest_of(const float *values, size_t count) {
  float lanes[16] = {0}, top = 0;
  int bad = 0;
  for (size_t i = 0; i + 16 <= count; i += 16)
    for (int k = 0; k < 16; k++) {
      float v = values[i + (size_t)k];
      bad |= !(v >= 0) | !(v <= MOST_BRDF);
      lanes[k] = v > lanes[k] ? v : lanes[k];
    }
  for (size_t i = count - count % 16; i < count; i++) {
    bad |= !(values[i] >= 0) | !(values[i] <= MOST_BRDF);
    lanes[0] = fmaxf(lanes[0], values[i]);
  }
  for (int k = 0; k < 16; k++)
    top = fmaxf(top, lanes[k]);
  return bad ? NAN : top;
}

static void put_values(const float *from, size_t stride, size_t count, float *to) {
  for (size_t n = 0; n < count; n++)
    to[n * stride] = from[n];
}

INLINE void put_codes_of(const float *from, size_t stride, size_t count, float least, float low,
                         uint16_t *to) {
  uint16_t codes[CHUNK];
  float scale = LARGEST_CODE / OCTAVES;
  for (size_t n = 0; n < count; n++) {
    float code = (log2_of(from[n] > least ? from[n] : least) - low) * scale;
    code = code > 0 ? code : 0;
    codes[n] = (uint16_t)(int)((code < LARGEST_CODE ? code : LARGEST_CODE) + 0.5f);
  }
  for (size_t n = 0; n < count; n++)
    to[n * stride] = codes[n];
}

#if defined(__x86_64__)
#define WITH_AVX2 __attribute__((target("arch=x86-64-v3")))
WITH_AVX2 static float largest_avx2(const float *values, size_t count) {
  return largest_of(values, count);
}
WITH_AVX2 static void put_codes_avx2(const float *from, size_t stride, size_t count, float least,
                                     float low, uint16_t *to) {
  put_codes_of(from, stride, count, least, low, to);
}
#define HAS_AVX2 __builtin_cpu_supports("avx2")
#else
#define HAS_AVX2 0
#define largest_avx2 largest_of
#define put_codes_avx2 put_codes_of
#endif

static float largest(const float *values, size_t count) {
  return HAS_AVX2 ? largest_avx2(values, count) : largest_of(values, count);
}

static void put_codes(const float *from, size_t stride, size_t count, float least, float low,
                      uint16_t *to) {
  if (HAS_AVX2)
    put_codes_avx2(from, stride, count, least, low, to);
  else
    put_codes_of(from, stride, count, least, low, to);
}

/* rows[channel], `apart` numbers from one to the next. */
static void put_plane(const loading *l, size_t theta_i, const float *rows, size_t apart,
                      float high) {
  hetab_dense_source *d = l->dense;
  float least = fmaxf(ldexpf(high, -(int)OCTAVES), LEAST_BRDF), low = log2f(least);
  if (d->row_low)
    d->row_low[theta_i] = high > LEAST_BRDF ? (double)low : -HUGE_VAL;
  for (size_t n = 0; n < l->plane; n += CHUNK) {
    size_t count = l->plane - n < CHUNK ? l->plane - n : CHUNK;
    for (size_t c = 0; c < d->channels; c++) {
      size_t to = (theta_i * l->plane + n) * d->stride + c;
      if (d->codes)
        put_codes(rows + c * apart + n, d->stride, count, least, low, d->codes + to);
      else
        put_values(rows + c * apart + n, d->stride, count, d->values + to);
    }
  }
}

/* ---- all of them --------------------------------------------------------------------------- */

static hetab_status fail_damaged(const loading *l, size_t theta_i, const float *rows,
                                 size_t apart) {
  size_t i = 0, c = 0;
  while (c + 1 < l->dense->channels && !isnan(largest(rows + c * apart, l->plane)))
    c++;
  while (i + 1 < l->plane && rows[c * apart + i] >= 0 && rows[c * apart + i] <= MOST_BRDF)
    i++;
  return hetab_fail(l->ctx, HETAB_ERR_PARSE,
                    "'%s' is damaged: /brdf holds %g at wavelength %zu, theta_i %zu, entry %zu; "
                    "get a complete copy, or mend it with hetab audit --repair",
                    l->path, (double)rows[c * apart + i], c, theta_i, i);
}

static void load_rows(void *user, size_t piece, int worker) {
  loading *l = user;
  size_t first = piece * l->step, left = l->dense->count[HETAB_THETA_I] - first;
  size_t count = left < l->step ? left : l->step, apart = count * l->plane;
  float *rows = l->rows[worker];
  pthread_mutex_lock(&l->mutex);
  if (l->status == HETAB_OK)
    l->status = hetab_h5_read_rows(l->ctx, l->table, first, count, rows);
  bool sound = l->status == HETAB_OK;
  pthread_mutex_unlock(&l->mutex);
  for (size_t i = 0; i < count && sound; i++) {
    float high = 0;
    for (size_t c = 0; c < l->dense->channels; c++) {
      float top = largest(rows + c * apart + i * l->plane, l->plane);
      high = top > high || isnan(top) ? top : high;
    }
    if ((sound = !isnan(high)))
      put_plane(l, first + i, rows + i * l->plane, apart, high);
    pthread_mutex_lock(&l->mutex);
    if (!sound && l->status == HETAB_OK)
      l->status = fail_damaged(l, first + i, rows + i * l->plane, apart);
    pthread_mutex_unlock(&l->mutex);
  }
}

/* Black rows are as low as the table. */
static void set_range(hetab_dense_source *d) {
  double top = (double)log2f(LEAST_BRDF);
  for (size_t i = 0; i < d->count[HETAB_THETA_I]; i++)
    top = fmax(top, d->row_low[i] + (double)OCTAVES);
  d->high = (float)top;
  d->low = d->high - OCTAVES;
  d->step = OCTAVES / LARGEST_CODE;
  for (size_t i = 0; i < d->count[HETAB_THETA_I]; i++)
    if (d->row_low[i] == -HUGE_VAL)
      d->row_low[i] = (double)d->low;
}

static hetab_status read_all(hetab_context *ctx, loading *l) {
  size_t pieces = (l->dense->count[HETAB_THETA_I] + l->step - 1) / l->step;
  hetab_status status = HETAB_OK;
  for (int w = 0; w < hetab_worker_count() && status == HETAB_OK; w++)
    if (!(l->rows[w] = hetab_alloc(ctx, l->dense->channels * l->step, l->plane * sizeof(float))))
      status = HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = hetab_each(ctx, pieces, load_rows, l);
  for (int w = 0; w < HETAB_MOST_WORKERS; w++)
    free(l->rows[w]);
  return status == HETAB_OK ? l->status : status;
}

/* The model is 0 at exactly 90 degrees, where it is not continuous for practical purposes: a node
 * there is left out, and the others go on to it. */
static size_t inner_count(const hetab_dense_source *d, hetab_axis axis) {
  size_t count = d->count[axis];
  return axis != HETAB_PHI && count > 1 && d->nodes[axis][count - 1] > 0.999999 * M_PI_2 ? count - 1
                                                                                         : count;
}

static hetab_status copy_axes(hetab_context *ctx, const hetab_grid *grid,
                              hetab_dense_source *dense) {
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    size_t count = dense->count[axis] = hetab_grid_count(grid, axis);
    dense->nodes[axis] = hetab_alloc(ctx, count, sizeof *dense->nodes[axis]);
    HETAB_NEED(dense->nodes[axis]);
    memcpy(dense->nodes[axis], hetab_grid_radians(grid, axis), count * sizeof *dense->nodes[axis]);
    HETAB_TRY(hetab_stencil_axis_create(ctx, dense->nodes[axis], inner_count(dense, axis),
                                        &dense->axes[axis]));
  }
  return HETAB_OK;
}

static hetab_status allocate(hetab_context *ctx, const char *path, bool logarithms,
                             hetab_dense_source *dense) {
  size_t nodes = dense->count[0] * dense->count[1] * dense->count[2];
  double size = logarithms ? sizeof *dense->codes : sizeof *dense->values;
  double bytes = (double)nodes * (double)dense->stride * size;
  if (bytes > MOST_BYTES)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "'%s' would take %.3g GiB of memory, over 16; tabulate fewer wavelengths or "
                      "angles",
                      path, bytes / (1 << 30));
  if (logarithms) {
    dense->codes = hetab_alloc(ctx, nodes, dense->stride * sizeof *dense->codes);
    dense->row_low = hetab_alloc(ctx, dense->count[HETAB_THETA_I], sizeof *dense->row_low);
    return dense->codes && dense->row_low ? HETAB_OK : HETAB_ERR_MEMORY;
  }
  dense->values = hetab_alloc(ctx, nodes, dense->stride * sizeof *dense->values);
  return dense->values ? HETAB_OK : HETAB_ERR_MEMORY;
}

hetab_status hetab_dense_source_load(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                     bool logarithms, hetab_dense_source *dense) {
  loading l = {.ctx = ctx, .table = table, .path = path, .dense = dense};
  size_t channels = hetab_h5_wavelength_count(table);
  *dense = (hetab_dense_source){.channels = channels,
                                .stride = logarithms ? (channels + 7) / 8 * 8 : channels};
  HETAB_TRY(copy_axes(ctx, hetab_h5_grid(table), dense));
  HETAB_TRY(allocate(ctx, path, logarithms, dense));
  l.plane = dense->count[HETAB_THETA_R] * dense->count[HETAB_PHI];
  l.step = hetab_h5_row_step(table);
  pthread_mutex_init(&l.mutex, NULL);
  hetab_status status = read_all(ctx, &l);
  pthread_mutex_destroy(&l.mutex);
  if (status == HETAB_OK && logarithms)
    set_range(dense);
  return status;
}

void hetab_dense_source_clear(hetab_dense_source *dense) {
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    free(dense->nodes[axis]);
    hetab_stencil_axis_clear(&dense->axes[axis]);
  }
  free(dense->values);
  free(dense->codes);
  free(dense->row_low);
  *dense = (hetab_dense_source){0};
}
