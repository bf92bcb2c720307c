/* What the fit command is asked for. */
#pragma once

#include <hetab/hetab.h>
#include "options.h"

typedef struct fit_request {
  const char *measurements, *free, *index, *wavelengths, *theta_i;
  const char *surface, *csv, *points, *html, *device;
  cli_list bounds;
  int weights, constraint, precision, per_wavelength, force, quiet, json;
  double exclude_mirror_deg;
  size_t seed;
  hetab_fit_options options;
} fit_request;

/* As cli_parse_operand; and whether it makes sense. */
int fit_parse(const cli_command *self, int argc, char **argv, fit_request *r);
int fit_check(const cli_command *self, fit_request *r);
