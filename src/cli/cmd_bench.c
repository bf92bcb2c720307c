/* hetab bench: speed against error of every method. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "output.h"
#include "progress.h"

typedef struct bench {
  hetab_context *ctx;
  hetab_bench_options options;
  const char *device; /* in words */
  const char *label;  /* of the surface at work */
  int json, quiet, rows;
  json_t *results; /* with json */
  cli_text csv;    /* its stream is NULL without --csv */
} bench;

/* ---- the surfaces -------------------------------------------------------------------------- */

static const char *const presets[] = {"BBQAL1", "BBQAL2", "GGAL120", "GGAL240", "NGGAL"};

/* Where methods break: a lobe a degree wide, a near mirror, g in the thousands, slope 1. */
static const struct hard_surface {
  const char *name;
  double sigma0_um, tau_um;
} hard_surfaces[] = {{"needle", 0.05, 60}, {"smooth", 0.02, 3}, {"rough", 5, 50}, {"steep", 1, 1}};

static const double hard_n = 0.958, hard_k = 6.69; /* aluminium at 550 nm */
enum { BANDS = 31 };                               /* 400:700:10 */

static hetab_status create_hard(hetab_context *ctx, const struct hard_surface *hard,
                                hetab_surface **out) {
  double lambda_um[BANDS];
  for (int i = 0; i < BANDS; i++)
    lambda_um[i] = (400 + 10 * i) / 1000.0;
  return hetab_surface_create(ctx, hard->sigma0_um, hard->tau_um, hard_n, hard_k, lambda_um, BANDS,
                              out);
}

/* roughness-R: sigma0 is R wavelengths at 550 nm, the slope 0.1. */
static int parse_roughness(const char *name, struct hard_surface *hard) {
  char *end;
  if (strncmp(name, "roughness-", 10) != 0)
    return 0;
  double ratio = strtod(name + 10, &end);
  *hard = (struct hard_surface){name, 0.55 * ratio, 5.5 * ratio};
  return *end == 0 && end > name + 10 && ratio >= 1e-3 && ratio <= 1e4;
}

/* A hard surface by its name, else what hetab_surface_open knows. */
static hetab_status open_surface(hetab_context *ctx, const char *name, hetab_surface **out) {
  for (size_t i = 0; i < sizeof hard_surfaces / sizeof *hard_surfaces; i++)
    if (strcmp(name, hard_surfaces[i].name) == 0)
      return create_hard(ctx, &hard_surfaces[i], out);
  struct hard_surface swept;
  if (parse_roughness(name, &swept))
    return create_hard(ctx, &swept, out);
  return hetab_surface_open(ctx, name, out);
}

/* ---- the results --------------------------------------------------------------------------- */

static const char csv_header[] =
    "surface,method,precision,tolerance,entries_per_s,ratio_literal,"
    "ratio_store,operations,ratio_peak,max_rel,p99_rel,rms_rel,samples,device,version\n";

/* RFC 4180: quoted if it has to be. */
static void write_quoted(FILE *stream, const char *text) {
  int quote = strpbrk(text, ",\"\r\n") != NULL;
  if (quote)
    putc('"', stream);
  for (; *text; text++) {
    if (*text == '"')
      putc('"', stream);
    putc(*text, stream);
  }
  if (quote)
    putc('"', stream);
}

static void write_csv_row(const bench *b, const hetab_bench_row *row) {
  FILE *stream = b->csv.stream;
  write_quoted(stream, b->label);
  fprintf(stream, ",%s,%s,%g,%.6g,%.6g,%.6g,%.6g,%.6g,", row->method, row->precision,
          row->tolerance, row->entries_per_second, row->ratio_to_literal, row->ratio_to_store,
          row->operations_per_entry, row->ratio_to_peak);
  if (row->error.compared)
    fprintf(stream, "%.3e,%.3e,%.3e", row->error.max_rel, row->error.p99_rel, row->error.rms_rel);
  else
    fputs(",,", stream); /* nothing to compare: the baselines */
  fprintf(stream, ",%zu,", row->error.samples);
  write_quoted(stream, b->device);
  fprintf(stream, ",%s\n", hetab_version());
}

static json_t *row_json(const bench *b, const hetab_bench_row *row) {
  return json_pack("{so ss ss sf sf sf sf sf sf so}", "surface", cli_json_text(b->label), "method",
                   row->method, "precision", row->precision, "tolerance", row->tolerance,
                   "entries_per_second", row->entries_per_second, "ratio_to_literal",
                   row->ratio_to_literal, "ratio_to_store", row->ratio_to_store,
                   "operations_per_entry", row->operations_per_entry, "ratio_to_peak",
                   row->ratio_to_peak, "error", cli_json_error(&row->error));
}

static void print_row(bench *b, const hetab_bench_row *row) {
  char speed[16], ratio[16], tolerance[16] = "-";
  if (b->rows++ == 0)
    printf("%-14s %-9s %-7s %9s %10s %10s %9s %8s %10s %9s %9s\n", "surface", "method", "prec.",
           "tolerance", "entries/s", "x literal", "of store", "of peak", "max error", "p99", "RMS");
  cli_si(row->entries_per_second, speed, sizeof speed);
  cli_si(row->ratio_to_literal, ratio, sizeof ratio);
  if (row->tolerance > 0)
    snprintf(tolerance, sizeof tolerance, "%.0e", row->tolerance);
  cli_errors errors = cli_error_texts(&row->error);
  printf("%-14s %-9s %-7s %9s %10s %10s %8.3g%% %7.3g%% %10s %9s %9s\n", b->label, row->method,
         row->precision, tolerance, speed, ratio, 100 * row->ratio_to_store,
         100 * row->ratio_to_peak, errors.max, errors.p99, errors.rms);
  fflush(stdout);
}

