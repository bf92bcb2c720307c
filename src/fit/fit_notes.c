/* The result in plain sentences: what the numbers do not say by themselves. */
#include "fit/fit_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static const double POOR = 0.1;     /* E: the model does not describe the measurements */
static const double MIRROR_DEG = 3; /* instruments' apertures: they see the mirror this near */
static const double MUCH_SPECULAR = 1e-3;
static const double CORRELATED = 0.98;
enum { MOST_NOTES = 32 };

typedef struct notes {
  const hetab_fit_problem *p;
  hetab_fit *fit;
  hetab_status status;
} notes;

static void note(notes *n, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void note(notes *n, const char *format, ...) {
  char text[512];
  va_list args;
  if (n->status != HETAB_OK || n->fit->note_count == MOST_NOTES)
    return;
  va_start(args, format);
  int length = vsnprintf(text, sizeof text, format, args);
  va_end(args);
  size_t size = length < (int)sizeof text ? (size_t)length + 1 : sizeof text;
  char *copy = hetab_alloc(n->p->ctx, size, 1);
  if (!copy) {
    n->status = HETAB_ERR_MEMORY;
    return;
  }
  snprintf(copy, size, "%s", text);
  n->fit->notes[n->fit->note_count++] = copy;
}

static const char *bound_words(const hetab_fit *fit) {
  return fit->constraint == HETAB_FIT_ENERGY ? "1 (energy)" : "that of the polished material";
}

/* ---- convergence ----------------------------------------------------------------------------- */

static void note_stop(notes *n) {
  if (n->fit->stop == HETAB_FIT_STOP_BUDGET)
    note(n, "Not converged: stopped after %zu evaluations with the best so far.",
         n->p->evaluations);
  if (n->fit->stop == HETAB_FIT_STOP_INFEASIBLE)
    note(n,
         "No result: within the bounds nothing keeps rho_dh at or below %s; the values are the "
         "nearest to it. Widen the bounds or choose another constraint.",
         bound_words(n->fit));
  if (n->fit->ambiguous)
    note(n, "Another minimum is as good: the measurements do not tell which is right; the starts "
            "list where the others ended. Fix one of the unknowns or add incidences.");
}

static void note_fit_quality(notes *n) {
  if (n->fit->error > 1 && n->fit->weights != HETAB_FIT_WEIGHTS_LOG)
    note(n, "E is above 100 %%: f = 0 everywhere would be nearer to these measurements than this "
            "model is. The intervals mean nothing.");
  else if (n->fit->error > POOR)
    note(n,
         "The model does not describe these measurements: it leaves %.3g %% (E) unexplained. The "
         "intervals are those of the best fit of this model, not of the surface's roughness.",
         100 * n->fit->error);
}

/* ---- the constraint -------------------------------------------------------------------------- */

/* ", on the upper bound of slope, 1", where the fit without the constraint sits. */
static void name_wished_bound(const hetab_fit_problem *p, char *text, size_t size) {
  for (size_t f = 0; f < p->free_count; f++) {
    const hetab_fit_parameter *at = &p->options.parameters[p->free[f]];
    double value = p->wish.value[p->free[f]];
    int low = value <= at->low * (1 + 1e-6), high = value >= at->high * (1 - 1e-6);
    if (low || high)
      snprintf(text, size, ", on the %s of %s, %.4g",
               hetab_fit_end_name(low ? HETAB_FIT_END_LOW : HETAB_FIT_END_HIGH),
               hetab_fit_quantity_name(p->free[f]), value);
  }
}

static void note_constraint(notes *n) {
  const hetab_fit_wish *w = &n->p->wish;
  const hetab_fit *fit = n->fit;
  if (!fit->on_constraint || fit->stop == HETAB_FIT_STOP_INFEASIBLE)
    return;
  char on[96] = "";
  name_wished_bound(n->p, on, sizeof on);
  note(n,
       "The fit ends on the constraint: rho_dh may not exceed %s. Without it slope %.4g would fit "
       "with E %.3g %% instead of %.3g %%%s, but rho_dh would be %.3g too large at theta_i %.4g "
       "degrees and %.4g nm.",
       bound_words(fit), w->value[HETAB_FIT_SLOPE], 100 * sqrt(w->q), 100 * fit->error, on,
       w->excess, hetab_degrees(w->theta_i), 1e3 * w->lambda_um);
}

/* k of any wavelength fitted. */
static int is_metal(const hetab_surface *surface) {
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++)
    if (hetab_surface_bands(surface)[b].k > 0)
      return 1;
  return 0;
}

