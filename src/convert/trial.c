#include "convert/trial.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/merl.h>

#include "convert/grid_read.h"
#include "core/random.h"

typedef struct trial {
  hetab_convert_source *source;
  hetab_lookup *out;
  hetab_merl *merl;       /* read by cells; NULL: the output's rule is the interpolated one */
  const hetab_grid *grid; /* likewise, linear between its nodes */
  double *corners, *linear;
  uint64_t random;
  float *in_value, *out_value;
  double *expected;
  double sum, error, error_own, bias;
} trial;

/* A viewer for wi, from the mixture of both densities; returns cos(theta_o) over that, or 0. */
static double draw_viewer(trial *t, const float wi[3], float wo[3]) {
  const float u[2] = {(float)hetab_random_unit(&t->random), (float)hetab_random_unit(&t->random)};
  const float uc = (float)hetab_random_unit(&t->random);
  const hetab_lookup_query query = {.without_delta = 1};
  hetab_lookup_drawn drawn;
  float pdf;
  if (hetab_random_unit(&t->random) < 0.5) {
    double radius = sqrt((double)u[0]), phi = 2 * M_PI * (double)u[1];
    wo[0] = (float)(radius * cos(phi));
    wo[1] = (float)(radius * sin(phi));
    wo[2] = (float)sqrt(1 - (double)u[0]);
  } else {
    hetab_lookup_sample(t->source->table, &query, 1, wi, &uc, u, &drawn, t->in_value);
    memcpy(wo, drawn.wo, sizeof drawn.wo);
  }
  double cosine = (double)wo[2];
  hetab_lookup_eval(t->source->table, &query, 1, wi, wo, NULL, &pdf);
  return cosine > 0 ? cosine / (0.5 * (double)pdf + 0.5 * cosine / M_PI) : 0;
}

/* The output's values by its readers' rule, t->linear[channels]. */
static hetab_status read_own(hetab_context *ctx, trial *t, const float wi[3], const float wo[3]) {
  hetab_convert_source *source = t->source;
  const hetab_directions pair = {acos((double)wi[2]), acos((double)wo[2]),
                                 atan2((double)wo[1], (double)wo[0])};
  size_t clamped = source->clamped;
  for (size_t c = 0; c < source->channels; c++)
    t->linear[c] = (double)t->out_value[c];
  if (t->merl)
    hetab_merl_lookup(t->merl, pair, t->linear);
  hetab_status status = t->grid ? hetab_grid_read(ctx, t->grid, hetab_convert_values, source,
                                                  source->channels, &pair, t->corners, t->linear)
                                : HETAB_OK;
  source->clamped = clamped;
  return status;
}

static hetab_status add_pair(hetab_context *ctx, trial *t, const float wi[3], const float wo[3],
                             double weight) {
  hetab_lookup_eval(t->source->table, NULL, 1, wi, wo, t->in_value, NULL);
  hetab_convert_channels(t->source, t->in_value, t->expected);
  hetab_lookup_eval(t->out, NULL, 1, wi, wo, t->out_value, NULL);
  HETAB_TRY(read_own(ctx, t, wi, wo));
  for (size_t c = 0; c < t->source->channels; c++) {
    double difference = (double)t->out_value[c] - t->expected[c];
    t->sum += weight * t->expected[c];
    t->bias += weight * difference;
    t->error += weight * fabs(difference);
    t->error_own += weight * fabs(fmax(t->linear[c], 0) - t->expected[c]);
  }
  return HETAB_OK;
}

static hetab_status run(hetab_context *ctx, trial *t, size_t pairs) {
  const double steepest = 80 * M_PI / 180;
  for (size_t i = 0; i < pairs; i++) {
    double theta_i = hetab_random_unit(&t->random) * steepest;
    float wi[3] = {(float)sin(theta_i), 0, (float)cos(theta_i)}, wo[3];
    double weight = draw_viewer(t, wi, wo);
    if (weight > 0)
      HETAB_TRY(add_pair(ctx, t, wi, wo, weight));
    if (i % 4096 == 0)
      HETAB_TRY(hetab_progress(ctx, (double)i, (double)pairs));
  }
  return HETAB_OK;
}

/* ---- a finer grid -------------------------------------------------------------------------- */

/* From this error on a grid is proposed, which leaves that. */
static const double PROPOSING = 0.1, PROPOSED = 0.05;

/* Evenly spaced axes of nodes[]. */
static hetab_status even_grid(hetab_context *ctx, const size_t *nodes, hetab_grid **out) {
  char spec[64];
  HETAB_TRY(hetab_grid_create(ctx, out));
  hetab_status status = HETAB_OK;
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT && status == HETAB_OK; axis++) {
    snprintf(spec, sizeof spec, "0:%d:%zu", axis == HETAB_PHI ? 180 : 90, nodes[axis]);
    status = hetab_grid_set_axis(ctx, *out, axis, spec);
  }
  HETAB_MADE(hetab_grid, out, status);
}

/* The first of ever finer grids that serves. */
static hetab_status propose(hetab_context *ctx, const trial *t, size_t *nodes) {
  enum { PAIRS = 3000, MOST = 20000 };
  const double finer = 1.25;
  double factor = finer, error = 1.0;
  for (; error > PROPOSED && nodes[HETAB_PHI] < MOST; factor *= finer) {
    trial own = *t;
    hetab_grid *grid;
    own.sum = own.error_own = 0.0;
    for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
      nodes[axis] = (size_t)ceil(factor * (double)hetab_grid_count(t->grid, axis));
    HETAB_TRY(even_grid(ctx, nodes, &grid));
    own.grid = grid;
    hetab_status status = run(ctx, &own, PAIRS);
    hetab_grid_free(grid);
    HETAB_TRY(status);
    error = own.sum > 0.0 ? own.error_own / own.sum : 0.0;
  }
  return HETAB_OK;
}

hetab_status hetab_convert_trial(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                 size_t pairs, unsigned seed, hetab_convert_report *report) {
  trial t = {.source = source, .random = seed};
  hetab_status status;
  hetab_h5_table *h5 = NULL;
  t.in_value = hetab_alloc(ctx, source->channels_in, sizeof *t.in_value);
  t.out_value = hetab_alloc(ctx, source->channels, sizeof *t.out_value);
  t.expected = hetab_alloc(ctx, source->channels, sizeof *t.expected);
  t.corners = hetab_alloc(ctx, 8 * source->channels, sizeof *t.corners);
  t.linear = hetab_alloc(ctx, source->channels, sizeof *t.linear);
  if (!t.in_value || !t.out_value || !t.expected || !t.corners || !t.linear)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  HETAB_GOTO(hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &t.out));
  if (report->to == HETAB_FORMAT_MERL)
    HETAB_GOTO(hetab_merl_load(ctx, path, &t.merl));
  if (report->to == HETAB_FORMAT_H5) {
    HETAB_GOTO(hetab_h5_open_any(ctx, path, &h5));
    t.grid = hetab_h5_grid(h5);
  }
  HETAB_GOTO(run(ctx, &t, pairs));
  double scale = t.sum > 0 ? 1 / t.sum : 0;
  report->error_l1 = t.error_own * scale;
  report->error_l1_interpolated = t.error * scale;
  report->bias = t.bias * scale;
  if (t.grid && report->error_l1 > PROPOSING)
    HETAB_GOTO(propose(ctx, &t, report->proposed));
done:
  free(t.in_value);
  free(t.out_value);
  free(t.expected);
  free(t.corners);
  free(t.linear);
  hetab_h5_free(h5);
  hetab_lookup_free(t.out);
  hetab_merl_free(t.merl);
  return status;
}
