/* MERL tables: the half/difference frame on the device, channels and colour on the host. */
#include <hetab/tabulate.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cl/device.h"
#include "engine/dense.h"
#include "engine/sample.h"
#include "engine/specular_cone.h"
#include "kernels/tables.h"
#include "model/colour.h"
#include "model/limits.h"

enum { ROWS = HETAB_MERL_THETA_H * HETAB_MERL_THETA_D, CHANNELS = 3, MEAN_SUBSAMPLES = 3 };

/* Where in a cell samples lie: offsets in [0, 1] of the cell's index range. */
typedef struct sub_samples {
  int count;
  double offset[MEAN_SUBSAMPLES];
} sub_samples;

typedef struct merl_job {
  hetab_context *ctx;
  const hetab_engine *engine;
  const hetab_surface *surface;
  hetab_band *bands; /* [band_count]: what is summed */
  size_t band_count;
  const hetab_merl_options *options;
  sub_samples sub;
  size_t phi_samples; /* along phi_d, up to 90 degrees: the rest mirrors them */
  size_t stride;      /* the same, padded */
  hetab_atlas atlas;
  double *waves; /* [wavelength][HETAB_WAVE_REALS], the weights among them */
  double (*weights)[CHANNELS];
  cl_kernel kernel;
  cl_mem waves_buffer, frame, mu_i, mu_r, channels, panels, segments, coefficients;
  double kernel_seconds;
  double *sum;          /* [channel][cell], of valid samples */
  unsigned char *valid; /* [cell], how many */
} merl_job;

/* A (theta_h, theta_d, phi_d), in the units of the table's indices. */
static double theta_h_at(double index) {
  double u = index / HETAB_MERL_THETA_H;
  return u * u * M_PI_2;
}

static double theta_d_at(double index) {
  return index / HETAB_MERL_THETA_D * M_PI_2;
}

static double phi_d_at(double index) {
  return index / HETAB_MERL_PHI_D * M_PI;
}

static sub_samples sub_samples_of(hetab_merl_sampling sampling) {
  if (sampling == HETAB_MERL_EDGE)
    return (sub_samples){1, {0.0}};
  if (sampling == HETAB_MERL_CENTRE)
    return (sub_samples){1, {0.5}};
  return (sub_samples){MEAN_SUBSAMPLES, {1.0 / 6.0, 0.5, 5.0 / 6.0}};
}

/* phi_d and 180 - phi_d swap the two directions, which changes nothing (reciprocity and the plane
 * of incidence's symmetry): only samples up to 90 degrees are computed. */
static double phi_index(const merl_job *job, size_t sample) {
  size_t n = (size_t)job->sub.count;
  return (double)(sample / n) + job->sub.offset[sample % n];
}

/* The computed sample that equals sample number p of the whole row. */
static size_t mirrored(const merl_job *job, size_t p) {
  if (phi_index(job, p) <= 0.5 * HETAB_MERL_PHI_D)
    return p;
  size_t last = (size_t)job->sub.count * HETAB_MERL_PHI_D - 1;
  return job->options->sampling == HETAB_MERL_EDGE ? last + 1 - p : last - p;
}

static size_t phi_samples(const merl_job *job) {
  size_t half = (size_t)job->sub.count * HETAB_MERL_PHI_D / 2;
  return job->options->sampling == HETAB_MERL_EDGE ? half + 1 : half;
}

/* mu_i = cos(theta_h) cos(theta_d) - sin(theta_h) sin(theta_d) cos(phi_d), and mu_r with +: in
 * double, for both vanish at the horizon. */
static void fill_cosines(const merl_job *job, const double *cos_phi, double theta_h, double theta_d,
                         double *mu_i, double *mu_r) {
  double even = cos(theta_h) * cos(theta_d), odd = sin(theta_h) * sin(theta_d);
  for (size_t p = 0; p < job->stride; p++) {
    mu_i[p] = p < job->phi_samples ? even - odd * cos_phi[p] : -1.0;
    mu_r[p] = p < job->phi_samples ? even + odd * cos_phi[p] : -1.0;
  }
}

