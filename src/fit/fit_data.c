/* Which measurements are in the fit, and what each of them weighs. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdlib.h>

static const double WAVELENGTH_TOLERANCE_UM = 1e-4, INCIDENCE_TOLERANCE_DEG = 0.1;
static const double PLANE_TOLERANCE_DEG = 0.5;
static const double SAME_ANGLE_DEG = 0.05; /* angles written with few digits */
static const double INCIDENCE_BIN_DEG = 5.0;
static const double FAINT = 1e-3;        /* of a wavelength's mean */
static const double LEAST_SCALE = 1e-60; /* below it squares get lost */
enum { MOST_INCIDENCES = 40, MOST_POINTS = 100000 };

void hetab_fit_data_clear(hetab_fit_data *data) {
  free(data->pair_of);
  free(data->pairs);
  free(data->band_of);
  free(data->lambda_um);
  free(data->measured);
  free(data->weight);
  free(data->mean);
  free(data->incidence);
  free(data->theta_i);
  *data = (hetab_fit_data){0};
}

/* ---- wavelengths ----------------------------------------------------------------------------- */

static size_t nearest_band(const hetab_measurements *m, double lambda_um) {
  const double *all = hetab_measurements_lambda_um(m);
  size_t best = 0;
  for (size_t b = 1; b < hetab_measurements_wavelength_count(m); b++)
    if (fabs(all[b] - lambda_um) < fabs(all[best] - lambda_um))
      best = b;
  return best;
}

static hetab_status choose_bands(hetab_context *ctx, const hetab_measurements *m,
                                 const hetab_fit_options *o, hetab_fit_data *data) {
  const double *all = hetab_measurements_lambda_um(m);
  data->bands = o->lambda_count ? o->lambda_count : hetab_measurements_wavelength_count(m);
  if (data->bands > HETAB_FIT_MOST_BANDS)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%zu wavelengths: choose at most %d of them",
                      data->bands, HETAB_FIT_MOST_BANDS);
  data->band_of = hetab_alloc(ctx, data->bands, sizeof *data->band_of);
  data->lambda_um = hetab_alloc(ctx, data->bands, sizeof *data->lambda_um);
  HETAB_NEED(data->band_of && data->lambda_um);
  for (size_t b = 0; b < data->bands; b++) {
    size_t band = o->lambda_count ? nearest_band(m, o->lambda_um[b]) : b;
    if (o->lambda_count && !(fabs(all[band] - o->lambda_um[b]) <= WAVELENGTH_TOLERANCE_UM))
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%s: no measurements at %g nm, the nearest are at %g nm: choose one of its "
                        "%zu wavelengths",
                        hetab_measurements_name(m), 1e3 * o->lambda_um[b], 1e3 * all[band],
                        hetab_measurements_wavelength_count(m));
    data->band_of[b] = band;
  }
  return HETAB_OK;
}

/* By wavelength, each once: surfaces are made of such. */
static hetab_status sort_bands(hetab_context *ctx, const hetab_measurements *m,
                               hetab_fit_data *data) {
  const double *all = hetab_measurements_lambda_um(m);
  for (size_t b = 1; b < data->bands; b++)
    for (size_t i = b; i > 0 && all[data->band_of[i]] < all[data->band_of[i - 1]]; i--) {
      size_t swap = data->band_of[i];
      data->band_of[i] = data->band_of[i - 1];
      data->band_of[i - 1] = swap;
    }
  for (size_t b = 0; b < data->bands; b++) {
    data->lambda_um[b] = all[data->band_of[b]];
    if (b && data->lambda_um[b] == data->lambda_um[b - 1])
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT, "%g nm is there twice: name each wavelength once",
                        1e3 * data->lambda_um[b]);
  }
  return HETAB_OK;
}

/* ---- pairs ----------------------------------------------------------------------------------- */

static int is_in_plane(const hetab_directions *p) {
  double phi = hetab_degrees(p->phi), normal = hetab_degrees(fmin(p->theta_i, p->theta_r));
  return phi <= PLANE_TOLERANCE_DEG || phi >= 180 - PLANE_TOLERANCE_DEG || normal <= SAME_ANGLE_DEG;
}

