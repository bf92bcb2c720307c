#include "roughness/component.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/student.h"
#include "roughness/scan_worker.h"

/* ---- averages ------------------------------------------------------------------------------ */

/* Element i of values that lie `bytes` apart. */
static hetab_estimate element(const hetab_estimate *first, size_t i, size_t bytes) {
  hetab_estimate value;
  memcpy(&value, (const char *)first + i * bytes, sizeof value);
  return value;
}

/* What cannot be negative has its interval in the logarithm, which ends above 0. */
static void set_interval(hetab_average *a, double reach, bool positive) {
  if (positive && a->mean > 0) {
    a->low = a->mean * exp(-reach / a->mean);
    a->high = a->mean * exp(reach / a->mean);
  } else {
    a->low = a->mean - reach;
    a->high = a->mean + reach;
  }
}

/* Of `count` estimates that lie `bytes` apart, worth `independent` independent ones. */
static hetab_average average_of(const hetab_estimate *first, size_t count, size_t bytes,
                                double independent, bool positive) {
  hetab_average a = {.count = 0};
  double sum = 0, squares = 0, errors = 0;
  for (size_t i = 0; i < count; i++) {
    hetab_estimate e = element(first, i, bytes);
    if (isfinite(e.value)) {
      sum += e.value;
      errors += e.error * e.error;
      a.count++;
    }
  }
  double n = (double)a.count, worth = fmax(1, fmin(independent, n));
  a.mean = sum / n;
  for (size_t i = 0; i < count; i++) {
    double value = element(first, i, bytes).value;
    squares += isfinite(value) ? (value - a.mean) * (value - a.mean) : 0;
  }
  a.deviation = a.count > 1 ? sqrt(squares / (n - 1)) : (double)NAN;
  double within = sqrt(errors / n / worth), between = a.deviation / sqrt(worth);
  bool scatter = worth > 1.5; /* of independent scans, to speak of */
  double reach = scatter ? hetab_student_95(worth - 1) * between : 0;
  a.error = scatter ? fmax(within, between) : within;
  reach = fmax(1.96 * within, reach);
  set_interval(&a, reach, positive);
  return a;
}

/* ---- independence of the scans of a map ---------------------------------------------------- */

/* Scans `spacing` apart on a surface with this tau: neighbours within sqrt(pi/2) tau, the integral
 * of the squared Gaussian autocorrelation, say the same. */
static double worth_of_rows(size_t scans, double spacing_um, double tau_um) {
  return fmax(1, fmin((double)scans, (double)scans * spacing_um / (1.2533 * tau_um)));
}

/* Rows and columns of a map are made of the same points: the larger of the two counts. */
static double worth_of_scans(const hetab_scan_list *list, const hetab_component *c, double tau_um) {
  double worth = 0;
  for (size_t input = 0; input < list->inputs; input++) {
    const hetab_heights *h = list->heights[input];
    size_t rows = 0, columns = 0;
    for (size_t i = 0; i < c->count; i++) {
      const hetab_listed_scan *scan = &list->scans[c->scans[i].scan];
      if (scan->input == input)
        *(scan->is_column ? &columns : &rows) += 1;
    }
    if (hetab_heights_kind_of(h) == HETAB_HEIGHTS_MAP && rows + columns)
      worth += fmax(worth_of_rows(rows, hetab_heights_spacing_y_um(h), tau_um),
                    worth_of_rows(columns, hetab_heights_spacing_um(h), tau_um));
    else
      worth += (double)rows;
  }
  return worth;
}

static hetab_average average_field(const hetab_component *c, const hetab_estimate *first,
                                   double worth, bool positive) {
  return average_of(first, c->count, sizeof *c->scans, worth, positive);
}

