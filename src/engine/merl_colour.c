/* MERL tables: from bands to channels, and from their sums to colours. */
#include <stdlib.h>
#include <string.h>

#include "engine/dense.h"
#include "engine/merl_job.h"
#include "engine/specular_cone.h"
#include "kernels/tables.h"
#include "model/colour.h"
#include "model/model.h"

/* The surface's own wavelengths for colour, else the bands that the options name. */
static hetab_status select_bands(hetab_merl_job *job) {
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
static hetab_status set_weights(hetab_merl_job *job) {
  size_t count = job->band_count;
  double *lambda_um = hetab_alloc(job->ctx, count, sizeof *lambda_um);
  job->weights = hetab_alloc(job->ctx, count, sizeof *job->weights);
  hetab_status status = lambda_um && job->weights ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t w = 0; lambda_um && w < count; w++)
    lambda_um[w] = job->bands[w].lambda_um;
  if (status == HETAB_OK && job->options->colour == HETAB_MERL_SRGB)
    status = hetab_xyz_weights(job->ctx, lambda_um, count, job->weights);
  else if (status == HETAB_OK)
    for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
      job->weights[count == 1 ? 0 : c][c] = 1.0;
  free(lambda_um);
  return status;
}

static hetab_status set_waves(hetab_merl_job *job) {
  size_t count = job->band_count;
  job->waves = hetab_alloc(job->ctx, count, HETAB_WAVE_REALS * sizeof *job->waves);
  if (!job->waves)
    return HETAB_ERR_MEMORY;
  for (size_t w = 0; w < count; w++) {
    double *row = job->waves + w * HETAB_WAVE_REALS;
    hetab_band_row(job->engine, job->surface, &job->bands[w], row);
    memcpy(row + HETAB_WAVE_WEIGHTS, job->weights[w], sizeof job->weights[w]);
  }
  return HETAB_OK;
}

/* Channel sums to the table's RGB; 1 if a component was negative and became 0. */
static int to_rgb(const hetab_merl_job *job, const double channels[HETAB_MERL_CHANNELS],
                  double rgb[HETAB_MERL_CHANNELS]) {
  int clamped = 0;
  if (job->options->colour == HETAB_MERL_SRGB)
    hetab_xyz_to_srgb(channels, rgb);
  else
    memcpy(rgb, channels, HETAB_MERL_CHANNELS * sizeof *rgb);
  for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
    if (rgb[c] < 0.0) {
      rgb[c] = 0.0;
      clamped = 1;
    }
  return clamped;
}

hetab_status hetab_merl_job_bands(hetab_merl_job *job) {
  HETAB_TRY(select_bands(job));
  HETAB_TRY(set_weights(job));
  return set_waves(job);
}

hetab_status hetab_merl_job_add_cone(hetab_merl_job *job) {
  double lobe[HETAB_MERL_THETA_D][HETAB_MERL_CHANNELS];
  int cone_rows = hetab_specular_cone_rows(job->options->specular_cone);
  if (cone_rows == 0)
    return HETAB_OK;
  for (int d = 0; d < HETAB_MERL_THETA_D; d++) {
    double theta = hetab_merl_theta_d(d + 0.5),
           per_energy = hetab_specular_cone_lobe(theta, cone_rows);
    hetab_direction direction = hetab_direction_at(theta, hetab_tau_2sigma(job->surface));
    memset(lobe[d], 0, sizeof lobe[d]);
    for (size_t w = 0; w < job->band_count; w++) {
      hetab_wave wave = hetab_wave_of(hetab_surface_sigma0_um(job->surface),
                                      hetab_surface_tau_um(job->surface), &job->bands[w]);
      double rho_s = hetab_specular(&direction, &wave);
      for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
        lobe[d][c] += job->weights[w][c] * rho_s * per_energy;
    }
  }
  for (size_t cell = 0; cell < (size_t)cone_rows * HETAB_MERL_THETA_D * HETAB_MERL_PHI_D; cell++)
    for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
      job->sum[c * HETAB_MERL_CELLS + cell] +=
          job->valid[cell] * lobe[cell / HETAB_MERL_PHI_D % HETAB_MERL_THETA_D][c];
  return HETAB_OK;
}

size_t hetab_merl_job_fill(const hetab_merl_job *job, hetab_merl *merl) {
  size_t clamped = 0;
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    double channels[HETAB_MERL_CHANNELS], rgb[HETAB_MERL_CHANNELS];
    if (!job->valid[cell])
      continue;
    for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
      channels[c] = job->sum[c * HETAB_MERL_CELLS + cell] / job->valid[cell];
    clamped += (size_t)to_rgb(job, channels, rgb);
    for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
      hetab_merl_channel(merl, c)[cell] = rgb[c];
  }
  return clamped;
}
