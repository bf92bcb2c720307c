/* The tabulate command's job, shared by what runs it and what reports it. */
#pragma once

#include <hetab/hetab.h>
#include "options.h"

/* What the command line asks for. */
typedef struct tabulate_request {
  const char *surface;
  cli_list files;
  const char *axes[HETAB_AXIS_COUNT], *wavelengths, *device, *bands;
  int precision, method, element, sampling, colour; /* -1: chosen; element: as precision */
  int exr_parts, exr_type; /* as hetab_exr_parts, hetab_exr_element; -1: as exr_parts has it */
  int renderer;            /* tabulate_renderers[]; -1: none named */
  double tolerance, cone_deg, table_error;
  size_t samples, seed, compression;
  int force, quiet, json;
} tabulate_request;

typedef struct tabulate_job {
  const tabulate_request *request;
  hetab_context *ctx;
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_engine_options engine;
  hetab_tabulate_options sample;
  hetab_h5_options h5;
  hetab_exr_options exr;
  hetab_merl_options merl;
  hetab_rgl_options rgl;
  hetab_output_report *reports; /* [request->files.count] */
} tabulate_job;

/* What reads .bsdf tables, in the order of --for. */
typedef struct tabulate_renderer {
  const char *name;
  hetab_rgl_bands bands;
} tabulate_renderer;
extern const tabulate_renderer tabulate_renderers[];

/* -1 to go on with *request, else the exit status. */
int tabulate_parse(const cli_command *self, int argc, char **argv, tabulate_request *request);

int tabulate_has_format(const tabulate_request *request, hetab_format format);

/* The summary on standard output; the exit status. */
int tabulate_summary(const tabulate_job *job);
