/* Measured BRDFs in memory; the file formats are in measurements_*.c. */
#include "measured/measurements_internal.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/number.h"

/* ---- life ---- */

void hetab_measurements_free(hetab_measurements *measurements) {
  if (!measurements)
    return;
  free(measurements->name);
  free(measurements->lambda_um);
  free(measurements->pairs);
  free(measurements->values);
  free(measurements);
}

hetab_status hetab_measurements_new(hetab_context *ctx, const char *name, size_t wavelengths,
                                    size_t count, hetab_measurements **out) {
  *out = NULL;
  if (wavelengths && count > SIZE_MAX / wavelengths)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "%s: out of memory for %zu x %zu values", name, count,
                      wavelengths);
  hetab_measurements *made = hetab_alloc(ctx, 1, sizeof *made);
  HETAB_NEED(made);
  made->name = hetab_alloc(ctx, strlen(name) + 1, 1);
  made->lambda_um = hetab_alloc(ctx, wavelengths, sizeof *made->lambda_um);
  made->pairs = hetab_alloc(ctx, count, sizeof *made->pairs);
  made->values = hetab_alloc(ctx, count * wavelengths, sizeof *made->values);
  if (!made->name || !made->lambda_um || !made->pairs || !made->values) {
    hetab_measurements_free(made);
    return HETAB_ERR_MEMORY;
  }
  strcpy(made->name, name);
  made->wavelengths = wavelengths;
  made->count = count;
  *out = made;
  return HETAB_OK;
}

/* ---- what a measurement can be ---- */

static hetab_status check_wavelengths(hetab_context *ctx, const hetab_measurements *m) {
  if (m->wavelengths == 0)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%s: no wavelengths: give at least one", m->name);
  for (size_t b = 0; b < m->wavelengths; b++)
    if (hetab_number_check(ctx, &hetab_rule_length, m->lambda_um[b]) != HETAB_OK)
      return hetab_fail(ctx, HETAB_ERR_RANGE, "%s: wavelength %zu: %g um is out of range: give %s",
                        m->name, b + 1, m->lambda_um[b], hetab_rule_length.wanted);
  return HETAB_OK;
}

static int above_horizon(const hetab_directions *pair) {
  return pair->theta_i >= 0 && pair->theta_i < M_PI_2 && pair->theta_r >= 0 &&
         pair->theta_r < M_PI_2;
}

static double folded(double phi) {
  phi = fabs(remainder(phi, 2 * M_PI));
  return phi > M_PI ? M_PI : phi;
}

/* Values that are none become NaN. */
static hetab_status clean_values(hetab_context *ctx, hetab_measurements *m, double *values) {
  for (size_t b = 0; b < m->wavelengths; b++) {
    if (isfinite(values[b]) && fabs(values[b]) > HETAB_MOST_BRDF)
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%s: a BRDF of %g / sr is no surface's: give at most %g / sr", m->name,
                        values[b], HETAB_MOST_BRDF);
    if (isinf(values[b])) {
      m->skipped.not_finite++;
      values[b] = (double)NAN;
    }
    m->skipped.negative += values[b] < 0;
  }
  return HETAB_OK;
}

/* Checks the wavelengths, and takes out what a measurement cannot be, counting it in `skipped`:
 * rows with a direction at or below the horizon or not a number are removed, infinite values become
 * NaN, phi is folded to [0, pi]. HETAB_ERR_RANGE if nothing is left, or
 * a value is above HETAB_MOST_BRDF. */
static hetab_status clean(hetab_context *ctx, hetab_measurements *m) {
  HETAB_TRY(check_wavelengths(ctx, m));
  size_t kept = 0;
  for (size_t i = 0; i < m->count; i++) {
    hetab_directions pair = m->pairs[i];
    if (isnan(pair.theta_i) || isnan(pair.theta_r) || !isfinite(pair.phi)) {
      m->skipped.not_finite++;
      continue;
    }
    if (!above_horizon(&pair)) {
      m->skipped.below_horizon++;
      continue;
    }
    pair.phi = folded(pair.phi);
    m->pairs[kept] = pair;
    memmove(&m->values[kept * m->wavelengths], &m->values[i * m->wavelengths],
            m->wavelengths * sizeof *m->values);
    HETAB_TRY(clean_values(ctx, m, &m->values[kept++ * m->wavelengths]));
  }
  m->count = kept;
  if (kept == 0)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "%s: no pair of directions above the horizon (%zu below it, %zu not finite): "
                      "check the columns and the unit of the angles",
                      m->name, m->skipped.below_horizon, m->skipped.not_finite);
  return HETAB_OK;
}

hetab_status hetab_measurements_create(hetab_context *ctx, const double *lambda_um,
                                       size_t wavelengths, const hetab_directions *pairs,
                                       size_t count, const double *values,
                                       hetab_measurements **out) {
  hetab_measurements *made;
  *out = NULL;
  HETAB_TRY(hetab_measurements_new(ctx, "measurements", wavelengths, count, &made));
  if (wavelengths && count) {
    memcpy(made->lambda_um, lambda_um, wavelengths * sizeof *lambda_um);
    memcpy(made->pairs, pairs, count * sizeof *pairs);
    memcpy(made->values, values, count * wavelengths * sizeof *values);
  }
  *out = made;
  HETAB_MADE(hetab_measurements, out, clean(ctx, made));
}

/* ---- reading them ---- */

const char *hetab_measurements_name(const hetab_measurements *measurements) {
  return measurements->name;
}

size_t hetab_measurements_wavelength_count(const hetab_measurements *measurements) {
  return measurements->wavelengths;
}

const double *hetab_measurements_lambda_um(const hetab_measurements *measurements) {
  return measurements->lambda_um;
}

size_t hetab_measurements_pair_count(const hetab_measurements *measurements) {
  return measurements->count;
}

const hetab_directions *hetab_measurements_pairs(const hetab_measurements *measurements) {
  return measurements->pairs;
}

const double *hetab_measurements_values(const hetab_measurements *measurements) {
  return measurements->values;
}

hetab_measurements_skipped hetab_measurements_skipped_of(const hetab_measurements *measurements) {
  return measurements->skipped;
}
