/* What a finished tabulation says on standard output. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "core/number.h"
#include "numbers.h"
#include "output.h"
#include "tabulate_job.h"

static double rate(double entries, double seconds) {
  return seconds > 0 ? entries / seconds : 0;
}

/* How the tables were made that a device made; NULL: all on the host. */
static const hetab_report *device_report(const tabulate_job *job) {
  const hetab_report *found = NULL;
  for (size_t i = 0; i < job->request->files.count; i++)
    if (*job->reports[i].report.device)
      found = &job->reports[i].report;
  return found;
}

/* ---- JSON ---------------------------------------------------------------------------------- */

/* Whether the delta is in the table, as a lobe. HDF5 always keeps it apart. */
static int is_folded(const tabulate_job *job, size_t i) {
  hetab_format format = job->reports[i].format;
  return job->request->cone_deg > 0 && format != HETAB_FORMAT_H5;
}

/* The name of the file that holds the specular reflectance; free() it. */
static char *specular_file(const tabulate_job *job, size_t i) {
  hetab_format format = job->reports[i].format;
  const char *path = job->request->files.items[i];
  int beside = (format == HETAB_FORMAT_MERL || format == HETAB_FORMAT_RGL) && !is_folded(job, i);
  return beside ? hetab_specular_path(job->ctx, path) : strdup(path);
}

static json_t *specular_json(const tabulate_job *job, size_t i) {
  HETAB_FREED char *file = specular_file(job, i);
  return json_pack("{sf sf so so sf}", "max", job->reports[i].specular_max, "share",
                   hetab_specular_share(job->surface), "file", cli_json_text(file ? file : ""),
                   "in_table", json_boolean(is_folded(job, i)), "cone_deg",
                   is_folded(job, i) ? job->request->cone_deg : 0.0);
}

enum { READ_AT = 6 };
static const double read_at_deg[READ_AT] = {0, 30, 60, 75, 85, 88};

/* What a truncating reader makes of the delta in a MERL table; false: it has none. */
static bool read_delta(const tabulate_job *job, size_t i, double *rho_s, double *read) {
  double theta_i[READ_AT];
  for (int t = 0; t < READ_AT; t++)
    theta_i[t] = hetab_radians(read_at_deg[t]);
  return job->reports[i].format == HETAB_FORMAT_MERL && is_folded(job, i) &&
         hetab_merl_cone_read(job->ctx, job->surface, &job->merl, theta_i, READ_AT, rho_s, read) ==
             HETAB_OK;
}

static json_t *read_json(const tabulate_job *job, size_t i) {
  double rho_s[READ_AT], read[READ_AT];
  if (!read_delta(job, i, rho_s, read))
    return json_null();
  return json_pack("{so so so}", "theta_i_deg", cli_json_numbers(read_at_deg, READ_AT, 1), "rho_s",
                   cli_json_numbers(rho_s, READ_AT, 1), "read", cli_json_numbers(read, READ_AT, 1));
}

static int is_spectral(const tabulate_job *job) {
  return job->rgl.bands == HETAB_RGL_SPECTRAL;
}

/* Readers of spectra ask for 360 to 830 nm, and repeat the outer bands where there are none. */
static const char *readers_remark(const tabulate_job *job, hetab_format format) {
  const hetab_band *bands = hetab_surface_bands(job->surface);
  size_t last = hetab_surface_band_count(job->surface) - 1;
  int is_short = bands[0].lambda_um > 0.3601 || bands[last].lambda_um < 0.8299;
  int is_seen = bands[0].lambda_um <= 0.83 && bands[last].lambda_um >= 0.36;
  if (format != HETAB_FORMAT_RGL || (is_spectral(job) && !is_short))
    return "";
  return !is_spectral(job) ? "; for pbrt-v4 take --for pbrt"
         : is_seen ? ", where outer bands stand for all beyond (--wavelengths 360:830:10 has them)"
                   : ", where outer bands stand for all beyond, the visible ones too";
}

static int is_atlas(const tabulate_job *job, hetab_format format) {
  return format == HETAB_FORMAT_EXR && job->exr.parts == HETAB_EXR_ATLAS;
}