/* The rows' tables for one offset within the cells along theta_h and theta_d. */
static hetab_status upload_frame(merl_job *job, double offset_h, double offset_d) {
  const hetab_lane *lane = &job->engine->lanes[0];
  hetab_status status = HETAB_ERR_MEMORY;
  double *frame = hetab_alloc(job->ctx, ROWS, HETAB_FRAME_REALS * sizeof *frame);
  double *mu_i = hetab_alloc(job->ctx, ROWS, job->stride * sizeof *mu_i);
  double *mu_r = hetab_alloc(job->ctx, ROWS, job->stride * sizeof *mu_r);
  double *cos_phi = hetab_alloc(job->ctx, job->phi_samples, sizeof *cos_phi);
  if (!frame || !mu_i || !mu_r || !cos_phi)
    goto done;
  for (size_t p = 0; p < job->phi_samples; p++) {
    double index = phi_index(job, p);
    cos_phi[p] = index == 0.5 * HETAB_MERL_PHI_D ? 0.0 : cos(phi_d_at(index));
  }
  for (size_t row = 0; row < ROWS; row++) {
    double theta_h = theta_h_at((double)(row / HETAB_MERL_THETA_D) + offset_h);
    double theta_d = theta_d_at((double)(row % HETAB_MERL_THETA_D) + offset_d);
    double lateral = 2.0 * cos(theta_d) * sin(theta_h), mu = 2.0 * cos(theta_h) * cos(theta_d);
    hetab_two_reals(job->engine, lateral * lateral, frame + row * HETAB_FRAME_REALS);
    frame[row * HETAB_FRAME_REALS + 2] = mu * mu;
    fill_cosines(job, cos_phi, theta_h, theta_d, mu_i + row * job->stride,
                 mu_r + row * job->stride);
  }
  HETAB_GOTO(hetab_lane_upload(job->ctx, job->engine, lane, frame, (size_t)ROWS * HETAB_FRAME_REALS,
                               &job->frame));
  HETAB_GOTO(hetab_lane_upload(job->ctx, job->engine, lane, mu_i, ROWS * job->stride, &job->mu_i));
  HETAB_GOTO(hetab_lane_upload(job->ctx, job->engine, lane, mu_r, ROWS * job->stride, &job->mu_r));
done:
  free(frame);
  free(mu_i);
  free(mu_r);
  free(cos_phi);
  return status;
}

static void release_frame(merl_job *job) {
  hetab_release(job->frame);
  hetab_release(job->mu_i);
  hetab_release(job->mu_r);
  job->frame = job->mu_i = job->mu_r = NULL;
}

static double tau_2sigma(const hetab_surface *surface) {
  return hetab_surface_tau_um(surface) / (2.0 * hetab_surface_sigma0_um(surface));
}

static double diffuse_channel(const merl_job *job, int channel) {
  double sum = 0.0;
  for (size_t w = 0; w < job->band_count; w++)
    sum += job->weights[w][channel] * job->bands[w].diffuse_brdf;
  return sum;
}

static hetab_status run_kernel(merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  double start = hetab_seconds();
  hetab_args args = {job->ctx, job->engine, lane, job->kernel, 0, HETAB_OK};
  hetab_arg_mem(&args, job->waves_buffer);
  hetab_arg_int(&args, job->band_count);
  hetab_arg_real(&args, tau_2sigma(job->surface));
  for (int c = 0; c < CHANNELS; c++)
    hetab_arg_real(&args, diffuse_channel(job, c));
  hetab_arg_mem(&args, job->frame);
  hetab_arg_mem(&args, job->mu_i);
  hetab_arg_mem(&args, job->mu_r);
  hetab_arg_int(&args, ROWS);
  hetab_arg_int(&args, job->stride);
  hetab_arg_mem(&args, job->panels);
  hetab_arg_mem(&args, job->segments);
  hetab_arg_mem(&args, job->coefficients);
  hetab_arg_int(&args, job->atlas.panel_count);
  hetab_arg_int(&args, (size_t)job->atlas.first_panel);
  hetab_arg_mem(&args, job->channels);
  HETAB_TRY(args.status);
  HETAB_TRY(hetab_lane_run_rows(job->ctx, lane, job->kernel, ROWS));
  job->kernel_seconds += hetab_seconds() - start;
  return HETAB_OK;
}

