/* Directional-hemispherical reflectances: nodes from the host (model/hemisphere.h), the model at
 * them from the device, as many integrals a launch as there are. What a launch leaves unconverged
 * goes again with more rays, more nodes along them, or both. */
#include <hetab/reflectance.h>

#include <math.h>
#include <stdlib.h>

#include "engine/dense.h"
#include "kernels/tables.h"
#include "model/limits.h"
#include "model/hemisphere.h"

enum { FIRST_NODES = 64, NODES_UNIT = 32, RAYS_UNIT = 2 };
enum { MOST_NODES = 1 << 20, LAUNCH_NODES = 1 << 18 }; /* of one integral; of one launch, about */
enum { PART_EVALUATIONS = 1 << 22 };
static const double FIRST_STEP = 0.4; /* of rays, in u */

const char *hetab_stop_name(hetab_stop stop) {
  static const char *const names[] = {"tolerance", "roundoff", "budget"};
  return (size_t)stop < 3 ? names[stop] : "unknown";
}

/* ---- the jobs ------------------------------------------------------------------------------ */

/* One incidence at some wavelengths, whose lobes are alike: they share the nodes. */
typedef struct job {
  hetab_hemisphere at;
  size_t angle, first_band, band_count;
  double rounding; /* relative, the largest of its bands */
  size_t rays, nodes;
  int done;
} job;

typedef struct integration {
  hetab_context *ctx;
  const hetab_engine *engine;
  const hetab_surface *surface;
  size_t angle_count, band_count;
  double tolerance;
  hetab_reflectance *out;
  job *jobs;
  size_t job_count, done_count, total; /* integrals done and wanted: a job has one for each band */
  cl_kernel kernel;
  cl_mem waves;
} integration;

/* How far the device's arithmetic is from the model, relative, in these sums
 * (tests/test_reflectance.c compares float with double). Materials that hardly reflect lose digits
 * in the Fresnel coefficients, differences whose squares it is. */
static double rounding_of(const integration *in, const hetab_band *band) {
  double unit = hetab_engine_precision(in->engine) == HETAB_DOUBLE ? 2e-11 : 1e-6;
  double normal = hetab_fresnel_at(1.0, band->n, band->k);
  return unit * (1.0 + 0.05 / sqrt(normal + 1e-30));
}

static double default_tolerance(const hetab_engine *engine) {
  return hetab_engine_precision(engine) == HETAB_DOUBLE ? 1e-9 : 1e-5;
}

/* What lies beyond the rays' reach, relative. */
static double left_out(const integration *in) {
  return 1e-3 * in->tolerance;
}

/* The end of the octave of wavelengths that begins with a band, whose kink is in one place. */
static size_t octave_end(const integration *in, size_t first) {
  const hetab_band *bands = hetab_surface_bands(in->surface);
  size_t end = first + 1;
  while (end < in->band_count && bands[end].lambda_um <= 2.0 * bands[first].lambda_um &&
         hetab_hemisphere_kink(&bands[first]) == hetab_hemisphere_kink(&bands[end]))
    end++;
  return end;
}

/* At the rim shadows fall within cosines of the slope: a layer that rules with few nodes in it do
 * not see, nor that they do not. The nodes' map goes with the 4th power of their number there. */
static size_t first_nodes(const hetab_hemisphere *at) {
  static const double LAYER_NODES = 16.0;
  double rim = at->in.mu * at->in.mu / (1.0 + at->in.s), nodes = FIRST_NODES;
  if (at->reach > rim)
    nodes = fmax(nodes, LAYER_NODES * pow(18.0 * at->tau_2sigma, 0.25));
  return NODES_UNIT * (size_t)ceil(nodes / NODES_UNIT);
}

/* In the widest panel as elsewhere: where rays are crowded at its ends, they are sparse in the
 * middle. */
static size_t first_rays(const hetab_hemisphere *at) {
  double middle = hetab_crowd(0.5).slope, widest = 0.0;
  double step = at->panels > 1 ? FIRST_STEP / (middle * middle) : FIRST_STEP; /* crowded twice */
  for (size_t i = 0; i < at->panels; i++)
    widest = fmax(widest, at->cut[i + 1] - at->cut[i]);
  return RAYS_UNIT * (size_t)ceil(widest / (RAYS_UNIT * step)) * at->panels;
}

