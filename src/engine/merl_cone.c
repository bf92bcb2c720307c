/* MERL tables: the specular delta as a lobe, in cells and as it is read from them. */
#include <math.h>
#include <string.h>

#include <hetab/host_model.h>

#include "core/option_size.h"
#include "engine/merl_job.h"
#include "model/fold.h"

enum { ROW = HETAB_MERL_THETA_D * HETAB_MERL_PHI_D };
enum { PARTS = 6, SPOKES = 360 }; /* of a row; of half a ring */

static double theta_h_of_row(double row) {
  return hetab_merl_angles((hetab_merl_place){row, 0.0, 0.0}).theta_h;
}

/* The rows that a cone reaches into: whole ones, for readers truncate. */
static size_t cone_rows(double cone) {
  hetab_merl_place end = hetab_merl_place_of((hetab_half_diff){cone, 0.0, 0.0});
  double rows = ceil(fmin(end.h, HETAB_MERL_THETA_H) - 1e-9);
  return rows < 1.0 ? 1 : (size_t)rows;
}

static double sin2_of_row(double row) {
  return pow(sin(theta_h_of_row(row)), 2.0);
}

/* sin^2(theta_h) at which a row's cells hold the lobe. The middle of theta_h would leave readers
 * who truncate 1 % too much, the mean over the cell those who interpolate as much too little:
 * halfway. */
static double lobe_place(size_t row) {
  double edges = 0.5 * (sin2_of_row((double)row) + sin2_of_row((double)row + 1.0));
  return 0.5 * (edges + sin2_of_row((double)row + 0.5));
}

/* The lobe that fills whole rows. */
static hetab_status create_fold(hetab_context *ctx, const hetab_surface *surface,
                                const hetab_band *bands, size_t count, double cone,
                                hetab_fold **out) {
  return hetab_fold_create(ctx, surface, bands, count, theta_h_of_row((double)cone_rows(cone)),
                           out);
}

/* The lobe in a cell, added to `bands`; false: its middle is below the horizon. phi_d and
 * 180 - phi_d are one, to the last bit. */
static bool lobe_in(const hetab_fold *fold, size_t cell, double *bands) {
  size_t p = cell % HETAB_MERL_PHI_D, mirrored = HETAB_MERL_PHI_D - 1 - p;
  hetab_half_diff middle = hetab_merl_middle(cell - p + (p < mirrored ? p : mirrored));
  hetab_merl_pair pair;
  if (!hetab_merl_pair_of(middle, &pair))
    return false;
  hetab_fold_add(fold, pair.at.theta_i, pair.at.theta_r, lobe_place(cell / ROW), bands);
  return true;
}

/* ---- into the job's cells ------------------------------------------------------------------ */

/* Times the samples that it is added to. */
static void add_lobe(hetab_merl_job *job, const hetab_fold *fold, size_t cell, double *bands) {
  memset(bands, 0, job->band_count * sizeof *bands);
  if (!job->valid[cell] || !lobe_in(fold, cell, bands))
    return;
  for (size_t w = 0; w < job->band_count; w++)
    for (size_t c = 0; c < HETAB_MERL_CHANNELS; c++)
      job->sum[c * HETAB_MERL_CELLS + cell] += job->valid[cell] * job->weights[w][c] * bands[w];
}

hetab_status hetab_merl_job_add_cone(hetab_merl_job *job) {
  hetab_fold *fold;
  double cone = job->options->specular_cone;
  if (!(cone > 0.0))
    return HETAB_OK;
  HETAB_FREED double *bands = hetab_alloc(job->ctx, job->band_count, sizeof *bands);
  HETAB_NEED(bands);
  HETAB_TRY(create_fold(job->ctx, job->surface, job->bands, job->band_count, cone, &fold));
  for (size_t cell = 0; cell < cone_rows(cone) * ROW; cell++)
    add_lobe(job, fold, cell, bands);
  hetab_fold_free(fold);
  return HETAB_OK;
}

/* ---- as it is read ------------------------------------------------------------------------- */

/* A table of nothing but the lobe, of one band. */
static hetab_status fill_lobe(hetab_context *ctx, const hetab_surface *surface,
                              const hetab_band *band, double cone, hetab_merl *merl) {
  hetab_fold *fold;
  HETAB_TRY(create_fold(ctx, surface, band, 1, cone, &fold));
  for (size_t cell = 0; cell < cone_rows(cone) * ROW; cell++) {
    double value = 0.0;
    bool above = lobe_in(fold, cell, &value);
    for (int c = 0; c < HETAB_MERL_CHANNELS && above; c++)
      hetab_merl_channel(merl, c)[cell] = value;
  }
  hetab_fold_free(fold);
  return HETAB_OK;
}

/* Of half a ring of half vectors, per solid angle of them: dr = 4 (i.h) dh. */
static double read_ring(const hetab_merl *merl, double theta_i, double h) {
  double s = sin(theta_i), c = cos(theta_i), theta_h = theta_h_of_row(h), sum = 0.0;
  for (int spoke = 0; spoke < SPOKES; spoke++) {
    double phi = M_PI * (spoke + 0.5) / SPOKES, rgb[HETAB_MERL_CHANNELS];
    double i_h = c * cos(theta_h) + s * sin(theta_h) * cos(phi);
    double mu_r = 2.0 * i_h * cos(theta_h) - c;
    if (!(i_h > 0.0 && mu_r > 0.0))
      continue;
    hetab_half_diff at = {theta_h, acos(fmin(i_h, 1.0)),
                          atan2(s * sin(phi), s * cos(phi) * cos(theta_h) - c * sin(theta_h))};
    hetab_merl_place place = hetab_merl_place_of(at);
    place.h = h;
    hetab_merl_read_truncated(merl, place, rgb);
    sum += rgb[0] * 4.0 * i_h * mu_r / SPOKES;
  }
  return sum;
}

static double read_lobe(const hetab_merl *merl, double theta_i, size_t rows) {
  double sum = 0.0;
  for (size_t part = 0; part < rows * PARTS; part++) {
    double from = (double)part / PARTS, to = (double)(part + 1) / PARTS;
    double solid_angle = 2.0 * M_PI * (cos(theta_h_of_row(from)) - cos(theta_h_of_row(to)));
    sum += solid_angle * read_ring(merl, theta_i, 0.5 * (from + to));
  }
  return sum;
}

hetab_status hetab_merl_cone_read(hetab_context *ctx, const hetab_surface *surface,
                                  const hetab_merl_options *options, const double *theta_i,
                                  size_t count, double *rho_s, double *read) {
  HETAB_OPTIONS(ctx, hetab_merl_options, o, options);
  hetab_band band;
  hetab_merl *merl;
  HETAB_TRY(
      hetab_surface_at(ctx, surface, o.colour == HETAB_MERL_SRGB ? 0.7 : o.band_um[0], &band));
  HETAB_TRY(hetab_merl_create(ctx, &merl));
  hetab_specular_of_bands(surface, &band, 1, theta_i, count, rho_s);
  hetab_status status = fill_lobe(ctx, surface, &band, o.specular_cone, merl);
  for (size_t i = 0; i < count && status == HETAB_OK; i++)
    read[i] = read_lobe(merl, theta_i[i], cone_rows(o.specular_cone));
  hetab_merl_free(merl);
  return status;
}
