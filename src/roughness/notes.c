#include "roughness/notes.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include "roughness/heights.h"

enum { MOST_NOTES = 16 };

typedef struct note_taker {
  hetab_context *ctx;
  hetab_roughness *roughness;
  const hetab_component *main; /* what the model's parameters come from */
  hetab_status status;
} note_taker;

static void note(note_taker *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void note(note_taker *t, const char *format, ...) {
  hetab_roughness *r = t->roughness;
  va_list args;
  va_start(args, format);
  if (t->status == HETAB_OK && r->note_count < MOST_NOTES) {
    if (vasprintf(&r->notes[r->note_count], format, args) >= 0)
      r->note_count++;
    else
      t->status = hetab_fail(t->ctx, HETAB_ERR_MEMORY, "out of memory for a note");
  }
  va_end(args);
}

/* ---- heights ------------------------------------------------------------------------------- */

/* Significant, and large enough to matter. */
static bool differs(const hetab_average *a, double from, double by) {
  return fabs(a->mean - from) > by && fabs(a->mean - from) > 3 * a->error;
}

static void note_distribution(note_taker *t) {
  const hetab_component *c = t->main;
  if (differs(&c->skewness, 0, 0.3) || differs(&c->kurtosis, 3, 0.7))
    note(t,
         "The heights are not Gaussian: skewness %.2f (0), kurtosis %.2f (3), distribution off by "
         "up to %.3f; the model takes Gaussian heights.",
         c->skewness.mean, c->kurtosis.mean, c->normal_distance);
}

static void note_missing(note_taker *t) {
  size_t points = 0, missing = 0, outliers = 0;
  for (size_t i = 0; i < t->roughness->count; i++) {
    points += t->roughness->scans[i].points;
    missing += t->roughness->scans[i].missing;
    outliers += t->roughness->scans[i].outliers;
  }
  double share = (double)(missing + outliers) / (double)points;
  if (share > 0.05)
    note(t, "%.0f %% of the heights are missing or outliers: what is steep may be among them.",
         100 * share);
}

/* ---- lengths ------------------------------------------------------------------------------- */

static void note_jagged(note_taker *t) {
  const hetab_component *c = t->main;
  if (c->misfit_exponential < c->misfit_gaussian)
    note(t,
         "The autocorrelation is nearer exponential than Gaussian (rms difference %.3f against "
         "%.3f): the surface is jagged, and its slope depends on the spacing of the heights; the "
         "model takes a Gaussian autocorrelation.",
         c->misfit_exponential, c->misfit_gaussian);
}

/* For one Gaussian scale rms_slope is sqrt(2) sigma / tau. */
static void note_scales(note_taker *t) {
  const hetab_component *c = t->main;
  const hetab_roughness *r = t->roughness;
  double ratio = c->rms_slope.mean / (M_SQRT2 * c->slope.mean);
  if (c == &r->small && r->raw.tau_um.mean > 3 * c->tau_um.mean)
    note(t,
         "The surface has several scales: unfiltered sigma %.3g um, tau %.3g um; behind the "
         "%.3g um cut-off sigma %.3g um, tau %.3g um. The model takes one scale: the small one "
         "scatters light, the large one only bends the mean plane.",
         r->raw.sigma_um.mean, r->raw.tau_um.mean, r->cutoff_um, c->sigma_um.mean, c->tau_um.mean);
  else if (ratio > 1.3)
    note(t,
         "The rms slope, %.3g, is %.2g times what one Gaussian scale with sigma / tau = %.3g would "
         "have: there are smaller scales than tau%s.",
         c->rms_slope.mean, ratio, c->slope.mean, c == &r->raw ? "; --cutoff separates them" : "");
}

static void note_curvature(note_taker *t, double wavelength_um) {
  hetab_roughness *r = t->roughness;
  double sigma = t->main->sigma_um.mean, tau = t->main->tau_um.mean;
  r->curvature_um = tau * tau / (sqrt(12) * sigma);
  if (r->curvature_um < 5 * wavelength_um)
    note(t,
         "The radius of curvature, about tau^2 / (3.5 sigma) = %.3g um, is not large against the "
         "wavelength of %.3g um: the model's tangent planes do not hold.",
         r->curvature_um, wavelength_um);
}

/* Levelling takes sqrt(pi) tau / length of the variance of a Gaussian autocorrelation, and a line
 * somewhat more. */
static void note_length(note_taker *t) {
  const hetab_component *c = t->main;
  double length = 0;
  for (size_t i = 0; i < c->count; i++)
    length += c->scans[i].length_um / (double)c->count;
  double taus = length / c->tau_um.mean;
  if (taus < (c == &t->roughness->raw ? 50 : 20))
    note(t,
         "The scans are too short for their tau: %.3g um evaluated are %.2g tau%s. Longer scans "
         "are needed.",
         length, taus,
         c == &t->roughness->raw ? "; levelling alone makes sigma and tau several per cent too low"
                                 : "");
}

static void note_spacing(note_taker *t) {
  double spacing = 0;
  for (size_t i = 0; i < t->main->count; i++)
    spacing = fmax(spacing, t->roughness->scans[t->main->scans[i].scan].spacing_um);
  if (t->main->tau_um.mean < 4 * spacing)
    note(t,
         "The heights lie too far apart: tau is %.2g of their spacing of %.3g um, and what lies "
         "between is not seen.",
         t->main->tau_um.mean / spacing, spacing);
}

static void note_cutoff(note_taker *t) {
  const hetab_roughness *r = t->roughness;
  const hetab_cutoff_scan *s = &r->cutoff_scan;
  if (s->count && !r->small.count)
    note(t,
         "No large scale is there to be removed, and no filter was applied: the unfiltered sigma "
         "%.3g um and tau %.3g um are those of the surface.",
         r->raw.sigma_um.mean, r->raw.tau_um.mean);
  if (t->main != &r->small)
    return;
  if (r->cutoff_um < 16 * r->small.tau_um.mean)
    note(t,
         "The cut-off of %.3g um is %.2g tau: it takes part of the small scale's own variance, "
         "sigma and tau are those behind the filter; sigma / tau is little affected.",
         r->cutoff_um, r->cutoff_um / r->small.tau_um.mean);
  if (!s->count)
    return;
  if (!s->from_fit)
    note(t,
         "Two Gaussian scales do not describe the surface (%.1f %% off): the cut-off is that of "
         "the largest slope measured, which noise moves.",
         100 * s->misfit);
  if (r->cutoff_um <= s->trials[0].cutoff_um * 1.01)
    note(t, "The slope grows down to the shortest cut-off: no small scale stands out.");
  if (r->cutoff_um >= s->trials[s->count - 1].cutoff_um * 0.99)
    note(t, "The slope grows up to the longest cut-off that the scans allow: no large scale is "
            "there to be removed, or the scans are too short to see it.");
}

/* Surfaces that scatter light are flat: steeper ones are mostly units mixed up. */
static void note_steep(note_taker *t) {
  const hetab_component *c = t->main;
  if (c->slope.mean > 1 || c->rms_slope.mean > 1)
    note(t,
         "sigma / tau is %.3g and the rms slope %.3g, %.0f degrees: are the units of places and "
         "heights the right ones? --unit mm,um gives them apart.",
         c->slope.mean, c->rms_slope.mean, atan(c->rms_slope.mean) * 180 / M_PI);
}

/* How the files were read. */
static void note_reading(note_taker *t, const hetab_heights *const *heights, size_t inputs) {
  for (size_t i = 0; i < inputs; i++)
    if (heights[i]->note)
      note(t, "%s", heights[i]->note);
}

hetab_status hetab_roughness_notes(hetab_context *ctx, hetab_roughness *roughness,
                                   const hetab_heights *const *heights, size_t inputs,
                                   double wavelength_um) {
  note_taker t = {ctx, roughness, roughness->small.count ? &roughness->small : &roughness->raw,
                  HETAB_OK};
  roughness->notes = hetab_alloc(ctx, MOST_NOTES, sizeof *roughness->notes);
  HETAB_NEED(roughness->notes);
  note_reading(&t, heights, inputs);
  note_steep(&t);
  note_distribution(&t);
  note_jagged(&t);
  note_scales(&t);
  note_curvature(&t, wavelength_um);
  note_length(&t);
  note_spacing(&t);
  note_cutoff(&t);
  note_missing(&t);
  return t.status;
}