static void note_polished(notes *n) {
  double least = HUGE_VAL, theta = 0;
  if (n->fit->constraint != HETAB_FIT_ENERGY)
    return;
  for (size_t t = 0; t < n->fit->incidence_count; t++)
    if (n->fit->incidences[t].polished_margin < least) {
      least = n->fit->incidences[t].polished_margin;
      theta = hetab_degrees(n->fit->incidences[t].theta_i);
    }
  if (least < 0)
    note(n,
         "rho_dh is kept below 1, not below the polished surface's reflectance, which it exceeds "
         "by up to %.3g (theta_i %.4g degrees)%s.",
         -least, theta,
         is_metal(n->p->model.surface) ? ": the constraint `polished` keeps a metal below it"
                                       : ": light that enters a dielectric comes back");
}

static void note_asked(notes *n) {
  double asked = n->p->options.asked_diffuse, room = HUGE_VAL, theta = 0;
  if (asked <= 0)
    return;
  for (size_t t = 0; t < n->fit->incidence_count; t++)
    if (n->fit->incidences[t].room < room) {
      room = n->fit->incidences[t].room;
      theta = hetab_degrees(n->fit->incidences[t].theta_i);
    }
  if (asked <= room)
    note(n, "a = %.4g (reflectance) would keep to the bound: there is room for %.4g.", asked, room);
  else
    note(
        n,
        "a = %.4g (reflectance) would need rho_dh to exceed %s by %.4g at theta_i %.4g degrees: at "
        "this roughness there is room for %.4g there.",
        asked, bound_words(n->fit), asked - room, theta, fmax(room, 0));
}

/* ---- unknowns -------------------------------------------------------------------------------- */

static void note_bounds(notes *n) {
  size_t on_low = 0;
  for (size_t i = 0; i < n->fit->estimate_count; i++) {
    const hetab_fit_estimate *e = &n->fit->estimates[i];
    int diffuse = e->quantity == HETAB_FIT_DIFFUSE;
    if (diffuse && e->end == HETAB_FIT_END_LOW)
      on_low++;
    else if (e->end == HETAB_FIT_END_LOW || e->end == HETAB_FIT_END_HIGH)
      note(n, "%s ends on its %s, %.4g: the best value may lie beyond it.",
           hetab_fit_quantity_name(e->quantity), hetab_fit_end_name(e->end), e->value);
  }
  if (on_low)
    note(n, "The diffuse part is on its lower bound, %.3g, at %zu of %zu wavelengths.",
         n->p->options.parameters[HETAB_FIT_DIFFUSE].low, on_low,
         n->p->groups == 1 ? 1 : n->fit->bands);
}

static void note_correlation(notes *n) {
  const hetab_fit *fit = n->fit;
  for (size_t a = 0; a < n->p->free_count && a < fit->free_count; a++)
    for (size_t b = 0; b < a; b++) {
      double r = fit->correlation[a * fit->free_count + b];
      if (fabs(r) >= CORRELATED)
        note(n, "%s and %s are hardly determined apart: correlation %.5f.",
             hetab_fit_quantity_name(fit->estimates[fit->free_estimates[b]].quantity),
             hetab_fit_quantity_name(fit->estimates[fit->free_estimates[a]].quantity), r);
    }
}

