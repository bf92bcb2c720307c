#include "lookup/dense_source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lookup/stencil.h"

static const double most_bytes = 16.0 * (1 << 30);

/* ---- reading ------------------------------------------------------------------------------- */

static hetab_status copy_axes(hetab_context *ctx, const hetab_grid *grid,
                              hetab_dense_source *dense) {
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    size_t count = dense->count[axis] = hetab_grid_count(grid, (hetab_axis)axis);
    dense->nodes[axis] = hetab_alloc(ctx, count, sizeof *dense->nodes[axis]);
    if (!dense->nodes[axis])
      return HETAB_ERR_MEMORY;
    for (size_t i = 0; i < count; i++)
      dense->nodes[axis][i] = hetab_grid_deg(grid, (hetab_axis)axis)[i] * M_PI / 180;
  }
  return HETAB_OK;
}

static size_t node_count(const hetab_dense_source *dense) {
  return dense->count[HETAB_THETA_I] * dense->count[HETAB_THETA_R] * dense->count[HETAB_PHI];
}

static hetab_status read_channels(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                  hetab_dense_source *dense) {
  size_t nodes = node_count(dense);
  double *band = hetab_alloc(ctx, nodes, sizeof *band);
  dense->values = hetab_alloc(ctx, nodes, dense->stride * sizeof *dense->values);
  hetab_status status = band && dense->values ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t w = 0; w < dense->channels && status == HETAB_OK; w++) {
    status = hetab_h5_read(ctx, table, w, band);
    for (size_t n = 0; n < nodes && status == HETAB_OK; n++) {
      dense->values[n * dense->stride + w] = (float)band[n];
      if (!(band[n] >= 0 && band[n] <= 1e30))
        status = hetab_fail(ctx, HETAB_ERR_PARSE,
                            "'%s' is damaged: /brdf holds %g at wavelength %zu, entry %zu; get a "
                            "complete copy, or mend it with hetab audit --repair",
                            path, band[n], w, n);
    }
    if (status == HETAB_OK)
      status = hetab_progress(ctx, (double)(w + 1), (double)dense->channels);
  }
  free(band);
  return status;
}

hetab_status hetab_dense_source_load(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                     hetab_dense_source *dense) {
  size_t channels = hetab_h5_wavelength_count(table);
  *dense = (hetab_dense_source){.channels = channels, .stride = hetab_lattice_stride(channels)};
  HETAB_TRY(copy_axes(ctx, hetab_h5_grid(table), dense));
  double bytes = (double)dense->stride * sizeof(float);
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    bytes *= (double)dense->count[axis];
  if (bytes > most_bytes)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "'%s' would take %.3g GiB of memory, over 16; tabulate fewer wavelengths or "
                      "angles",
                      path, bytes / (1 << 30));
  return read_channels(ctx, table, path, dense);
}

void hetab_dense_source_clear(hetab_dense_source *dense) {
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    free(dense->nodes[axis]);
  free(dense->values);
  *dense = (hetab_dense_source){0};
}

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

static const float *row_of(const hetab_dense_source *d, size_t i, size_t r, size_t p) {
  return d->values + ((i * d->count[HETAB_THETA_R] + r) * d->count[HETAB_PHI] + p) * d->stride;
}

void hetab_dense_source_nearest(const hetab_dense_source *d, const float wi[3], const float wo[3],
                                float *value) {
  size_t i = nearest(d->nodes[HETAB_THETA_I], d->count[HETAB_THETA_I], polar(wi));
  size_t r = nearest(d->nodes[HETAB_THETA_R], d->count[HETAB_THETA_R], polar(wo));
  size_t p = nearest(d->nodes[HETAB_PHI], d->count[HETAB_PHI], azimuth(wi, wo));
  memcpy(value, row_of(d, i, r, p), d->channels * sizeof *value);
}

/* ---- between nodes ------------------------------------------------------------------------- */