/* Add the kernel's samples to their cells; those below the horizon do not count. */
static void accumulate(merl_job *job, const void *reals) {
  int is_double = job->engine->precision == HETAB_DOUBLE;
  for (size_t c = 0; c < CHANNELS; c++)
    for (size_t row = 0; row < ROWS; row++)
      for (size_t p = 0; p < (size_t)job->sub.count * HETAB_MERL_PHI_D; p++) {
        size_t at = (c * ROWS + row) * job->stride + mirrored(job, p);
        double value = is_double ? ((const double *)reals)[at] : (double)((const float *)reals)[at];
        size_t cell = row * HETAB_MERL_PHI_D + p / (size_t)job->sub.count;
        if (value < 0.0)
          continue;
        job->sum[c * HETAB_MERL_CELLS + cell] += value;
        job->valid[cell] = (unsigned char)(job->valid[cell] + (c == 0));
      }
}

static hetab_status collect(merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  cl_int error = CL_SUCCESS;
  size_t bytes = (size_t)CHANNELS * ROWS * job->stride * hetab_real_size(job->engine);
  void *reals = clEnqueueMapBuffer(lane->queue, job->channels, CL_TRUE, CL_MAP_READ, 0, bytes, 0,
                                   NULL, NULL, &error);
  HETAB_TRY(hetab_cl_check(job->ctx, error, "clEnqueueMapBuffer", lane->device));
  accumulate(job, reals);
  clEnqueueUnmapMemObject(lane->queue, job->channels, reals, 0, NULL, NULL);
  return hetab_cl_check(job->ctx, clFinish(lane->queue), "clFinish", lane->device);
}

static double samples_per_cell(const merl_job *job) {
  return (double)(job->sub.count * job->sub.count * job->sub.count);
}

static hetab_status evaluate_cells(merl_job *job) {
  double total = HETAB_MERL_CELLS * samples_per_cell(job) * (double)job->band_count, done = 0.0;
  double part = total / (double)(job->sub.count * job->sub.count);
  for (int h = 0; h < job->sub.count; h++)
    for (int d = 0; d < job->sub.count; d++) {
      hetab_status status = upload_frame(job, job->sub.offset[h], job->sub.offset[d]);
      if (status == HETAB_OK)
        status = run_kernel(job);
      if (status == HETAB_OK)
        status = collect(job);
      release_frame(job);
      HETAB_TRY(status);
      HETAB_TRY(hetab_progress(job->ctx, done += part, total));
    }
  return HETAB_OK;
}

/* --- colour ---------------------------------------------------------------------------------- */

/* The surface's own wavelengths for colour, else the bands that the options name. */
static hetab_status select_bands(merl_job *job) {
  const hetab_merl_options *o = job->options;
  size_t own = hetab_surface_band_count(job->surface);
  job->band_count = o->colour == HETAB_MERL_SRGB ? own : o->colour == HETAB_MERL_MONO ? 1 : 3;
  job->bands = hetab_alloc(job->ctx, job->band_count, sizeof *job->bands);
  if (!job->bands)
    return HETAB_ERR_MEMORY;
  for (size_t b = 0; b < job->band_count; b++) {
    if (o->colour == HETAB_MERL_SRGB)
      job->bands[b] = hetab_surface_bands(job->surface)[b];
    else
      HETAB_TRY(hetab_surface_at(job->ctx, job->surface, o->band_um[b], &job->bands[b]));
  }
  return HETAB_OK;
}

