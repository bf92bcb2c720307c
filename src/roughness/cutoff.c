#include "roughness/cutoff.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include "roughness/scan_worker.h"
#include "roughness/two_scales.h"

enum { TRIALS = 24, MOST_SCANS = 64, FINE = 400 };

/* A fit further off than this on average says little about the surface. */
static const double worst_misfit = 0.05;

/* ---- trials -------------------------------------------------------------------------------- */

static hetab_status choose_trials(hetab_context *ctx, const hetab_scan_list *list,
                                  hetab_cutoff_scan *scan) {
  double low = 0, high = HUGE_VAL;
  for (size_t i = 0; i < list->count; i++) {
    low = fmax(low, 10 * list->scans[i].spacing_um);
    high = fmin(high, (double)list->scans[i].count * list->scans[i].spacing_um / 3);
  }
  if (!(high > 2 * low))
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "the scans are too short to look for a cut-off between 10 spacings, %g um, "
                      "and a third of the shortest, %g um: give one",
                      low, high);
  scan->trials = hetab_alloc(ctx, TRIALS, sizeof *scan->trials);
  HETAB_NEED(scan->trials);
  scan->count = TRIALS;
  for (int i = 0; i < TRIALS; i++)
    scan->trials[i].cutoff_um = low * pow(high / low, i / (TRIALS - 1.0));
  return HETAB_OK;
}

/* Adds one scan to the trials it has statistics for. */
static void try_scan(hetab_context *ctx, hetab_scan_worker *w, hetab_cutoff_scan *scan,
                     size_t *counts) {
  for (size_t t = 0; t < scan->count && !hetab_stopping(ctx); t++) {
    hetab_cutoff_trial *trial = &scan->trials[t];
    double sigma, tau;
    const double *line_um = hetab_scan_worker_filter(w, trial->cutoff_um);
    if (!hetab_sigma_tau(&w->statistics, w->z_um, line_um, w->evaluated, w->count, &sigma, &tau))
      continue;
    trial->sigma_um += sigma;
    trial->tau_um += tau;
    trial->slope += sigma / tau;
    counts[t]++;
  }
}

/* Trials that no scan had statistics for go. */
static void average_trials(hetab_cutoff_scan *scan, const size_t *counts) {
  size_t kept = 0;
  for (size_t t = 0; t < scan->count; t++) {
    hetab_cutoff_trial trial = scan->trials[t];
    double n = (double)counts[t];
    if (counts[t])
      scan->trials[kept++] = (hetab_cutoff_trial){trial.cutoff_um, trial.sigma_um / n,
                                                  trial.tau_um / n, trial.slope / n, (double)NAN};
  }
  scan->count = kept;
}

static hetab_status run_trials(hetab_context *ctx, const hetab_scan_list *list,
                               hetab_cutoff_scan *scan) {
  size_t counts[TRIALS] = {0}, stride = (list->count - 1) / MOST_SCANS + 1;
  double longest = scan->trials[scan->count - 1].cutoff_um;
  hetab_scan_worker worker;
  hetab_status status;
  HETAB_TRY(hetab_scan_worker_create(ctx, list, &worker));
  for (size_t i = 0; i < list->count; i += stride) {
    HETAB_GOTO(hetab_progress(ctx, (double)i, (double)list->count));
    HETAB_GOTO(hetab_scan_worker_take(ctx, list, i, longest, &worker));
    try_scan(ctx, &worker, scan, counts);
  }
  HETAB_GOTO(hetab_progress(ctx, (double)list->count, (double)list->count));
  average_trials(scan, counts);
done:
  hetab_scan_worker_free(&worker);
  return status;
}

/* ---- the maximum --------------------------------------------------------------------------- */

static size_t largest_slope(const hetab_cutoff_scan *scan) {
  size_t best = 0;
  for (size_t t = 1; t < scan->count; t++)
    if (scan->trials[t].slope > scan->trials[best].slope)
      best = t;
  return best;
}

static hetab_status fit_trials(hetab_context *ctx, const hetab_component *raw,
                               hetab_cutoff_scan *scan, hetab_two_scales *scales) {
  double cutoffs[TRIALS], sigmas[TRIALS], taus[TRIALS];
  for (size_t t = 0; t < scan->count; t++) {
    cutoffs[t] = scan->trials[t].cutoff_um;
    sigmas[t] = scan->trials[t].sigma_um;
    taus[t] = scan->trials[t].tau_um;
  }
  size_t best = largest_slope(scan);
  *scales = (hetab_two_scales){{sigmas[best], raw->sigma_um.mean},
                               {taus[best], fmax(raw->tau_um.mean, 3 * taus[best])}};
  return hetab_two_scales_fit(ctx, cutoffs, sigmas, taus, scan->count, cutoffs[scan->count - 1] * 3,
                              scales, &scan->misfit);
}

static double smooth_slope(const hetab_two_scales *scales, double cutoff_um) {
  double sigma, tau;
  hetab_two_scales_filtered(scales, cutoff_um, &sigma, &tau);
  return sigma / tau;
}

/* Within the cut-offs tried. */
static double smooth_maximum(const hetab_two_scales *scales, const hetab_cutoff_scan *scan) {
  double low = scan->trials[0].cutoff_um, high = scan->trials[scan->count - 1].cutoff_um;
  double best = low, most = 0;
  for (int i = 0; i < FINE; i++) {
    double cutoff = low * pow(high / low, i / (FINE - 1.0)), slope = smooth_slope(scales, cutoff);
    if (slope > most) {
      most = slope;
      best = cutoff;
    }
  }
  return best;
}

/* The unfiltered scans are the fit's small scale already. More tolerance would take a weak large
 * scale, most of which levelling removed, for none. */
static bool one_scale(const hetab_component *raw, const hetab_cutoff_scan *scan) {
  return scan->from_fit && raw->sigma_um.mean < 1.03 * scan->sigma_um[0] &&
         raw->tau_um.mean < 1.03 * scan->tau_um[0];
}

hetab_status hetab_find_cutoff(hetab_context *ctx, const hetab_scan_list *list,
                               const hetab_component *raw, hetab_cutoff_scan *scan,
                               double *cutoff_um) {
  hetab_two_scales scales;
  HETAB_TRY(choose_trials(ctx, list, scan));
  HETAB_TRY(run_trials(ctx, list, scan));
  if (scan->count < 6)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "gaps and end zones leave too little of the scans to look for a cut-off: "
                      "give one");
  HETAB_TRY(fit_trials(ctx, raw, scan, &scales));
  for (int i = 0; i < 2; i++) {
    scan->sigma_um[i] = scales.sigma_um[i];
    scan->tau_um[i] = scales.tau_um[i];
  }
  for (size_t t = 0; t < scan->count; t++)
    scan->trials[t].smooth = smooth_slope(&scales, scan->trials[t].cutoff_um);
  scan->from_fit = scan->misfit <= worst_misfit;
  if (one_scale(raw, scan))
    *cutoff_um = 0;
  else
    *cutoff_um = scan->from_fit ? smooth_maximum(&scales, scan)
                                : scan->trials[largest_slope(scan)].cutoff_um;
  return HETAB_OK;
}
