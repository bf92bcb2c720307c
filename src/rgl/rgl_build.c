/* The choice of a table's shape. */
#include "rgl/rgl_build.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "model/model.h"
#include "rgl/rgl_file.h"
#include "rgl/rgl_table.h"
#include "rgl/rgl_trial.h"

enum { PROBES = HETAB_RGL_PROBES, LAST_PROBE = 42 };
/* Beyond 84 degrees the error may be this much larger. */
static const double grazing_share = 5.0;

/* ---- incidences ---------------------------------------------------------------------------- */

/* sums[2] += |prediction - truth|, |truth| at probe k, the prediction being the mean of its
 * neighbours, as a reader takes it. */
static hetab_status probe_error(hetab_context *ctx, const hetab_rgl_source *source,
                                const hetab_rgl *probe, size_t k, double *slices, double *error) {
  size_t values = source->channels * probe->resolution * probe->resolution;
  double *before = slices + (k - 1) * values, *after = slices + (k + 1) * values, sums[2] = {0};
  hetab_blend blend = {2, {k - 1, k + 1}, {0.5f, 0.5f}};
  double *truth = hetab_alloc(ctx, values, sizeof *truth);
  if (!truth)
    return HETAB_ERR_MEMORY;
  hetab_status status =
      hetab_rgl_spectra_at(ctx, source, probe, &blend, (double)probe->theta_i[k], truth);
  for (size_t i = 0; i < values; i++) {
    sums[0] += fabs(0.5 * (before[i] + after[i]) - truth[i]);
    sums[1] += truth[i];
  }
  *error = sums[1] > 0.0 ? sums[0] / sums[1] : 0.0;
  free(truth);
  return status;
}

/* How dense incidences should stand, density[PROBES]: the number of intervals of an error of 1 per
 * radian. */
static hetab_status probe_density(hetab_context *ctx, const hetab_rgl_source *source,
                                  hetab_rgl_shape shape, const double *lobe, double *density) {
  size_t values = source->channels * shape.resolution * shape.resolution;
  double theta[PROBES], *slices = NULL, step = M_PI_2 / (PROBES - 1);
  hetab_rgl *probe;
  hetab_status status;
  shape.theta_i = PROBES;
  for (size_t k = 0; k < PROBES; k++)
    theta[k] = step * (double)k;
  HETAB_TRY(hetab_rgl_new(ctx, source, &shape, lobe, theta, &probe));
  slices = hetab_alloc(ctx, PROBES * values, sizeof *slices);
  HETAB_GOTO(slices ? HETAB_OK : HETAB_ERR_MEMORY);
  for (size_t k = 0; k < PROBES; k++) {
    hetab_blend own = {1, {k}, {1.0f}};
    double at = k + 1 < PROBES ? theta[k] : theta[k] - 0.25 * step;
    HETAB_GOTO(hetab_rgl_spectra_at(ctx, source, probe, &own, at, slices + k * values));
  }
  for (size_t k = 1; k + 1 < PROBES; k++) {
    double error;
    HETAB_GOTO(probe_error(ctx, source, probe, k, slices, &error));
    density[k] = sqrt(error) / (2 * step);
  }
  density[0] = density[1];
  density[PROBES - 1] = density[PROBES - 2];
  for (size_t k = LAST_PROBE + 1; k < PROBES; k++)
    density[k] /= sqrt(grazing_share);
done:
  free(slices);
  hetab_rgl_free(probe);
  return status;
}

/* theta_i[count] such that each interval holds the same part of the density's integral; evenly
 * where it is 0 throughout. */
