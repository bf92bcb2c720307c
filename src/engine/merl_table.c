/* MERL tables: cells on the device, in the half/difference frame, and the job as a whole. */
#include <hetab/tabulate.h>

#include <math.h>
#include <stdlib.h>

#include "core/option_size.h"
#include "core/clock.h"
#include "engine/dense.h"
#include "engine/merl_job.h"
#include "kernels/tables.h"
#include "model/fold.h"
#include "model/limits.h"

enum { ROWS = HETAB_MERL_THETA_H * HETAB_MERL_THETA_D };

static hetab_sub_samples sub_samples_of(hetab_merl_sampling sampling) {
  if (sampling == HETAB_MERL_EDGE)
    return (hetab_sub_samples){1, {0.0}};
  if (sampling == HETAB_MERL_CENTRE)
    return (hetab_sub_samples){1, {0.5}};
  return (hetab_sub_samples){HETAB_MERL_SUBSAMPLES, {1.0 / 6.0, 0.5, 5.0 / 6.0}};
}

/* phi_d and 180 - phi_d swap the two directions, which changes nothing (reciprocity and the plane
 * of incidence's symmetry): only samples up to 90 degrees are computed. */
static double phi_index(const hetab_merl_job *job, size_t sample) {
  size_t n = (size_t)job->sub.count;
  return (double)(sample / n) + job->sub.offset[sample % n];
}

/* The computed sample that equals sample number p of the whole row. */
static size_t mirrored(const hetab_merl_job *job, size_t p) {
  if (phi_index(job, p) <= 0.5 * HETAB_MERL_PHI_D)
    return p;
  size_t last = (size_t)job->sub.count * HETAB_MERL_PHI_D - 1;
  return job->options->sampling == HETAB_MERL_EDGE ? last + 1 - p : last - p;
}

static size_t phi_samples(const hetab_merl_job *job) {
  size_t half = (size_t)job->sub.count * HETAB_MERL_PHI_D / 2;
  return job->options->sampling == HETAB_MERL_EDGE ? half + 1 : half;
}

/* mu_i = cos(theta_h) cos(theta_d) - sin(theta_h) sin(theta_d) cos(phi_d), and mu_r with +: in
 * double, for both vanish at the horizon. */
static void fill_cosines(const hetab_merl_job *job, const double *cos_phi, double theta_h,
                         double theta_d, double *mu_i, double *mu_r) {
  double even = cos(theta_h) * cos(theta_d), odd = sin(theta_h) * sin(theta_d);
  for (size_t p = 0; p < job->stride; p++) {
    mu_i[p] = p < job->phi_samples ? even - odd * cos_phi[p] : -1.0;
    mu_r[p] = p < job->phi_samples ? even + odd * cos_phi[p] : -1.0;
  }
}

/* The rows' tables for one offset within the cells along theta_h and theta_d. */
static hetab_status upload_frame(hetab_merl_job *job, double offset_h, double offset_d) {
  const hetab_lane *lane = &job->engine->lanes[0];
  HETAB_FREED double *frame = hetab_alloc(job->ctx, ROWS, HETAB_FRAME_REALS * sizeof *frame);
  HETAB_FREED double *mu_i = hetab_alloc(job->ctx, ROWS, job->stride * sizeof *mu_i);
  HETAB_FREED double *mu_r = hetab_alloc(job->ctx, ROWS, job->stride * sizeof *mu_r);
  HETAB_FREED double *cos_phi = hetab_alloc(job->ctx, job->phi_samples, sizeof *cos_phi);
  HETAB_NEED(frame && mu_i && mu_r && cos_phi);
  for (size_t p = 0; p < job->phi_samples; p++) {
    double index = phi_index(job, p);
    cos_phi[p] = index == 0.5 * HETAB_MERL_PHI_D
                     ? 0.0
                     : cos(hetab_merl_angles((hetab_merl_place){0.0, 0.0, index}).phi_d);
  }
  for (size_t row = 0; row < ROWS; row++) {
    hetab_half_diff at =
        hetab_merl_angles((hetab_merl_place){(double)(row / HETAB_MERL_THETA_D) + offset_h,
                                             (double)(row % HETAB_MERL_THETA_D) + offset_d, 0.0});
    double theta_h = at.theta_h, theta_d = at.theta_d;
    double lateral = 2.0 * cos(theta_d) * sin(theta_h), mu = 2.0 * cos(theta_h) * cos(theta_d);
    hetab_two_reals(job->engine, lateral * lateral, frame + row * HETAB_FRAME_REALS);
    frame[row * HETAB_FRAME_REALS + HETAB_FRAME_MU2] = mu * mu;
    fill_cosines(job, cos_phi, theta_h, theta_d, mu_i + row * job->stride,
                 mu_r + row * job->stride);
  }
  HETAB_TRY(hetab_lane_upload(job->ctx, job->engine, lane, frame, (size_t)ROWS * HETAB_FRAME_REALS,
                              &job->frame));
  HETAB_TRY(hetab_lane_upload(job->ctx, job->engine, lane, mu_i, ROWS * job->stride, &job->mu_i));
  return hetab_lane_upload(job->ctx, job->engine, lane, mu_r, ROWS * job->stride, &job->mu_r);
}

