#include "plan/fixed_error.h"

#include <math.h>
#include <stdlib.h>

#include <hetab/sampler.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/random.h"
#include "plan/scene.h"
#include "rgl/rgl_model.h"
#include "table/merl_frame.h"

HETAB_HANDLE(hetab_model_sampler)
HETAB_HANDLE(hetab_rgl_model)

enum { DIRECTIONS = 300, INCIDENCES = 5, MOST_NODES = 8, STRIDE = MOST_NODES + 1 };

/* What a reader makes its value of: nodes, and their weights. */
typedef struct reading {
  size_t count;
  hetab_directions node[MOST_NODES];
  double weight[MOST_NODES];
} reading;

static reading read_merl(const hetab_directions *at) {
  hetab_merl_place place =
      hetab_merl_place_of(hetab_half_diff_of(at->theta_i, at->theta_r, at->phi));
  hetab_merl_place middle = {floor(place.h) + 0.5, floor(place.d) + 0.5, floor(place.p) + 0.5};
  hetab_merl_pair pair;
  reading r = {0};
  if (hetab_merl_pair_of(hetab_merl_angles(middle), &pair)) {
    r.count = 1;
    r.node[0] = pair.at;
    r.weight[0] = 1.0;
  }
  return r;
}

/* The nodes on both sides, and the place between them. */
static double between(double value, double most, size_t count, double node[2]) {
  double step = most / (double)(count - 1), low = fmin(floor(value / step), (double)(count - 2));
  node[0] = low * step;
  node[1] = (low + 1.0) * step;
  return fmin((value - node[0]) / step, 1.0);
}

static reading read_dense(const hetab_scene *scene, double spacing_deg,
                          const hetab_directions *at) {
  double i[2], r[2], phi[2], turn = fabs(remainder(at->phi, 2.0 * M_PI));
  double part[3] = {between(at->theta_i, scene->max_theta_i,
                            hetab_scene_thetas(scene->max_theta_i, spacing_deg), i),
                    between(at->theta_r, scene->max_theta_r,
                            hetab_scene_thetas(scene->max_theta_r, spacing_deg), r),
                    between(turn, M_PI, hetab_scene_phis(spacing_deg), phi)};
  reading out = {.count = MOST_NODES};
  for (size_t n = 0; n < MOST_NODES; n++) {
    size_t a = n & 1, b = n >> 1 & 1, c = n >> 2;
    out.node[n] = (hetab_directions){i[a], r[b], phi[c]};
    out.weight[n] = (a ? part[0] : 1.0 - part[0]) * (b ? part[1] : 1.0 - part[1]) *
                    (c ? part[2] : 1.0 - part[2]);
  }
  return out;
}

/* A direction with its weight, 0 for none. */
static double draw(const hetab_model_sampler *sampler, double theta_i, uint64_t *state,
                   hetab_directions *at) {
  const double wi[3] = {sin(theta_i), 0.0, cos(theta_i)};
  double u[3], wo[3];
  for (int k = 0; k < 3; k++)
    u[k] = hetab_random_unit(state);
  double density = hetab_model_sampler_sample(sampler, wi, u, wo, NULL);
  *at = (hetab_directions){theta_i, atan2(hypot(wo[0], wo[1]), wo[2]), atan2(wo[1], wo[0])};
  return density > 0.0 ? wo[2] / density : 0.0;
}

static hetab_status error_at(hetab_context *ctx, const hetab_scene *scene,
                             const hetab_rgl_source *source, const hetab_model_sampler *sampler,
                             double spacing_deg, double theta_i, uint64_t state, double *error) {
  hetab_directions pairs[DIRECTIONS * STRIDE];
  double weight[DIRECTIONS], sums[2] = {0.0};
  reading readings[DIRECTIONS];
  size_t channels = source->channels, count = 0;
  for (size_t d = 0; d < DIRECTIONS; d++) {
    double near = fmin(theta_i + hetab_radians(hetab_random_unit(&state)), scene->max_theta_i);
    hetab_directions *at = &pairs[count++];
    weight[d] = draw(sampler, near, &state, at);
    if (at->theta_r > scene->max_theta_r)
      weight[d] = 0.0;
    readings[d] =
        scene->consumer == HETAB_CONSUMER_MERL ? read_merl(at) : read_dense(scene, spacing_deg, at);
    for (size_t n = 0; n < readings[d].count; n++)
      pairs[count++] = readings[d].node[n];
  }
  double *values = hetab_alloc(ctx, count * channels, sizeof *values), *value = values;
  hetab_status status =
      values ? source->values(ctx, source->user, pairs, count, values) : HETAB_ERR_MEMORY;
  for (size_t d = 0; status == HETAB_OK && d < DIRECTIONS; d++) {
    const reading *r = &readings[d];
    for (size_t c = 0; c < channels; c++) {
      double read = 0.0;
      for (size_t n = 0; n < r->count; n++)
        read += r->weight[n] * value[(n + 1) * channels + c];
      sums[0] += weight[d] * fabs(read - value[c]);
      sums[1] += weight[d] * value[c];
    }
    value += (r->count + 1) * channels;
  }
  free(values);
  *error = sums[1] > 0.0 ? sums[0] / sums[1] : 0.0;
  return status;
}

hetab_status hetab_fixed_error(hetab_context *ctx, const hetab_scene *scene,
                               const hetab_surface *surface, const hetab_plan_item *item,
                               uint64_t seed, double *error) {
  const hetab_rgl_options options = {
      .bands = scene->consumer == HETAB_CONSUMER_HDF5 ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB,
      .specular_cone = item->delta == HETAB_DELTA_FOLDED ? scene->specular_cone : 0.0};
  double most = fmin(scene->max_theta_i, hetab_radians(75.0)), one;
  HETAB_ENDS(hetab_rgl_model_end) hetab_rgl_model *model = NULL;
  HETAB_ENDS(hetab_model_sampler_end) hetab_model_sampler *sampler = NULL;
  hetab_status status = hetab_rgl_model_create(ctx, surface, &options, &model);
  if (status == HETAB_OK)
    status =
        hetab_model_sampler_create(ctx, surface, hetab_surface_band_count(surface) / 2, &sampler);
  *error = 0.0;
  for (int i = 0; i < INCIDENCES && status == HETAB_OK; i++) {
    status = error_at(ctx, scene, hetab_rgl_model_source(model), sampler, item->spacing_deg,
                      most * i / (INCIDENCES - 1), seed, &one);
    *error = fmax(*error, one);
  }
  return status;
}