static void place_incidences(const double *density, size_t count, double *theta_i) {
  const double least = 1e-9;
  double running[PROBES] = {0}, step = M_PI_2 / (PROBES - 1);
  for (size_t k = 1; k < PROBES; k++)
    running[k] = running[k - 1] + 0.5 * (density[k - 1] + density[k]) + least;
  for (size_t i = 0, k = 1; i < count; i++) {
    double want = running[PROBES - 1] * (double)i / (double)(count - 1);
    while (k + 1 < PROBES && running[k] < want)
      k++;
    theta_i[i] = step * ((double)k - 1 + (want - running[k - 1]) / (running[k] - running[k - 1]));
  }
  theta_i[0] = 0.0;
  theta_i[count - 1] = M_PI_2;
}

/* ---- one shape ----------------------------------------------------------------------------- */

hetab_status hetab_rgl_measure(hetab_context *ctx, const hetab_rgl_source *source,
                               const hetab_rgl *rgl, hetab_rgl_report *report) {
  hetab_rgl_trial trial;
  HETAB_TRY(hetab_rgl_trial_create(ctx, source, rgl, 2, &trial));
  hetab_status status = hetab_rgl_trial_run(ctx, &trial, rgl, report);
  hetab_rgl_trial_clear(&trial);
  return status;
}

/* ---- the candidates ------------------------------------------------------------------------ */

enum {
  MOST_THETA_I = 96,
  MOST_RESOLUTION = 128,
  LEAST_THETA_I = 4,
  LEAST_RESOLUTION = 8,
  LEVELS = 48
};

/* Of what is asked for, so that other random directions find the error below it too. */
static const double margin = 0.9;
/* The bias asked for, of the error: a third, with a tenth to spare once more. */
static const double bias_share = 0.3;
/* From the error expected of one candidate to that of the next. */
static const double coarsest = 0.3, finer = 0.87;

/* How well a search looks: nodes of the tables that `cells` and the softness are found from, nodes
 * of the slices that incidences are placed by, directions at each of its incidences, and the last
 * of these. A search goes on until the error is met; a forecast has to know the worst. */
typedef struct effort {
  size_t cells, slices, directions;
  double last_deg;
} effort;
static const effort forecasting = {24, 12, 250, 80.0};
static const effort searching = {48, 24, HETAB_RGL_DIRECTIONS, 75.0};

/* What one surface's candidates are made of. Incidences alone would leave an error of (intervals /
 * (theta_i - 1))^2, nodes one of (cells / (resolution - 1))^2. */
typedef struct search {
  hetab_context *ctx;
  const hetab_rgl_source *source;
  double target;
  double lobe[HETAB_RGL_MOST_NDF], density[PROBES];
  double intervals, cells, width; /* of the lobe, at half height: of the axis of half vectors */
  hetab_rgl_shape shape;
  effort effort;
  hetab_rgl_trial trial;
  size_t failing; /* an incidence where the last candidate did not serve */
  hetab_rgl *best;
  hetab_rgl_report report;
} search;

static size_t clamp_count(double count, size_t least, size_t most) {
  return count < (double)least ? least : count > (double)most ? most : (size_t)count;
}

/* The shape that errors of `level` are expected of. A quarter of it is left to the incidences,
 * whose errors are biased: their cost is linear, that of nodes quadratic. */
static hetab_rgl_shape shape_for(const search *s, double level) {
  hetab_rgl_shape shape = s->shape;
  shape.theta_i =
      clamp_count(ceil(s->intervals / sqrt(0.5 * level)) + 1.0, LEAST_THETA_I, MOST_THETA_I);
  shape.resolution =
      clamp_count(ceil(s->cells / sqrt(0.5 * level)) + 1.0, LEAST_RESOLUTION, MOST_RESOLUTION);
  return shape;
}

static int is_same(const hetab_rgl_shape *a, const hetab_rgl_shape *b) {
  return a->theta_i == b->theta_i && a->resolution == b->resolution;
}

static int serves(const search *s, const hetab_rgl_report *report) {
  double allowed = margin * s->target;
  return report->error_l1 <= allowed && fabs(report->bias) <= bias_share * allowed &&
         report->error_grazing <= 0.1;
}

/* The report's errors; of a candidate that does not serve and is not the last, those up to the
 * incidence that shows it. It begins where the candidate before failed. */