static job job_of(const integration *in, const hetab_hemisphere *at, size_t angle, size_t first,
                  size_t end) {
  double sigma0 = hetab_surface_sigma0_um(in->surface), tau = hetab_surface_tau_um(in->surface);
  job j = {.at = *at, .angle = angle, .first_band = first, .band_count = end - first};
  j.at.reach = 0.0;
  for (size_t b = first; b < end; b++) {
    const hetab_band *band = &hetab_surface_bands(in->surface)[b];
    hetab_wave wave = hetab_wave_of(sigma0, tau, band);
    j.rounding = fmax(j.rounding, rounding_of(in, band));
    j.at.reach = fmax(j.at.reach, hetab_hemisphere_reach(at, &wave, left_out(in)));
  }
  double kink = hetab_hemisphere_kink(&hetab_surface_bands(in->surface)[first]);
  j.nodes = first_nodes(&j.at);
  if (kink > 0.0) {
    hetab_hemisphere_split(&j.at, kink);
    j.nodes *= 2;
  }
  j.rays = first_rays(&j.at);
  return j;
}

/* At exactly 90 degrees there is nothing to integrate. */
static hetab_status plan(integration *in, const double *theta_i) {
  double tau_2sigma = hetab_tau_2sigma(in->surface);
  in->jobs = hetab_alloc(in->ctx, in->angle_count, in->band_count * sizeof *in->jobs);
  HETAB_NEED(in->jobs);
  for (size_t a = 0; a < in->angle_count; a++) {
    hetab_hemisphere at = hetab_hemisphere_at(theta_i[a], tau_2sigma);
    for (size_t first = 0, end; at.in.mu > 0.0 && first < in->band_count; first = end) {
      end = octave_end(in, first);
      in->jobs[in->job_count++] = job_of(in, &at, a, first, end);
    }
    HETAB_TRY(hetab_progress(in->ctx, 0.0, (double)in->angle_count));
  }
  return HETAB_OK;
}

/* ---- one launch ---------------------------------------------------------------------------- */

/* The jobs [first, end) that are not done, and their rays. */
typedef struct launch {
  size_t first, end;
  size_t ray_count, most_bands, results;
  size_t stride; /* nodes in all */
  double *nodes; /* [HETAB_NODE_REALS][stride] */
  cl_int *rays;  /* [ray_count][HETAB_RAY_INTS] */
} launch;

static size_t job_size(const job *j) {
  return j->done ? 0 : (j->rays + 1) * j->nodes;
}

/* From `first` on, what fits. */
static launch launch_from(const integration *in, size_t first) {
  launch l = {.first = first, .end = first};
  while (l.end < in->job_count &&
         (l.stride == 0 || l.stride + job_size(&in->jobs[l.end]) <= LAUNCH_NODES)) {
    const job *j = &in->jobs[l.end++];
    l.stride += job_size(j);
    if (j->done)
      continue;
    l.ray_count += j->rays + 1;
    l.results += (j->rays + 1) * j->band_count;
    l.most_bands = j->band_count > l.most_bands ? j->band_count : l.most_bands;
  }
  return l;
}

static void fill_nodes(const job *j, size_t ray, hetab_node *nodes, double *columns,
                       size_t stride) {
  hetab_hemisphere_ray(&j->at, ray, j->rays, j->nodes, nodes);
  for (size_t i = 0; i < j->nodes; i++) {
    columns[HETAB_NODE_COS2_D * stride + i] = nodes[i].cos2_d;
    columns[HETAB_NODE_LATERAL2 * stride + i] = nodes[i].lateral2;
    columns[HETAB_NODE_G * stride + i] = nodes[i].g;
    columns[HETAB_NODE_WEIGHT * stride + i] = nodes[i].weight;
  }
}

