/* Fits on the terminal, and as CSV. */
#include <math.h>
#include <stdio.h>

#include "core/angle.h"
#include "fit_command.h"
#include "options.h"

static const char *const units[HETAB_FIT_QUANTITIES] = {"", "um", "um", "", ""};

/* ---- one fit ------------------------------------------------------------------------------- */

static void print_label(const hetab_fit_estimate *e) {
  char text[64];
  int diffuse = e->quantity == HETAB_FIT_DIFFUSE;
  static const char *const names[HETAB_FIT_QUANTITIES] = {"slope", "sigma0", "tau", "n", "a"};
  if (diffuse && e->lambda_um > 0)
    snprintf(text, sizeof text, "a %.6g nm", 1e3 * e->lambda_um);
  else
    snprintf(text, sizeof text, "%s%s%s", names[e->quantity], *units[e->quantity] ? " " : "",
             units[e->quantity]);
  printf("  %-12s", text);
}

static void print_estimate(const hetab_fit *fit, const hetab_fit_estimate *e) {
  print_label(e);
  if (e->low == e->high)
    printf("%12.6g %11s %-11s", e->value, "", "");
  else
    printf("%12.6g %11.5g %-11.5g", e->value, e->low, e->high);
  if (fit->bootstrap_count)
    printf(" %11.5g %-11.5g", e->bootstrap_low, e->bootstrap_high);
  printf(" %s%s\n", hetab_fit_end_name(e->end), e->undetermined ? ", not determined" : "");
}

static void print_head(const fit_report *report, const hetab_fit *fit) {
  printf("%s: %zu values at %zu pairs of directions, %zu wavelength%s, %zu incidence%s\n",
         hetab_measurements_name(report->measurements), fit->used_values, fit->used_pairs,
         fit->bands, fit->bands == 1 ? "" : "s", fit->incidence_count,
         fit->incidence_count == 1 ? "" : "s");
  printf("error E %.4g %% (weights: %s), rms %.4g /sr; stopped: %s after %zu evaluations\n",
         100 * fit->error, hetab_fit_weights_name(fit->weights), fit->rms,
         hetab_fit_stop_name(fit->stop), fit->evaluations);
  printf("constraint %s: %s\n\n", hetab_fit_constraint_name(fit->constraint),
         fit->stop == HETAB_FIT_STOP_INFEASIBLE ? "cannot be kept within the bounds"
         : fit->on_constraint                   ? "the fit ends on it"
                                                : "not reached");
}

static void print_estimates(const hetab_fit *fit) {
  printf("  %-12s%12s %11s %-11s", "", "value", "95 % from", "to");
  if (fit->bootstrap_count)
    printf(" %11s %-11s", "bootstrap", "to");
  puts(" ended");
  for (size_t i = 0; i < fit->estimate_count; i++)
    print_estimate(fit, &fit->estimates[i]);
  puts("  (a: as a reflectance, pi times the diffuse BRDF)");
}

static void print_incidences(const hetab_fit *fit) {
  printf("\n  %9s %7s %9s %10s %10s %9s %9s %10s %9s\n", "theta_i", "values", "E %", "rms /sr",
         "bias /sr", "rho_dh", "bound", "margin", "a fits");
  for (size_t i = 0; i < fit->incidence_count; i++) {
    const hetab_fit_incidence *in = &fit->incidences[i];
    printf("  %9.4g %7zu %9.3g %10.3g %10.2g %9.5f %9.5f %10.2e %9.4g\n",
           hetab_degrees(in->theta_i), in->values, 100 * in->error, in->rms, in->bias, in->rho_dh,
           in->bound, in->margin, fmax(in->room, 0));
  }
}

static int is_roughness_or_index(const hetab_fit *fit, size_t i) {
  return fit->estimates[fit->free_estimates[i]].quantity != HETAB_FIT_DIFFUSE;
}

/* Among roughness and index, and the largest of a diffuse part with them; JSON has all. */
static void print_correlations(const hetab_fit *fit) {
  for (size_t a = 0; a < fit->free_count; a++)
    for (size_t b = 0; b < a; b++)
      if (is_roughness_or_index(fit, b) && (fit->free_count <= 4 || is_roughness_or_index(fit, a)))
        printf("  correlation of %s and %s: %.4f\n",
               hetab_fit_quantity_name(fit->estimates[fit->free_estimates[b]].quantity),
               hetab_fit_quantity_name(fit->estimates[fit->free_estimates[a]].quantity),
               fit->correlation[a * fit->free_count + b]);
}

static void print_starts(const hetab_fit *fit) {
  size_t best = 0, starts = 0;
  for (size_t i = 0; i < fit->start_count; i++) {
    starts += (size_t)!fit->starts[i].probe;
    best += (size_t)(fit->starts[i].best && !fit->starts[i].probe);
  }
  if (starts)
    printf("  %zu of %zu starts gave this answer\n", best, starts);
}

