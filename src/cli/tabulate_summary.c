/* What a finished tabulation says on standard output. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/angle.h"
#include "output.h"
#include "tabulate_job.h"

static double rate(double entries, double seconds) {
  return seconds > 0 ? entries / seconds : 0;
}

/* Of the file's numbers. */
static hetab_error_stats file_error(const tabulate_job *job, const table_output *output) {
  const hetab_error_stats *error = &job->reports[output->format].error;
  hetab_h5_options rounded = {.element = HETAB_FLOAT, .slabs = job->exr_options.slabs};
  if (output->format == OUTPUT_EXR)
    return hetab_h5_error(&rounded, error);
  return output->format == OUTPUT_H5 ? hetab_h5_error(&job->h5_options, error) : *error;
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static json_t *specular_json(const tabulate_job *job, const table_output *output) {
  double cone = output->format == OUTPUT_MERL ? hetab_degrees(job->merl_options.specular_cone) : 0;
  return json_pack("{sf so so sf}", "max", job->specular_max[output->format], "file",
                   cli_json_text(output->specular_path ? output->specular_path : output->path),
                   "in_table", json_boolean(cone > 0), "cone_deg", cone);
}

static const char *bands_name(const tabulate_job *job) {
  return job->rgl_options.bands == HETAB_RGL_SPECTRAL ? "spectral" : "rgb";
}

static json_t *rgl_json(const tabulate_job *job) {
  const hetab_rgl_report *r = &job->rgl_report;
  return json_pack("{ss sf sf sf sf sI sI sI sI}", "bands", bands_name(job), "table_error",
                   r->target, "error_l1", r->error_l1, "bias", r->bias, "error_grazing",
                   r->error_grazing, "theta_i", (json_int_t)r->theta_i_count, "resolution",
                   (json_int_t)r->resolution, "bytes", (json_int_t)r->bytes, "clamped",
                   (json_int_t)r->clamped);
}

static const char *format_name(output_format format) {
  static const char *const names[OUTPUT_FORMATS] = {
      [OUTPUT_H5] = "hdf5", [OUTPUT_MERL] = "merl", [OUTPUT_RGL] = "rgl", [OUTPUT_EXR] = "exr"};
  return names[format];
}

static json_t *output_json(const tabulate_job *job, const table_output *output) {
  const hetab_report *report = &job->reports[output->format];
  hetab_error_stats error = file_error(job, output);
  json_t *json = json_pack("{so ss sf sf sf sf sf so so}", "file", cli_json_text(output->path),
                           "format", format_name(output->format), "entries", report->entries,
                           "seconds", report->wall_seconds, "entries_per_second",
                           rate(report->entries, report->wall_seconds), "kernel_seconds",
                           report->kernel_seconds, "kernel_entries_per_second",
                           rate(report->entries, report->kernel_seconds), "error",
                           cli_json_error(&error), "specular", specular_json(job, output));
  if (json && output->format == OUTPUT_MERL)
    json_object_set_new(json, "clamped", json_integer((json_int_t)report->clamped));
  if (json && output->format == OUTPUT_EXR)
    json_object_set_new(json, "saturated", json_integer((json_int_t)output->saturated));
  if (json && output->format == OUTPUT_RGL)
    json_object_set_new(json, "table", rgl_json(job));
  return json;
}

static json_t *engine_json(const hetab_engine *engine) {
  if (!engine)
    return json_pack("{sn sn sn sn}", "device", "method", "precision", "tolerance");
  return json_pack("{so ss ss sf}", "device", cli_json_text(hetab_engine_device(engine)), "method",
                   hetab_method_name(hetab_engine_method(engine)), "precision",
                   hetab_precision_name(hetab_engine_precision(engine)), "tolerance",
                   hetab_engine_tolerance(engine));
}

static int print_json(const tabulate_job *job) {
  json_t *outputs = json_array();
  for (size_t i = 0; i < job->output_count; i++)
    json_array_append_new(outputs, output_json(job, &job->outputs[i]));
  json_t *json = json_pack("{so}", "surface", cli_json_text(hetab_surface_name(job->surface)));
  json_object_update_new(json, engine_json(job->engine));
  json_object_set_new(json, "version", json_string(hetab_version()));
  json_object_set_new(json, "outputs", outputs);
  return cli_json_print(json);
}

/* ---- text ---------------------------------------------------------------------------------- */

static int longest_path(const tabulate_job *job) {
  size_t longest = strlen("file");
  for (size_t i = 0; i < job->output_count; i++)
    if (strlen(job->outputs[i].path) > longest)
      longest = strlen(job->outputs[i].path);
  return (int)longest;
}

static void print_row(const tabulate_job *job, const table_output *output, int width) {
  const hetab_report *report = &job->reports[output->format];
  hetab_error_stats error = file_error(job, output);
  char entries[16], speed[16], kernel[16] = "-", max[16], p99[16], rms[16];
  cli_si(report->entries, entries, sizeof entries);
  cli_si(rate(report->entries, report->wall_seconds), speed, sizeof speed);
  if (report->kernel_seconds > 0)
    cli_si(rate(report->entries, report->kernel_seconds), kernel, sizeof kernel);
  cli_error_text(&error, error.max_rel, max, sizeof max);
  cli_error_text(&error, error.p99_rel, p99, sizeof p99);
  cli_error_text(&error, error.rms_rel, rms, sizeof rms);
  printf("%-*s %8s %8.3f %10s %10s %9s %9s %9s\n", width, output->path, entries,
         report->wall_seconds, speed, kernel, max, p99, rms);
}

static void print_rgl(const tabulate_job *job, const char *path) {
  const hetab_rgl_report *r = &job->rgl_report;
  printf("%s: %s, %zu incidences of %zu x %zu nodes, %.2f MB; relative L1 error at most %.2g (%.2g "
         "asked for), bias %.2g; beyond 80 degrees %.2g\n",
         path, bands_name(job), r->theta_i_count, r->resolution, r->resolution,
         1e-6 * (double)r->bytes, r->error_l1, r->target, r->bias, r->error_grazing);
  if (r->error_l1 > r->target || fabs(r->bias) > r->target / 3.0 || r->error_grazing > 0.1)
    printf("%s: warning: no table of any size keeps that error, this is the largest: allow more by "
           "--table-error, or take .h5\n",
           path);
}

static void print_notes(const tabulate_job *job, const table_output *output) {
  int merl = output->format == OUTPUT_MERL;
  double max = job->specular_max[output->format];
  double cone = merl ? hetab_degrees(job->merl_options.specular_cone) : 0;
  size_t clamped = job->reports[output->format].clamped;
  if (output->format == OUTPUT_H5) {
    printf("%s: specular reflectance, at most %.3g, is in /specular_reflectance\n", output->path,
           max);
    return;
  }
  if (output->format == OUTPUT_EXR) {
    printf("%s: specular reflectance, at most %.3g, is in the part specular_reflectance\n",
           output->path, max);
    if (output->saturated)
      printf("%s: %zu pixels above 65504 are stored as 65504: take --exr-type float\n",
             output->path, output->saturated);
    return;
  }
  if (output->format == OUTPUT_RGL)
    print_rgl(job, output->path);
  if (cone > 0)
    printf("%s: specular reflectance, at most %.3g, folded in as a %g degree lobe; "
           "do not add %s again\n",
           output->path, max, cone, output->specular_path);
  else
    printf("%s: specular reflectance, at most %.3g, omitted; it is in %s\n", output->path, max,
           output->specular_path);
  if (clamped)
    printf("%s: %zu cells out of gamut: negative values set to 0\n", output->path, clamped);
}

static void print_engine(const tabulate_job *job) {
  const hetab_engine *engine = job->engine;
  if (engine)
    printf("%s on %s, method %s, %s\n", hetab_surface_name(job->surface),
           hetab_engine_device(engine), hetab_method_name(hetab_engine_method(engine)),
           hetab_precision_name(hetab_engine_precision(engine)));
  else
    printf("%s on the host\n", hetab_surface_name(job->surface));
}

static int print_text(const tabulate_job *job) {
  int width = longest_path(job);
  print_engine(job);
  printf("%-*s %8s %8s %10s %10s %9s %9s %9s\n", width, "file", "entries", "seconds", "entries/s",
         "kernel/s", "max error", "p99 error", "RMS error");
  for (size_t i = 0; i < job->output_count; i++)
    print_row(job, &job->outputs[i], width);
  for (size_t i = 0; i < job->output_count; i++)
    print_notes(job, &job->outputs[i]);
  return CLI_OK;
}

int tabulate_summary(const tabulate_job *job) {
  if (job->request->quiet && !job->request->json)
    return CLI_OK;
  return job->request->json ? print_json(job) : print_text(job);
}
