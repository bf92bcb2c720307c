/* The direct problem: the BRDF that a surface's roughness predicts, with the bounds that its
 * measured non-uniformity allows, and measurements judged against them.
 *
 * The bounds are the envelope of the model over the whole interval (of sigma0, tau, or the
 * rectangle of both), not its values at the ends: where a lobe narrows and rises with falling
 * sigma0, the largest value at many directions is met inside. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/evaluate.h>
#include <hetab/measurements.h>
#include <hetab/surface.h>

HETAB_BEGIN

/* low = high = 0: no interval, the point's or the surface's own value alone. */
typedef struct hetab_interval {
  double low, high;
} hetab_interval;

typedef struct hetab_roughness_bounds {
  hetab_interval sigma0_um, tau_um; /* 0 < low <= high */
} hetab_roughness_bounds;

typedef struct hetab_bounds {
  double nominal, low, high; /* low <= nominal <= high */
  double error; /* by how much the true envelope may lie outside low and high, at most */
} hetab_bounds;

typedef enum hetab_bounded {
  HETAB_BOUNDED_TOTAL,   /* dd + ud, 1/sr */
  HETAB_BOUNDED_SPECULAR /* rho_s(theta_i) */
} hetab_bounded;

/* out[count]: the envelope at points[count]; nominal is the value at the point's own sigma0 and
 * tau, and belongs to the envelope.
 *
 * Method: samples a tenth apart in ln sigma0 and ln tau (17 at least, 65 at most, on each side),
 * then a search about the lowest and the highest one that halves its step seven times.
 * Error: what is missed of the true envelope is below 1e-6 of the value in every case of
 * tests/test_predict.c (intervals up to +-60 %, 0.05 to 2 um, rectangles; against 4001 samples, 65
 * x 65 for rectangles, of the literal equations), and never more than `error` says; in float add
 * the 1e-5 of hetab_evaluate(). HETAB_ERR_ARGUMENT: intervals that are none, points as
 * hetab_evaluate() says. */
hetab_status hetab_envelope(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, const hetab_roughness_bounds *bounds,
                            hetab_bounded quantity, hetab_bounds *out);

typedef struct hetab_predict_options {
  size_t size;                   /* of the struct; 0: of this header's */
  hetab_roughness_bounds bounds; /* the surface's own values have to lie within */
  const double *theta_i;         /* [theta_i_count], 0 <= theta_i < pi/2 */
  size_t theta_i_count;
  const double *lambda_um; /* [lambda_count]; NULL: those of the surface */
  size_t lambda_count;
  double step; /* of theta_r; 0: half a degree */

  /* NULL: none. Used: those within 0.1 degrees of a theta_i and 0.1 nm of a wavelength. */
  const hetab_measurements *measurements;
  double accuracy;       /* relative, of the measured values: widens the bounds, 0 to 1 */
  double exclude_mirror; /* leave out views this near the mirror direction */
} hetab_predict_options;

typedef struct hetab_prediction_curve {
  double lambda_um, theta_i;
  const hetab_bounds *f; /* [theta_r_count], 1/sr */
  hetab_bounds specular; /* rho_s */
  double peak;           /* theta_r of the nominal curve's maximum */
} hetab_prediction_curve;

typedef struct hetab_predicted_point {
  size_t curve; /* of the same incidence and wavelength */
  hetab_directions directions;
  int in_plane;         /* phi within 0.5 degrees of 0 or 180 */
  double plane_theta_r; /* signed as in theta_r; in the plane only */
  double measured;      /* 1/sr */
  hetab_bounds f;       /* without the accuracy */
  int side; /* -1: below the bounds by more than 1e-9 / sr, 0: within, 1: above by more */
} hetab_predicted_point;

/* How the measured points lie. */
typedef struct hetab_prediction_count {
  size_t points, below, within, above;
  double bias; /* sum of the measured over sum of the predicted values, less 1 */
} hetab_prediction_count;

typedef struct hetab_prediction {
  hetab_roughness_bounds bounds; /* in force: low = high where there is no interval */
  double *theta_r; /* [theta_r_count], in the plane: > 0 is the mirror side (phi 180), < 0 the
                    * light's (phi 0) */
  size_t theta_r_count;
  hetab_prediction_curve *curves; /* [wavelength][theta_i] */
  size_t curve_count;
  double error; /* the largest error / high of the curves, where high >= 1e-9 / sr */

  hetab_predicted_point *points;
  size_t point_count;
  hetab_prediction_count plane, hemisphere; /* hemisphere: all points, those in the plane too */
  hetab_bounds *values;                     /* what curves point into */
} hetab_prediction;

/* HETAB_ERR_RANGE: no measurement at any of the incidences and wavelengths, or wavelengths outside
 * the index data. */
hetab_status hetab_predict(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                           const hetab_predict_options *options, hetab_prediction **out);
void hetab_prediction_free(hetab_prediction *prediction); /* NULL is fine */

HETAB_END
