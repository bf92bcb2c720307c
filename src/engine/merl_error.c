/* MERL tables: the error against the printed equations, on a sample. */
#include <math.h>
#include <string.h>

#include "engine/merl_job.h"
#include "engine/sample.h"
#include "model/model.h"

/* The literal reference of the channel sums at one sample; 0 if it is below the horizon. */
static int literal_channels(const hetab_merl_job *job, double theta_h, double theta_d, double phi_d,
                            double channels[HETAB_MERL_CHANNELS]) {
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
    for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
      channels[c] += job->weights[w][c] * value;
  }
  return 1;
}

/* The literal reference of a cell's channel sums, before colour and cone. */
static void literal_cell(const hetab_merl_job *job, size_t cell,
                         double channels[HETAB_MERL_CHANNELS]) {
  size_t h = cell / (HETAB_MERL_THETA_D * HETAB_MERL_PHI_D);
  size_t d = cell / HETAB_MERL_PHI_D % HETAB_MERL_THETA_D, p = cell % HETAB_MERL_PHI_D;
  int valid = 0, n = job->sub.count;
  memset(channels, 0, HETAB_MERL_CHANNELS * sizeof *channels);
  for (int s = 0; s < n * n * n; s++)
    valid += literal_channels(job, hetab_merl_theta_h((double)h + job->sub.offset[s / (n * n)]),
                              hetab_merl_theta_d((double)d + job->sub.offset[s / n % n]),
                              hetab_merl_phi_d((double)p + job->sub.offset[s % n]), channels);
  for (int c = 0; c < HETAB_MERL_CHANNELS && valid; c++)
    channels[c] /= valid;
}

hetab_status hetab_merl_job_error(hetab_merl_job *job, hetab_error_stats *stats) {
  hetab_sample sample;
  HETAB_TRY(hetab_sample_create(job->ctx, job->options->samples, HETAB_MERL_CELLS,
                                job->options->seed, &sample));
  for (size_t s = 0; s < sample.count; s++) {
    size_t cell = (size_t)sample.positions[s];
    double channels[HETAB_MERL_CHANNELS];
    if (!job->valid[cell])
      continue;
    literal_cell(job, cell, channels);
    /* one channel a cell: their errors are one */
    size_t c = s % HETAB_MERL_CHANNELS;
    hetab_sample_add(&sample, job->sum[c * HETAB_MERL_CELLS + cell] / job->valid[cell],
                     channels[c]);
  }
  *stats = hetab_sample_finish(&sample);
  hetab_sample_clear(&sample);
  return HETAB_OK;
}
