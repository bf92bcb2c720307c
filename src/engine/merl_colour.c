/* MERL tables: from bands to channels, and from their sums to colours. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/dense.h"
#include "engine/merl_job.h"
#include "kernels/tables.h"
#include "model/colour.h"

/* The surface's own wavelengths for colour, else the bands that the options name. */
static hetab_status select_bands(hetab_merl_job *job) {
  const hetab_merl_options *o = job->options;
  size_t own = hetab_surface_band_count(job->surface);
  job->band_count = o->colour == HETAB_MERL_SRGB ? own : o->colour == HETAB_MERL_MONO ? 1 : 3;
  job->bands = hetab_alloc(job->ctx, job->band_count, sizeof *job->bands);
  HETAB_NEED(job->bands);
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
  HETAB_FREED double *lambda_um = hetab_alloc(job->ctx, count, sizeof *lambda_um);
  job->weights = hetab_alloc(job->ctx, count, sizeof *job->weights);
  hetab_status status = lambda_um && job->weights ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t w = 0; lambda_um && w < count; w++)
    lambda_um[w] = job->bands[w].lambda_um;
  if (status == HETAB_OK && job->options->colour == HETAB_MERL_SRGB)
    status = hetab_xyz_weights(job->ctx, lambda_um, count, job->weights);
  else if (status == HETAB_OK)
    for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
      job->weights[count == 1 ? 0 : c][c] = 1.0;
  return status;
}

static hetab_status set_waves(hetab_merl_job *job) {
  size_t count = job->band_count;
  job->waves = hetab_alloc(job->ctx, count, HETAB_WAVE_REALS * sizeof *job->waves);
  HETAB_NEED(job->waves);
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