static double from_mirror(const hetab_directions *p) {
  double cosine =
      cos(p->theta_i) * cos(p->theta_r) - sin(p->theta_i) * sin(p->theta_r) * cos(p->phi);
  return acos(fmin(fmax(cosine, -1.0), 1.0));
}

static int has_value(const hetab_measurements *m, const hetab_fit_data *data, size_t i) {
  const double *values = hetab_measurements_values(m) + i * hetab_measurements_wavelength_count(m);
  for (size_t b = 0; b < data->bands; b++)
    if (!isnan(values[data->band_of[b]]))
      return 1;
  return 0;
}

/* found[theta_i_count]: which of the incidences asked for are there. */
static int is_chosen(const hetab_measurements *m, const hetab_fit_options *o,
                     const hetab_fit_data *data, size_t i, unsigned char *found) {
  const hetab_directions *p = &hetab_measurements_pairs(m)[i];
  int incidence = o->theta_i_count == 0;
  for (size_t t = 0; t < o->theta_i_count; t++)
    if (fabs(hetab_degrees(p->theta_i) - hetab_degrees(o->theta_i[t])) <= INCIDENCE_TOLERANCE_DEG)
      incidence = found[t] = 1;
  return incidence && (!o->plane || is_in_plane(p)) &&
         (o->exclude_mirror <= 0.0 || from_mirror(p) >= o->exclude_mirror) && has_value(m, data, i);
}

static hetab_status check_found(hetab_context *ctx, const hetab_measurements *m,
                                const hetab_fit_options *o, const unsigned char *found) {
  for (size_t t = 0; t < o->theta_i_count; t++)
    if (!found[t])
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%s: no measurements at theta_i = %g degrees: choose incidences that are "
                        "there",
                        hetab_measurements_name(m), hetab_degrees(o->theta_i[t]));
  return HETAB_OK;
}

/* Evenly out of all. */
static void thin(const hetab_fit_options *o, hetab_fit_data *data) {
  size_t most = o->max_points ? o->max_points : MOST_POINTS, kept = 0;
  if (data->count <= most)
    return;
  for (size_t i = 0; i < data->count; i++)
    if ((size_t)((double)i * (double)most / (double)data->count) == kept && kept < most)
      data->pair_of[kept++] = data->pair_of[i];
  data->thinned = data->count - kept;
  data->count = kept;
}

static hetab_status choose_pairs(hetab_context *ctx, const hetab_measurements *m,
                                 const hetab_fit_options *o, hetab_fit_data *data) {
  hetab_status status = HETAB_OK;
  HETAB_FREED unsigned char *found = hetab_alloc(ctx, o->theta_i_count, 1);
  data->pair_of = hetab_alloc(ctx, hetab_measurements_pair_count(m), sizeof *data->pair_of);
  if (!found || !data->pair_of)
    status = HETAB_ERR_MEMORY;
  for (size_t i = 0; status == HETAB_OK && i < hetab_measurements_pair_count(m); i++)
    if (is_chosen(m, o, data, i, found))
      data->pair_of[data->count++] = i;
  if (status == HETAB_OK)
    status = check_found(ctx, m, o, found);
  if (status == HETAB_OK && data->count == 0)
    status = hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%s: no measurement is left to fit: all are missing, or outside the "
                        "incidences, the plane and the wavelengths chosen",
                        hetab_measurements_name(m));
  thin(o, data);
  return status;
}

static hetab_status copy_values(hetab_context *ctx, const hetab_measurements *m,
                                hetab_fit_data *data) {
  size_t wavelengths = hetab_measurements_wavelength_count(m);
  data->pairs = hetab_alloc(ctx, data->count, sizeof *data->pairs);
  data->measured = hetab_alloc(ctx, data->count * data->bands, sizeof *data->measured);
  data->weight = hetab_alloc(ctx, data->count * data->bands, sizeof *data->weight);
  HETAB_NEED(data->pairs && data->measured && data->weight);
  for (size_t i = 0; i < data->count; i++) {
    const double *values = hetab_measurements_values(m) + data->pair_of[i] * wavelengths;
    data->pairs[i] = hetab_measurements_pairs(m)[data->pair_of[i]];
    for (size_t b = 0; b < data->bands; b++) {
      double value = values[data->band_of[b]];
      data->missing += isnan(value) != 0;
      data->negative += value < 0;
      data->measured[i * data->bands + b] = isnan(value) ? 0 : value;
      data->weight[i * data->bands + b] = !isnan(value);
    }
  }
  return HETAB_OK;
}