static void fill_launch(const integration *in, const launch *l, hetab_node *nodes) {
  size_t node = 0, ray = 0, result = 0;
  for (size_t i = l->first; i < l->end; i++) {
    const job *j = &in->jobs[i];
    for (size_t r = 0; !j->done && r <= j->rays; r++) {
      const size_t fields[HETAB_RAY_INTS] = {[HETAB_RAY_FIRST_NODE] = node,
                                             [HETAB_RAY_NODES] = j->nodes,
                                             [HETAB_RAY_FIRST_WAVE] = j->first_band,
                                             [HETAB_RAY_WAVES] = j->band_count,
                                             [HETAB_RAY_FIRST_SUM] = result};
      for (size_t f = 0; f < HETAB_RAY_INTS; f++)
        l->rays[ray * HETAB_RAY_INTS + f] = (cl_int)fields[f];
      fill_nodes(j, r, nodes, l->nodes + node, l->stride);
      node += j->nodes;
      result += j->band_count;
      ray++;
    }
  }
}

static hetab_status prepare(const integration *in, launch *l) {
  size_t most = 0;
  for (size_t i = l->first; i < l->end; i++)
    most = in->jobs[i].nodes > most ? in->jobs[i].nodes : most;
  HETAB_FREED hetab_node *nodes = hetab_alloc(in->ctx, most, sizeof *nodes);
  l->nodes = hetab_alloc(in->ctx, l->stride, HETAB_NODE_REALS * sizeof *l->nodes);
  l->rays = hetab_alloc(in->ctx, l->ray_count, HETAB_RAY_INTS * sizeof *l->rays);
  if (nodes && l->nodes && l->rays)
    fill_launch(in, l, nodes);
  return nodes && l->nodes && l->rays ? HETAB_OK : HETAB_ERR_MEMORY;
}

/* Runs the kernel over the launch's rays and its wavelengths, in parts that take a moment. */
static hetab_status run_parts(const integration *in, const launch *l, hetab_args *args) {
  const cl_uint first_arg = args->next;
  size_t part = PART_EVALUATIONS * l->ray_count / (l->stride * l->most_bands) + 1;
  for (size_t first = 0; first < l->ray_count; first += part) {
    size_t rest = l->ray_count - first;
    args->next = first_arg;
    hetab_arg_int(args, first);
    HETAB_TRY(hetab_lane_run(args, rest < part ? rest : part, l->most_bands, NULL));
    HETAB_TRY(hetab_lane_finish(in->ctx, args->lane));
    HETAB_TRY(hetab_progress(in->ctx, (double)in->done_count, (double)in->total));
  }
  return HETAB_OK;
}

static hetab_status run_kernel(const integration *in, const launch *l, hetab_output *sums) {
  const hetab_lane *lane = &in->engine->lanes[0];
  cl_mem rays = NULL, nodes = NULL;
  hetab_status status;
  hetab_args args = {in->ctx, in->engine, lane, in->kernel, 0, HETAB_OK};
  HETAB_GOTO(hetab_lane_upload_bytes(in->ctx, lane, l->rays,
                                     l->ray_count * HETAB_RAY_INTS * sizeof *l->rays, &rays));
  HETAB_GOTO(
      hetab_lane_upload(in->ctx, in->engine, lane, l->nodes, l->stride * HETAB_NODE_REALS, &nodes));
  hetab_arg_mem(&args, in->waves);
  hetab_arg_mem(&args, rays);
  hetab_arg_int(&args, l->ray_count);
  hetab_arg_mem(&args, nodes);
  hetab_arg_int(&args, l->stride);
  hetab_arg_mem(&args, sums->buffer);
  HETAB_GOTO(run_parts(in, l, &args));
  HETAB_GOTO(hetab_output_fetch(in->ctx, in->engine, l->results * HETAB_SUM_REALS, sums));
done:
  hetab_release(rays);
  hetab_release(nodes);
  return status;
}

/* ---- error estimates ----------------------------------------------------------------------- */

typedef struct estimate {
  double value, along, across; /* errors relative */
} estimate;

/* Pieces between kinks may be short, or the kink not infinitely sharp: no credit for convergence.
 */
static double rule_error(const job *j, double difference) {
  return j->at.kink > 0.0 ? 4.0 * difference : hetab_rule_error(difference);
}

/* Of one integral: sums[ray][stride] over its rays. Differences along rays add up as magnitudes, so
 * that no two of them pass for convergence. */
