/* Wavelengths as places among a table's channels. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { HETAB_BANDS_AT_ONCE = 8 };

/* Between channel `first` and, where the fraction is not 0, the next. */
typedef struct hetab_band_places {
  size_t count;
  uint32_t first[HETAB_BANDS_AT_ONCE];
  float fraction[HETAB_BANDS_AT_ONCE];
} hetab_band_places;

/* A table's wavelengths, ascending. */
typedef struct hetab_band_axis {
  const double *lambda_um;
  size_t channels;
  bool even;            /* they are evenly spaced */
  float low_um, per_um; /* then the first, and channels per um */
} hetab_band_axis;

/* lambda_um stays the caller's. */
hetab_band_axis hetab_band_axis_of(const double *lambda_um, size_t channels);

/* Of asked_um[count] on the axis; held beyond its ends. */
void hetab_band_places_of(const hetab_band_axis *axis, const float *asked_um, size_t count,
                          hetab_band_places *places);

/* A row of all channels at the places; places NULL: copied. */
void hetab_band_values(const hetab_band_places *places, size_t channels, const float *row,
                       float *value);