/* ---- incidences ------------------------------------------------------------------------------ */

typedef struct keyed {
  double key;
  size_t at;
} keyed;

static int by_key(const void *a, const void *b) {
  const keyed *x = a, *y = b;
  return x->key < y->key ? -1 : x->key > y->key ? 1 : (x->at > y->at) - (x->at < y->at);
}

/* Numbers the groups of sorted keys whose neighbours are no more than `apart` from each other. */
static size_t number_groups(const keyed *sorted, size_t count, double apart, size_t *group) {
  size_t groups = 0;
  for (size_t i = 0; i < count; i++) {
    if (i == 0 || sorted[i].key - sorted[i - 1].key > apart)
      groups++;
    group[sorted[i].at] = groups - 1;
  }
  return groups;
}

static size_t number_bins(const keyed *sorted, size_t count, size_t *group) {
  size_t groups = 0;
  for (size_t i = 0; i < count; i++) {
    if (i == 0 ||
        floor(sorted[i].key / INCIDENCE_BIN_DEG) > floor(sorted[i - 1].key / INCIDENCE_BIN_DEG))
      groups++;
    group[sorted[i].at] = groups - 1;
  }
  return groups;
}

/* An incidence's angle is the mean of its measurements'. */
static hetab_status number_incidences(hetab_context *ctx, hetab_fit_data *data) {
  HETAB_FREED keyed *sorted = hetab_alloc(ctx, data->count, sizeof *sorted);
  HETAB_FREED double *members = hetab_alloc(ctx, data->count, sizeof *members);
  data->incidence = hetab_alloc(ctx, data->count, sizeof *data->incidence);
  data->theta_i = hetab_alloc(ctx, data->count, sizeof *data->theta_i);
  HETAB_NEED(sorted && members && data->incidence && data->theta_i);
  for (size_t i = 0; i < data->count; i++)
    sorted[i] = (keyed){hetab_degrees(data->pairs[i].theta_i), i};
  qsort(sorted, data->count, sizeof *sorted, by_key);
  data->incidence_count = number_groups(sorted, data->count, SAME_ANGLE_DEG, data->incidence);
  if (data->incidence_count > MOST_INCIDENCES)
    data->incidence_count = number_bins(sorted, data->count, data->incidence);
  for (size_t i = 0; i < data->count; i++) {
    data->theta_i[data->incidence[i]] += data->pairs[i].theta_i;
    members[data->incidence[i]]++;
  }
  for (size_t t = 0; t < data->incidence_count; t++)
    data->theta_i[t] /= members[t];
  return HETAB_OK;
}

hetab_status hetab_fit_data_select(hetab_context *ctx, const hetab_measurements *measurements,
                                   const hetab_fit_options *options, hetab_fit_data *data) {
  data->below_horizon = hetab_measurements_skipped_of(measurements).below_horizon;
  HETAB_TRY(choose_bands(ctx, measurements, options, data));
  HETAB_TRY(sort_bands(ctx, measurements, data));
  HETAB_TRY(choose_pairs(ctx, measurements, options, data));
  HETAB_TRY(copy_values(ctx, measurements, data));
  return number_incidences(ctx, data);
}

/* ---- weights --------------------------------------------------------------------------------- */

/* Solid angles of the rings about the normal on which [first, end) of the sorted measurements of
 * one incidence lie; border of two rings half way between them. */
static void weigh_rings(const keyed *sorted, size_t first, size_t end, double *omega) {
  double below = 0;
  for (size_t i = first, next; i < end; i = next) {
    for (next = i + 1; next < end && sorted[next].key - sorted[i].key <= SAME_ANGLE_DEG;)
      next++;
    double above = next < end ? 0.5 * (sorted[next - 1].key + sorted[next].key) : 90;
    double ring = 2 * M_PI * (cos(below * M_PI / 180) - cos(above * M_PI / 180));
    for (size_t j = i; j < next; j++)
      omega[sorted[j].at] = ring / (double)(next - i);
    below = above;
  }
}

