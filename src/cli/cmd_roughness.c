/* hetab roughness: height scans to the model's parameters. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "core/held_files.h"
#include "output.h"
#include "progress.h"
#include "roughness_command.h"

enum { PUBLISHED_DIFFERS = 3 }; /* exit status */

typedef struct request {
  const char *cutoff, *unit, *columns, *csv, *html, *surface, *index, *rows;
  double spacing_um, resample_um, outlier, wavelength_nm, cutoff_um;
  int level, filter, force, json, quiet, decimal, ignore_checksums;
} request;

typedef struct roughness_job {
  const request *request;
  hetab_context *ctx;
  const hetab_heights **heights;
  size_t count;
  hetab_roughness *roughness;
  char index[4400]; /* as YAML has it */
} roughness_job;

/* ---- refractive index ---------------------------------------------------------------------- */

static int is_metal(const char *symbol) {
  for (size_t i = 0; i < hetab_metal_count(); i++)
    if (strcmp(symbol, hetab_metal_symbol(i)) == 0)
      return 1;
  return 0;
}

static int constant_index(roughness_job *job, double n, double k) {
  hetab_index *index;
  CLI_CALL(job->ctx, hetab_index_constant(job->ctx, n, k, &index));
  hetab_index_free(index);
  snprintf(job->index, sizeof job->index, "{n: %.10g, k: %.10g}", n, k);
  return -1;
}

/* A path in a surface starts at the surface's folder: an absolute one holds anywhere. */
static int index_file(roughness_job *job, const char *path) {
  hetab_index *index;
  CLI_CALL(job->ctx, hetab_index_load(job->ctx, path, &index));
  hetab_index_free(index);
  char *whole = realpath(path, NULL);
  int length = whole ? snprintf(job->index, sizeof job->index, "{file: \"%s\"}", whole) : -1;
  int plain = whole && !strpbrk(whole, "\"\\\n");
  free(whole);
  if (length < 0 || (size_t)length >= sizeof job->index || !plain)
    return cli_fail("--index: %s: give a path of plain characters", path);
  return -1;
}

static int write_index(roughness_job *job) {
  const char *text = job->request->index;
  double n, k;
  if (is_metal(text)) {
    snprintf(job->index, sizeof job->index, "%s", text);
    return -1;
  }
  int constant = cli_constant_index(text, &n, &k);
  if (constant < 0)
    return cli_fail("--index: '%s' is neither n=N, n=N,k=K nor N,K, nor the name of a file", text);
  return constant ? constant_index(job, n, k) : index_file(job, text);
}

/* ---- scans --------------------------------------------------------------------------------- */

static int load_scans(roughness_job *job, char **paths, size_t count) {
  hetab_heights_options options = {.spacing_um = job->request->spacing_um,
                                   .unit = job->request->unit,
                                   .resample_um = job->request->resample_um,
                                   .columns = job->request->columns,
                                   .decimal = "\0.,"[job->request->decimal],
                                   .ignore_checksums = job->request->ignore_checksums};
  job->heights = calloc(count, sizeof *job->heights);
  if (!job->heights)
    return cli_fail("out of memory");
  for (size_t i = 0; i < count; i++) {
    hetab_heights *heights;
    CLI_CALL(job->ctx, hetab_heights_load(job->ctx, paths[i], &options, &heights));
    job->heights[job->count++] = heights;
  }
  return -1;
}

