#include "lookup/dense_source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- nearest ------------------------------------------------------------------------------- */

static size_t nearest(const double *nodes, size_t count, double x) {
  size_t low = 0, high = count - 1;
  while (low < high) {
    size_t middle = (low + high) / 2;
    if (x < 0.5 * (nodes[middle] + nodes[middle + 1]))
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

static double polar(const float w[3]) {
  return atan2(hypot((double)w[0], (double)w[1]), (double)w[2]);
}

/* Between two directions' azimuths, in [0, pi]. */
static double azimuth(const float a[3], const float b[3]) {
  double cross = (double)a[0] * (double)b[1] - (double)a[1] * (double)b[0];
  return atan2(fabs(cross), (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1]);
}

static size_t node_of(const hetab_dense_source *d, size_t i, size_t r, size_t p) {
  return (i * d->count[HETAB_THETA_R] + r) * d->count[HETAB_PHI] + p;
}

const float *hetab_dense_source_nearest(const hetab_dense_source *d, const float wi[3],
                                        const float wo[3]) {
  size_t i = nearest(d->nodes[HETAB_THETA_I], d->count[HETAB_THETA_I], polar(wi));
  size_t r = nearest(d->nodes[HETAB_THETA_R], d->count[HETAB_THETA_R], polar(wo));
  size_t p = nearest(d->nodes[HETAB_PHI], d->count[HETAB_PHI], azimuth(wi, wo));
  return d->values + node_of(d, i, r, p) * d->stride;
}

/* ---- between nodes ------------------------------------------------------------------------- */

enum { MOST_ROWS = HETAB_STENCIL * HETAB_STENCIL * HETAB_STENCIL, WIDE = 8, BLOCK = 8 * WIDE };

/* The nodes that one order of the two directions is the weighted sum of. */
typedef struct sum {
  int count;
  const uint16_t *row[MOST_ROWS];
  float weight[MOST_ROWS];
  double low;
} sum;

typedef struct direction {
  double theta, sin, cos;
  double sin_phi, cos_phi; /* against the incident direction's azimuth */
} direction;

/* Within 2e-7, for y >= 0. */
static inline double angle_of(double y, double x) {
  const double quarter_tangent = 0.41421356237309503;
  double ax = fabs(x), most = fmax(ax, y), base = 0.0;
  double a = most > 0.0 ? fmin(ax, y) / most : 0.0;
  if (a > quarter_tangent) {
    a = (a - 1.0) / (a + 1.0);
    base = M_PI_4;
  }
  double z = a * a;
  double p = (8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1;
  double angle = base + a + a * z * (p * z - 3.33329491539e-1);
  angle = y > ax ? M_PI_2 - angle : angle;
  return x < 0.0 ? M_PI - angle : angle;
}

/* The place in the plane of node i as the mirror direction is turned with the incident one, by the
 * tilt to that node. */
static void add_plane(const hetab_dense_source *d, size_t i, double weight, const direction *r,
                      double tilt_sin, double tilt_cos, sum *s) {
  double x = r->sin * r->cos_phi, y = r->sin * r->sin_phi;
  double tx = x * tilt_cos - r->cos * tilt_sin, tz = x * tilt_sin + r->cos * tilt_cos;
  hetab_stencil theta =
      hetab_stencil_at(&d->axes[HETAB_THETA_R], angle_of(sqrt(tx * tx + y * y), tz));
  hetab_stencil phi = hetab_stencil_at(&d->axes[HETAB_PHI], angle_of(y, tx));
  for (int a = 0; a < theta.count; a++)
    for (int b = 0; b < phi.count; b++) {
      size_t node = node_of(d, i, theta.first + (size_t)a, phi.first + (size_t)b);
      const uint16_t *row = s->row[s->count] = d->codes + node * d->stride;
      __builtin_prefetch(row); /* rows lie far apart: they come while others are found */
      __builtin_prefetch(row + d->stride - 1);
      s->weight[s->count++] = (float)(weight * theta.weight[a] * phi.weight[b]);
    }
  s->low += weight * d->row_low[i];
}

/* How far an incidence may turn the other direction: not over the horizon. */
static double turning(const hetab_dense_source *d, const hetab_stencil *s, double theta_i,
                      double theta_r) {
  double most = 0;
  for (int a = 0; a < s->count; a++)
    most = fmax(most, fabs(d->nodes[HETAB_THETA_I][s->first + (size_t)a] - theta_i));
  double room = 0.5 * (M_PI_2 - theta_r);
  return most > room ? room / most : 1;
}

/* Cubic along theta_i in the frame of the mirror direction, so that a lobe is compared with itself
 * at its neighbours' place; cubic along theta_r and phi. */
static void add_order(const hetab_dense_source *d, double theta_i, const direction *r, sum *s) {
  hetab_stencil at = hetab_stencil_at(&d->axes[HETAB_THETA_I], theta_i);
  double share = turning(d, &at, theta_i, r->theta);
  for (int a = 0; a < at.count; a++) {
    double tilt = share * (d->nodes[HETAB_THETA_I][at.first + (size_t)a] - theta_i);
    add_plane(d, at.first + (size_t)a, at.weight[a], r, sin(tilt), cos(tilt), s);
  }
}

typedef uint16_t codes8 __attribute__((vector_size(16)));
typedef int32_t ints8 __attribute__((vector_size(32)));
typedef float floats8 __attribute__((vector_size(32)));

#define INLINE static inline __attribute__((always_inline))

/* out[count] += the weighted codes of the channels from `from` on. */
INLINE void add_codes(const sum *s, size_t from, size_t count, float *out) {
  for (size_t first = 0; first < count; first += WIDE) {
    floats8 sum;
    memcpy(&sum, out + first, sizeof sum);
    for (int n = 0; n < s->count; n++) {
      codes8 codes;
      memcpy(&codes, s->row[n] + from + first, sizeof codes);
      sum += s->weight[n] * __builtin_convertvector(__builtin_convertvector(codes, ints8), floats8);
    }
    memcpy(out + first, &sum, sizeof sum);
  }
}

#if defined(__x86_64__)
__attribute__((target("arch=x86-64-v3"))) static void add_codes_avx2(const sum *s, size_t from,
                                                                     size_t count, float *out) {
  add_codes(s, from, count, out);
}
#endif

static void add_sum(const sum *s, size_t from, size_t count, float *out) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    add_codes_avx2(s, from, count, out);
    return;
  }
#endif
  add_codes(s, from, count, out);
}

/* Of |wi + wo|^2 = 4 c^2, without cancellation at pi. */
static void set_azimuth(const hetab_lattice_place *p, direction *a, direction *b) {
  double product = a->sin * b->sin, lateral2 = 4 * p->cos_d * p->cos_d * p->sin2_h;
  double difference = (p->mu_high - p->mu_low) * (p->mu_high + p->mu_low) / (a->sin + b->sin);
  double half = product > 0 ? (lateral2 - difference * difference) / (4 * product) : 0;
  half = fmin(fmax(half, 0), 1); /* cos^2(phi / 2) */
  a->cos_phi = b->cos_phi = 2 * half - 1;
  a->sin_phi = b->sin_phi = 2 * sqrt(half * (1 - half));
}

static direction direction_of(double mu) {
  double sine = sqrt((1 - mu) * (1 + mu));
  return (direction){.theta = angle_of(sine, mu), .sin = sine, .cos = mu};
}

void hetab_dense_source_at(const void *user, const hetab_lattice_place *place, float *log2_values) {
  const hetab_dense_source *d = user;
  direction low = direction_of(place->mu_low), high = direction_of(place->mu_high);
  sum s = {0}, t = {0};
  set_azimuth(place, &low, &high);
  /* reciprocity: the mean of both orders */
  add_order(d, low.theta, &high, &s);
  add_order(d, high.theta, &low, &t);
  for (size_t from = 0; from < d->stride; from += BLOCK) {
    size_t count = d->stride - from < BLOCK ? d->stride - from : BLOCK;
    float codes[BLOCK] = {0};
    add_sum(&s, from, count, codes);
    add_sum(&t, from, count, codes);
    for (size_t c = from; c < from + count && c < d->channels; c++) {
      float value = 0.5f * ((float)(s.low + t.low) + d->step * codes[c - from]);
      log2_values[c] = value > d->low ? fminf(value, d->high + 1) : HETAB_LATTICE_ZERO;
    }
  }
}