static const char *readers(const tabulate_job *job, hetab_format format) {
  return is_atlas(job, format) ? "OpenImageIO, OpenCV and shaders (scripts/exr_atlas.glsl)"
                               : cli_readers(format, is_spectral(job));
}

static const char *bands_name(const tabulate_job *job) {
  return is_spectral(job) ? "spectral" : "rgb";
}

static json_t *rgl_json(const tabulate_job *job, const hetab_rgl_report *r) {
  return json_pack("{ss sf sf sf sf sI sI sI sI}", "bands", bands_name(job), "table_error",
                   r->target, "error_l1", r->error_l1, "bias", r->bias, "error_grazing",
                   r->error_grazing, "theta_i", (json_int_t)r->theta_i_count, "resolution",
                   (json_int_t)r->resolution, "bytes", (json_int_t)r->bytes, "clamped",
                   (json_int_t)r->clamped);
}

static json_t *output_json(const tabulate_job *job, size_t i) {
  const hetab_output_report *output = &job->reports[i];
  const hetab_report *report = &output->report;
  json_t *json = json_pack(
      "{so ss sf sf sf sf sf so so}", "file", cli_json_text(job->request->files.items[i]), "format",
      hetab_format_word(output->format), "entries", report->entries, "seconds",
      report->wall_seconds, "entries_per_second", rate(report->entries, report->wall_seconds),
      "kernel_seconds", report->kernel_seconds, "kernel_entries_per_second",
      rate(report->entries, report->kernel_seconds), "error", cli_json_error(&report->error),
      "specular", specular_json(job, i));
  if (json)
    json_object_set_new(json, "loads_in", json_string(readers(job, output->format)));
  if (json && output->format == HETAB_FORMAT_MERL)
    json_object_set_new(json, "clamped", json_integer((json_int_t)report->clamped));
  if (json && output->format == HETAB_FORMAT_MERL && is_folded(job, i))
    json_object_set_new(json, "delta_as_read", read_json(job, i));
  if (json && (output->format == HETAB_FORMAT_H5 || output->format == HETAB_FORMAT_EXR))
    json_object_set_new(json, "linear_readers",
                        json_pack("{sf sf sf sI sI}", "error_l1", output->grid.error_l1, "lobe_deg",
                                  output->grid.lobe_deg, "step_deg", output->grid.step_deg,
                                  "theta_needed", (json_int_t)output->grid.theta_count,
                                  "phi_needed", (json_int_t)output->grid.phi_count));
  if (json && output->format == HETAB_FORMAT_EXR)
    json_object_set_new(json, "saturated", json_integer((json_int_t)output->saturated));
  if (json && output->format == HETAB_FORMAT_RGL)
    json_object_set_new(json, "table", rgl_json(job, &output->rgl));
  return json;
}

static json_t *engine_json(const hetab_report *report) {
  if (!report)
    return json_pack("{sn sn sn sn}", "device", "method", "precision", "tolerance");
  return json_pack("{so ss ss sf}", "device", cli_json_text(report->device), "method",
                   hetab_method_name(report->method), "precision",
                   hetab_precision_name(report->precision), "tolerance", report->tolerance);
}

static int print_json(const tabulate_job *job) {
  json_t *outputs = CLI_JSON_LIST(job->request->files.count, output_json(job, i));
  json_t *json = json_pack("{so}", "surface", cli_json_text(hetab_surface_name(job->surface)));
  json_object_update_new(json, engine_json(device_report(job)));
  json_object_set_new(json, "version", json_string(hetab_version()));
  json_object_set_new(json, "outputs", outputs);
  return cli_json_print(json);
}

/* ---- text ---------------------------------------------------------------------------------- */

static int longest_path(const tabulate_job *job) {
  size_t longest = strlen("file");
  for (size_t i = 0; i < job->request->files.count; i++)
    if (strlen(job->request->files.items[i]) > longest)
      longest = strlen(job->request->files.items[i]);
  return (int)longest;
}