static void on_row(void *user, const char *surface, const hetab_bench_row *row) {
  (void)surface; /* one made in memory has no telling name */
  bench *b = user;
  cli_progress_end();
  if (b->csv.stream)
    write_csv_row(b, row);
  if (b->json)
    json_array_append_new(b->results, row_json(b, row));
  else if (!b->quiet)
    print_row(b, row);
}

/* ---- the run ------------------------------------------------------------------------------- */

static int bench_one(bench *b, const char *name) {
  hetab_surface *surface;
  CLI_CALL(b->ctx, open_surface(b->ctx, name, &surface));
  b->label = name;
  cli_progress_begin(name, b->quiet);
  hetab_status status = hetab_bench(b->ctx, surface, &b->options, on_row, b);
  hetab_surface_free(surface);
  cli_progress_end();
  return status == HETAB_OK ? -1 : cli_fail_context(b->ctx);
}

static int bench_all(bench *b, char **names) {
  int status = -1;
  for (; *names && status < 0; names++)
    status = bench_one(b, *names);
  return status;
}

static int bench_default(bench *b) {
  int status = -1;
  for (size_t i = 0; i < sizeof presets / sizeof *presets && status < 0; i++)
    status = bench_one(b, presets[i]);
  for (size_t i = 0; i < sizeof hard_surfaces / sizeof *hard_surfaces && status < 0; i++)
    status = bench_one(b, hard_surfaces[i].name);
  return status;
}

/* Mistakes in names come out before minutes of measuring. */
static int check_surfaces(hetab_context *ctx, char **names) {
  for (; *names; names++) {
    hetab_surface *surface;
    CLI_CALL(ctx, open_surface(ctx, *names, &surface));
    hetab_surface_free(surface);
  }
  return -1;
}

static int publish(bench *b, const char *csv_path, int overwrite) {
  int status = csv_path ? cli_text_save(&b->csv, b->ctx, csv_path, overwrite) : -1;
  if (status < 0)
    status = cli_publish(b->ctx);
  if (status >= 0)
    return status;
  if (!b->json)
    return CLI_OK;
  json_t *report = json_pack("{so ss sO}", "device", cli_json_text(b->device), "version",
                             hetab_version(), "results", b->results);
  return cli_json_print(report);
}

static int measure(bench *b, char **names, const char *csv_path, int overwrite) {
  hetab_engine_options device = {.devices = b->options.devices};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  int status = check_surfaces(b->ctx, names);
  if (status >= 0)
    return status;
  CLI_CALL(b->ctx, hetab_engine_create(b->ctx, &device, &engine));
  b->device = hetab_engine_device(engine);
  if (csv_path)
    status = cli_text_begin(&b->csv);
  if (b->csv.stream)
    fputs(csv_header, b->csv.stream);
  if (status < 0)
    status = *names ? bench_all(b, names) : bench_default(b);
  if (status < 0)
    status = publish(b, csv_path, overwrite);
  cli_text_free(&b->csv);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  bench b = {0};
  const char *csv_path = NULL;
  size_t repeats = 0;
  int first, force = 0;
  const cli_option options[] = {
      {CLI_TEXT, "csv", 0, "FILE", "also write the results to FILE, a row per surface and method",
       &csv_path, 0, 0},
      CLI_FORCE(&force),
      CLI_DEVICE(&b.options.devices),
      {CLI_COUNT, "samples", 0, "N", "entries compared with the literal reference (20000)",
       &b.options.samples, 1, 1e9},
      {CLI_COUNT, "repeats", 0, "N",
       "timed runs of each kernel; the median counts (5 to 64, for 0.6 s)", &repeats, 1, 1000},
      CLI_QUIET(&b.quiet),
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {device, version, results: [{surface, method, precision, tolerance, "
       "entries_per_second, ratio_to_literal, ratio_to_store, "
       "operations_per_entry, ratio_to_peak, error}]}",
       &b.json, 0, 0},
      {0},
  };
  int status = cli_parse_options(self, options, argc, argv, &first);
  if (status >= 0)
    return status;
  b.options.repeats = (unsigned)repeats;
  if (!(b.ctx = cli_context()))
    return CLI_FAILURE;
  status = CLI_FAILURE;
  if (!csv_path || cli_output_allowed(b.ctx, csv_path, force)) {
    b.results = json_array();
    status = measure(&b, argv + first, csv_path, force);
    json_decref(b.results);
  }
  hetab_context_free(b.ctx);
  return status;
}

const cli_command cli_bench = {
    .name = "bench",
    .arguments = "[SURFACE]...",
    .summary = "measure speed against error of every method",
    .description =
        "Measures, in one run on one device, the literal equations in double on one core, every "
        "method in float and double, and a kernel that only stores; prints entries per second of "
        "kernel time beside the relative error against the literal equations.\n\n"
        "SURFACE is a preset, a YAML file, or one of the hard surfaces needle (sigma0 0.05 um, tau "
        "60 um), smooth (0.02, 3), rough (5, 50) and steep (1, 1) of aluminium, or roughness-R: "
        "sigma0 "
        "R times 0.55 um at slope 0.1. Without one: the "
        "presets BBQAL1, BBQAL2, GGAL120, GGAL240 and NGGAL, and the hard ones.",
    .run = run,
};
