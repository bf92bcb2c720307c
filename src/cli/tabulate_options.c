/* The tabulate command's options, in groups. Each group returns the place after its last one. */
#include <limits.h>
#include <stdbool.h>
#include <string.h>

#include "cli.h"
#include "tabulate_job.h"

/* What is written. */
static cli_option *output_options(cli_option *next, tabulate_request *r) {
  const cli_option options[] = {
      {CLI_LIST, "output", 'o', "FILE",
       "write FILE: a dense HDF5 table (.h5, .hdf5), the same as an OpenEXR image (.exr), a MERL "
       "table (.binary) or an RGL table (.bsdf); several -o share one evaluation",
       &r->files, 0, 0},
      CLI_FORCE(&r->force),
      {CLI_CHOICE, "element", 0, "float|double", "numbers in the HDF5 file (as --precision)",
       &r->element, 0, 0},
      {CLI_COUNT, "compress", 0, "LEVEL", "deflate level of the HDF5 file, 0 to 9 (0: none)",
       &r->compression, 0, 9},
      CLI_QUIET(&r->quiet),
      {CLI_FLAG, "json", 0, NULL, "print the summary as JSON, as described above", &r->json, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* Where the dense table is evaluated. */
static cli_option *grid_options(cli_option *next, tabulate_request *r) {
  const cli_option options[] = {
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "incident polar angles of the dense table in degrees: start:stop:count, cells:N, or a list "
       "(0:90:90)",
       &r->axes[HETAB_THETA_I], 0, 0},
      {CLI_TEXT, "theta-r", 0, "SPEC", "exitant polar angles (0:90:90)", &r->axes[HETAB_THETA_R], 0,
       0},
      {CLI_TEXT, "phi", 0, "SPEC", "azimuths, 180 being the mirror side (0:180:181)",
       &r->axes[HETAB_PHI], 0, 0},
      {CLI_TEXT, "wavelengths", 0, "SPEC",
       "wavelengths in nm: start:stop:step or a list (the surface's own)", &r->wavelengths, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* How it is evaluated, and measured. */
static cli_option *engine_options(cli_option *next, tabulate_request *r) {
  const cli_option options[] = {
      {CLI_CHOICE, "precision", 0, "float|double",
       "arithmetic on the device (float; double for a --tolerance below 1e-5, and for n < 1 with k "
       "near 0)",
       &r->precision, 0, 0},
      {CLI_CHOICE, "method", 0, "rows|series|literal",
       "polynomials of the series, made to the tolerance; the series itself at every entry; or the "
       "printed equations in double on one core (rows)",
       &r->method, 0, 0},
      {CLI_SHARE, "tolerance", 0, "E",
       "largest relative error that rows may make (1e-5 in float, 1e-9 in double)", &r->tolerance,
       1e-15, 0.1},
      {CLI_TEXT, "device", 0, "SEL",
       "number, numbers (0,1) or part of the name of a device, or all; see 'hetab devices'",
       &r->device, 0, 0},
      {CLI_COUNT, "samples", 0, "N",
       "entries compared with the literal equations; 0 measures no error (2000)", &r->samples, 0,
       1e9},
      {CLI_COUNT, "seed", 0, "N", "seed of that sample (1)", &r->seed, 0, UINT_MAX},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

/* OpenEXR tables. */
static cli_option *exr_options(cli_option *next, tabulate_request *r) {
  const cli_option options[] = {
      {CLI_CHOICE, "exr-layout", 0, "theta_i|wavelength|atlas",
       "parts of the .exr: one for each incidence; one for each wavelength, which are spectral; or "
       "one for all, R G B with the incidences as tiles, for shaders and for readers that know one "
       "part (theta_i)",
       &r->exr_parts, 0, 0},
      {CLI_CHOICE, "exr-parts", 0, "theta_i|wavelength", "--exr-layout, as it was called",
       &r->exr_parts, 0, 0},
      {CLI_CHOICE, "exr-type", 0, "float|half",
       "numbers in the .exr; half saturates above 65504, which is counted, or in an atlas refused "
       "(float; half in an atlas)",
       &r->exr_type, 0, 0},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

const tabulate_renderer tabulate_renderers[] = {{"mitsuba-rgb", HETAB_RGL_RGB},
                                                {"mitsuba-spectral", HETAB_RGL_SPECTRAL},
                                                {"pbrt", HETAB_RGL_SPECTRAL},
                                                {"powitacq", HETAB_RGL_SPECTRAL},
                                                {"powitacq-rgb", HETAB_RGL_RGB}};

/* Tables for renderers. */
static cli_option *renderer_options(cli_option *next, tabulate_request *r) {
  const cli_option options[] = {
      {CLI_CHOICE, "for", 0, "mitsuba-rgb|mitsuba-spectral|pbrt|powitacq|powitacq-rgb",
       "who is to read the .bsdf: linear sRGB for Mitsuba 3's rgb variants and powitacq_rgb, "
       "spectra for its spectral variants, pbrt-v4 and powitacq (mitsuba-rgb)",
       &r->renderer, 0, 0},
      {CLI_CHOICE, "merl-sampling", 0, "centre|edge|mean",
       "where a MERL cell is evaluated; readers truncate, so centre serves them best (centre)",
       &r->sampling, 0, 0},
      {CLI_CHOICE, "merl-colour", 0, "srgb|mono|bands",
       "MERL channels: linear sRGB under D65, one band, or one band each (srgb)", &r->colour, 0, 0},
      {CLI_TEXT, "bands", 0, "BANDS",
       "OpenEXR, RGL: rgb or spectral (rgb); MERL: wavelengths in nm of mono or bands (R,G,B)",
       &r->bands, 0, 0},
      {CLI_SHARE, "table-error", 0, "E",
       "RGL: the smallest table whose relative L1 is at most E and whose bias is at most E / 3 at "
       "every incidence to 80 degrees, and L1 at most 0.1 beyond (0.01)",
       &r->table_error, 1e-4, 0.5},
      {CLI_NUMBER, "specular-cone", 0, "DEG",
       "fold the specular delta into .binary, .bsdf and .exr as a lobe of half vectors up to DEG "
       "from the normal that reflects rho_s at every incidence",
       &r->cone_deg, 1e-3, 90},
  };
  memcpy(next, options, sizeof options);
  return next + sizeof options / sizeof *options;
}

int tabulate_has_format(const tabulate_request *r, hetab_format format) {
  const cli_list *files = &r->files;
  hetab_format found;
  for (size_t i = 0; i < files->count; i++)
    if (hetab_format_by_ending(files->items[i], &found) && found == format)
      return 1;
  return 0;
}

/* An option of files that are not asked for is a mistake; -1 if there is none. */
static int check_given(const cli_command *self, const tabulate_request *r) {
  enum { H5 = 1 << HETAB_FORMAT_H5, EXR = 1 << HETAB_FORMAT_EXR, MERL = 1 << HETAB_FORMAT_MERL };
  enum { RGL = 1 << HETAB_FORMAT_RGL };
  const struct {
    bool given;
    const char *option, *files;
    int formats;
  } options[] = {{r->axes[HETAB_THETA_I], "theta-i", ".h5 and .exr", H5 | EXR},
                 {r->axes[HETAB_THETA_R], "theta-r", ".h5 and .exr", H5 | EXR},
                 {r->axes[HETAB_PHI], "phi", ".h5 and .exr", H5 | EXR},
                 {r->element >= 0, "element", ".h5", H5},
                 {r->compression > 0, "compress", ".h5", H5},
                 {r->tolerance > 0, "tolerance", ".h5, .exr and .binary", H5 | EXR | MERL},
                 {r->device, "device", ".h5, .exr and .binary", H5 | EXR | MERL},
                 {r->exr_parts, "exr-layout", ".exr", EXR},
                 {r->exr_type >= 0, "exr-type", ".exr", EXR},
                 {r->sampling, "merl-sampling", ".binary", MERL},
                 {r->colour, "merl-colour", ".binary", MERL},
                 {r->renderer >= 0, "for", ".bsdf", RGL},
                 {r->table_error > 0, "table-error", ".bsdf", RGL},
                 {r->cone_deg > 0, "specular-cone",
                  ".binary, .bsdf and .exr (.h5 keeps the delta apart)", MERL | RGL | EXR}};
  int asked = 0;
  for (hetab_format f = HETAB_FORMAT_H5; f <= HETAB_FORMAT_EXR; f++)
    asked |= tabulate_has_format(r, f) << f;
  for (size_t i = 0; i < sizeof options / sizeof *options; i++)
    if (options[i].given && !(options[i].formats & asked))
      return cli_usage(self, "--%s is for %s outputs, and there is none", options[i].option,
                       options[i].files);
  return -1;
}

int tabulate_parse(const cli_command *self, int argc, char **argv, tabulate_request *r) {
  cli_option options[CLI_MAX_OPTIONS + 1] = {0};
  cli_option *next = engine_options(grid_options(output_options(options, r), r), r);
  renderer_options(exr_options(next, r), r);
  CLI_TRY(cli_parse_operand(self, options, argc, argv, "SURFACE", &r->surface));
  if (r->files.count == 0)
    return cli_usage(self, "no output given: use -o FILE");
  return check_given(self, r);
}
