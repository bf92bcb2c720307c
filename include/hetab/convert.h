/* Tables from one format to another: HDF5 (.h5) and RGL (.bsdf) tables, ours, and MERL (.binary)
 * tables, anyone's. The input is told by its content, the output by its ending.
 *
 * Channels: MERL has linear sRGB; HDF5 and RGL have linear sRGB or wavelengths. From wavelengths to
 * linear sRGB a table is integrated under D65 for the CIE 1931 observer (they have to reach from
 * 400 to 700 nm in steps of 10 nm or less); components outside the gamut become 0 and are counted.
 * From linear sRGB no spectrum is made up: HDF5 then has three channels in place of wavelengths, on
 * the axis `channel`, and no n, k and uniform_diffuse (NaN); look-ups and `hetab view` read
 * it, what needs a spectrum refuses it.
 *
 * What the input is at a direction: its interpolated value, as hetab_lookup_eval() gives it.
 * Measured MERL tables have holes: cells marked invalid, negative or not numbers. They are filled
 * from their neighbours first, smoothly in the logarithm, and counted.
 *
 * The specular delta goes with the table: /specular_reflectance, or NAME.specular.csv beside MERL
 * and RGL tables: spectra, or the three channels of an HDF5 table in linear sRGB. A delta that was
 * folded in as a lobe of 2 degrees or more keeps its energy within 1 % at every incidence to 85
 * degrees, in HDF5 also for readers that interpolate linearly (tests/test_convert.c); the output
 * says that it is in it.
 */
#pragma once

#include <stddef.h>
#include <hetab/grid.h>
#include <hetab/output_file.h>
#include <hetab/types.h>

HETAB_BEGIN

typedef struct hetab_convert_options {
  size_t size; /* of the struct; 0: of this header's */
  /* Of HDF5, as hetab_grid_set_axis() reads them. NULL: hetab_grid_create()'s, or where the delta
   * is in the input as a lobe, one that holds it; one given that does not is HETAB_ERR_RANGE. */
  const char *axes[HETAB_AXIS_COUNT];
  int srgb;           /* linear sRGB even where wavelengths could be kept */
  double table_error; /* of RGL, as in hetab_rgl_options; 0: 0.01 */
  int compression;    /* of HDF5, 0 to 9 */
  int overwrite;
  size_t pairs;  /* of directions, for the error; 0: 100000 */
  unsigned seed; /* of the pairs */
} hetab_convert_options;

typedef struct hetab_convert_report {
  hetab_format from, to;
  size_t channels_in, channels_out;
  int srgb_in, srgb_out;
  /* What the conversion added: sum |out - in| cos / sum in cos over all channels and viewers, at
   * random incidences from 0 to 80 degrees; `in` is interpolated, in the output's channels. */
  double error_l1;              /* by its readers' rule: MERL truncates, HDF5 linear */
  double error_l1_interpolated; /* by hetab_lookup_eval() */
  double bias;                  /* as error_l1_interpolated, without the modulus */
  size_t filled;                /* cells of the input above the horizon without data */
  size_t negative;              /* numbers of the input a little below 0, set to 0: .bsdf */
  size_t clamped;               /* sRGB components below 0, set to 0 */
  double specular_max;          /* the largest rho_s of the input, which the output keeps */
  /* HDF5 with an error_l1 above 0.1: nodes of evenly spaced axes that leave such a reader 0.05 at
   * most, as tried on 3000 pairs; else 0. */
  size_t proposed[HETAB_AXIS_COUNT];
} hetab_convert_report;

/* HETAB_ERR_UNSUPPORTED: no such format, HETAB_ERR_PARSE: a damaged input, HETAB_ERR_RANGE: no
 * colour; the message names the file and the remedy. The output appears whole or not at all.
 * options and report may be NULL. */
hetab_status hetab_convert(hetab_context *ctx, const char *in, const char *out,
                           const hetab_convert_options *options, hetab_convert_report *report);

HETAB_END