static hetab_status judge(search *s, int is_last) {
  for (size_t n = 0; n < s->trial.incidences; n++) {
    size_t k = (s->failing + n) % s->trial.incidences;
    HETAB_TRY(hetab_rgl_trial_add(s->ctx, &s->trial, k, s->best, &s->report));
    if (!is_last && !serves(s, &s->report)) {
      s->failing = k;
      return HETAB_OK;
    }
  }
  return HETAB_OK;
}

/* Where the candidate before failed, a few slices tell of most that they fail too. */
static hetab_status try_shape(search *s, const hetab_rgl_shape *shape, int is_last) {
  size_t k = s->failing;
  double theta_i[MOST_THETA_I];
  s->report = (hetab_rgl_report){.target = s->target,
                                 .theta_i_count = shape->theta_i,
                                 .ndf_count = shape->ndf,
                                 .vndf_count = shape->vndf_theta,
                                 .resolution = shape->resolution};
  hetab_rgl_free(s->best);
  place_incidences(s->density, shape->theta_i, theta_i);
  HETAB_TRY(hetab_rgl_new(s->ctx, s->source, shape, s->lobe, theta_i, &s->best));
  if (!is_last) {
    HETAB_TRY(hetab_rgl_fill_about(s->ctx, s->source, s->best, s->trial.theta_i[k]));
    HETAB_TRY(hetab_rgl_trial_add(s->ctx, &s->trial, k, s->best, &s->report));
    if (!serves(s, &s->report))
      return HETAB_OK;
  }
  HETAB_TRY(hetab_rgl_fill(s->ctx, s->source, s->best));
  HETAB_TRY(hetab_rgl_bytes(s->ctx, s->best, &s->report.bytes));
  return judge(s, is_last);
}

/* The first candidate that serves, else the last. Candidates do not depend on the target, and those
 * that are left out untried are fewer for a larger one, so that more error allowed never asks for a
 * larger file. */
static hetab_status find_shape(search *s) {
  const double hopeless = 2.0; /* times the target */
  hetab_rgl_shape next = shape_for(s, coarsest);
  double level = coarsest;
  for (size_t k = 0; k < LEVELS; k++) {
    hetab_rgl_shape shape = next;
    int is_last = k + 1 == LEVELS, is_tried = level <= hopeless * s->target || is_last;
    next = shape_for(s, level *= finer);
    if (!is_last && (!is_tried || is_same(&shape, &next)))
      continue;
    HETAB_TRY(try_shape(s, &shape, is_last));
    HETAB_TRY(hetab_progress(s->ctx, (double)k, LEVELS));
    if (serves(s, &s->report))
      break;
  }
  return HETAB_OK;
}

static bool keeps(const search *s) {
  return s->report.error_l1 <= s->target && fabs(s->report.bias) <= s->target / 3.0 &&
         s->report.error_grazing <= 0.1;
}

/* The shape that is given, 15 % larger k times. */
static hetab_rgl_shape given_shape(const search *s, int k) {
  double larger = pow(1.15, k);
  hetab_rgl_shape shape = s->shape;
  shape.theta_i = clamp_count(larger * (double)shape.theta_i, LEAST_THETA_I, MOST_THETA_I);
  shape.resolution =
      clamp_count(larger * (double)shape.resolution, LEAST_RESOLUTION, MOST_RESOLUTION);
  return shape;
}

/* The shape that is given, or the first of a few larger ones that keeps what is asked for; if none
 * does, the first whose L1 does; if none does, the largest. */
static hetab_status try_given(search *s) {
  enum { TRIES = 4 };
  hetab_rgl_shape shape;
  int keeps_l1 = TRIES;
  for (int k = 0; k < TRIES; k++) {
    shape = given_shape(s, k);
    HETAB_TRY(try_shape(s, &shape, 1));
    if (keeps(s))
      return HETAB_OK;
    if (keeps_l1 == TRIES && s->report.error_l1 <= s->target)
      keeps_l1 = k;
  }
  shape = given_shape(s, keeps_l1);
  return keeps_l1 < TRIES - 1 ? try_shape(s, &shape, 1) : HETAB_OK;
}