static void release_frame(hetab_merl_job *job) {
  hetab_release(job->frame);
  hetab_release(job->mu_i);
  hetab_release(job->mu_r);
  job->frame = job->mu_i = job->mu_r = NULL;
}

static double diffuse_channel(const hetab_merl_job *job, int channel) {
  double sum = 0.0;
  for (size_t w = 0; w < job->band_count; w++)
    sum += job->weights[w][channel] * job->bands[w].diffuse_brdf;
  return sum;
}

/* One launch, or one for the atlas and one for the series. */
static hetab_status run_kernels(hetab_merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  size_t reals = (size_t)HETAB_MERL_CHANNELS * ROWS * job->stride;
  double start = hetab_seconds();
  hetab_output_return(&job->channels);
  for (int k = 0; k < 2 && job->kernels[k]; k++) {
    hetab_args args = {job->ctx, job->engine, lane, job->kernels[k], 0, HETAB_OK};
    hetab_arg_mem(&args, job->waves_buffer);
    hetab_arg_int(&args, job->band_count);
    hetab_arg_real(&args, hetab_tau_2sigma(job->surface));
    for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
      hetab_arg_real(&args, diffuse_channel(job, c));
    hetab_arg_mem(&args, job->frame);
    hetab_arg_mem(&args, job->mu_i);
    hetab_arg_mem(&args, job->mu_r);
    hetab_arg_int(&args, ROWS);
    hetab_arg_int(&args, job->stride);
    hetab_arg_mem(&args, job->atlas_buffers.panels);
    hetab_arg_mem(&args, job->atlas_buffers.segments);
    hetab_arg_mem(&args, job->atlas_buffers.coefficients);
    hetab_arg_int(&args, job->atlas.panel_count);
    hetab_arg_int(&args, (size_t)job->atlas.first_panel);
    hetab_arg_mem(&args, job->channels.buffer);
    HETAB_TRY(hetab_lane_run_rows(&args, ROWS, lane->shape->cell_items, NULL));
  }
  HETAB_TRY(hetab_output_fetch(job->ctx, job->engine, reals, &job->channels));
  HETAB_TRY(hetab_output_wait(job->ctx, &job->channels));
  job->kernel_seconds += hetab_seconds() - start;
  return HETAB_OK;
}

/* Add the kernel's samples to their cells; those below the horizon do not count. */
static void accumulate(hetab_merl_job *job, const void *reals) {
  for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
    for (size_t row = 0; row < ROWS; row++)
      for (size_t p = 0; p < (size_t)job->sub.count * HETAB_MERL_PHI_D; p++) {
        size_t at = (c * ROWS + row) * job->stride + mirrored(job, p);
        double value = hetab_real_at(job->engine, reals, at);
        size_t cell = row * HETAB_MERL_PHI_D + p / (size_t)job->sub.count;
        if (value < 0.0)
          continue;
        job->sum[c * HETAB_MERL_CELLS + cell] += value;
        job->valid[cell] = (unsigned char)(job->valid[cell] + (c == 0));
      }
}

static double samples_per_cell(const hetab_merl_job *job) {
  return (double)(job->sub.count * job->sub.count * job->sub.count);
}

static hetab_status evaluate_cells(hetab_merl_job *job) {
  double total = HETAB_MERL_CELLS * samples_per_cell(job) * (double)job->band_count, done = 0.0;
  double part = total / (double)(job->sub.count * job->sub.count);
  for (int h = 0; h < job->sub.count; h++)
    for (int d = 0; d < job->sub.count; d++) {
      hetab_status status = upload_frame(job, job->sub.offset[h], job->sub.offset[d]);
      if (status == HETAB_OK)
        status = run_kernels(job);
      if (status == HETAB_OK)
        accumulate(job, job->channels.values);
      release_frame(job);
      HETAB_TRY(status);
      HETAB_TRY(hetab_progress(job->ctx, done += part, total));
    }
  return HETAB_OK;
}

/* The series method has no atlas: one unused number stands for each table. */
static hetab_status upload_no_atlas(hetab_merl_job *job) {
  static const double unused[1] = {0.0};
  hetab_atlas_buffers *b = &job->atlas_buffers;
  cl_mem *const tables[] = {&b->panels, &b->segments, &b->coefficients};
  for (int t = 0; t < 3; t++)
    HETAB_TRY(
        hetab_lane_upload(job->ctx, job->engine, &job->engine->lanes[0], unused, 1, tables[t]));
  hetab_atlas_degrees(1e-3, job->engine->lanes[0].vector_width, &job->atlas);
  return HETAB_OK;
}

