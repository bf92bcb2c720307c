#include "model/fold.h"

#include <math.h>
#include <stdlib.h>

enum { NODES = 721 /* of s, every eighth of a degree */, RINGS = 24, SPOKES = 48, TURNS = 40 };

struct hetab_fold {
  size_t bands;
  double sin2_cone;
  double *s; /* [NODES][bands] */
};

/* ---- between nodes ------------------------------------------------------------------------- */

typedef struct place {
  size_t node;
  double part; /* towards the next */
} place;

static place place_of(double theta) {
  double at = theta / M_PI_2 * (NODES - 1);
  size_t node = at < NODES - 2 ? (size_t)at : NODES - 2;
  return (place){node, fmin(at - (double)node, 1.0)};
}

static double profile(const hetab_fold *fold, double sin2_h) {
  double rest = 1.0 - sin2_h / fold->sin2_cone;
  if (!(rest > 0.0))
    return 0.0;
  return rest * rest;
}

double hetab_sin2_h(const hetab_pair *pair, double one_plus_cos) {
  double lateral2 = pair->d2 + pair->p * one_plus_cos;
  return lateral2 > 0.0 ? lateral2 / (pair->mu2 + lateral2) : 0.0;
}

double hetab_fold_of_band(const hetab_fold *fold, size_t band, double theta_i, double theta_r,
                          double sin2_h) {
  place i = place_of(theta_i), r = place_of(theta_r);
  const double *s = fold->s + band;
  size_t bands = fold->bands;
  double at_i = s[i.node * bands] + i.part * (s[(i.node + 1) * bands] - s[i.node * bands]);
  double at_r = s[r.node * bands] + r.part * (s[(r.node + 1) * bands] - s[r.node * bands]);
  return profile(fold, sin2_h) * (at_i * at_r);
}

void hetab_fold_add(const hetab_fold *fold, double theta_i, double theta_r, double sin2_h,
                    double *values) {
  if (!(profile(fold, sin2_h) > 0.0))
    return;
  for (size_t b = 0; b < fold->bands; b++)
    values[b] += hetab_fold_of_band(fold, b, theta_i, theta_r, sin2_h);
}

/* ---- construction -------------------------------------------------------------------------- */

/* row[NODES]: what s at every node adds to the integral of K s cos over the viewers of theta_i. */
static void integral_row(const hetab_fold *fold, double theta_i, double *row) {
  double cap = 1.0 - sqrt(1.0 - fold->sin2_cone), c_i = cos(theta_i), s_i = sin(theta_i);
  for (int ring = 0; ring < RINGS; ring++) {
    double up = 1.0 - cap * (ring + 0.5) / RINGS, side2 = 1.0 - up * up;
    double k = profile(fold, side2) * 2.0 * M_PI * cap / (RINGS * SPOKES);
    for (int spoke = 0; spoke < SPOKES; spoke++) {
      double i_h = c_i * up + s_i * sqrt(side2) * cos(M_PI * (spoke + 0.5) / SPOKES);
      double mu_r = 2.0 * i_h * up - c_i;
      if (!(i_h > 0.0 && mu_r > 0.0))
        continue;
      place r = place_of(acos(fmin(mu_r, 1.0)));
      double weight = k * 4.0 * i_h * mu_r; /* dr = 4 (i.h) dh */
      row[r.node] += (1.0 - r.part) * weight;
      row[r.node + 1] += r.part * weight;
    }
  }
}

/* s of one band: a fixed point of s <- sqrt(s rho / (M s)). M has nothing farther than `reach` from
 * its diagonal. */
static void solve(const double (*matrix)[NODES], int reach, const double *rho, double *s,
                  double *next) {
  for (int i = 0; i < NODES; i++)
    s[i] = sqrt(rho[i]);
  for (int turn = 0; turn < TURNS; turn++) {
    for (int i = 0; i < NODES; i++) {
      double sum = 0.0;
      int last = i + reach < NODES - 1 ? i + reach : NODES - 1;
      for (int j = i > reach ? i - reach : 0; j <= last; j++)
        sum += matrix[i][j] * s[j];
      next[i] = sum > 0.0 ? sqrt(s[i] * rho[i] / sum) : 0.0;
    }
    for (int i = 0; i < NODES; i++)
      s[i] = next[i];
  }
}

static hetab_status fill(hetab_context *ctx, const hetab_surface *surface, const hetab_band *bands,
                         hetab_fold *fold) {
  double(*matrix)[NODES] = hetab_alloc(ctx, NODES, sizeof *matrix), rho[NODES], s[NODES];
  double sigma0 = hetab_surface_sigma0_um(surface), next[NODES];
  double tau = hetab_surface_tau_um(surface);
  fold->s = hetab_alloc(ctx, NODES * fold->bands, sizeof *fold->s);
  if (!matrix || !fold->s) {
    free(matrix);
    return HETAB_ERR_MEMORY;
  }
  int reach = (int)(2.0 * asin(sqrt(fold->sin2_cone)) / M_PI_2 * (NODES - 1)) + 2;
  for (int i = 0; i < NODES; i++)
    integral_row(fold, M_PI_2 * i / (NODES - 1), matrix[i]);
  for (size_t b = 0; b < fold->bands; b++) {
    hetab_wave wave = hetab_wave_of(sigma0, tau, &bands[b]);
    for (int i = 0; i < NODES; i++) {
      hetab_direction d = hetab_direction_at(M_PI_2 * i / (NODES - 1), tau / (2.0 * sigma0));
      rho[i] = hetab_specular(&d, &wave);
    }
    solve((const double(*)[NODES])matrix, reach, rho, s, next);
    for (size_t i = 0; i < NODES; i++)
      fold->s[i * fold->bands + b] = s[i];
  }
  free(matrix);
  return HETAB_OK;
}

hetab_status hetab_fold_check(hetab_context *ctx, double cone, double least, const char *table) {
  if (!(cone > 0.0) || cone >= least * (1.0 - 1e-9))
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "a specular cone of %g degrees is below two spacings of %s: take %.2g or more",
                    hetab_degrees(cone), table, hetab_degrees(least));
}

hetab_status hetab_fold_create(hetab_context *ctx, const hetab_surface *surface,
                               const hetab_band *bands, size_t count, double cone,
                               hetab_fold **out) {
  hetab_fold *fold = *out = hetab_alloc(ctx, 1, sizeof *fold);
  HETAB_NEED(fold);
  *fold = (hetab_fold){.bands = count, .sin2_cone = sin(cone) * sin(cone)};
  HETAB_MADE(hetab_fold, out, fill(ctx, surface, bands, fold));
}

void hetab_fold_free(hetab_fold *fold) {
  if (!fold)
    return;
  free(fold->s);
  free(fold);
}