/* Nodes for the lobe: at least 4 over its half width. */
static hetab_status choose_nodes(search *s) {
  enum { FINE = 256 };
  size_t half = 1, nodes = 32;
  HETAB_TRY(hetab_rgl_lobe_from_data(s->ctx, s->source, FINE, s->lobe));
  while (half + 1 < FINE && s->lobe[half] > 0.5 * s->lobe[0])
    half++;
  while (nodes < HETAB_RGL_MOST_NODES && nodes * half < 4 * FINE)
    nodes *= 2;
  s->width = (double)half / FINE;
  s->shape = (hetab_rgl_shape){.ndf = 4 * nodes, .vndf_theta = nodes, .vndf_phi = 16};
  return HETAB_OK;
}

/* How many nodes an error of 1 would take with this softness: of a table read at its own
 * incidences. With `trial`, in place of that, the directions that candidates are judged at. */
static hetab_status probe_cells(search *s, double soft, hetab_rgl_trial *trial, double *cells) {
  enum { SLICES = 6 };
  const double theta_deg[SLICES] = {0.0, 20.0, 40.0, 60.0, s->effort.last_deg, 90.0};
  double theta_i[SLICES];
  hetab_rgl_shape shape = s->shape;
  hetab_rgl_report report;
  hetab_rgl_trial own = {0};
  hetab_rgl *probe;
  hetab_status status;
  shape.theta_i = SLICES;
  shape.resolution = s->effort.cells;
  shape.soft = soft;
  for (size_t k = 0; k < SLICES; k++)
    theta_i[k] = hetab_radians(theta_deg[k]);
  HETAB_TRY(hetab_rgl_new(s->ctx, s->source, &shape, s->lobe, theta_i, &probe));
  HETAB_GOTO(hetab_rgl_fill(s->ctx, s->source, probe));
  if (trial)
    HETAB_GOTO(hetab_rgl_trial_create(s->ctx, s->source, probe, 1, trial));
  else
    HETAB_GOTO(hetab_rgl_trial_at(s->ctx, s->source, probe, theta_i, SLICES - 1,
                                  s->effort.directions, &own));
  if (cells) {
    HETAB_GOTO(hetab_rgl_trial_run(s->ctx, &own, probe, &report));
    *cells = (double)(s->effort.cells - 1) * sqrt(report.error_l1);
  }
done:
  hetab_rgl_trial_clear(&own);
  hetab_rgl_free(probe);
  return status;
}

/* The softness that asks for the fewest nodes. */
static hetab_status choose_soft(search *s) {
  static const double tried[] = {0.0, 0.3, 0.6};
  for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
    double cells;
    HETAB_TRY(probe_cells(s, tried[i], NULL, &cells));
    if (i == 0 || cells < s->cells) {
      s->cells = cells;
      s->shape.soft = tried[i];
    }
  }
  return HETAB_OK;
}

static hetab_status prepare(search *s) {
  HETAB_TRY(choose_nodes(s));
  HETAB_TRY(hetab_rgl_lobe_from_data(s->ctx, s->source, s->shape.ndf, s->lobe));
  HETAB_TRY(choose_soft(s));
  hetab_rgl_shape slices = s->shape;
  slices.resolution = s->effort.slices;
  HETAB_TRY(probe_density(s->ctx, s->source, slices, s->lobe, s->density));
  for (size_t k = 1; k < PROBES; k++)
    s->intervals += 0.5 * (s->density[k - 1] + s->density[k]) * M_PI_2 / (PROBES - 1);
  return HETAB_OK;
}

/* ---- forecasts ----------------------------------------------------------------------------- */