static void print_row(const char *path, const hetab_report *report, int width) {
  const hetab_error_stats *error = &report->error;
  char entries[16], speed[16], kernel[16] = "-";
  cli_si(report->entries, entries, sizeof entries);
  cli_si(rate(report->entries, report->wall_seconds), speed, sizeof speed);
  if (report->kernel_seconds > 0)
    cli_si(rate(report->entries, report->kernel_seconds), kernel, sizeof kernel);
  cli_errors errors = cli_error_texts(error);
  printf("%-*s %8s %8.3f %10s %10s %9s %9s %9s\n", width, path, entries, report->wall_seconds,
         speed, kernel, errors.max, errors.p99, errors.rms);
}

static void print_rgl(const tabulate_job *job, const char *path, const hetab_rgl_report *r) {
  printf("%s: %s, %zu incidences of %zu x %zu nodes, %.2f MB; relative L1 error at most %.2g (%.2g "
         "asked for), bias %.2g; beyond 80 degrees %.2g\n",
         path, bands_name(job), r->theta_i_count, r->resolution, r->resolution,
         1e-6 * (double)r->bytes, r->error_l1, r->target, r->bias, r->error_grazing);
  if (r->error_l1 > r->target || fabs(r->bias) > r->target / 3.0 || r->error_grazing > 0.1)
    printf("%s: warning: no table of any size keeps that error, this is the largest: allow more by "
           "--table-error, or take .h5\n",
           path);
}

/* Where the delta is, and what leaving it out would cost. */
static void print_specular(const tabulate_job *job, size_t i) {
  const hetab_output_report *r = &job->reports[i];
  const char *path = job->request->files.items[i];
  double share = hetab_specular_share(job->surface), allowed = job->request->table_error;
  HETAB_FREED char *file = specular_file(job, i);
  if (is_folded(job, i))
    printf("%s: specular reflectance, at most %.3g, folded in as a %g degree lobe\n", path,
           r->specular_max, job->request->cone_deg);
  else if (r->format == HETAB_FORMAT_H5 || r->format == HETAB_FORMAT_EXR)
    printf("%s: specular reflectance, at most %.3g, is in %s\n", path, r->specular_max,
           r->format == HETAB_FORMAT_H5 ? "/specular_reflectance"
           : is_atlas(job, r->format)   ? "the attributes specular_reflectance_R, _G and _B"
                                        : "the part specular_reflectance");
  else if (share > (allowed > 0 ? allowed : 0.01))
    printf("%s: warning: the table lacks %s %% of the light, the specular delta (rho_s up to "
           "%.3g): fold it in (--specular-cone 2), let the renderer add %s, or in Mitsuba take the "
           "model itself (hetab shader)\n",
           path, hetab_two_digits(100 * share).text, r->specular_max, file);
  else
    printf("%s: specular reflectance, at most %.3g, %s %% of the light, is in %s\n", path,
           r->specular_max, hetab_two_digits(100 * share).text, file);
}

/* What MERL's truncation makes of a folded delta, incidence by incidence. */
static void print_read_delta(const tabulate_job *job, size_t i) {
  static const double few = 0.01; /* of the light */
  const char *path = job->request->files.items[i];
  double rho_s[READ_AT], read[READ_AT];
  bool off = false, gains = false;
  if (!read_delta(job, i, rho_s, read))
    return;
  printf("%s: the delta as truncating readers see it:", path);
  for (int t = 0; t < READ_AT; t++) {
    printf("%s %.3f", t ? "," : "", rho_s[t] > 0 ? read[t] / rho_s[t] : 1.0);
    off |= fabs(read[t] - rho_s[t]) > few;
    gains |= read[t] > 1;
  }
  for (int t = 0; t < READ_AT; t++)
    printf("%s%g", t ? ", " : " of rho_s at ", read_at_deg[t]);
  printf(" degrees\n");
  if (off || gains)
    printf("%s: warning: that %s: take a wider --specular-cone, or .bsdf, which follows the lobe\n",
           path,
           gains ? "reflects more light than falls in" : "is off by more than 1 % of the light");
}

