/* The fit command's options, in groups, each of which returns the place after its last one; and
 * what they have to be. */
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "fit_request.h"
#include "numbers.h"
#include "core/held_files.h"

/* ---- what is free -------------------------------------------------------------------------- */

static const char *const quantities[HETAB_FIT_QUANTITIES] = {"slope", "sigma0", "tau", "n", "a"};

/* The quantity that text[length] names; HETAB_FIT_QUANTITIES: none. */
static int quantity_of(const char *text, size_t length) {
  int q = 0;
  while (q < HETAB_FIT_QUANTITIES &&
         (strlen(quantities[q]) != length || memcmp(quantities[q], text, length) != 0))
    q++;
  return q;
}

static int parse_free(const cli_command *self, fit_request *r) {
  for (const char *text = r->free; *text;) {
    size_t length = strcspn(text, ",");
    int one = length == strlen("a-constant") && memcmp(text, "a-constant", length) == 0;
    int q = one ? HETAB_FIT_DIFFUSE : quantity_of(text, length);
    if (q == HETAB_FIT_QUANTITIES)
      return cli_usage(self, "--free: '%.*s' is none of slope, sigma0, tau, n, a, a-constant",
                       (int)length, text);
    r->options.parameters[q].free = 1;
    r->options.one_diffuse |= one;
    text += length + (text[length] == ',');
  }
  return -1;
}

/* "slope=0.01:0.5" */
static int parse_bounds(const cli_command *self, fit_request *r, const char *text) {
  double bounds[2];
  size_t length = strcspn(text, "=");
  int q = quantity_of(text, length);
  if (q == HETAB_FIT_QUANTITIES || !strchr(text + length, ':'))
    return cli_usage(self, "--bounds: '%s' is not NAME=LOW:HIGH with a name of --free", text);
  if (!cli_interval(text + length + 1, &bounds[0], &bounds[1]) || bounds[0] == bounds[1] ||
      bounds[0] < 0)
    return cli_usage(self, "--bounds: '%s': give two numbers, the lower one first", text);
  if (!r->options.parameters[q].free)
    return cli_usage(self, "--bounds: %s is not free: name it in --free", quantities[q]);
  r->options.parameters[q].low = bounds[0];
  r->options.parameters[q].high = bounds[1];
  return -1;
}

int fit_check(const cli_command *self, fit_request *r) {
  int status = parse_free(self, r);
  for (size_t i = 0; i < r->bounds.count && status < 0; i++)
    status = parse_bounds(self, r, r->bounds.items[i]);
  if (status >= 0)
    return status;
  if (!r->index)
    return cli_usage(self, "no --index given: name a metal, n=N or a file");
  const char *outputs[] = {r->surface, r->csv, r->points, r->html};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      if (outputs[i] && outputs[j] && i < j && hetab_same_file(outputs[i], outputs[j]))
        return cli_usage(self, "two outputs would be %s: give one another name", outputs[i]);
  if (r->per_wavelength && r->surface)
    return cli_usage(self, "--surface takes one fit: leave out --per-wavelength");
  return -1;
}

/* ---- the command line ---------------------------------------------------------------------- */