/* Wide lobes end at the horizon all round, where errors fall with less than the square of the
 * nodes: more of them are left at usual resolutions. */
static double cells_of(const search *s) {
  return s->cells * (1.0 + 1.5 * fmax(s->width - 0.42, 0.0));
}

hetab_status hetab_rgl_forecast_make(hetab_context *ctx, const hetab_rgl_source *source,
                                     hetab_rgl_forecast *out) {
  search s = {.ctx = ctx, .source = source, .effort = forecasting};
  double most = 1e-9;
  HETAB_TRY(prepare(&s));
  *out = (hetab_rgl_forecast){.intervals = s.intervals, .cells = cells_of(&s), .shape = s.shape};
  for (size_t k = 0; k < PROBES; k++)
    most = fmax(most, s.density[k]);
  for (size_t k = 0; k < PROBES; k++)
    out->density[k] = (unsigned char)lround(255.0 * s.density[k] / most);
  return HETAB_OK;
}

static hetab_status prepare_given(search *s, const hetab_rgl_forecast *f) {
  s->shape = f->shape;
  for (size_t k = 0; k < PROBES; k++)
    s->density[k] = (double)f->density[k];
  return hetab_rgl_lobe_from_data(s->ctx, s->source, s->shape.ndf, s->lobe);
}

/* The worst incidence's error is about this of the part that incidences leave, and this of the part
 * that nodes leave: within a factor of 2 (tests/test_cli_batch.sh). `spare` keeps nearly all
 * below what is asked for. */
static const double of_intervals = 1.1, of_cells = 1.0, spare = 0.72;

/* The bytes, T R^2, are least where nodes are left two thirds of the error. */
hetab_status hetab_rgl_forecast_at(hetab_context *ctx, const hetab_rgl_forecast *f,
                                   const hetab_rgl_source *source, double table_error,
                                   hetab_rgl_report *out) {
  double sum = spare * table_error;
  hetab_rgl_shape shape = f->shape;
  shape.theta_i = clamp_count(ceil(f->intervals * sqrt(3.0 * of_intervals / sum)) + 1.0,
                              LEAST_THETA_I, MOST_THETA_I);
  shape.resolution = clamp_count(ceil(f->cells * sqrt(1.5 * of_cells / sum)) + 1.0,
                                 LEAST_RESOLUTION, MOST_RESOLUTION);
  *out = (hetab_rgl_report){.target = table_error,
                            .theta_i_count = shape.theta_i,
                            .ndf_count = shape.ndf,
                            .vndf_count = shape.vndf_theta,
                            .resolution = shape.resolution};
  out->error_l1 = of_intervals * pow(f->intervals / (double)(shape.theta_i - 1), 2) +
                  of_cells * pow(f->cells / (double)(shape.resolution - 1), 2);
  return hetab_rgl_shape_bytes(ctx, source, &shape, &out->bytes);
}

hetab_status hetab_rgl_build(hetab_context *ctx, const hetab_rgl_source *source,
                             const hetab_rgl_options *options, hetab_rgl **out,
                             hetab_rgl_report *report) {
  search s = {.ctx = ctx,
              .source = source,
              .target = options->table_error,
              .effort = options->forecast ? forecasting : searching};
  hetab_status status;
  *out = NULL;
  if (s.target == 0.0)
    s.target = 0.01;
  if (!(s.target > 0.0 && s.target <= 1.0))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "table_error %g: give a value up to 1", s.target);
  HETAB_GOTO(options->forecast ? prepare_given(&s, options->forecast) : prepare(&s));
  HETAB_GOTO(probe_cells(&s, s.shape.soft, &s.trial, NULL));
  HETAB_GOTO(options->forecast ? try_given(&s) : find_shape(&s));
done:
  hetab_rgl_trial_clear(&s.trial);
  if (status != HETAB_OK) {
    hetab_rgl_free(s.best);
    return status;
  }
  *out = s.best;
  *report = s.report;
  return HETAB_OK;
}
