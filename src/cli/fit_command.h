/* The fit command's results, shared by what computes them and what reports them. */
#pragma once

#include <stdio.h>
#include <jansson.h>
#include <hetab/hetab.h>

/* One fit, or with --per-wavelength one for each wavelength. */
typedef struct fit_report {
  const hetab_measurements *measurements;
  hetab_fit **fits;
  size_t count;
  const char *device;
  hetab_precision precision;
} fit_report;

void fit_print(const fit_report *report);

/* Its keys are those that `hetab fit --help` documents. */
json_t *fit_json(const fit_report *report);

/* The estimates, and measured and fitted values side by side. */
void fit_csv(FILE *stream, const fit_report *report);
void fit_points_csv(FILE *stream, const fit_report *report);

/* One self-contained page of measurement, fit and residuals. Fails where the model cannot be
 * evaluated for the curves. */
hetab_status fit_html(hetab_context *ctx, FILE *stream, const fit_report *report);