/* What each wavelength adds to each channel: X, Y, Z for colour, the channels themselves else. */
static hetab_status set_weights(merl_job *job) {
  size_t count = job->band_count;
  double *lambda_um = hetab_alloc(job->ctx, count, sizeof *lambda_um);
  job->weights = hetab_alloc(job->ctx, count, sizeof *job->weights);
  hetab_status status = lambda_um && job->weights ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t w = 0; lambda_um && w < count; w++)
    lambda_um[w] = job->bands[w].lambda_um;
  if (status == HETAB_OK && job->options->colour == HETAB_MERL_SRGB)
    status = hetab_xyz_weights(job->ctx, lambda_um, count, job->weights);
  else if (status == HETAB_OK)
    for (size_t c = 0; c < CHANNELS; c++)
      job->weights[count == 1 ? 0 : c][c] = 1.0;
  free(lambda_um);
  return status;
}

static hetab_status set_waves(merl_job *job) {
  size_t count = job->band_count;
  job->waves = hetab_alloc(job->ctx, count, HETAB_WAVE_REALS * sizeof *job->waves);
  if (!job->waves)
    return HETAB_ERR_MEMORY;
  for (size_t w = 0; w < count; w++) {
    double *row = job->waves + w * HETAB_WAVE_REALS;
    hetab_wave_row(job->engine, job->surface, &job->bands[w], row);
    memcpy(row + HETAB_WAVE_WEIGHTS, job->weights[w], sizeof job->weights[w]);
  }
  return HETAB_OK;
}

/* Channel sums to the table's RGB; 1 if a component was negative and became 0. */
static int to_rgb(const merl_job *job, const double channels[CHANNELS], double rgb[CHANNELS]) {
  int clamped = 0;
  if (job->options->colour == HETAB_MERL_SRGB)
    hetab_xyz_to_srgb(channels, rgb);
  else
    memcpy(rgb, channels, CHANNELS * sizeof *rgb);
  for (int c = 0; c < CHANNELS; c++)
    if (rgb[c] < 0.0) {
      rgb[c] = 0.0;
      clamped = 1;
    }
  return clamped;
}

/* The cone's lobe, in channels, at the cells of one theta_d. */
static hetab_status add_specular_cone(merl_job *job) {
  double lobe[HETAB_MERL_THETA_D][CHANNELS];
  int cone_rows = hetab_specular_cone_rows(job->options->specular_cone_deg);
  if (cone_rows == 0)
    return HETAB_OK;
  for (int d = 0; d < HETAB_MERL_THETA_D; d++) {
    double theta = theta_d_at(d + 0.5), per_energy = hetab_specular_cone_lobe(theta, cone_rows);
    hetab_direction direction = hetab_direction_at(theta, tau_2sigma(job->surface));
    memset(lobe[d], 0, sizeof lobe[d]);
    for (size_t w = 0; w < job->band_count; w++) {
      hetab_wave wave = hetab_wave_of(hetab_surface_sigma0_um(job->surface),
                                      hetab_surface_tau_um(job->surface), &job->bands[w]);
      double rho_s = hetab_specular(&direction, &wave);
      for (int c = 0; c < CHANNELS; c++)
        lobe[d][c] += job->weights[w][c] * rho_s * per_energy;
    }
  }
  for (size_t cell = 0; cell < (size_t)cone_rows * HETAB_MERL_THETA_D * HETAB_MERL_PHI_D; cell++)
    for (size_t c = 0; c < CHANNELS; c++)
      job->sum[c * HETAB_MERL_CELLS + cell] +=
          job->valid[cell] * lobe[cell / HETAB_MERL_PHI_D % HETAB_MERL_THETA_D][c];
  return HETAB_OK;
}

static size_t fill_table(const merl_job *job, hetab_merl *merl) {
  size_t clamped = 0;
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    double channels[CHANNELS], rgb[CHANNELS];
    if (!job->valid[cell])
      continue;
    for (size_t c = 0; c < CHANNELS; c++)
      channels[c] = job->sum[c * HETAB_MERL_CELLS + cell] / job->valid[cell];
    clamped += (size_t)to_rgb(job, channels, rgb);
    for (int c = 0; c < CHANNELS; c++)
      hetab_merl_channel(merl, c)[cell] = rgb[c];
  }
  return clamped;
}

/* --- measured error -------------------------------------------------------------------------- */

