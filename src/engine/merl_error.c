/* MERL tables: the error against the printed equations, on a sample. */
#include <string.h>

#include "engine/merl_job.h"
#include "engine/sample.h"
#include "model/model.h"

/* The literal reference of the channel sums at one sample; 0 if it is below the horizon. */
static int literal_channels(const hetab_merl_job *job, hetab_merl_place place,
                            double channels[HETAB_MERL_CHANNELS]) {
  hetab_merl_pair pair;
  if (!hetab_merl_pair_of(hetab_merl_angles(place), &pair))
    return 0;
  hetab_point point = {.theta_i = pair.at.theta_i,
                       .theta_r = pair.at.theta_r,
                       .phi = pair.at.phi,
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
    valid += literal_channels(job,
                              (hetab_merl_place){(double)h + job->sub.offset[s / (n * n)],
                                                 (double)d + job->sub.offset[s / n % n],
                                                 (double)p + job->sub.offset[s % n]},
                              channels);
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