static void print_notes(const hetab_fit *fit) {
  if (fit->note_count)
    putchar('\n');
  for (size_t i = 0; i < fit->note_count; i++) {
    int column = printf("  -");
    cli_print_wrapped(fit->notes[i], 4, column);
  }
}

static void print_one(const fit_report *report, const hetab_fit *fit) {
  print_head(report, fit);
  print_estimates(fit);
  print_incidences(fit);
  putchar('\n');
  print_correlations(fit);
  print_starts(fit);
  print_notes(fit);
}

/* ---- a fit for each wavelength ------------------------------------------------------------- */

static void print_row(const hetab_fit *fit) {
  const hetab_fit_estimate *slope = &fit->estimates[HETAB_FIT_SLOPE];
  const hetab_fit_estimate *diffuse = &fit->estimates[fit->estimate_count - 1];
  printf("  %7.6g %9.3g %11.5g %11.5g %-11.5g %10.4g %10.4g %-10.4g %s%s\n",
         1e3 * fit->lambda_um[0], 100 * fit->error, slope->value, slope->low, slope->high,
         diffuse->value, diffuse->low, diffuse->high, hetab_fit_stop_name(fit->stop),
         fit->on_constraint ? ", on the constraint" : "");
}

static void print_all(const fit_report *report) {
  printf("%s: a fit for each wavelength\n\n", hetab_measurements_name(report->measurements));
  printf("  %7s %9s %11s %11s %-11s %10s %10s %-10s %s\n", "nm", "E %", "slope", "95 % from", "to",
         "a", "95 % from", "to", "stopped");
  for (size_t i = 0; i < report->count; i++)
    print_row(report->fits[i]);
  for (size_t i = 0; i < report->count; i++)
    if (report->fits[i]->note_count) {
      printf("\n%.6g nm:", 1e3 * report->fits[i]->lambda_um[0]);
      print_notes(report->fits[i]);
    }
}

void fit_print(const fit_report *report) {
  if (report->count == 1)
    print_one(report, report->fits[0]);
  else
    print_all(report);
}

/* ---- CSV ----------------------------------------------------------------------------------- */

static void print_number(FILE *stream, double value) {
  if (isfinite(value))
    fprintf(stream, ",%.10g", value);
  else
    fputc(',', stream);
}

static void print_csv_row(FILE *stream, const hetab_fit *fit, const hetab_fit_estimate *e) {
  fputs(hetab_fit_quantity_name(e->quantity), stream);
  print_number(stream, e->lambda_um > 0  ? 1e3 * e->lambda_um
                       : fit->bands == 1 ? 1e3 * fit->lambda_um[0]
                                         : (double)NAN);
  const double numbers[] = {e->value,          e->low,    e->high,   e->bootstrap_low,
                            e->bootstrap_high, e->wanted, fit->error};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    print_number(stream, numbers[i]);
  fprintf(stream, ",%s,%d,%s\n", hetab_fit_end_name(e->end), !e->undetermined,
          hetab_fit_stop_name(fit->stop));
}

void fit_csv(FILE *stream, const fit_report *report) {
  fputs("quantity,wavelength_nm,value,low,high,bootstrap_low,bootstrap_high,unconstrained,error,"
        "end,determined,stop\n",
        stream);
  for (size_t i = 0; i < report->count; i++)
    for (size_t k = 0; k < report->fits[i]->estimate_count; k++)
      print_csv_row(stream, report->fits[i], &report->fits[i]->estimates[k]);
}

static void print_point(FILE *stream, const fit_report *report, const hetab_fit *fit, size_t i,
                        size_t b) {
  const hetab_measurements *m = report->measurements;
  const hetab_directions *p = &hetab_measurements_pairs(m)[i];
  double measured =
      hetab_measurements_values(m)[i * hetab_measurements_wavelength_count(m) + fit->band_of[b]];
  fprintf(stream, "%.10g,%.8g,%.8g,%.8g", 1e3 * fit->lambda_um[b], hetab_degrees(p->theta_i),
          hetab_degrees(p->theta_r), hetab_degrees(p->phi));
  print_number(stream, measured);
  print_number(stream, fit->model[i * fit->bands + b]);
  fprintf(stream, ",%d,%d\n", fit->used[i * fit->bands + b], fit->distrusted[i * fit->bands + b]);
}

void fit_points_csv(FILE *stream, const fit_report *report) {
  fputs("wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,measured,model,used,distrusted\n", stream);
  for (size_t f = 0; f < report->count; f++)
    for (size_t i = 0; i < hetab_measurements_pair_count(report->measurements); i++)
      for (size_t b = 0; b < report->fits[f]->bands; b++)
        print_point(stream, report, report->fits[f], i, b);
}
