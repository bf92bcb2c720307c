/* MERL and RGL tables. MERL: 1,458,000 cells are more than a fit needs, and their incidences are
 * all different. Here are the directions of a gonioreflectometer, interpolated between the cells'
 * centres. */
#include <math.h>

#include <hetab/merl.h>
#include <hetab/rgl.h>

#include "measured/measurement_sheet.h"
#include "table/merl_frame.h"

HETAB_HANDLE(hetab_merl)
HETAB_HANDLE(hetab_rgl)

enum { CHANNELS = HETAB_MERL_CHANNELS, MOST_CHANNELS = 4096 };

/* In degrees; theta_r every 2.5 so that every theta_i has its mirror direction. */
enum { THETA_I_STEP = 10, THETA_I_END = 80, THETA_R_END = 85, PHI_STEP = 15 };
static const double theta_r_step = 2.5;

/* ---- directions ---------------------------------------------------------------------------- */

/* What a table holds at a pair of directions. */
typedef void (*table_at)(const void *table, const hetab_measured_angles *angles, double *values);

static void merl_at(const void *table, const hetab_measured_angles *angles, double *values) {
  hetab_half_diff half = hetab_half_diff_of(angles->theta_i, angles->theta_r, angles->phi_r);
  if (!hetab_merl_read_interpolated(table, hetab_merl_place_of(half), values))
    for (int c = 0; c < CHANNELS; c++)
      values[c] = (double)NAN;
}

static void rgl_at(const void *table, const hetab_measured_angles *a, double *values) {
  float wi[3] = {(float)sin(a->theta_i), 0, (float)cos(a->theta_i)}, found[MOST_CHANNELS];
  float wo[3] = {(float)(sin(a->theta_r) * cos(a->phi_r)), (float)(sin(a->theta_r) * sin(a->phi_r)),
                 (float)cos(a->theta_r)};
  hetab_rgl_eval(table, wi, wo, found);
  for (size_t c = 0; c < hetab_rgl_channel_count(table); c++)
    values[c] = (double)found[c];
}

static hetab_status add_incidence(hetab_sheet *sheet, table_at at, const void *table,
                                  double theta_i_deg) {
  double values[MOST_CHANNELS];
  for (double theta_r = 0; theta_r <= THETA_R_END; theta_r += theta_r_step) {
    /* At the normal every azimuth is the same direction. */
    int first = theta_i_deg == 0 || theta_r == 0 ? 180 : 0;
    for (int phi = first; phi <= 180; phi += PHI_STEP) {
      hetab_measured_angles angles = {theta_i_deg * M_PI / 180, 0, theta_r * M_PI / 180,
                                      phi * M_PI / 180};
      at(table, &angles, values);
      HETAB_TRY(hetab_sheet_add(sheet, &angles, values));
    }
  }
  return HETAB_OK;
}

static hetab_status sample(hetab_sheet *sheet, table_at at, const void *table,
                           const double *lambda_um, size_t channels) {
  HETAB_TRY(hetab_sheet_begin(sheet, lambda_um ? lambda_um : hetab_rgb_um, channels));
  for (int theta_i = 0; theta_i <= THETA_I_END; theta_i += THETA_I_STEP)
    HETAB_TRY(add_incidence(sheet, at, table, theta_i));
  return HETAB_OK;
}

hetab_status hetab_measurements_read_merl(hetab_sheet *sheet) {
  HETAB_ENDS(hetab_merl_end) hetab_merl *merl = NULL;
  HETAB_TRY(hetab_merl_load(sheet->ctx, sheet->path, &merl));
  return sample(sheet, merl_at, merl, NULL, CHANNELS);
}

hetab_status hetab_measurements_read_rgl(hetab_sheet *sheet) {
  HETAB_ENDS(hetab_rgl_end) hetab_rgl *rgl = NULL;
  HETAB_TRY(hetab_rgl_load(sheet->ctx, sheet->path, &rgl));
  return sample(sheet, rgl_at, rgl, hetab_rgl_wavelengths_um(rgl), hetab_rgl_channel_count(rgl));
}