/* What the column "max error" is. */
static void print_sample(const char *path, const hetab_error_stats *error) {
  static const double few = 0.01;
  double share = hetab_error_share_above(error);
  if (error->samples && share > few)
    printf(
        "%s: warning: only %zu of the %zu entries compared are above 1e-9 / sr: max error may be "
        "exceeded by %.3g %% of all such entries (at 95 %%); take more --samples\n",
        path, error->compared, error->samples, 100.0 * share);
  else if (error->samples)
    printf("%s: max error is that of %zu entries compared; at most %s %% of all exceed it (at 95 "
           "%%)\n",
           path, error->compared, hetab_two_digits(100.0 * share).text);
}

/* What a reader makes of the nodes, and the grid that a lobe needs which falls between them. */
static void print_grid(const tabulate_job *job, size_t i) {
  static const double poor = 0.1;
  const hetab_grid_report *g = &job->reports[i].grid;
  const char *path = job->request->files.items[i];
  double nodes = (double)g->theta_count * (double)g->theta_count * (double)g->phi_count;
  double bands = (double)hetab_surface_band_count(job->surface);
  if (g->error_l1 <= poor) {
    printf("%s: readers that interpolate linearly between nodes see a relative L1 error of %.2g\n",
           path, g->error_l1);
    return;
  }
  printf("%s: warning: the grid does not hold the lobe, %.2g degrees wide (standard deviation) "
         "among nodes %.2g degrees apart: readers that interpolate linearly see a relative L1 "
         "error of %.2g; --theta-i 0:90:%zu --theta-r 0:90:%zu --phi 0:180:%zu leaves about 0.05 "
         "(%.2g GB); .bsdf and .binary follow the lobe\n",
         path, g->lobe_deg, g->step_deg, g->error_l1, g->theta_count, g->theta_count, g->phi_count,
         4e-9 * nodes * bands);
}

static void print_notes(const tabulate_job *job, size_t i) {
  const hetab_output_report *r = &job->reports[i];
  const char *path = job->request->files.items[i];
  print_sample(path, &r->report.error);
  if (r->format == HETAB_FORMAT_RGL)
    print_rgl(job, path, &r->rgl);
  if (r->format == HETAB_FORMAT_H5 || r->format == HETAB_FORMAT_EXR)
    print_grid(job, i);
  print_specular(job, i);
  print_read_delta(job, i);
  if (r->saturated)
    printf("%s: %zu pixels above 65504 are stored as 65504: take --exr-type float\n", path,
           r->saturated);
  if (r->format == HETAB_FORMAT_MERL && r->report.clamped)
    printf("%s: %zu cells out of gamut: negative values set to 0\n", path, r->report.clamped);
  printf("%s: loads in %s%s\n", path, readers(job, r->format), readers_remark(job, r->format));
}

static const double MANY_UM = 20; /* rms heights beyond are no polished or ground surface's */

static void print_engine(const tabulate_job *job) {
  const hetab_report *report = device_report(job);
  if (report)
    printf("%s on %s, method %s, %s\n", hetab_surface_name(job->surface), report->device,
           hetab_method_name(report->method), hetab_precision_name(report->precision));
  else
    printf("%s on the host\n", hetab_surface_name(job->surface));
  double sigma0_um = hetab_surface_sigma0_um(job->surface);
  if (sigma0_um > MANY_UM)
    printf("note: sigma0_um is %g, a fraction of a millimetre: were nanometres meant?\n",
           sigma0_um);
}

static int print_text(const tabulate_job *job) {
  int width = longest_path(job);
  print_engine(job);
  printf("%-*s %8s %8s %10s %10s %9s %9s %9s\n", width, "file", "entries", "seconds", "entries/s",
         "kernel/s", "max error", "p99 error", "RMS error");
  for (size_t i = 0; i < job->request->files.count; i++)
    print_row(job->request->files.items[i], &job->reports[i].report, width);
  for (size_t i = 0; i < job->request->files.count; i++)
    print_notes(job, i);
  return CLI_OK;
}

int tabulate_summary(const tabulate_job *job) {
  if (job->request->quiet && !job->request->json)
    return CLI_OK;
  return job->request->json ? print_json(job) : print_text(job);
}
