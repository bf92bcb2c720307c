/* The predict command's result, shared by what computes it and what reports it. */
#pragma once

#include <stdio.h>
#include <jansson.h>
#include <hetab/hetab.h>

typedef struct predict_report {
  const hetab_surface *surface;
  const hetab_measurements *measurements; /* NULL: none */
  const hetab_prediction *prediction;
  const hetab_prediction *with_tau;   /* the same slopes by tau; NULL: not asked for */
  size_t theta_i_count, lambda_count; /* of the prediction's curves */
  double accuracy;
} predict_report;

/* "sigma0 at fixed tau", "tau at fixed sigma0", "sigma0 and tau"; NULL without bounds. */
const char *predict_varied(const hetab_prediction *prediction);

/* The delta of a rough surface is e^-g: what float leaves of it at 1e-40 is nothing. */
static inline double predict_shown(double rho_s) {
  return rho_s < 1e-30 ? 0 : rho_s;
}

void predict_print(const predict_report *report);
/* The curves and the measured points. */
void predict_csv(FILE *stream, const predict_report *report);
/* Its keys are those that `hetab predict --help` documents. */
json_t *predict_json(const predict_report *report);
/* One self-contained page. */
void predict_html(FILE *stream, const predict_report *report);
