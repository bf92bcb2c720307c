#include "table/band_places.h"

#include <math.h>
#include <string.h>

hetab_band_axis hetab_band_axis_of(const double *lambda_um, size_t channels) {
  hetab_band_axis axis = {.lambda_um = lambda_um, .channels = channels, .even = true};
  double per_um =
      channels > 1 ? (double)(channels - 1) / (lambda_um[channels - 1] - lambda_um[0]) : 0;
  for (size_t i = 0; i < channels; i++)
    axis.even &= fabs((lambda_um[i] - lambda_um[0]) * per_um - (double)i) < 1e-6;
  axis.low_um = (float)lambda_um[0];
  axis.per_um = (float)per_um;
  return axis;
}

/* NaN becomes the lowest. */
static float held(float x, float high) {
  x = x > 0 ? x : 0;
  return x < high ? x : high;
}

static void even_places(const hetab_band_axis *axis, const float *asked_um, size_t count,
                        hetab_band_places *places) {
  float high = (float)(axis->channels - 1), last = high > 1 ? high - 1 : 0;
  for (size_t i = 0; i < count; i++) {
    float channel = held((asked_um[i] - axis->low_um) * axis->per_um, high);
    int32_t at = (int32_t)held(channel, last);
    places->first[i] = (uint32_t)at;
    places->fraction[i] = channel - (float)at;
  }
}

static void search_places(const hetab_band_axis *axis, const float *asked_um, size_t count,
                          hetab_band_places *places) {
  const double *lambda_um = axis->lambda_um;
  double low = lambda_um[0], high = lambda_um[axis->channels - 1];
  for (size_t i = 0; i < count; i++) {
    double um = (double)asked_um[i];
    size_t at = 0, above = axis->channels - 1;
    um = um > low ? um < high ? um : high : low;
    while (above - at > 1) {
      size_t middle = (at + above) / 2;
      *(lambda_um[middle] <= um ? &at : &above) = middle;
    }
    places->first[i] = (uint32_t)at;
    places->fraction[i] = (float)((um - lambda_um[at]) / (lambda_um[above] - lambda_um[at]));
  }
}

void hetab_band_places_of(const hetab_band_axis *axis, const float *asked_um, size_t count,
                          hetab_band_places *places) {
  *places = (hetab_band_places){.count = count};
  if (!axis->even)
    search_places(axis, asked_um, count, places);
  else if (count == 4) /* the most common, at once */
    even_places(axis, asked_um, 4, places);
  else
    even_places(axis, asked_um, count, places);
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
