#include "model/colour.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

/* x-bar, y-bar, z-bar of the CIE 1931 2-degree standard observer and the relative spectral power of
 * CIE standard illuminant D65 (ISO/CIE 11664-1 and 11664-2), 400 to 700 nm in steps of 10 nm. */
enum { BANDS = 31, FIRST_NM = 400, STEP_NM = 10 };
static const double observer_d65[BANDS][4] = {
    {0.01431, 0.000396, 0.06785001, 82.7549},
    {0.04351, 0.00121, 0.2074, 91.486},
    {0.13438, 0.004, 0.6456, 93.4318},
    {0.2839, 0.0116, 1.3856, 86.6823},
    {0.34828, 0.023, 1.74706, 104.865},
    {0.3362, 0.038, 1.77211, 117.008},
    {0.2908, 0.06, 1.6692, 117.812},
    {0.19536, 0.09098, 1.28764, 114.861},
    {0.09564, 0.13902, 0.8129501, 115.923},
    {0.03201, 0.20802, 0.46518, 108.811},
    {0.0049, 0.323, 0.272, 109.354},
    {0.0093, 0.503, 0.1582, 107.802},
    {0.06327, 0.71, 0.07824999, 104.79},
    {0.1655, 0.862, 0.04216, 107.689},
    {0.2904, 0.954, 0.0203, 104.405},
    {0.4334499, 0.9949501, 0.008749999, 104.046},
    {0.5945, 0.995, 0.0039, 100},
    {0.7621, 0.952, 0.0021, 96.3342},
    {0.9163, 0.87, 0.001650001, 95.788},
    {1.0263, 0.757, 0.0011, 88.6856},
    {1.0622, 0.631, 0.0008, 90.0062},
    {1.0026, 0.503, 0.00034, 89.5991},
    {0.8544499, 0.381, 0.00019, 87.6987},
    {0.6424, 0.265, 4.999999e-05, 83.2886},
    {0.4479, 0.175, 2e-05, 83.6992},
    {0.2835, 0.107, 0, 80.0268},
    {0.1649, 0.061, 0, 80.2146},
    {0.0874, 0.032, 0, 82.2778},
    {0.04677, 0.017, 0, 78.2842},
    {0.0227, 0.00821, 0, 69.7213},
    {0.01135916, 0.004102, 0, 71.6091},
};

/* Of D65. */
static const double WHITE[3] = {0.950470, 1.0, 1.088830};

/* What to set wavelengths to is no remedy where none is visible. */
static hetab_status fail_cover(hetab_context *ctx, double first_nm, double last_nm,
                               double widest_nm) {
  char given[96];
  bool visible = first_nm <= FIRST_NM + STEP_NM * (BANDS - 1) && last_nm >= FIRST_NM;
  if (widest_nm > 0.0)
    snprintf(given, sizeof given, "%g to %g nm in steps of up to %g nm", first_nm, last_nm,
             widest_nm);
  else
    snprintf(given, sizeof given, "%g nm alone", first_nm);
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "colour needs wavelengths from 400 to 700 nm in steps of at most 10 nm, not "
                    "%s; %sask for single bands (.binary: --merl-colour mono --bands %g; .bsdf: "
                    "--for pbrt)",
                    given, visible ? "set them to 400:700:10, or " : "", first_nm);
}

static hetab_status check_cover(hetab_context *ctx, const double *lambda_um, size_t count) {
  const double last_nm = FIRST_NM + STEP_NM * (BANDS - 1), slack_nm = 1e-6;
  double widest = 0.0;
  for (size_t w = 1; w < count; w++)
    widest = fmax(widest, 1e3 * (lambda_um[w] - lambda_um[w - 1]));
  if (1e3 * lambda_um[0] > FIRST_NM + slack_nm || 1e3 * lambda_um[count - 1] < last_nm - slack_nm ||
      widest > STEP_NM + slack_nm)
    return fail_cover(ctx, 1e3 * lambda_um[0], 1e3 * lambda_um[count - 1], widest);
  return HETAB_OK;
}

hetab_status hetab_xyz_weights(hetab_context *ctx, const double *lambda_um, size_t count,
                               double (*weights)[3]) {
  double sum[3] = {0.0};
  HETAB_TRY(check_cover(ctx, lambda_um, count));
  for (size_t w = 0; w < count; w++)
    weights[w][0] = weights[w][1] = weights[w][2] = 0.0;
  for (int b = 0; b < BANDS; b++)
    for (int c = 0; c < 3; c++)
      sum[c] += observer_d65[b][c] * observer_d65[b][3];
  size_t right = 1;
  for (int b = 0; b < BANDS; b++) {
    double lambda = 1e-3 * (FIRST_NM + STEP_NM * b);
    while (right + 1 < count && lambda_um[right] < lambda)
      right++;
    size_t left = right - 1;
    double t = (lambda - lambda_um[left]) / (lambda_um[right] - lambda_um[left]);
    t = fmin(fmax(t, 0.0), 1.0);
    for (int c = 0; c < 3; c++) {
      double weight = WHITE[c] * observer_d65[b][c] * observer_d65[b][3] / sum[c];
      weights[left][c] += (1.0 - t) * weight;
      weights[right][c] += t * weight;
    }
  }
  return HETAB_OK;
}

/* IEC 61966-2-1, each row scaled by some 1e-7 such that the white is (1, 1, 1). */
void hetab_xyz_to_srgb(const double xyz[3], double rgb[3]) {
  static const double matrix[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                      {-0.9692660, 1.8760108, 0.0415560},
                                      {0.0556434, -0.2040259, 1.0572252}};
  for (int c = 0; c < 3; c++) {
    const double *m = matrix[c];
    double white = m[0] * WHITE[0] + m[1] * WHITE[1] + m[2] * WHITE[2];
    rgb[c] = (m[0] * xyz[0] + m[1] * xyz[1] + m[2] * xyz[2]) / white;
  }
}

hetab_status hetab_srgb_weights(hetab_context *ctx, const double *lambda_um, size_t count,
                                double (*weights)[3]) {
  HETAB_TRY(hetab_xyz_weights(ctx, lambda_um, count, weights));
  for (size_t w = 0; w < count; w++) {
    const double xyz[3] = {weights[w][0], weights[w][1], weights[w][2]};
    hetab_xyz_to_srgb(xyz, weights[w]);
  }
  return HETAB_OK;
}

double hetab_luminance(const float rgb[3]) {
  return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}