static void note_undetermined(notes *n) {
  size_t diffuse = 0;
  for (size_t i = 0; i < n->fit->estimate_count; i++) {
    const hetab_fit_estimate *e = &n->fit->estimates[i];
    if (e->undetermined && e->quantity == HETAB_FIT_DIFFUSE)
      diffuse++;
    else if (e->undetermined)
      note(n, "%s is not determined by these measurements: its 95 %% interval is %.3g to %.3g.",
           hetab_fit_quantity_name(e->quantity), e->low, e->high);
  }
  if (diffuse)
    note(n, "The diffuse part is not determined at %zu wavelengths.", diffuse);
  if (n->fit->estimates[HETAB_FIT_SIGMA0].undetermined &&
      n->fit->estimates[HETAB_FIT_TAU].undetermined &&
      !n->fit->estimates[HETAB_FIT_SLOPE].undetermined)
    note(n, "Their ratio, the slope, is determined: a rough surface's reflection depends on little "
            "else. Give tau or sigma0 from a height scan.");
}

/* ---- the measurements ------------------------------------------------------------------------ */

static int is_near_mirror(const hetab_directions *p) {
  double cosine =
      cos(p->theta_i) * cos(p->theta_r) - sin(p->theta_i) * sin(p->theta_r) * cos(p->phi);
  return cosine > cos(MIRROR_DEG * M_PI / 180);
}

static void note_specular(notes *n) {
  const hetab_fit_data *data = &n->p->data;
  double most = 0, theta = 0;
  size_t near = 0;
  for (size_t i = 0; i < data->count; i++)
    near += (size_t)is_near_mirror(&data->pairs[i]);
  for (size_t t = 0; t < data->incidence_count; t++)
    for (size_t b = 0; b < data->bands; b++) {
      double rho_s = n->p->model.reflectances[b * data->incidence_count + t].specular;
      if (rho_s > most) {
        most = rho_s;
        theta = hetab_degrees(data->theta_i[t]);
      }
    }
  if (near && most > MUCH_SPECULAR)
    note(n,
         "The fitted surface has a specular part (rho_s %.3g at theta_i %.4g degrees), which the "
         "fit leaves out and an instrument sees: %zu measured pairs lie within %g degrees of the "
         "mirror direction. Leave them out to see whether it matters.",
         most, theta, near, MIRROR_DEG);
}

static void note_data(notes *n) {
  const hetab_fit_data *data = &n->p->data;
  size_t zeros = data->count * data->bands - data->missing - data->values;
  if (data->below_horizon)
    note(n, "%zu rows of the file lie below the horizon and were left out.", data->below_horizon);
  if (data->missing)
    note(n, "%zu values are missing.", data->missing);
  if (data->negative && n->p->options.weights != HETAB_FIT_WEIGHTS_LOG)
    note(n, "%zu values are below 0, as noise about a weak signal is; they are in the fit.",
         data->negative);
  if (n->p->distrusted_count)
    note(n,
         "%zu of %zu values lie more than 5 robust standard deviations off the model and count for "
         "little: --points and --json list them as distrusted.",
         n->p->distrusted_count, data->values);
  if (data->thinned)
    note(n, "%zu pairs of directions were left out evenly, to keep %zu.", data->thinned,
         data->count);
  if (n->p->options.weights == HETAB_FIT_WEIGHTS_LOG && zeros)
    note(n, "%zu values of 0 or below have no logarithm and were left out.", zeros);
}

hetab_status hetab_fit_add_notes(const hetab_fit_problem *problem, hetab_fit *fit) {
  notes n = {.p = problem, .fit = fit};
  fit->notes = hetab_alloc(problem->ctx, MOST_NOTES, sizeof *fit->notes);
  HETAB_NEED(fit->notes);
  note_stop(&n);
  note_constraint(&n);
  note_asked(&n);
  note_fit_quality(&n);
  note_undetermined(&n);
  note_correlation(&n);
  note_bounds(&n);
  note_polished(&n);
  note_specular(&n);
  note_data(&n);
  return n.status;
}
