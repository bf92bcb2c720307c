/* What a finished tabulation says on standard output. */
#include <stdio.h>
#include <string.h>

#include "output.h"
#include "tabulate_job.h"

static double rate(double entries, double seconds) {
  return seconds > 0 ? entries / seconds : 0;
}

/* Of the file's numbers. */
static hetab_error_stats file_error(const tabulate_job *job, const table_output *output) {
  const hetab_error_stats *error = &job->reports[output->format].error;
  return output->format == OUTPUT_MERL ? *error : hetab_h5_error(&job->h5_options, error);
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static json_t *specular_json(const tabulate_job *job, const table_output *output) {
  int merl = output->format == OUTPUT_MERL;
  double cone = merl ? job->merl_options.specular_cone_deg : 0;
  return json_pack("{sf so so sf}", "max", job->specular_max[output->format], "file",
                   cli_json_text(merl ? output->specular_path : output->path), "in_table",
                   json_boolean(cone > 0), "cone_deg", cone);
}

static const char *format_name(output_format format) {
  static const char *const names[OUTPUT_FORMATS] = {
      [OUTPUT_H5] = "hdf5", [OUTPUT_MERL] = "merl", [OUTPUT_EXR] = "exr"};
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
  return json;
}

static int print_json(const tabulate_job *job) {
  json_t *outputs = json_array();
  for (size_t i = 0; i < job->output_count; i++)
    json_array_append_new(outputs, output_json(job, &job->outputs[i]));
  return cli_json_print(json_pack(
      "{so so ss ss sf ss so}", "surface", cli_json_text(hetab_surface_name(job->surface)),
      "device", cli_json_text(hetab_engine_device(job->engine)), "method",
      hetab_method_name(hetab_engine_method(job->engine)), "precision",
      hetab_precision_name(hetab_engine_precision(job->engine)), "tolerance",
      hetab_engine_tolerance(job->engine), "version", hetab_version(), "outputs", outputs));
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

static void print_notes(const tabulate_job *job, const table_output *output) {
  double max = job->specular_max[output->format], cone = job->merl_options.specular_cone_deg;
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

static int print_text(const tabulate_job *job) {
  int width = longest_path(job);
  printf("%s on %s, method %s, %s\n", hetab_surface_name(job->surface),
         hetab_engine_device(job->engine), hetab_method_name(hetab_engine_method(job->engine)),
         hetab_precision_name(hetab_engine_precision(job->engine)));
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
