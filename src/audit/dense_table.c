#include "audit/dense_table.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "model/model.h"

/* ---- weights ------------------------------------------------------------------------------- */

/* A measure's integral over [0, x], and that of x times it. */
typedef struct measure {
  double (*mass)(double x);
  double (*moment)(double x);
  double end;
} measure;

/* sin cos dtheta: projected solid angle over azimuth. */
static double polar_mass(double x) {
  return 0.5 * sin(x) * sin(x);
}
static double polar_moment(double x) {
  return (0.5 * sin(2 * x) - x * cos(2 * x)) / 4;
}

/* Both sides of the plane of incidence. */
static double azimuth_mass(double x) {
  return 2 * x;
}
static double azimuth_moment(double x) {
  return x * x;
}

static const measure measures[HETAB_AXIS_COUNT] = {
    [HETAB_THETA_R] = {polar_mass, polar_moment, M_PI_2},
    [HETAB_PHI] = {azimuth_mass, azimuth_moment, M_PI},
};

/* What every entry of an axis counts for in an integral over what is looked up between them. */
static void fill_weights(const hetab_dense_table *t, hetab_axis axis) {
  const measure *m = &measures[axis];
  const double *deg = hetab_grid_deg(t->grid, axis);
  double *w = t->weights[axis];
  size_t last = t->count[axis] - 1;
  w[0] += m->mass(hetab_radians(deg[0])) - m->mass(0);
  for (size_t i = 0; i < last; i++) {
    double a = hetab_radians(deg[i]), b = hetab_radians(deg[i + 1]);
    double mass = m->mass(b) - m->mass(a), moment = m->moment(b) - m->moment(a);
    double right = t->lookup == HETAB_READ_TRUNCATE ? 0 : (moment - a * mass) / (b - a);
    w[i] += mass - right;
    w[i + 1] += right;
  }
  w[last] += m->mass(m->end) - m->mass(hetab_radians(deg[last]));
}

hetab_status hetab_dense_table_create(hetab_context *ctx, const hetab_grid *grid,
                                      hetab_reading lookup, hetab_dense_table *table) {
  *table = (hetab_dense_table){.grid = grid, .lookup = lookup};
  size_t total = 1;
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    table->count[axis] = hetab_grid_count(grid, axis);
    if (total > (size_t)PTRDIFF_MAX / sizeof(double) / table->count[axis])
      return hetab_fail(ctx, HETAB_ERR_MEMORY, "the table is too large for this computer");
    total *= table->count[axis];
  }
  table->values = hetab_alloc(ctx, total, sizeof *table->values);
  HETAB_NEED(table->values);
  for (hetab_axis axis = HETAB_THETA_R; axis < HETAB_AXIS_COUNT; axis++) {
    table->weights[axis] = hetab_alloc(ctx, table->count[axis], sizeof *table->weights[axis]);
    HETAB_NEED(table->weights[axis]);
    fill_weights(table, axis);
  }
  return HETAB_OK;
}

void hetab_dense_table_clear(hetab_dense_table *table) {
  for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    free(table->weights[axis]);
  free(table->values);
  *table = (hetab_dense_table){0};
}

double hetab_dense_table_energy(const hetab_dense_table *t, size_t theta_i) {
  double sum = 0;
  for (size_t r = 0; r < t->count[HETAB_THETA_R]; r++) {
    const double *row = hetab_dense_table_at(t, theta_i, r, 0);
    double over_phi = 0;
    for (size_t p = 0; p < t->count[HETAB_PHI]; p++)
      over_phi += isfinite(row[p]) ? t->weights[HETAB_PHI][p] * row[p] : 0;
    sum += t->weights[HETAB_THETA_R][r] * over_phi;
  }
  return sum;
}

/* ---- lookup -------------------------------------------------------------------------------- */

/* Between entries `low` and low + 1, at `fraction`; 0 at the ends and for a truncating reader. */
typedef struct position {
  size_t low;
  double fraction;
} position;

static position find(const hetab_dense_table *t, hetab_axis axis, double deg) {
  const double *x = hetab_grid_deg(t->grid, axis);
  size_t low = 0, high = t->count[axis] - 1;
  if (!(deg > x[0]))
    return (position){0, 0};
  if (deg >= x[high])
    return (position){high, 0};
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (x[middle] <= deg)
      low = middle;
    else
      high = middle;
  }
  double fraction = (deg - x[low]) / (x[low + 1] - x[low]);
  return (position){low, t->lookup == HETAB_READ_TRUNCATE ? 0 : fraction};
}

double hetab_dense_table_read(const hetab_dense_table *t, double theta_i, double theta_r,
                              double phi) {
  double folded = fabs(remainder(phi, 2 * M_PI)), sum = 0;
  const double deg[HETAB_AXIS_COUNT] = {theta_i * 180 / M_PI, theta_r * 180 / M_PI,
                                        folded * 180 / M_PI};
  position at[HETAB_AXIS_COUNT];
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    at[axis] = find(t, axis, deg[axis]);
  for (int corner = 0; corner < 8; corner++) {
    size_t index[HETAB_AXIS_COUNT];
    double weight = 1;
    for (int axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
      int up = corner >> axis & 1;
      index[axis] = at[axis].low + (size_t)up;
      weight *= up ? at[axis].fraction : 1 - at[axis].fraction;
    }
    if (weight == 0) /* also keeps what lies beyond the last entry out of reach */
      continue;
    double value = *hetab_dense_table_at(t, index[0], index[1], index[2]);
    sum += isfinite(value) ? weight * value : 0;
  }
  return sum;
}

int hetab_dense_table_same_axes(const hetab_dense_table *t) {
  size_t count = t->count[HETAB_THETA_I];
  return count == t->count[HETAB_THETA_R] &&
         memcmp(hetab_grid_deg(t->grid, HETAB_THETA_I), hetab_grid_deg(t->grid, HETAB_THETA_R),
                count * sizeof(double)) == 0;
}