static void average_scans(const hetab_scan_list *list, hetab_component *c) {
  if (!c->count)
    return;
  const hetab_scan_statistics *first = &c->scans[0];
  double tau = average_field(c, &first->tau_um, 1, true).mean, worth = worth_of_scans(list, c, tau);
  c->sigma_um = average_field(c, &first->sigma_um, worth, true);
  c->tau_um = average_field(c, &first->tau_um, worth, true);
  c->slope = average_field(c, &first->slope, worth, true);
  c->rms_slope = average_field(c, &first->rms_slope, worth, true);
  c->skewness = average_field(c, &first->skewness, worth, false);
  c->kurtosis = average_field(c, &first->kurtosis, worth, false);
  c->non_uniformity = c->sigma_um.deviation / c->sigma_um.mean;
  for (size_t i = 0; i < c->count; i++) {
    c->normal_distance += c->scans[i].normal_distance / (double)c->count;
    c->misfit_gaussian += c->scans[i].misfit_gaussian / (double)c->count;
    c->misfit_exponential += c->scans[i].misfit_exponential / (double)c->count;
  }
  for (int i = 0; i < HETAB_HISTOGRAM_BINS; i++)
    c->histogram[i] /= (double)c->count;
  for (int i = 0; i < HETAB_CORRELATION_LAGS; i++)
    c->correlation[i] /= (double)c->count;
}

/* ---- scans --------------------------------------------------------------------------------- */

/* Up to four tau of the first scan, linear between its lags. */
static void add_correlation(hetab_component *c, const hetab_statistics *s) {
  if (c->count == 0)
    c->lag_step_um = 4 * c->scans[0].tau_um.value / (HETAB_CORRELATION_LAGS - 1);
  for (int i = 0; i < HETAB_CORRELATION_LAGS; i++) {
    double lag = i * c->lag_step_um / s->spacing_um;
    size_t below = (size_t)lag;
    if (below + 1 < s->lags)
      c->correlation[i] +=
          s->correlation[below] +
          (lag - (double)below) * (s->correlation[below + 1] - s->correlation[below]);
  }
}

static void measure_scan(hetab_scan_worker *w, double cutoff_um, size_t scan, hetab_component *c) {
  const double *line_um = hetab_scan_worker_filter(w, cutoff_um);
  hetab_scan_statistics *result = &c->scans[c->count];
  *result = (hetab_scan_statistics){.scan = scan};
  if (!hetab_statistics_of(&w->statistics, w->z_um, line_um, w->evaluated, w->count, result))
    return;
  result->normal_distance =
      hetab_histogram_add(w->z_um, line_um, w->evaluated, w->count, c->histogram);
  add_correlation(c, &w->statistics);
  c->count++;
}

/* The weights need some heights to be on, and the end zones may take half of a scan. */
static bool suits(const hetab_listed_scan *scan, double cutoff_um) {
  return cutoff_um >= 10 * scan->spacing_um &&
         cutoff_um <= 0.5 * (double)scan->count * scan->spacing_um;
}

hetab_status hetab_component_measure(hetab_context *ctx, const hetab_scan_list *list,
                                     double cutoff_um, hetab_component *component) {
  hetab_scan_worker worker;
  hetab_status status;
  *component = (hetab_component){0};
  HETAB_TRY(hetab_scan_worker_create(ctx, list, &worker));
  status = HETAB_ERR_MEMORY;
  component->scans = hetab_alloc(ctx, list->count, sizeof *component->scans);
  if (!component->scans)
    goto done;
  for (size_t i = 0; i < list->count; i++) {
    HETAB_GOTO(hetab_progress(ctx, (double)i, (double)list->count));
    if (cutoff_um > 0 && !suits(&list->scans[i], cutoff_um))
      continue;
    HETAB_GOTO(hetab_scan_worker_take(ctx, list, i, cutoff_um, &worker));
    measure_scan(&worker, cutoff_um, i, component);
  }
  HETAB_GOTO(hetab_progress(ctx, (double)list->count, (double)list->count));
  average_scans(list, component);
done:
  hetab_scan_worker_free(&worker);
  return status;
}