/* The literal reference of the channel sums at one sample; 0 if it is below the horizon. */
static int literal_channels(const merl_job *job, double theta_h, double theta_d, double phi_d,
                            double channels[CHANNELS]) {
  double lateral = sin(theta_d) * sin(phi_d);
  double forward = sin(theta_d) * cos(phi_d) * cos(theta_h), up = cos(theta_d) * sin(theta_h);
  double mu_i = cos(theta_h) * cos(theta_d) - sin(theta_h) * sin(theta_d) * cos(phi_d);
  double mu_r = cos(theta_h) * cos(theta_d) + sin(theta_h) * sin(theta_d) * cos(phi_d);
  if (mu_i <= 0.0 || mu_r <= 0.0)
    return 0;
  double xi = forward + up, xr = up - forward;
  hetab_point point = {.theta_i = atan2(hypot(xi, lateral), mu_i),
                       .theta_r = atan2(hypot(xr, lateral), mu_r),
                       .phi = atan2(-lateral, xr) - atan2(lateral, xi),
                       .sigma0_um = hetab_surface_sigma0_um(job->surface),
                       .tau_um = hetab_surface_tau_um(job->surface)};
  for (size_t w = 0; w < job->band_count; w++) {
    const hetab_band *band = &job->bands[w];
    point.lambda_um = band->lambda_um;
    point.n = band->n;
    point.k = band->k;
    point.diffuse_brdf = band->diffuse_brdf;
    double value = hetab_literal(&point).total;
    for (int c = 0; c < CHANNELS; c++)
      channels[c] += job->weights[w][c] * value;
  }
  return 1;
}

/* The literal reference of a cell's channel sums, before colour and cone. */
static void literal_cell(const merl_job *job, size_t cell, double channels[CHANNELS]) {
  size_t h = cell / (HETAB_MERL_THETA_D * HETAB_MERL_PHI_D);
  size_t d = cell / HETAB_MERL_PHI_D % HETAB_MERL_THETA_D, p = cell % HETAB_MERL_PHI_D;
  int valid = 0, n = job->sub.count;
  memset(channels, 0, CHANNELS * sizeof *channels);
  for (int s = 0; s < n * n * n; s++)
    valid += literal_channels(job, theta_h_at((double)h + job->sub.offset[s / (n * n)]),
                              theta_d_at((double)d + job->sub.offset[s / n % n]),
                              phi_d_at((double)p + job->sub.offset[s % n]), channels);
  for (int c = 0; c < CHANNELS && valid; c++)
    channels[c] /= valid;
}

/* Channel sums (X, Y, Z or the bands) of random cells above the horizon against the reference. */
static hetab_status measure_error(merl_job *job, hetab_error_stats *stats) {
  hetab_sample sample;
  HETAB_TRY(hetab_sample_create(job->ctx, job->options->samples, HETAB_MERL_CELLS,
                                job->options->seed, &sample));
  for (size_t s = 0; s < sample.count; s++) {
    size_t cell = (size_t)sample.positions[s];
    double channels[CHANNELS];
    if (!job->valid[cell])
      continue;
    literal_cell(job, cell, channels);
    /* one channel a cell: their errors are one */
    size_t c = s % CHANNELS;
    hetab_sample_add(&sample, job->sum[c * HETAB_MERL_CELLS + cell] / job->valid[cell],
                     channels[c]);
  }
  *stats = hetab_sample_finish(&sample);
  hetab_sample_clear(&sample);
  return HETAB_OK;
}

/* --- the job --------------------------------------------------------------------------------- */

/* The series method has no atlas: one unused number stands for each table. */
static hetab_status upload_no_atlas(merl_job *job) {
  static const double unused[1] = {0.0};
  cl_mem *const tables[] = {&job->panels, &job->segments, &job->coefficients};
  for (int t = 0; t < 3; t++)
    HETAB_TRY(
        hetab_lane_upload(job->ctx, job->engine, &job->engine->lanes[0], unused, 1, tables[t]));
  hetab_atlas_degrees(1e-3, job->engine->lanes[0].vector_width, &job->atlas);
  return HETAB_OK;
}

