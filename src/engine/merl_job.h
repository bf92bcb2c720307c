/* A MERL table in the making, shared by what evaluates it, colours it and measures its error. */
#pragma once

#include <hetab/tabulate.h>

#include "engine/engine_internal.h"
#include "table/merl_frame.h"

enum { HETAB_MERL_SUBSAMPLES = 3 };

/* Where in a cell samples lie: offsets in [0, 1] of the cell's index range. */
typedef struct hetab_sub_samples {
  int count;
  double offset[HETAB_MERL_SUBSAMPLES];
} hetab_sub_samples;

typedef struct hetab_merl_job {
  hetab_context *ctx;
  const hetab_engine *engine;
  const hetab_surface *surface;
  hetab_band *bands; /* [band_count]: what is summed */
  size_t band_count;
  const hetab_merl_options *options;
  hetab_sub_samples sub;
  size_t phi_samples; /* along phi_d, up to 90 degrees: the rest mirrors them */
  size_t stride;      /* the same, padded */
  hetab_atlas atlas;
  double *waves; /* [wavelength][HETAB_WAVE_REALS], the weights among them */
  double (*weights)[HETAB_MERL_CHANNELS];
  cl_kernel kernels[2]; /* the second may be NULL: the series, where it is apart */
  cl_mem waves_buffer, frame, mu_i, mu_r;
  hetab_output channels;
  hetab_atlas_buffers atlas_buffers;
  double kernel_seconds;
  double *sum;          /* [channel][cell], of valid samples */
  unsigned char *valid; /* [cell], how many */
} hetab_merl_job;

/* Bands, their weights in the channels, and the kernels' rows of them. */
hetab_status hetab_merl_job_bands(hetab_merl_job *job);
/* The specular delta as a lobe, added to the sums of valid cells. */
hetab_status hetab_merl_job_add_cone(hetab_merl_job *job);
/* Sums to colours: the table's cells. How many have a component that was negative and became 0. */
size_t hetab_merl_job_fill(const hetab_merl_job *job, hetab_merl *merl);

/* Channel sums (X, Y, Z or the bands) of random cells above the horizon against the literal
 * reference. */
hetab_status hetab_merl_job_error(hetab_merl_job *job, hetab_error_stats *stats);