static estimate estimate_of(const integration *in, const job *j, const void *sums, size_t first) {
  size_t stride = j->band_count, rays = j->rays;
  double all = 0.0, even = 0.0, along = 0.0;
  for (size_t r = 0; r <= rays; r++) {
    size_t at = (first + r * stride) * HETAB_SUM_REALS;
    double coarse = hetab_real_at(in->engine, sums, at + HETAB_SUM_FIRST);
    double rest = hetab_real_at(in->engine, sums, at + HETAB_SUM_SECOND);
    all += coarse + rest;
    even += r % 2 ? 0.0 : coarse + rest;
    along += fabs(rest - coarse);
  }
  double scale = all > 0.0 ? 1.0 / all : 0.0;
  return (estimate){all, rule_error(j, along * scale),
                    rule_error(j, fabs(all - 2.0 * even) * scale)};
}

/* ---- refinement ---------------------------------------------------------------------------- */

/* The relative error that the rule may have. */
static double goal(const integration *in, const job *j) {
  return fmax(in->tolerance - j->rounding, 0.5 * j->rounding) - 2.0 * left_out(in);
}

static void store(const integration *in, const job *j, size_t band, const estimate *e) {
  static const double underflow = 1e-30;
  hetab_integral *dd = &in->out[band * in->angle_count + j->angle].dd;
  double rule = e->along + e->across, error = rule + left_out(in) + j->rounding;
  dd->value = e->value;
  dd->error = error * e->value + underflow;
  dd->evaluations += (j->rays + 1) * (j->nodes - 1);
  dd->stop = rule > goal(in, j)       ? HETAB_STOP_BUDGET
             : error <= in->tolerance ? HETAB_STOP_TOLERANCE
                                      : HETAB_STOP_ROUNDOFF;
}

/* How many rays, or nodes, it takes for an error to come down to `goal`: the logarithm of the error
 * goes with the number, but one is not told the constant. */
static size_t grown(size_t count, size_t unit, double error, double goal) {
  double factor = error < 1.0 ? fmin(fmax(log(goal) / log(error), 1.2), 2.0) : 2.0;
  return error <= goal ? count : unit * (size_t)ceil(factor * (double)count / (double)unit);
}

/* The job's results are stored; is it done, or what has to be refined? */
static void judge(integration *in, job *j, const void *sums, size_t first) {
  double along = 0.0, across = 0.0, worst = 0.0;
  for (size_t b = 0; b < j->band_count; b++) {
    estimate e = estimate_of(in, j, sums, first + b);
    store(in, j, j->first_band + b, &e);
    along = fmax(along, e.along);
    across = fmax(across, e.across);
    worst = fmax(worst, e.along + e.across);
  }
  size_t rays = grown(j->rays, RAYS_UNIT * j->at.panels, across, 0.5 * goal(in, j));
  size_t nodes = grown(j->nodes, NODES_UNIT, along, 0.5 * goal(in, j));
  j->done = worst <= goal(in, j) || (rays + 1) * nodes > MOST_NODES;
  if (!j->done) {
    j->rays = rays;
    j->nodes = nodes;
  }
  in->done_count += (size_t)j->done * j->band_count;
}

static void take_sums(integration *in, const launch *l, const void *sums) {
  size_t first = 0;
  for (size_t i = l->first; i < l->end; i++) {
    job *j = &in->jobs[i];
    if (j->done)
      continue;
    size_t results = (j->rays + 1) * j->band_count;
    judge(in, j, sums, first);
    first += results;
  }
}

static hetab_status run_launch(integration *in, launch *l) {
  hetab_output sums = {0};
  hetab_status status;
  HETAB_GOTO(prepare(in, l));
  HETAB_GOTO(hetab_output_create(in->ctx, in->engine, &in->engine->lanes[0],
                                 l->results * HETAB_SUM_REALS, &sums));
  HETAB_GOTO(run_kernel(in, l, &sums));
  HETAB_GOTO(hetab_output_wait(in->ctx, &sums));
  take_sums(in, l, sums.values);
done:
  hetab_output_free(&sums);
  free(l->nodes);
  free(l->rays);
  return status;
}