static hetab_status upload_atlas(hetab_merl_job *job) {
  HETAB_FREED double *transposed = NULL;
  HETAB_TRY(hetab_engine_atlas(job->ctx, job->engine, job->waves, job->band_count,
                               hetab_tau_2sigma(job->surface), &job->atlas));
  HETAB_TRY(hetab_atlas_transpose(job->ctx, &job->atlas, &transposed));
  size_t table = (size_t)job->atlas.degree_x * (size_t)job->atlas.pad_g;
  return hetab_lane_upload_atlas(job->ctx, job->engine, &job->engine->lanes[0], &job->atlas,
                                 transposed, table, &job->atlas_buffers);
}

static hetab_status build_kernels(hetab_merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  hetab_build build = {.program = "half_diff",
                       .kernel = "hetab_k_half_diff",
                       .atlas = &job->atlas,
                       .row_items = lane->shape->cell_items,
                       .parts = lane->shape->apart ? HETAB_PART_ATLAS : 0};
  HETAB_TRY(hetab_lane_kernel(job->ctx, job->engine, lane, &build, &job->kernels[0]));
  build.parts = HETAB_PART_SERIES;
  return !lane->shape->apart
             ? HETAB_OK
             : hetab_lane_kernel(job->ctx, job->engine, lane, &build, &job->kernels[1]);
}

static hetab_status prepare(hetab_merl_job *job) {
  const hetab_lane *lane = &job->engine->lanes[0];
  hetab_context *ctx = job->ctx;
  HETAB_TRY(hetab_check_surface(ctx, job->surface));
  HETAB_TRY(hetab_fold_check(ctx, job->options->specular_cone,
                             hetab_merl_angles((hetab_merl_place){2.0, 0.0, 0.0}).theta_h,
                             "MERL's cells"));
  HETAB_TRY(hetab_merl_job_bands(job));
  job->sub = sub_samples_of(job->options->sampling);
  job->phi_samples = phi_samples(job);
  job->stride = (job->phi_samples + 15) / 16 * 16;
  job->sum = hetab_alloc(ctx, (size_t)HETAB_MERL_CHANNELS * HETAB_MERL_CELLS, sizeof *job->sum);
  job->valid = hetab_alloc(ctx, HETAB_MERL_CELLS, 1);
  HETAB_NEED(job->sum && job->valid);
  HETAB_TRY(job->engine->method == HETAB_METHOD_ROWS ? upload_atlas(job) : upload_no_atlas(job));
  HETAB_TRY(build_kernels(job));
  HETAB_TRY(hetab_lane_upload(ctx, job->engine, lane, job->waves,
                              job->band_count * HETAB_WAVE_REALS, &job->waves_buffer));
  return hetab_output_create(ctx, job->engine, lane,
                             (size_t)HETAB_MERL_CHANNELS * ROWS * job->stride, &job->channels);
}

static void clear(hetab_merl_job *job) {
  release_frame(job);
  hetab_release(job->waves_buffer);
  hetab_output_free(&job->channels);
  hetab_atlas_release(&job->atlas_buffers);
  hetab_atlas_clear(&job->atlas);
  for (int k = 0; k < 2; k++)
    if (job->kernels[k])
      clReleaseKernel(job->kernels[k]);
  free(job->bands);
  free(job->waves);
  free(job->weights);
  free(job->sum);
  free(job->valid);
}

hetab_status hetab_tabulate_merl(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_surface *surface, const hetab_merl_options *options,
                                 hetab_merl **out, hetab_report *report) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_merl_options, o, options);
  o.samples = o.samples == HETAB_NO_SAMPLES ? 0 : o.samples ? o.samples : 500;
  double start = hetab_seconds();
  hetab_error_stats error = {0};
  HETAB_ENDS(clear)
  hetab_merl_job job = {.ctx = ctx, .engine = engine, .surface = surface, .options = &o};
  if (!engine->lane_count)
    return hetab_fail(ctx, HETAB_ERR_UNSUPPORTED,
                      "MERL tables are computed on a device; use another method than literal");
  HETAB_TRY(prepare(&job));
  HETAB_TRY(evaluate_cells(&job));
  HETAB_TRY(hetab_merl_job_error(&job, &error));
  HETAB_TRY(hetab_merl_job_add_cone(&job));
  HETAB_TRY(hetab_merl_create(ctx, out));
  size_t clamped = hetab_merl_job_fill(&job, *out);
  hetab_merl_set_specular_cone(*out, o.specular_cone);
  if (report) {
    *report = hetab_report_of(engine, engine->lanes[0].text);
    report->entries = (double)HETAB_MERL_CELLS * samples_per_cell(&job) * (double)job.band_count;
    report->kernel_seconds = job.kernel_seconds;
    report->wall_seconds = hetab_seconds() - start;
    report->error = error;
    report->clamped = clamped;
  }
  return HETAB_OK;
}
