/* The choice of a table's shape. */
#include "rgl/rgl_build.h"

#include <math.h>
#include <stdlib.h>

#include "model/model.h"
#include "rgl/rgl_file.h"
#include "rgl/rgl_table.h"
#include "rgl/rgl_trial.h"

/* Incidences, every 2 degrees; those up to 80 degrees count. */
enum { TRIAL_INCIDENCES = 32, TRIAL_DIRECTIONS = 1000 };
enum { PROBES = 46, LAST_PROBE = 40, PROBE_RESOLUTION = 12 };

/* ---- incidences ---------------------------------------------------------------------------- */

/* sums[2] += |prediction - truth|, |truth| at probe k, the prediction being the mean of its
 * neighbours, as a reader takes it. */
static hetab_status probe_error(hetab_context *ctx, const hetab_rgl_source *source,
                                const hetab_rgl *probe, size_t k, double *slices, double *error) {
  size_t values = source->channels * PROBE_RESOLUTION * PROBE_RESOLUTION;
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
                                  double *density) {
  const hetab_rgl_shape shape = {PROBES, 256, 64, 32, PROBE_RESOLUTION};
  size_t values = source->channels * PROBE_RESOLUTION * PROBE_RESOLUTION;
  double theta[PROBES], *slices = NULL, step = M_PI_2 / (PROBES - 1);
  hetab_rgl *probe;
  hetab_status status;
  for (size_t k = 0; k < PROBES; k++)
    theta[k] = step * (double)k;
  HETAB_TRY(hetab_rgl_new(ctx, source, &shape, theta, &probe));
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
  for (size_t k = LAST_PROBE + 1; k < PROBES; k++)
    density[k] = fmin(density[k], density[LAST_PROBE]);
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

static hetab_status build_with(hetab_context *ctx, const hetab_rgl_source *source,
                               const double *density, const hetab_rgl_shape *shape,
                               hetab_rgl **out) {
  hetab_status status;
  *out = NULL;
  double *theta_i = hetab_alloc(ctx, shape->theta_i, sizeof *theta_i);
  if (!theta_i)
    return HETAB_ERR_MEMORY;
  place_incidences(density, shape->theta_i, theta_i);
  HETAB_GOTO(hetab_rgl_new(ctx, source, shape, theta_i, out));
  HETAB_GOTO(hetab_rgl_fill(ctx, source, *out));
done:
  free(theta_i);
  if (status != HETAB_OK) {
    hetab_rgl_free(*out);
    *out = NULL;
  }
  return status;
}

hetab_status hetab_rgl_build_at(hetab_context *ctx, const hetab_rgl_source *source,
                                const hetab_rgl_shape *shape, hetab_rgl **out) {
  double density[PROBES];
  *out = NULL;
  HETAB_TRY(probe_density(ctx, source, density));
  return build_with(ctx, source, density, shape, out);
}

hetab_status hetab_rgl_measure(hetab_context *ctx, const hetab_rgl_source *source,
                               const hetab_rgl *rgl, hetab_rgl_report *report) {
  hetab_rgl_trial trial;
  HETAB_TRY(
      hetab_rgl_trial_create(ctx, source, rgl, TRIAL_INCIDENCES, TRIAL_DIRECTIONS, 1, &trial));
  hetab_status status = hetab_rgl_trial_run(ctx, &trial, rgl, &report->error_l1, &report->bias);
  hetab_rgl_trial_clear(&trial);
  return status;
}

/* ---- the smallest shape that serves -------------------------------------------------------- */

static const size_t theta_i_counts[] = {4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 64};
static const size_t resolutions[] = {8, 12, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128};
enum {
  THETA_I_COUNTS = sizeof theta_i_counts / sizeof *theta_i_counts,
  RESOLUTIONS = sizeof resolutions / sizeof *resolutions
};

/* Of what was asked for, so that other random directions find the error below it too. */
static const double margin = 0.8;
/* The bias asked for, of the error. */
static const double bias_share = 0.3;

typedef struct search {
  hetab_context *ctx;
  const hetab_rgl_source *source;
  double target;
  double density[PROBES];
  hetab_rgl_shape shape;
  hetab_rgl_trial trial;
  size_t tried;
  hetab_rgl *best; /* the smallest that serves, else the most accurate */
  hetab_rgl_report report;
} search;

/* The errors over what is allowed: at most 1 serves. */
static double excess_of(const search *s, const hetab_rgl_report *report) {
  double allowed = margin * s->target;
  return fmax(report->error_l1 / allowed, fabs(report->bias) / (bias_share * allowed));
}

/* Whether `report` is of a better table than the best so far. */
static int is_better(const search *s, const hetab_rgl_report *report) {
  if (!s->best)
    return 1;
  double excess = excess_of(s, report), best = excess_of(s, &s->report);
  if (excess <= 1.0 && best <= 1.0)
    return report->bytes < s->report.bytes;
  return excess < best;
}

static hetab_status try_shape(search *s, const hetab_rgl_shape *shape, double *excess) {
  hetab_rgl_report report = {.target = s->target,
                             .theta_i_count = shape->theta_i,
                             .ndf_count = shape->ndf,
                             .vndf_count = shape->vndf_theta,
                             .resolution = shape->resolution};
  hetab_rgl *rgl;
  hetab_status status;
  HETAB_TRY(build_with(s->ctx, s->source, s->density, shape, &rgl));
  HETAB_GOTO(hetab_rgl_trial_run(s->ctx, &s->trial, rgl, &report.error_l1, &report.bias));
  HETAB_GOTO(hetab_rgl_bytes(s->ctx, rgl, &report.bytes));
  HETAB_GOTO(hetab_progress(s->ctx, (double)++s->tried, THETA_I_COUNTS + RESOLUTIONS));
  *excess = excess_of(s, &report);
  if (is_better(s, &report)) {
    hetab_rgl_free(s->best);
    s->best = rgl;
    s->report = report;
    return HETAB_OK;
  }
done:
  hetab_rgl_free(rgl);
  return status;
}

/* The first count of incidences whose own error is far below the target. */
static size_t enough_incidences(const search *s) {
  double intervals = 0.0, step = M_PI_2 / (PROBES - 1);
  for (size_t k = 1; k < PROBES; k++)
    intervals += 0.5 * (s->density[k - 1] + s->density[k]) * step;
  intervals /= sqrt(0.3 * s->target);
  size_t t = 0;
  while (t + 1 < THETA_I_COUNTS && (double)theta_i_counts[t] < intervals + 1.0)
    t++;
  return t;
}

/* The next resolution for a table whose error is `excess` times what it should be. */
static size_t more_nodes(size_t r, double excess) {
  double factor = fmin(sqrt(fmax(excess, 1.0)), 1.8);
  size_t next = r + 1;
  while (next + 1 < RESOLUTIONS && (double)resolutions[next + 1] <= factor * (double)resolutions[r])
    next++;
  return next;
}

/* Numbers in a table's large arrays: what its file's size goes by. */
static size_t numbers(const search *s, size_t theta_i, size_t resolution) {
  return theta_i * (s->shape.vndf_theta * s->shape.vndf_phi +
                    (s->source->channels + 1) * resolution * resolution);
}

/* Whether a table that serves is known, and one of this shape would be no smaller. */
static int is_in_vain(const search *s, const hetab_rgl_shape *shape) {
  return s->best && excess_of(s, &s->report) <= 1.0 &&
         numbers(s, shape->theta_i, shape->resolution) >=
             numbers(s, s->report.theta_i_count, s->report.resolution);
}

/* Along the border between shapes that serve and shapes that do not: more nodes where one does not,
 * fewer incidences where it does, or where it would be no smaller than one that does. */
static hetab_status walk(search *s, size_t t) {
  size_t r = 0;
  while (r < RESOLUTIONS) {
    hetab_rgl_shape shape = s->shape;
    double excess = 0.0;
    shape.theta_i = theta_i_counts[t];
    shape.resolution = resolutions[r];
    if (!is_in_vain(s, &shape))
      HETAB_TRY(try_shape(s, &shape, &excess));
    if (excess > 1.0)
      r = more_nodes(r, excess);
    else if (t == 0)
      break;
    else
      t--;
  }
  return HETAB_OK;
}

/* From as many incidences as should be enough; from the most if they are not. */
static hetab_status find_shape(search *s) {
  size_t enough = enough_incidences(s), most = THETA_I_COUNTS - 1;
  HETAB_TRY(walk(s, enough));
  if (excess_of(s, &s->report) <= 1.0 || enough == most)
    return HETAB_OK;
  return walk(s, most);
}

/* Nodes for the lobe: at least 8 over its half width. */
static hetab_status choose_nodes(search *s) {
  enum { FINE = 1024 };
  double theta[FINE], density[FINE];
  size_t half = 1, nodes = 64;
  for (size_t i = 0; i < FINE; i++)
    theta[i] = hetab_rgl_u_to_theta((double)i / (FINE - 1));
  HETAB_TRY(hetab_rgl_lobe_from_data(s->ctx, s->source, theta, FINE, density));
  while (half + 1 < FINE && density[half] > 0.5 * density[0])
    half++;
  while (nodes < 256 && nodes * half < 8 * FINE)
    nodes *= 2;
  s->shape = (hetab_rgl_shape){
      .ndf = 4 * nodes, .vndf_theta = nodes, .vndf_phi = 32, .theta_i = 12, .resolution = 24};
  return HETAB_OK;
}

static hetab_status prepare(search *s) {
  hetab_rgl *coarse = NULL;
  hetab_status status;
  HETAB_TRY(choose_nodes(s));
  HETAB_TRY(probe_density(s->ctx, s->source, s->density));
  HETAB_TRY(build_with(s->ctx, s->source, s->density, &s->shape, &coarse));
  status = hetab_rgl_trial_create(s->ctx, s->source, coarse, TRIAL_INCIDENCES, TRIAL_DIRECTIONS, 1,
                                  &s->trial);
  hetab_rgl_free(coarse);
  return status;
}

hetab_status hetab_rgl_build(hetab_context *ctx, const hetab_rgl_source *source,
                             const hetab_rgl_options *options, hetab_rgl **out,
                             hetab_rgl_report *report) {
  search s = {.ctx = ctx, .source = source, .target = options->table_error};
  hetab_status status;
  *out = NULL;
  if (s.target == 0.0)
    s.target = 0.01;
  if (!(s.target > 0.0 && s.target <= 1.0))
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "table_error %g: give a value up to 1", s.target);
  HETAB_GOTO(prepare(&s));
  HETAB_GOTO(find_shape(&s));
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