static hetab_status integrate(integration *in) {
  for (size_t i = 0; i < in->job_count; i++)
    in->total += in->jobs[i].band_count;
  while (in->done_count < in->total)
    for (size_t first = 0; first < in->job_count;) {
      launch l = launch_from(in, first);
      first = l.end;
      if (l.stride > 0)
        HETAB_TRY(run_launch(in, &l));
      HETAB_TRY(hetab_progress(in->ctx, (double)in->done_count, (double)in->total));
    }
  return HETAB_OK;
}

/* ---- the call ------------------------------------------------------------------------------ */

static hetab_status check(hetab_context *ctx, const hetab_engine *engine, const double *theta_i,
                          size_t count, double tolerance) {
  HETAB_TRY(hetab_check_tolerance(ctx, tolerance));
  for (size_t i = 0; i < count; i++)
    if (!(theta_i[i] >= 0.0 && theta_i[i] <= M_PI_2))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "theta_i = %g radians is not in [0, pi/2]",
                        theta_i[i]);
  if (hetab_engine_method(engine) == HETAB_METHOD_LITERAL)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "reflectances are integrated on a device: the literal method has none");
  return HETAB_OK;
}

/* Everything but the integral. */
static void fill_rest(const integration *in, const double *theta_i) {
  double sigma0 = hetab_surface_sigma0_um(in->surface), tau = hetab_surface_tau_um(in->surface);
  for (size_t a = 0; a < in->angle_count; a++) {
    hetab_direction d = hetab_direction_at(theta_i[a], tau / (2.0 * sigma0));
    for (size_t b = 0; b < in->band_count; b++) {
      const hetab_band *band = &hetab_surface_bands(in->surface)[b];
      hetab_wave wave = hetab_wave_of(sigma0, tau, band);
      hetab_reflectance *r = &in->out[b * in->angle_count + a];
      r->specular = hetab_specular(&d, &wave);
      r->ud = M_PI * band->diffuse_brdf;
      r->dh = r->dd.value + r->specular + r->ud;
      r->fresnel = hetab_fresnel_at(d.mu * d.mu, band->n, band->k);
    }
  }
}

static hetab_status open_kernel(integration *in) {
  const hetab_lane *lane = &in->engine->lanes[0];
  double *rows = hetab_alloc(in->ctx, in->band_count, HETAB_WAVE_REALS * sizeof *rows);
  HETAB_NEED(rows);
  for (size_t b = 0; b < in->band_count; b++) {
    hetab_wave wave =
        hetab_wave_of(hetab_surface_sigma0_um(in->surface), hetab_surface_tau_um(in->surface),
                      &hetab_surface_bands(in->surface)[b]);
    hetab_wave_row(in->engine, &wave, rows + b * HETAB_WAVE_REALS);
  }
  hetab_status status = hetab_lane_upload(in->ctx, in->engine, lane, rows,
                                          in->band_count * HETAB_WAVE_REALS, &in->waves);
  free(rows);
  HETAB_TRY(status);
  return hetab_lane_kernel(in->ctx, in->engine, lane,
                           &(hetab_build){.program = "hemisphere", .kernel = "hetab_k_hemisphere"},
                           &in->kernel);
}

hetab_status hetab_reflectance_dh(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, const double *theta_i, size_t count,
                                  double tolerance, hetab_reflectance *out) {
  integration in = {.ctx = ctx,
                    .engine = engine,
                    .surface = surface,
                    .angle_count = count,
                    .band_count = hetab_surface_band_count(surface),
                    .tolerance = tolerance > 0.0 ? tolerance : default_tolerance(engine)};
  hetab_status status;
  HETAB_TRY(check(ctx, engine, theta_i, count, tolerance));
  HETAB_TRY(hetab_check_surface(ctx, surface));
  in.out = hetab_alloc(ctx, in.band_count * count, sizeof *out);
  HETAB_NEED(in.out);
  HETAB_GOTO(plan(&in, theta_i));
  HETAB_GOTO(open_kernel(&in));
  HETAB_GOTO(integrate(&in));
  fill_rest(&in, theta_i);
  for (size_t i = 0; i < in.band_count * count; i++)
    out[i] = in.out[i];
done:
  if (in.kernel)
    clReleaseKernel(in.kernel);
  hetab_release(in.waves);
  free(in.jobs);
  free(in.out);
  return status;
}
