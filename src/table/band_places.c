#include "table/band_places.h"

#include <string.h>

void hetab_band_places_of(const double *lambda_um, size_t channels, const float *asked_um,
                          size_t count, hetab_band_places *places) {
  double low = lambda_um[0], high = lambda_um[channels - 1];
  double scale = channels > 1 ? (double)(channels - 1) / (high - low) : 0;
  *places = (hetab_band_places){.count = count};
  for (size_t i = 0; i < count; i++) {
    double um = (double)asked_um[i];
    size_t at = 0;
    um = um > low ? um < high ? um : high : low; /* NaN becomes the lowest */
    if (channels > 1) {
      at = (size_t)((um - low) * scale); /* right where they are evenly spaced */
      at = at < channels - 2 ? at : channels - 2;
      while (lambda_um[at] > um)
        at--;
      while (lambda_um[at + 1] < um)
        at++;
    }
    places->first[i] = (uint32_t)at;
    places->fraction[i] =
        channels > 1 ? (float)((um - lambda_um[at]) / (lambda_um[at + 1] - lambda_um[at])) : 0;
  }
}

void hetab_band_values(const hetab_band_places *places, size_t channels, const float *row,
                       float *value) {
  if (!places)
    memcpy(value, row, channels * sizeof *value);
  for (size_t i = 0; places && i < places->count; i++) {
    const float *at = row + places->first[i];
    value[i] = at[0] + (places->fraction[i] > 0 ? places->fraction[i] * (at[1] - at[0]) : 0);
  }
}