/* What is free, and what is given. */
static cli_option *unknown_options(cli_option *next, fit_request *r) {
  hetab_fit_options *o = &r->options;
  hetab_fit_parameter *p = r->options.parameters;
  const cli_option options[] = {
      {CLI_TEXT, "free", 0, "LIST",
       "what is fitted, of slope, sigma0, tau, n, a (one for each wavelength), a-constant (one for "
       "all) (slope,a)",
       &r->free, 0, 0},
      {CLI_NUMBER, "slope", 0, "S", "sigma0 / tau: given, or a start if it is free",
       &p[HETAB_FIT_SLOPE].value, 1e-4, 10},
      {CLI_NUMBER, "sigma0", 0, "UM", "rms height, likewise", &p[HETAB_FIT_SIGMA0].value, 1e-4,
       1e3},
      {CLI_NUMBER, "tau", 0, "UM", "correlation length, likewise", &p[HETAB_FIT_TAU].value, 1e-3,
       1e4},
      {CLI_NUMBER, "a", 0, "R", "diffuse part as a reflectance, if it is not free (0)",
       &p[HETAB_FIT_DIFFUSE].value, 0, 10},
      {CLI_TEXT, "index", 0, "INDEX",
       "refractive index: a metal ('hetab surfaces'), n=N or n=N,k=K, or a file", &r->index, 0, 0},
      {CLI_FLAG, "extrapolate", 0, NULL, "allow wavelengths outside the index data",
       &o->extrapolate_index, 0, 0},
      {CLI_LIST, "bounds", 0, "NAME=LOW:HIGH",
       "bounds of what is free (slope 0.005:1, sigma0 0.01:10, tau 0.3:100, n 1.05:3, a 0:1)",
       &r->bounds, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* Which measurements are used. */
static cli_option *data_options(cli_option *next, fit_request *r) {
  hetab_fit_options *o = &r->options;
  const cli_option options[] = {
      {CLI_TEXT, "wavelengths", 0, "SPEC", "those used, in nm: start:stop:step, a list, all (all)",
       &r->wavelengths, 0, 0},
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incidences used, in degrees: start:stop:count or a list (all)", &r->theta_i, 0, 0},
      {CLI_FLAG, "plane", 0, NULL, "use the incidence plane alone", &o->plane, 0, 0},
      {CLI_NUMBER, "exclude-mirror", 0, "DEG",
       "leave out views this near the mirror direction, where instruments see the specular delta "
       "(0)",
       &r->exclude_mirror_deg, 0, 180},
      {CLI_COUNT, "max-points", 0, "N", "pairs of directions used at most, evenly (100000)",
       &o->max_points, 10, 1e7},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* How they are fitted. */
static cli_option *search_options(cli_option *next, fit_request *r) {
  hetab_fit_options *o = &r->options;
  const cli_option options[] = {
      {CLI_CHOICE, "weights", 0, "auto|report|energy|equal|relative|log",
       "of the squared differences; report: cos^2(theta_r), Eq. 5 as printed; energy: "
       "cos(theta_i) cos(theta_r) dOmega; auto: report for scans of the incidence plane, else "
       "energy (auto)",
       &r->weights, 0, 0},
      {CLI_CHOICE, "constraint", 0, "auto|polished|energy|none",
       "rho_dh at most that of the polished material, or 1; auto: polished if k > 0 (auto)",
       &r->constraint, 0, 0},
      {CLI_NUMBER, "ask-a", 0, "R", "say what this diffuse part would need", &o->asked_diffuse, 0,
       10},
      {CLI_FLAG, "per-wavelength", 0, NULL, "a fit of its own for each wavelength",
       &r->per_wavelength, 0, 0},
      {CLI_COUNT, "starts", 0, "N", "random starts (4)", &o->starts, 1, 10000},
      {CLI_COUNT, "seed", 0, "N", "of the starts and the bootstrap (0)", &r->seed, 0, 4294967295.0},
      {CLI_COUNT, "max-evaluations", 0, "N", "of the objective, in all (20000)",
       &o->max_evaluations, 10, 1e9},
      {CLI_FLAG, "derivative-free", 0, NULL, "COBYLA alone, without SLSQP after it",
       &o->derivative_free, 0, 0},
      {CLI_FLAG, "robust", 0, NULL,
       "a Cauchy loss in place of squares: values far off do not pull, and are listed", &o->robust,
       0, 0},
      {CLI_COUNT, "bootstrap", 0, "N", "intervals also from N resamplings of the pairs (0)",
       &o->bootstrap, 0, 100000},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* What is written. */
static cli_option *output_options(cli_option *next, fit_request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "surface", 0, "FILE", "write the fitted surface as YAML, for 'hetab tabulate'",
       &r->surface, 0, 0},
      {CLI_TEXT, "csv", 0, "FILE", "write the estimates as CSV", &r->csv, 0, 0},
      {CLI_TEXT, "points", 0, "FILE", "write measured and fitted values as CSV", &r->points, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with the plots", &r->html, 0, 0},
      {CLI_CHOICE, "precision", 0, "double|float", "arithmetic on the device (double)",
       &r->precision, 0, 0},
      CLI_DEVICE(&r->device),
      CLI_FORCE(&r->force),
      {CLI_FLAG, "quiet", 'q', NULL, "print no progress", &r->quiet, 0, 0},
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {measurements, device, precision, version, fits: [{error, rms, weights, "
       "constraint, stop, on_constraint, ambiguous, margin, pairs, values, missing, thinned, "
       "evaluations, estimates: [{quantity, wavelength_nm, value, low, high, bootstrap_low, "
       "bootstrap_high, unconstrained, end, determined}], correlation: {estimates, matrix}, "
       "incidences: [{theta_i_deg, values, error, rms, mean, bias, margin, margin_wavelength_nm, "
       "rho_dh, bound, polished_margin, room, excess}], starts: [{start, end, error, feasible, "
       "best, probe}], distrusted: [{wavelength_nm, theta_i_deg, theta_r_deg, phi_deg, measured, "
       "model}], notes}]}",
       &r->json, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

int fit_parse(const cli_command *self, int argc, char **argv, fit_request *r) {
  cli_option options[CLI_MAX_OPTIONS + 1] = {{0}};
  cli_option *next = unknown_options(options, r);
  next = data_options(next, r);
  next = search_options(next, r);
  output_options(next, r);
  int status = cli_parse_operand(self, options, argc, argv, "MEASUREMENTS", &r->measurements);
  r->options.exclude_mirror = hetab_radians(r->exclude_mirror_deg);
  return status;
}
