/* From a surface to files, in one call: what `hetab tabulate` does. */
#pragma once

#include <hetab/engine.h>
#include <hetab/exr.h>
#include <hetab/rgl.h>
#include <hetab/table.h>
#include <hetab/tabulate.h>

HETAB_BEGIN

/* NULL and 0 stand for the defaults of the functions that the members are of. */
typedef struct hetab_tabulate_to_options {
  size_t size;                          /* of the struct; 0: of this header's */
  const hetab_engine_options *engine;   /* of the engine that is made where none is given */
  const hetab_grid *grid;               /* of .h5 and .exr */
  const hetab_tabulate_options *sample; /* of .h5 and .exr, and where merl is NULL; NULL: 2000 */
  const hetab_h5_options *h5;           /* element, compression; NULL: the engine's precision */
  const hetab_exr_options *exr;         /* bands, parts, element */
  const hetab_merl_options *merl;
  const hetab_rgl_options *rgl;
  int overwrite; /* 0: an existing file is HETAB_ERR_EXISTS */
} hetab_tabulate_to_options;

/* What a reader that interpolates linearly between a dense table's nodes gets, and what the grid
 * would have to be. */
typedef struct hetab_grid_report {
  /* sum |read - f| cos / sum f cos at random incidences from 0 to 80 degrees and viewers, of the
   * first, middle and last wavelength; tests/test_tabulate_to.c */
  double error_l1;
  double lobe_deg, step_deg; /* the lobe's least standard deviation in theta; the widest step */
  /* nodes of theta from 0 to 90 and of phi from 0 to 180 degrees that leave about 5 % */
  size_t theta_count, phi_count;
} hetab_grid_report;

/* What became of one output. */
typedef struct hetab_output_report {
  hetab_format format;
  hetab_report report; /* of all outputs of the kind; the error: of this file's numbers. RGL tables
                          are made on the host: device "" and no error but that of `rgl` */
  hetab_rgl_report rgl;
  hetab_grid_report grid; /* of .h5 and .exr */
  double specular_max;    /* the largest rho_s in, or beside, the file */
  size_t saturated;       /* OpenEXR, HALF: pixels too large */
  int published;          /* the file has its name */
} hetab_output_report;

/* Tables of the surface in the files paths[count], whose endings choose the format: .h5, .hdf5,
 * .exr, .binary (MERL), .bsdf (RGL). Beside MERL and RGL tables the specular delta goes to
 * hetab_specular_path(). Outputs of a kind share one evaluation.
 *
 * All files are written and read back before the first gets its name: they appear together, whole,
 * or not at all. Where a rename fails after others, reports and the message say which are there.
 *
 * engine: NULL: one is made from the options, if an output needs a device (RGL tables do not).
 * HETAB_ERR_ARGUMENT: no such ending, two outputs that are one file, or options that do not fit
 * each other; and what the functions of <hetab/tabulate.h>, <hetab/rgl.h>, <hetab/table.h> and
 * <hetab/exr.h> say. Progress runs from 0 once for each kind of table. options and reports may be
 * NULL; reports[count] is filled as far as the call came. Errors: those of the functions named, and
 * tests/test_tabulate_to.c. */
hetab_status hetab_tabulate_to(hetab_context *ctx, hetab_engine *engine,
                               const hetab_surface *surface, const char *const *paths, size_t count,
                               const hetab_tabulate_to_options *options,
                               hetab_output_report *reports);

HETAB_END