static hetab_status upload_atlas(merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  const hetab_atlas *a = &job->atlas;
  double *transposed;
  HETAB_TRY(hetab_engine_atlas(job->ctx, job->engine, job->waves, job->band_count,
                               tau_2sigma(job->surface), &job->atlas));
  HETAB_TRY(hetab_lane_upload(job->ctx, job->engine, lane, a->panels,
                              a->panel_count * HETAB_PANEL_REALS, &job->panels));
  HETAB_TRY(hetab_lane_upload(job->ctx, job->engine, lane, a->segments,
                              a->segment_count * HETAB_SEGMENT_REALS, &job->segments));
  HETAB_TRY(hetab_atlas_transpose(job->ctx, a, &transposed));
  hetab_status status = hetab_lane_upload(job->ctx, job->engine, lane, transposed,
                                          a->segment_count * (size_t)a->degree_x * (size_t)a->pad_g,
                                          &job->coefficients);
  free(transposed);
  return status;
}

static hetab_status prepare(merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  hetab_context *ctx = job->ctx;
  HETAB_TRY(hetab_check_surface(ctx, job->surface));
  HETAB_TRY(select_bands(job));
  HETAB_TRY(set_weights(job));
  HETAB_TRY(set_waves(job));
  job->sub = sub_samples_of(job->options->sampling);
  job->phi_samples = phi_samples(job);
  job->stride = (job->phi_samples + 15) / 16 * 16;
  job->sum = hetab_alloc(ctx, (size_t)CHANNELS * HETAB_MERL_CELLS, sizeof *job->sum);
  job->valid = hetab_alloc(ctx, HETAB_MERL_CELLS, 1);
  if (!job->sum || !job->valid)
    return HETAB_ERR_MEMORY;
  HETAB_TRY(job->engine->method == HETAB_METHOD_ROWS ? upload_atlas(job) : upload_no_atlas(job));
  HETAB_TRY(hetab_lane_kernel(ctx, job->engine, lane, &job->atlas, "half_diff", "hetab_k_half_diff",
                              &job->kernel));
  HETAB_TRY(hetab_lane_upload(ctx, job->engine, lane, job->waves,
                              job->band_count * HETAB_WAVE_REALS, &job->waves_buffer));
  return hetab_lane_output(ctx, job->engine, lane, (size_t)CHANNELS * ROWS * job->stride,
                           &job->channels);
}

static void clear(merl_job *job) {
  release_frame(job);
  hetab_release(job->waves_buffer);
  hetab_release(job->channels);
  hetab_release(job->panels);
  hetab_release(job->segments);
  hetab_release(job->coefficients);
  hetab_atlas_clear(&job->atlas);
  if (job->kernel)
    clReleaseKernel(job->kernel);
  free(job->bands);
  free(job->waves);
  free(job->weights);
  free(job->sum);
  free(job->valid);
}

hetab_status hetab_tabulate_merl(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_surface *surface, const hetab_merl_options *options,
                                 hetab_merl **out, hetab_report *report) {
  static const hetab_merl_options defaults = {.samples = 500};
  double start = hetab_seconds();
  hetab_status status;
  hetab_error_stats error = {0};
  merl_job job = {
      .ctx = ctx, .engine = engine, .surface = surface, .options = options ? options : &defaults};
  *out = NULL;
  if (!engine->lane_count)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "MERL tables are computed on a device; use another method than literal");
  HETAB_GOTO(prepare(&job));
  HETAB_GOTO(evaluate_cells(&job));
  HETAB_GOTO(measure_error(&job, &error));
  HETAB_GOTO(add_specular_cone(&job));
  HETAB_GOTO(hetab_merl_create(ctx, out));
  size_t clamped = fill_table(&job, *out);
  if (report) {
    *report = hetab_report_of(engine, engine->lanes[0].text);
    report->entries = (double)HETAB_MERL_CELLS * samples_per_cell(&job) * (double)job.band_count;
    report->kernel_seconds = job.kernel_seconds;
    report->wall_seconds = hetab_seconds() - start;
    report->error = error;
    report->clamped = clamped;
  }
done:
  clear(&job);
  return status;
}
