#include "audit/views.h"

#include <math.h>
#include <stdlib.h>

#include <hetab/evaluate.h>

static const double VIEW_THETA_DEG[HETAB_AUDIT_VIEWS] = {0, 30, 60, 80};

enum { LOBES = HETAB_AUDIT_VIEWS * HETAB_AUDIT_LOBE };

/* A place in the plane of incidence; theta_r < 0 is the side of the light. */
static void lobe_direction(int i, double *theta_r, double *phi) {
  double deg = -90 + 0.5 * i;
  *theta_r = fabs(deg) * M_PI / 180;
  *phi = deg < 0 ? 0 : M_PI;
}

/* The direction of a place on the square, [-1, 1]^2: Shirley and Chiu's concentric map to the disk,
 * whose radius is sqrt(1 - cos theta) so that equal areas are equal solid angles. */
static void map_direction(int row, int column, double *theta_r, double *phi) {
  double x = (2 * column + 1) / (double)HETAB_AUDIT_MAP - 1;
  double y = 1 - (2 * row + 1) / (double)HETAB_AUDIT_MAP;
  double radius, angle;
  if (fabs(x) > fabs(y)) {
    radius = x;
    angle = M_PI_4 * y / x;
  } else {
    radius = y;
    angle = M_PI_2 - (y != 0 ? M_PI_4 * x / y : 0);
  }
  if (radius < 0) {
    radius = -radius;
    angle += M_PI;
  }
  *theta_r = acos(1 - radius * radius);
  /* the mirror side, phi = pi, to the right */
  *phi = fmod(angle + M_PI + 2 * M_PI, 2 * M_PI);
}

static hetab_status make_views(hetab_context *ctx, hetab_audit *audit) {
  audit->views = hetab_alloc(ctx, HETAB_AUDIT_VIEWS, sizeof *audit->views);
  HETAB_NEED(audit->views);
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    audit->views[v].theta_i = hetab_radians(VIEW_THETA_DEG[v]);
    for (int i = 0; i < HETAB_AUDIT_LOBE; i++)
      audit->views[v].model[i] = (double)NAN;
  }
  return HETAB_OK;
}

hetab_status hetab_views_of_table(hetab_context *ctx, hetab_audit *audit,
                                  hetab_audit_view_fn lookup, const void *user) {
  double theta_r, phi;
  HETAB_TRY(make_views(ctx, audit));
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    hetab_audit_view *view = &audit->views[v];
    double theta_i = view->theta_i;
    for (int i = 0; i < HETAB_AUDIT_LOBE; i++) {
      lobe_direction(i, &theta_r, &phi);
      view->lobe[i] = lookup(user, theta_i, theta_r, phi);
    }
    for (int row = 0; row < HETAB_AUDIT_MAP; row++)
      for (int column = 0; column < HETAB_AUDIT_MAP; column++) {
        map_direction(row, column, &theta_r, &phi);
        view->map[row][column] = (float)lookup(user, theta_i, theta_r, phi);
      }
  }
  return HETAB_OK;
}

/* ---- the model ----------------------------------------------------------------------------- */

static hetab_point point_of(double sigma0_um, double tau_um, const hetab_band *band, int view) {
  return (hetab_point){.lambda_um = band->lambda_um,
                       .theta_i = hetab_radians(VIEW_THETA_DEG[view]),
                       .sigma0_um = sigma0_um,
                       .tau_um = tau_um,
                       .n = band->n,
                       .k = band->k,
                       .diffuse_brdf = band->diffuse_brdf};
}

hetab_status hetab_views_of_model(hetab_context *ctx, hetab_engine *engine, double sigma0_um,
                                  double tau_um, const hetab_band *bands, const double *weights,
                                  size_t count, hetab_audit *audit) {
  HETAB_FREED hetab_point *points = hetab_alloc(ctx, LOBES, sizeof *points);
  HETAB_FREED hetab_value *values = hetab_alloc(ctx, LOBES, sizeof *values);
  HETAB_NEED(points && values);
  for (size_t b = 0; b < count; b++) {
    if (weights[b] == 0.0)
      continue;
    for (int i = 0; i < LOBES; i++) {
      points[i] = point_of(sigma0_um, tau_um, &bands[b], i / HETAB_AUDIT_LOBE);
      lobe_direction(i % HETAB_AUDIT_LOBE, &points[i].theta_r, &points[i].phi);
    }
    HETAB_TRY(hetab_evaluate(ctx, engine, points, LOBES, values));
    for (int i = 0; i < LOBES; i++) {
      double *model = &audit->views[i / HETAB_AUDIT_LOBE].model[i % HETAB_AUDIT_LOBE];
      *model = (isnan(*model) ? 0.0 : *model) + weights[b] * values[i].total;
    }
  }
  return HETAB_OK;
}

enum { MAP = HETAB_AUDIT_MAP * HETAB_AUDIT_MAP };

static hetab_status map_of_surface(hetab_context *ctx, hetab_engine *engine,
                                   const hetab_surface *surface, hetab_audit *audit, int view) {
  const hetab_band *band = &hetab_surface_bands(surface)[audit->view_channel];
  HETAB_FREED hetab_point *points = hetab_alloc(ctx, MAP, sizeof *points);
  HETAB_FREED hetab_value *values = hetab_alloc(ctx, MAP, sizeof *values);
  HETAB_NEED(points && values);
  for (int i = 0; i < MAP; i++) {
    points[i] = point_of(audit->sigma0_um, audit->tau_um, band, view);
    map_direction(i / HETAB_AUDIT_MAP, i % HETAB_AUDIT_MAP, &points[i].theta_r, &points[i].phi);
  }
  HETAB_TRY(hetab_evaluate(ctx, engine, points, MAP, values));
  for (int i = 0; i < MAP; i++)
    audit->views[view].map[i / HETAB_AUDIT_MAP][i % HETAB_AUDIT_MAP] = (float)values[i].total;
  return HETAB_OK;
}

hetab_status hetab_views_of_surface(hetab_context *ctx, hetab_engine *engine,
                                    const hetab_surface *surface, hetab_audit *audit) {
  const hetab_band *band = &hetab_surface_bands(surface)[audit->view_channel];
  double weight = 1;
  HETAB_TRY(make_views(ctx, audit));
  HETAB_TRY(
      hetab_views_of_model(ctx, engine, audit->sigma0_um, audit->tau_um, band, &weight, 1, audit));
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    for (int i = 0; i < HETAB_AUDIT_LOBE; i++) {
      audit->views[v].lobe[i] = audit->views[v].model[i];
      audit->views[v].model[i] = (double)NAN;
    }
    HETAB_TRY(map_of_surface(ctx, engine, surface, audit, v));
  }
  return HETAB_OK;
}