static int measure(roughness_job *job) {
  const request *r = job->request;
  hetab_roughness_options options = {.cutoff_um = r->cutoff_um,
                                     .filter = (hetab_filter)r->filter,
                                     .level = (hetab_level)r->level,
                                     .outlier = r->outlier > 0 ? r->outlier : -1,
                                     .wavelength_um = r->wavelength_nm / 1000};
  cli_progress_begin("scans", r->quiet);
  hetab_status status =
      hetab_roughness_measure(job->ctx, job->heights, job->count, &options, &job->roughness);
  cli_progress_end();
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

/* ---- outputs ------------------------------------------------------------------------------- */

/* The file's name without folders and extension. */
static void surface_name(const char *path, char *name, size_t size) {
  const char *slash = strrchr(path, '/');
  snprintf(name, size, "%s", slash ? slash + 1 : path);
  char *dot = strrchr(name, '.');
  if (dot && dot > name)
    *dot = '\0';
  for (char *c = name; *c; c++)
    if (*c == '"' || *c == '\\' || *c < ' ')
      *c = '_';
}

static void write_surface(FILE *out, const roughness_job *job) {
  char name[256];
  surface_name(job->request->surface, name, sizeof name);
  roughness_yaml(out, job->roughness, name, job->index);
}

typedef enum output_kind { OUTPUT_CSV, OUTPUT_HTML, OUTPUT_SURFACE } output_kind;

static int save(roughness_job *job, const char *path, output_kind kind) {
  cli_text text;
  if (!path)
    return -1;
  CLI_TRY(cli_text_begin(&text));
  if (kind == OUTPUT_CSV)
    roughness_csv(text.stream, job->roughness);
  else if (kind == OUTPUT_HTML)
    roughness_html(text.stream, job->roughness);
  else
    write_surface(text.stream, job);
  return cli_text_save(&text, job->ctx, path, job->request->force);
}

static int publish(roughness_job *job) {
  const request *r = job->request;
  CLI_TRY(save(job, r->csv, OUTPUT_CSV));
  CLI_TRY(save(job, r->html, OUTPUT_HTML));
  CLI_TRY(save(job, r->surface, OUTPUT_SURFACE));
  CLI_TRY(cli_publish(job->ctx));
  if (r->json)
    return cli_json_print(roughness_json(job->roughness));
  if (!r->quiet)
    roughness_print(job->roughness);
  return CLI_OK;
}

static int check_outputs(const roughness_job *job) {
  const request *r = job->request;
  const char *const outputs[] = {r->csv, r->html, r->surface};
  for (int i = 0; i < 3; i++)
    if (outputs[i] && !cli_output_allowed(job->ctx, outputs[i], r->force))
      return CLI_FAILURE;
  return -1;
}

/* ---- the command --------------------------------------------------------------------------- */

static int run_scans(roughness_job *job, char **paths, size_t count) {
  CLI_TRY(check_outputs(job));
  if (job->request->surface)
    CLI_TRY(write_index(job));
  CLI_TRY(load_scans(job, paths, count));
  CLI_TRY(measure(job));
  return publish(job);
}

/* The option's own file and those after it. */
static int run_rows(roughness_job *job, char **paths, size_t count) {
  const char **tables = calloc(count + 1, sizeof *tables);
  HETAB_ENDS(hetab_published_end) hetab_published *published = NULL;
  if (!tables)
    return cli_fail("out of memory");
  tables[0] = job->request->rows;
  for (size_t i = 0; i < count; i++)
    tables[i + 1] = paths[i];
  hetab_status loaded = hetab_published_load(job->ctx, tables, count + 1, &published);
  free(tables);
  CLI_CALL(job->ctx, loaded);
  int status = roughness_published_agrees(published) ? CLI_OK : PUBLISHED_DIFFERS;
  if (job->request->json)
    status = cli_json_print(roughness_published_json(published)) == CLI_OK ? status : CLI_FAILURE;
  else if (!job->request->quiet)
    roughness_print_published(published);
  return status;
}

static int start(const request *r, char **paths, size_t count) {
  roughness_job job = {.request = r, .ctx = cli_context()};
  if (!job.ctx)
    return CLI_FAILURE;
  int status = r->rows ? run_rows(&job, paths, count) : run_scans(&job, paths, count);
  for (size_t i = 0; i < job.count; i++)
    hetab_heights_free((hetab_heights *)job.heights[i]);
  free(job.heights);
  hetab_roughness_free(job.roughness);
  hetab_context_free(job.ctx);
  return status;
}

static int check_request(const cli_command *self, request *r, char **paths) {
  const char *const outputs[] = {r->csv, r->html, r->surface};
  if (!r->rows && !*paths)
    return cli_usage(self, "no SCAN given");
  if (r->filter && !r->cutoff)
    return cli_usage(self, "--filter needs --cutoff: how long are the waves that it takes?");
  if (r->cutoff && strcmp(r->cutoff, "auto") == 0)
    r->cutoff_um = HETAB_CUTOFF_AUTO;
  else if (r->cutoff && !(cli_number(r->cutoff, &r->cutoff_um) && r->cutoff_um > 0))
    return cli_usage(self, "--cutoff: '%s' is neither a length in um nor auto", r->cutoff);
  for (int i = 0; i < 3; i++)
    for (int j = 0; outputs[i] && j < i; j++)
      if (outputs[j] && hetab_same_file(outputs[i], outputs[j]))
        return cli_usage(self, "two outputs would both be %s", outputs[i]);
  if (r->surface && !r->index)
    return cli_usage(self, "--surface needs --index: what the surface is made of");
  return -1;
}

static cli_option *filter_options(cli_option *next, request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "cutoff", 0, "UM|auto",
       "separate the small scale with a filter of this cut-off; auto: the one with the largest "
       "sigma / tau, with the cut-offs tried",
       &r->cutoff, 0, 0},
      {CLI_CHOICE, "filter", 0, "gaussian|robust|fourier|average",
       "the Gaussian filter of ISO 16610-21, the robust one of ISO 16610-31, all that is shorter "
       "than the cut-off, or less the mean over it (gaussian)",
       &r->filter, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

static cli_option *reading_options(cli_option *next, request *r) {
  const cli_option options[] = {
      {CLI_NUMBER, "spacing", 0, "UM", "between heights, for text without x and maps without sizes",
       &r->spacing_um, 1e-6, 1e4},
      {CLI_TEXT, "unit", 0, "UNIT",
       "nm, um, mm or m: of text whose header names no unit; mm,um: of places and of heights",
       &r->unit, 0, 0},
      {CLI_TEXT, "columns", 0, "X,Z",
       "the columns of text to read, by name or number from 1: z, x,z or x,y,z", &r->columns, 0, 0},
      {CLI_CHOICE, "decimal", 0, "any|point|comma",
       "the decimal mark, where the file allows both readings (any)", &r->decimal, 0, 0},
      {CLI_FLAG, "ignore-checksums", 0, NULL, "read X3P files whose checksums are wrong",
       &r->ignore_checksums, 0, 0},
      {CLI_NUMBER, "resample", 0, "UM",
       "interpolate unequally spaced heights linearly, this far apart", &r->resample_um, 1e-6, 1e4},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

static cli_option *level_options(cli_option *next, request *r) {
  const cli_option options[] = {
      {CLI_CHOICE, "level", 0, "fit|none",
       "subtract the least-squares line of a scan, plane of a map (fit)", &r->level, 0, 0},
      {CLI_NUMBER, "outliers", 0, "K",
       "leave out heights further than K robust standard deviations from the median of the 7 about "
       "them (6; 0: keep all)",
       &r->outlier, 0, 1e9},
      {CLI_NUMBER, "wavelength", 0, "NM", "that the radius of curvature is judged against (700)",
       &r->wavelength_nm, 1, 1e6},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

static cli_option *output_options(cli_option *next, request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "csv", 0, "FILE", "write FILE, a row per scan and component with all errors",
       &r->csv, 0, 0},
      {CLI_TEXT, "html", 0, "FILE", "write FILE, a page with tables and plots", &r->html, 0, 0},
      {CLI_TEXT, "surface", 0, "FILE",
       "write FILE, a surface for 'hetab tabulate', with the bounds as comments", &r->surface, 0,
       0},
      {CLI_TEXT, "index", 0, "INDEX", "of that surface: a metal, n=N or n=N,k=K, or a file",
       &r->index, 0, 0},
      {CLI_TEXT, "rows", 0, "FILE",
       "instead of scans: check published tables, this one and those named after it. CSV: a "
       "header, "
       "a row per scan, rows named average, deviation, non-uniformity. Checked: these, slope = "
       "sigma / tau in every row, a row of one table that has the averages of another. Exit status "
       "3: a number differs by more than the rounding of the rows allows",
       &r->rows, 0, 0},
      CLI_FORCE(&r->force),
      CLI_QUIET(&r->quiet),
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {version, scans: [{name, points, spacing_um, missing, outliers}], cutoff_um, "
       "filter, "
       "raw and small: {sigma_um, tau_um, slope, rms_slope, skewness, kurtosis: {average, "
       "deviation, error, interval}, non_uniformity, normal_distance, misfit_gaussian, "
       "misfit_exponential, lag_step_um, correlation, histogram, scans: [{scan, points, length_um, "
       "sigma_um ...: {value, error}, independent ...}]}, cutoff_scan: {trials: [{cutoff_um, "
       "sigma_um, tau_um, slope, smooth}], sigma_um, tau_um, misfit, from_fit}, curvature_um, "
       "notes, split: {levelled_um, line_um} of the first scan}; with --rows {version, tables: "
       "[{name, rows, columns: [{name, average, deviation, "
       "non_uniformity}]}], checks: [{table, against, row, column, stated, value, low, high, "
       "verdict}]}",
       &r->json, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.outlier = 6, .wavelength_nm = 700};
  cli_option options[CLI_MAX_OPTIONS + 1] = {{0}};
  int first;
  output_options(level_options(reading_options(filter_options(options, &r), &r), &r), &r);
  int status = cli_parse_options(self, options, argc, argv, &first);
  if (status < 0)
    status = check_request(self, &r, argv + first);
  return status < 0 ? start(&r, argv + first, (size_t)(argc - first)) : status;
}

const cli_command cli_roughness = {
    .name = "roughness",
    .arguments = "SCAN...",
    .summary = "sigma0 and tau of measured heights, with their errors",
    .description =
        "SCAN is a height scan, map or list of points: text as instruments export it (names and "
        "units of columns such as x_um,z_nm or 'Lateral um,Raw Micrometer'; every z column is a "
        "scan; maps with their size and unit above the rows), X3P (ISO 5436-2), SDF (ISO "
        "25178-71), "
        "Digital Surf's .sur or Zygo's ASCII. A map gives a scan per row and per column. "
        "Missing heights and outliers are left out and counted.\n\n"
        "Prints, per scan and over the scans, unfiltered and with --cutoff behind the filter: "
        "sigma "
        "(rms height), tau (where the autocorrelation falls to 1/e), sigma / tau (the slope of the "
        "model), the rms slope (another quantity, of first differences), skewness and kurtosis; "
        "averages with standard errors and 95 % intervals that allow for the finite length, the "
        "non-uniformity, and what speaks against the model's assumptions.\n\n"
        "The filter takes part of the small scale too: of a surface with tau 5.6 um a 30 um "
        "cut-off leaves less than a third of the variance, but 96 % of sigma / tau.",
    .run = run,
};
