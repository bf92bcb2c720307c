/* hetab convert: tables from one format to another, with what that cost. */
#include <stdio.h>

#include "cli.h"
#include "core/number.h"
#include "options.h"
#include "output.h"
#include "progress.h"

typedef struct request {
  const char *in, *out;
  hetab_convert_options options;
  size_t compression, seed;
  int quiet, json;
} request;

/* ---- results ------------------------------------------------------------------------------- */

static void print_text(const request *r, const hetab_convert_report *report) {
  printf("%s: %s, %zu %s\n", r->out, hetab_format_name(report->to), report->channels_out,
         report->srgb_out ? "channels of linear sRGB" : "wavelengths");
  printf("  error added by the conversion: L1 %s %%%s, bias %+.3g %%",
         hetab_two_digits(100 * report->error_l1).text,
         report->to == HETAB_FORMAT_MERL ? " in readers that take the nearest cell" : "",
         100 * report->bias);
  if (report->to != HETAB_FORMAT_RGL)
    printf(" (L1 %s %% if interpolated)",
           hetab_two_digits(100 * report->error_l1_interpolated).text);
  printf("\n");
  printf("  loads in %s\n", cli_readers(report->to, !report->srgb_out));
  const size_t *nodes = report->proposed;
  if (nodes[HETAB_PHI])
    printf("  warning: the lobe falls between the nodes: --theta-i 0:90:%zu --theta-r 0:90:%zu "
           "--phi 0:180:%zu leave readers 5 %%; .bsdf follows the lobe\n",
           nodes[HETAB_THETA_I], nodes[HETAB_THETA_R], nodes[HETAB_PHI]);
  if (report->filled)
    printf("  %zu cells of '%s' without data filled from their neighbours\n", report->filled,
           r->in);
  if (report->negative)
    printf("  %zu numbers of '%s' a little below 0 set to 0\n", report->negative, r->in);
  if (report->clamped)
    printf("  %zu colour components outside sRGB set to 0\n", report->clamped);
}

static int print_json(const request *r, const hetab_convert_report *report) {
  return cli_json_print(json_pack(
      "{so so ss ss sI sI sb sb sf sf sf sI sI sI sf s[III] ss}", "input", cli_json_text(r->in),
      "output", cli_json_text(r->out), "from", hetab_format_word(report->from), "to",
      hetab_format_word(report->to), "channels_in", (json_int_t)report->channels_in, "channels_out",
      (json_int_t)report->channels_out, "srgb_in", report->srgb_in, "srgb_out", report->srgb_out,
      "error_l1", report->error_l1, "error_l1_interpolated", report->error_l1_interpolated, "bias",
      report->bias, "filled", (json_int_t)report->filled, "negative", (json_int_t)report->negative,
      "clamped", (json_int_t)report->clamped, "specular_max", report->specular_max, "proposed",
      (json_int_t)report->proposed[HETAB_THETA_I], (json_int_t)report->proposed[HETAB_THETA_R],
      (json_int_t)report->proposed[HETAB_PHI], "version", hetab_version()));
}

static int print_report(const request *r, const hetab_convert_report *report) {
  if (r->json)
    return print_json(r, report);
  if (!r->quiet)
    print_text(r, report);
  return CLI_OK;
}

/* ---- the command --------------------------------------------------------------------------- */

static int run_request(request *r) {
  hetab_convert_report report;
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  if (!ctx)
    return CLI_FAILURE;
  cli_progress_begin("converting", r->quiet);
  hetab_status status = hetab_convert(ctx, r->in, r->out, &r->options, &report);
  cli_progress_end();
  int result = status == HETAB_OK ? cli_publish(ctx) : cli_fail_context(ctx);
  if (result < 0)
    result = print_report(r, &report);
  return result;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.seed = 0};
  hetab_convert_options *o = &r.options;
  int first;
  const cli_option options[] = {
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "HDF5: incident polar angles in degrees: start:stop:count, cells:N, or a list (0:90:90)",
       &o->axes[HETAB_THETA_I], 0, 0},
      {CLI_TEXT, "theta-r", 0, "SPEC", "HDF5: polar angles of the viewer (0:90:90)",
       &o->axes[HETAB_THETA_R], 0, 0},
      {CLI_TEXT, "phi", 0, "SPEC", "HDF5: azimuths between the two (0:180:181)",
       &o->axes[HETAB_PHI], 0, 0},
      {CLI_FLAG, "srgb", 0, NULL,
       "linear sRGB in the output where the input's wavelengths could be kept", &o->srgb, 0, 0},
      {CLI_SHARE, "table-error", 0, "E",
       "RGL: choose the resolution for a relative L1 error of E per incidence (0.01)",
       &o->table_error, 1e-4, 1},
      {CLI_COUNT, "compress", 0, "N", "HDF5: level of compression, 0 to 9 (0)", &r.compression, 0,
       9},
      {CLI_COUNT, "pairs", 0, "N", "pairs of directions for the error (100000)", &o->pairs, 1, 1e9},
      {CLI_COUNT, "seed", 0, "N", "seed of the pairs (0)", &r.seed, 0, 4294967295.0},
      CLI_FORCE(&o->overwrite),
      CLI_QUIET(&r.quiet),
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {input, output, from, to, channels_in, channels_out, srgb_in, srgb_out, "
       "error_l1, error_l1_interpolated, bias, filled, negative, clamped, specular_max, "
       "proposed (nodes), version}",
       &r.json, 0, 0},
      {0},
  };
  CLI_TRY(cli_parse_options(self, options, argc, argv, &first));
  if (!argv[first] || !argv[first + 1])
    return cli_usage(self, "give an input and an output");
  if (argv[first + 2])
    return cli_usage(self, "unexpected argument '%s'", argv[first + 2]);
  r.in = argv[first];
  r.out = argv[first + 1];
  o->compression = (int)r.compression;
  o->seed = (unsigned)r.seed;
  return run_request(&r);
}

const cli_command cli_convert = {
    .name = "convert",
    .arguments = "IN OUT",
    .summary = "convert tables between HDF5, MERL and RGL",
    .description =
        "Reads a table, HDF5 (.h5), MERL (.binary, anyone's) or RGL (.bsdf), told by its content, "
        "and writes the format that OUT ends in. Prints the error that the conversion added: the "
        "relative L1 difference between the input, interpolated, and the output, read by its own "
        "readers' rule (MERL truncates, HDF5 linear between nodes; also by hetab's look-ups, which "
        "know lobes), at random pairs of directions.\n\n"
        "From wavelengths to linear sRGB the colour under D65 is taken; out-of-gamut components "
        "become 0 and are counted. From linear sRGB to HDF5 the file has three channels in place "
        "of wavelengths: no spectrum is made up.\n\n"
        "Holes of measured MERL tables (marked, negative or not numbers) are filled from their "
        "neighbours, and counted; the input is never changed. RGL tables get their density of half "
        "vectors from the data; where no resolution reaches --table-error, as with noisy "
        "measurements, the most accurate table tried is written.\n\n"
        "The specular delta goes with the table: in HDF5 as /specular_reflectance, beside MERL "
        "and RGL tables in NAME.specular.csv. Where it is in IN as a lobe (--specular-cone), the "
        "nodes of HDF5 are chosen to hold it, close together at the mirror direction; axes that "
        "would not are refused.",
    .run = run,
};