/* dOmega of every pair. */
static hetab_status solid_angles(hetab_context *ctx, const hetab_fit_data *data, double *omega) {
  HETAB_FREED keyed *sorted = hetab_alloc(ctx, data->count, sizeof *sorted);
  HETAB_NEED(sorted);
  for (size_t t = 0, first = 0, end; t < data->incidence_count; t++, first = end) {
    end = first;
    for (size_t i = 0; i < data->count; i++)
      if (data->incidence[i] == t)
        sorted[end++] = (keyed){hetab_degrees(data->pairs[i].theta_r), i};
    qsort(sorted + first, end - first, sizeof *sorted, by_key);
    weigh_rings(sorted, first, end, omega);
  }
  return HETAB_OK;
}

static hetab_status weigh_by_energy(hetab_context *ctx, hetab_fit_data *data) {
  HETAB_FREED double *omega = hetab_alloc(ctx, data->count, sizeof *omega);
  HETAB_NEED(omega);
  hetab_status status = solid_angles(ctx, data, omega);
  for (size_t i = 0; i < data->count; i++)
    for (size_t b = 0; b < data->bands; b++)
      data->weight[i * data->bands + b] *=
          cos(data->pairs[i].theta_i) * cos(data->pairs[i].theta_r) * omega[i];
  return status;
}

static void weigh_by_value(hetab_fit_data *data) {
  for (size_t i = 0; i < data->count * data->bands; i++)
    if (data->weight[i] > 0)
      data->weight[i] = pow(fmax(data->measured[i], FAINT * data->mean[i % data->bands]), -2);
}

static hetab_status check_bands(hetab_context *ctx, hetab_fit_data *data) {
  if (!(data->mean = hetab_alloc(ctx, data->bands, sizeof *data->mean)))
    return HETAB_ERR_MEMORY;
  for (size_t b = 0; b < data->bands; b++) {
    double weight = 0, sum = 0;
    for (size_t i = b; i < data->count * data->bands; i += data->bands) {
      weight += data->weight[i];
      sum += data->weight[i] * data->measured[i];
    }
    if (!(weight > 0 && sum > 0))
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "%g nm: all measurements are %s: leave this wavelength out",
                        1e3 * data->lambda_um[b], weight > 0 ? "0 or below" : "missing");
    data->mean[b] = sum / weight;
  }
  return HETAB_OK;
}

/* The default. */
static hetab_fit_weights weights_for(const hetab_fit_data *data) {
  for (size_t i = 0; i < data->count; i++)
    if (!is_in_plane(&data->pairs[i]))
      return HETAB_FIT_WEIGHTS_ENERGY;
  return HETAB_FIT_WEIGHTS_REPORT;
}

static void weigh_as_printed(hetab_fit_data *data) {
  for (size_t i = 0; i < data->count * data->bands; i++)
    data->weight[i] *= pow(cos(data->pairs[i / data->bands].theta_r), 2);
}

hetab_status hetab_fit_data_weigh(hetab_context *ctx, hetab_fit_weights *weights,
                                  hetab_fit_data *data) {
  HETAB_TRY(check_bands(ctx, data));
  if (*weights == HETAB_FIT_WEIGHTS_AUTO)
    *weights = weights_for(data);
  if (*weights == HETAB_FIT_WEIGHTS_REPORT)
    weigh_as_printed(data);
  if (*weights == HETAB_FIT_WEIGHTS_ENERGY)
    HETAB_TRY(weigh_by_energy(ctx, data));
  if (*weights == HETAB_FIT_WEIGHTS_RELATIVE)
    weigh_by_value(data);
  int logarithms = *weights == HETAB_FIT_WEIGHTS_LOG;
  for (size_t i = 0; i < data->count * data->bands; i++) {
    double f = data->measured[i];
    if (logarithms && f <= 0)
      data->weight[i] = 0;
    data->values += data->weight[i] > 0;
    data->scale += data->weight[i] * (logarithms ? 1 : f * f);
  }
  if (!(data->scale >= LEAST_SCALE))
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "the measured values are next to 0, a weighted sum of squares of %g: leave "
                      "them out, or give 1/sr",
                      data->scale);
  return HETAB_OK;
}
