#include "convert/slab_fold.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/host_model.h>

#include "model/fold.h"

struct hetab_slab_fold {
  const hetab_grid *grid;
  double cone, tau_2sigma;
  hetab_precision precision;
  hetab_fold *fold;
  double *rho;                      /* [band][theta_i] */
  double *weight[HETAB_AXIS_COUNT]; /* of theta_r (times cos sin) and phi: of the hemisphere */
  void *values;
  size_t room; /* of values, in bytes */
};

/* ---- nodes within the lobe ------------------------------------------------------------------ */

static double projected(double theta) {
  return sin(theta) * cos(theta);
}

static double both_sides(double phi) {
  return 2.0;
}

/* What each node's hat function, held beyond the ends, adds to the integral from 0 to `end`. */
static void hat_weights(const double *node, size_t count, double end, double (*density)(double),
                        double *weight) {
  enum { STEPS = 16 };
  for (size_t i = 0; i <= count; i++) {
    double low = i > 0 ? node[i - 1] : 0.0, high = i < count ? node[i] : end;
    for (int s = 0; s < STEPS; s++) {
      double part = (s + 0.5) / STEPS, step = (high - low) / STEPS;
      double value = density(low + part * (high - low)) * step;
      if (i > 0)
        weight[i - 1] += (i < count ? 1.0 - part : 1.0) * value;
      if (i < count)
        weight[i] += (i > 0 ? part : 1.0) * value;
    }
  }
}

/* The nodes of one theta_i that are in the lobe. */
typedef struct walk {
  const hetab_slab_fold *f;
  hetab_direction in;
  size_t band, r, p;
  double value; /* of the lobe there, before scaling */
} walk;

static walk walk_of(const hetab_slab_fold *f, size_t band, size_t theta_i) {
  double theta = hetab_grid_radians(f->grid, HETAB_THETA_I)[theta_i];
  return (walk){
      .f = f, .in = hetab_direction_at(theta, f->tau_2sigma), .band = band, .p = (size_t)-1};
}

/* To the next one; false after the last. */
static bool walk_on(walk *w) {
  const hetab_grid *grid = w->f->grid;
  const double *theta_r = hetab_grid_radians(grid, HETAB_THETA_R);
  const double *phi = hetab_grid_radians(grid, HETAB_PHI);
  for (w->p++; w->r < hetab_grid_count(grid, HETAB_THETA_R); w->r++, w->p = 0) {
    if (fabs(theta_r[w->r] - w->in.theta) > 2.0 * w->f->cone)
      continue;
    hetab_direction to = hetab_direction_at(theta_r[w->r], w->f->tau_2sigma);
    hetab_pair pair = hetab_pair_of(&w->in, &to);
    for (; w->p < hetab_grid_count(grid, HETAB_PHI); w->p++) {
      double sin2_h = hetab_sin2_h(&pair, hetab_one_plus_cos(phi[w->p]));
      w->value = hetab_fold_of_band(w->f->fold, w->band, w->in.theta, to.theta, sin2_h);
      if (w->value > 0.0)
        return true;
    }
  }
  return false;
}

/* What the lobe is multiplied by; 0 where no node is in it. */
static double scale_of(const hetab_slab_fold *f, size_t band, size_t theta_i) {
  double sum = 0.0;
  size_t incidences = hetab_grid_count(f->grid, HETAB_THETA_I);
  for (walk w = walk_of(f, band, theta_i); walk_on(&w);)
    sum += w.value * f->weight[HETAB_THETA_R][w.r] * f->weight[HETAB_PHI][w.p];
  return sum > 0.0 ? f->rho[band * incidences + theta_i] / sum : 0.0;
}

/* ---- slabs ---------------------------------------------------------------------------------- */

static void add_row(hetab_slab_fold *f, size_t band, size_t theta_i, size_t from) {
  double scale = scale_of(f, band, theta_i);
  size_t columns = hetab_grid_count(f->grid, HETAB_PHI);
  for (walk w = walk_of(f, band, theta_i); scale > 0.0 && walk_on(&w);) {
    size_t at = from + w.r * columns + w.p;
    if (f->precision == HETAB_DOUBLE)
      ((double *)f->values)[at] += scale * w.value;
    else
      ((float *)f->values)[at] += (float)(scale * w.value);
  }
}

