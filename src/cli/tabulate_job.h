/* The tabulate command's job, shared by what runs it and what reports it. */
#ifndef HETAB_CLI_TABULATE_JOB_H
#define HETAB_CLI_TABULATE_JOB_H

#include <hetab/hetab.h>
#include "options.h"

typedef enum output_format {
  OUTPUT_H5,
  OUTPUT_MERL,
  OUTPUT_RGL,
  OUTPUT_EXR,
  OUTPUT_FORMATS
} output_format;

typedef struct table_output {
  const char *path;
  output_format format;
  char *specular_path;        /* MERL, RGL: the CSV of the specular reflectance beside it */
  hetab_table_writer *writer; /* H5, until it is committed */
  hetab_table_writer *exr;    /* EXR, likewise */
  size_t saturated;           /* EXR: pixels too large for half precision */
} table_output;

/* What the command line asks for. */
typedef struct tabulate_request {
  const char *surface;
  cli_list files;
  const char *axes[HETAB_AXIS_COUNT], *wavelengths, *device, *bands;
  int precision, method, element, sampling, colour; /* -1: chosen; element: as precision */
  int exr_parts, exr_type;                          /* as hetab_exr_parts, hetab_exr_element */
  double tolerance, cone_deg, table_error;
  size_t samples, seed, compression;
  int force, quiet, json;
} tabulate_request;

typedef struct tabulate_job {
  const tabulate_request *request;
  hetab_context *ctx;
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_preload *preload;
  hetab_engine *engine; /* NULL if all is done on the host */
  table_output *outputs;
  size_t output_count;
  hetab_h5_options h5_options;
  hetab_exr_options exr_options;
  int bad_slab; /* a NaN, infinite or negative entry came */
  hetab_merl_options merl_options;
  hetab_merl *merl;
  hetab_rgl_options rgl_options;
  hetab_rgl *rgl;
  hetab_rgl_report rgl_report;
  hetab_report reports[OUTPUT_FORMATS];
  double specular_max[OUTPUT_FORMATS]; /* largest rho_s */
} tabulate_job;

/* -1 to go on with *request, else the exit status. */
int tabulate_parse(const cli_command *self, int argc, char **argv, tabulate_request *request);

/* The summary on standard output; the exit status. */
int tabulate_summary(const tabulate_job *job);

#endif