void hetab_dense_source_prepare(hetab_dense_source *d) {
  size_t count = node_count(d) * d->stride;
  d->high = HETAB_LATTICE_ZERO;
  for (size_t n = 0; n < count; n++) {
    d->values[n] = hetab_log2_or_zero((double)d->values[n]);
    d->high = fmaxf(d->high, d->values[n]);
  }
  /* a cubic through what is next to nothing needs a number that is not much less */
  d->low = d->high - 50;
  for (size_t n = 0; n < count; n++)
    d->values[n] = fmaxf(d->values[n], d->low);
}

/* The model is 0 at exactly 90 degrees, where it is not continuous for practical purposes: a node
 * there is left out, and the others go on to it. */
static size_t inner_count(const hetab_dense_source *d, hetab_axis axis) {
  size_t count = d->count[axis];
  return count > 1 && d->nodes[axis][count - 1] > 0.999999 * M_PI_2 ? count - 1 : count;
}

typedef struct direction {
  double theta, phi; /* phi against the incident direction's azimuth */
} direction;

static void add_plane(const hetab_dense_source *d, size_t i, double weight, direction r,
                      float *sum) {
  hetab_stencil theta =
      hetab_stencil_at(d->nodes[HETAB_THETA_R], inner_count(d, HETAB_THETA_R), r.theta);
  hetab_stencil phi = hetab_stencil_at(d->nodes[HETAB_PHI], d->count[HETAB_PHI], r.phi);
  for (int a = 0; a < theta.count; a++)
    for (int b = 0; b < phi.count; b++) {
      const float *row = row_of(d, i, theta.first + (size_t)a, phi.first + (size_t)b);
      float w = (float)(weight * theta.weight[a] * phi.weight[b]);
      for (size_t c = 0; c < d->stride; c++)
        sum[c] += w * row[c];
    }
}

/* The direction turned with the mirror direction as the incident one is tilted by `tilt`. */
static direction turned(direction r, double tilt) {
  double x = sin(r.theta) * cos(r.phi), y = sin(r.theta) * sin(r.phi), z = cos(r.theta);
  double tx = x * cos(tilt) - z * sin(tilt), tz = x * sin(tilt) + z * cos(tilt);
  double lateral = hypot(tx, y);
  return (direction){atan2(lateral, tz), lateral > 0 ? atan2(y, tx) : 0};
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
static void add_order(const hetab_dense_source *d, double theta_i, direction r, float *sum) {
  hetab_stencil s =
      hetab_stencil_at(d->nodes[HETAB_THETA_I], inner_count(d, HETAB_THETA_I), theta_i);
  double share = turning(d, &s, theta_i, r.theta);
  for (int a = 0; a < s.count; a++) {
    double tilt = share * (d->nodes[HETAB_THETA_I][s.first + (size_t)a] - theta_i);
    add_plane(d, s.first + (size_t)a, s.weight[a], turned(r, tilt), sum);
  }
}

/* phi in [0, pi] of |wi + wo|^2 = 4 c^2, without cancellation at pi. */
static double azimuth_of(const hetab_lattice_place *p, double sin_a, double sin_b) {
  double product = sin_a * sin_b, lateral2 = 4 * p->cos_d * p->cos_d * p->sin2_h;
  double difference = (p->mu_high - p->mu_low) * (p->mu_high + p->mu_low) / (sin_a + sin_b);
  if (!(product > 0))
    return M_PI;
  double half = (lateral2 - difference * difference) / (4 * product); /* cos^2(phi / 2) */
  return 2 * acos(sqrt(fmin(fmax(half, 0), 1)));
}

void hetab_dense_source_at(const void *user, const hetab_lattice_place *place, float *log2_values) {
  const hetab_dense_source *d = user;
  double low = acos(place->mu_low), high = acos(place->mu_high);
  double phi = azimuth_of(place, sin(low), sin(high));
  memset(log2_values, 0, d->stride * sizeof *log2_values);
  /* reciprocity: the mean of both orders */
  add_order(d, low, (direction){high, phi}, log2_values);
  add_order(d, high, (direction){low, phi}, log2_values);
  for (size_t c = 0; c < d->channels; c++) {
    float value = 0.5f * log2_values[c];
    log2_values[c] = value > d->low ? fminf(value, d->high + 1) : HETAB_LATTICE_ZERO;
  }
}