hetab_status hetab_slab_fold_in(hetab_context *ctx, hetab_slab_fold *f, const hetab_slab *slab,
                                hetab_slab *out) {
  size_t row = hetab_grid_count(f->grid, HETAB_THETA_R) * hetab_grid_count(f->grid, HETAB_PHI);
  size_t bytes =
      slab->theta_i_count * row * (f->precision == HETAB_DOUBLE ? sizeof(double) : sizeof(float));
  if (bytes > f->room) {
    free(f->values);
    f->values = hetab_alloc(ctx, bytes, 1);
    f->room = f->values ? bytes : 0;
  }
  HETAB_NEED(f->values);
  memcpy(f->values, slab->values, bytes);
  for (size_t i = 0; i < slab->theta_i_count; i++)
    add_row(f, slab->wavelength, slab->theta_i_first + i, i * row);
  *out = *slab;
  out->values = f->values;
  return HETAB_OK;
}

/* ---- creation ------------------------------------------------------------------------------- */

static hetab_status check_grid(hetab_context *ctx, const hetab_grid *grid, double cone) {
  const double *theta_r = hetab_grid_radians(grid, HETAB_THETA_R);
  double widest = 0.0;
  for (size_t i = 1; i < hetab_grid_count(grid, HETAB_THETA_R); i++)
    widest = fmax(widest, theta_r[i] - theta_r[i - 1]);
  return hetab_fold_check(ctx, cone, widest, "the grid's half vectors (half of theta_r's)");
}

static hetab_status check_nodes(hetab_context *ctx, const hetab_slab_fold *f) {
  for (size_t i = 0; i < hetab_grid_count(f->grid, HETAB_THETA_I); i++) {
    double deg = hetab_grid_deg(f->grid, HETAB_THETA_I)[i];
    if (deg < 89.0 && f->rho[i] > 0.0 && !(scale_of(f, 0, i) > 0.0))
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "at theta_i %g degrees no node of the grid is within the specular cone of "
                        "%g degrees: take a wider one, or a phi that ends at 180",
                        deg, hetab_degrees(f->cone));
  }
  return HETAB_OK;
}

static hetab_status fill(hetab_context *ctx, const hetab_surface *surface, hetab_slab_fold *f) {
  size_t bands = hetab_surface_band_count(surface), count[HETAB_AXIS_COUNT];
  for (hetab_axis a = 0; a < HETAB_AXIS_COUNT; a++) {
    count[a] = hetab_grid_count(f->grid, a);
    if (!(f->weight[a] = hetab_alloc(ctx, count[a], sizeof(double))))
      return HETAB_ERR_MEMORY;
  }
  hat_weights(hetab_grid_radians(f->grid, HETAB_THETA_R), count[HETAB_THETA_R], M_PI_2, projected,
              f->weight[HETAB_THETA_R]);
  hat_weights(hetab_grid_radians(f->grid, HETAB_PHI), count[HETAB_PHI], M_PI, both_sides,
              f->weight[HETAB_PHI]);
  f->rho = hetab_alloc(ctx, bands * count[HETAB_THETA_I], sizeof *f->rho);
  HETAB_NEED(f->rho);
  HETAB_TRY(hetab_specular_reflectance(ctx, surface, hetab_grid_radians(f->grid, HETAB_THETA_I),
                                       count[HETAB_THETA_I], f->rho));
  HETAB_TRY(
      hetab_fold_create(ctx, surface, hetab_surface_bands(surface), bands, f->cone, &f->fold));
  return check_nodes(ctx, f);
}

hetab_status hetab_slab_fold_create(hetab_context *ctx, const hetab_surface *surface,
                                    const hetab_grid *grid, double cone, hetab_precision precision,
                                    hetab_slab_fold **out) {
  *out = NULL;
  HETAB_TRY(check_grid(ctx, grid, cone));
  hetab_slab_fold *f = hetab_alloc(ctx, 1, sizeof *f);
  HETAB_NEED(f);
  *f = (hetab_slab_fold){.grid = grid,
                         .cone = cone,
                         .precision = precision,
                         .tau_2sigma = hetab_surface_tau_um(surface) /
                                       (2.0 * hetab_surface_sigma0_um(surface))};
  *out = f;
  HETAB_MADE(hetab_slab_fold, out, fill(ctx, surface, f));
}

void hetab_slab_fold_free(hetab_slab_fold *f) {
  if (!f)
    return;
  for (int a = 0; a < HETAB_AXIS_COUNT; a++)
    free(f->weight[a]);
  hetab_fold_free(f->fold);
  free(f->rho);
  free(f->values);
  free(f);
}
