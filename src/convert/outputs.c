#include "convert/outputs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <hetab/merl.h>

#include "convert/cone_grid.h"
#include "convert/mend.h"
#include "core/angle.h"
#include "core/held_files.h"
#include "core/input_file.h"
#include "rgl/rgl_table.h"
#include "table/h5_head.h"
#include "table/specular.h"

HETAB_HANDLE(hetab_grid)
HETAB_HANDLE(hetab_merl)
HETAB_HANDLE(hetab_rgl)

/* ---- HDF5 ---------------------------------------------------------------------------------- */

/* One incidence, [channel][theta_r][phi], from pairs' values [theta_r][phi][channel]. */
static hetab_status write_row(hetab_context *ctx, hetab_convert_source *source, size_t row,
                              const hetab_directions *pairs, size_t count, double *values,
                              double *slab, hetab_table_writer *writer) {
  HETAB_TRY(hetab_convert_values(ctx, source, pairs, count, values));
  for (size_t c = 0; c < source->channels; c++) {
    for (size_t i = 0; i < count; i++)
      slab[i] = values[i * source->channels + c];
    hetab_slab part = {c, row, 1, slab};
    HETAB_TRY(hetab_table_write_slab(ctx, writer, &part));
  }
  return HETAB_OK;
}

static void row_pairs(const hetab_grid *grid, size_t row, hetab_directions *pairs) {
  const double radian = M_PI / 180, *deg[HETAB_AXIS_COUNT];
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    deg[axis] = hetab_grid_deg(grid, axis);
  for (size_t r = 0; r < hetab_grid_count(grid, HETAB_THETA_R); r++)
    for (size_t p = 0; p < hetab_grid_count(grid, HETAB_PHI); p++)
      *pairs++ = (hetab_directions){deg[HETAB_THETA_I][row] * radian,
                                    deg[HETAB_THETA_R][r] * radian, deg[HETAB_PHI][p] * radian};
}

static hetab_status write_rows(hetab_context *ctx, hetab_convert_source *source,
                               const hetab_grid *grid, hetab_table_writer *writer) {
  size_t rows = hetab_grid_count(grid, HETAB_THETA_I);
  size_t count = hetab_grid_count(grid, HETAB_THETA_R) * hetab_grid_count(grid, HETAB_PHI);
  HETAB_FREED hetab_directions *pairs = hetab_alloc(ctx, count, sizeof *pairs);
  HETAB_FREED double *values = hetab_alloc(ctx, count, source->channels * sizeof *values);
  HETAB_FREED double *slab = hetab_alloc(ctx, count, sizeof *slab);
  HETAB_NEED(pairs && values && slab);
  for (size_t row = 0; row < rows; row++) {
    row_pairs(grid, row, pairs);
    HETAB_TRY(write_row(ctx, source, row, pairs, count, values, slab, writer));
    HETAB_TRY(hetab_progress(ctx, (double)(row + 1), (double)rows));
  }
  return HETAB_OK;
}

static hetab_status write_specular(hetab_context *ctx, const hetab_convert_source *source,
                                   const hetab_grid *grid, hetab_table_writer *writer) {
  size_t count = hetab_grid_count(grid, HETAB_THETA_I), channels = source->channels;
  HETAB_FREED double *rho = hetab_alloc(ctx, channels * count, sizeof *rho);
  HETAB_FREED double *value = hetab_alloc(ctx, channels, sizeof *value);
  HETAB_NEED(rho && value);
  for (size_t i = 0; i < count; i++) {
    double theta_i = hetab_grid_deg(grid, HETAB_THETA_I)[i] * M_PI / 180;
    HETAB_TRY(hetab_convert_specular(ctx, source, theta_i, value));
    for (size_t c = 0; c < channels; c++)
      rho[c * count + i] = value[c];
  }
  return hetab_table_write_specular(ctx, writer, rho);
}

static hetab_status save_h5(hetab_context *ctx, hetab_convert_source *source, const char *path,
                            const hetab_grid *grid, const hetab_convert_options *options) {
  const hetab_h5_options h5 = {.element = HETAB_FLOAT,
                               .slabs = HETAB_DOUBLE,
                               .compression = options->compression,
                               .overwrite = options->overwrite};
  const hetab_h5_head head = {.name = source->path,
                              .sigma0_um = (double)NAN,
                              .tau_um = (double)NAN,
                              .source = source->path,
                              .channels = source->channels,
                              .lambda_um = source->lambda_um,
                              .specular_cone = source->specular_cone};
  hetab_table_writer *writer;
  HETAB_TRY(hetab_h5_create_from(ctx, path, &head, grid, &h5, &writer));
  hetab_status status = write_specular(ctx, source, grid, writer);
  if (status == HETAB_OK)
    status = write_rows(ctx, source, grid, writer);
  if (status == HETAB_OK)
    return hetab_table_commit(ctx, writer);
  hetab_table_abort(writer);
  return status;
}

hetab_status hetab_convert_to_h5(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                 const hetab_convert_options *options) {
  HETAB_ENDS(hetab_grid_end) hetab_grid *grid = NULL;
  HETAB_TRY(hetab_cone_grid(ctx, options->axes, source->specular_cone, source->path, &grid));
  return save_h5(ctx, source, path, grid, options);
}

/* ---- MERL ---------------------------------------------------------------------------------- */

/* The cells [first, end). */
static hetab_status fill_cells(hetab_context *ctx, hetab_convert_source *source, size_t first,
                               size_t end, hetab_directions *pairs, double *values,
                               hetab_merl *merl) {
  size_t count = 0;
  hetab_merl_pair pair;
  for (size_t cell = first; cell < end; cell++)
    if (hetab_merl_pair_of(hetab_merl_middle(cell), &pair))
      pairs[count++] = pair.at;
  HETAB_TRY(hetab_convert_values(ctx, source, pairs, count, values));
  for (size_t cell = first; cell < end; cell++)
    if (hetab_merl_pair_of(hetab_merl_middle(cell), &pair))
      for (int c = 0; c < HETAB_MERL_CHANNELS; c++)
        hetab_merl_channel(merl, c)[cell] = *values++;
  return HETAB_OK;
}

hetab_status hetab_convert_to_merl(hetab_context *ctx, hetab_convert_source *source,
                                   const char *path, const hetab_convert_options *options) {
  enum { ROW = HETAB_MERL_THETA_D * HETAB_MERL_PHI_D };
  HETAB_ENDS(hetab_merl_end) hetab_merl *merl = NULL;
  HETAB_FREED hetab_directions *pairs = hetab_alloc(ctx, ROW, sizeof *pairs);
  HETAB_FREED double *values = hetab_alloc(ctx, 3 * ROW, sizeof *values);
  HETAB_NEED(pairs && values);
  HETAB_TRY(hetab_merl_create(ctx, &merl));
  for (size_t row = 0; row < HETAB_MERL_THETA_H; row++) {
    HETAB_TRY(fill_cells(ctx, source, row * ROW, (row + 1) * ROW, pairs, values, merl));
    HETAB_TRY(hetab_progress(ctx, (double)(row + 1), HETAB_MERL_THETA_H));
  }
  hetab_merl_set_specular_cone(merl, source->specular_cone);
  return hetab_merl_save(ctx, merl, path, options->overwrite);
}

/* ---- RGL ----------------------------------------------------------------------------------- */

/* RGL tables sample what they reflect. */
static hetab_status check_not_black(hetab_context *ctx, const hetab_convert_source *source) {
  HETAB_FREED float *albedo = hetab_alloc(ctx, source->channels_in, sizeof *albedo);
  int lit = 0;
  HETAB_NEED(albedo);
  for (int deg = 0; deg <= 80; deg += 10) {
    const float wi[3] = {(float)sin(deg * M_PI / 180), 0, (float)cos(deg * M_PI / 180)};
    hetab_lookup_albedo(source->table, NULL, 1, wi, albedo, NULL);
    for (size_t c = 0; c < source->channels_in; c++)
      lit |= albedo[c] > 0;
  }
  return lit ? HETAB_OK
             : hetab_fail(ctx, HETAB_ERR_RANGE,
                          "'%s' is black at every incidence: an RGL table of it cannot be sampled; "
                          "convert it to .h5 or .binary",
                          source->path);
}

hetab_status hetab_convert_to_rgl(hetab_context *ctx, hetab_convert_source *source,
                                  const char *path, const hetab_convert_options *options) {
  char description[512];
  const char *slash = strrchr(source->path, '/');
  snprintf(description, sizeof description, "converted from %s by hetab %s",
           slash ? slash + 1 : source->path, hetab_version());
  const hetab_rgl_source table = {.channels = source->channels,
                                  .wavelengths_um = source->lambda_um,
                                  .description = description,
                                  .specular_cone_deg = hetab_degrees(source->specular_cone),
                                  .values = hetab_convert_values,
                                  .user = source};
  const hetab_rgl_options rgl_options = {.bands =
                                             source->lambda_um ? HETAB_RGL_SPECTRAL : HETAB_RGL_RGB,
                                         .table_error = options->table_error};
  hetab_rgl_report report;
  HETAB_ENDS(hetab_rgl_end) hetab_rgl *rgl = NULL;
  HETAB_TRY(check_not_black(ctx, source));
  HETAB_TRY(hetab_rgl_build(ctx, &table, &rgl_options, &rgl, &report));
  hetab_status status = HETAB_OK;
  if (source->clamped) { /* in any of the tables that were tried: count those of this one */
    source->clamped = 0;
    status = hetab_rgl_fill(ctx, &table, rgl);
  }
  if (status == HETAB_OK)
    status = hetab_rgl_save(ctx, rgl, path, options->overwrite);
  return status;
}

/* ---- the specular delta -------------------------------------------------------------------- */

enum { ANGLES = HETAB_SPECULAR_ANGLES };

/* Every degree of every wavelength of the table, before it was made sRGB; of channels where it has
 * no wavelengths, which stand at about those of the primaries. */
static hetab_status write_csv(hetab_context *ctx, const hetab_convert_source *source,
                              const char *path, int overwrite) {
  static const double primaries_um[] = {0.61, 0.55, 0.46};
  const double *lambda_um = hetab_lookup_wavelengths_um(source->table);
  size_t count = source->channels_in;
  HETAB_FREED float *at = hetab_alloc(ctx, count, sizeof *at);
  HETAB_FREED double *rho = hetab_alloc(ctx, ANGLES, count * sizeof *rho);
  HETAB_NEED(at && rho);
  for (size_t i = 0; i < ANGLES; i++) {
    double theta_i = (double)i * M_PI / 180;
    const float wi[3] = {(float)sin(theta_i), 0, (float)cos(theta_i)};
    hetab_lookup_albedo(source->table, NULL, 1, wi, NULL, at);
    for (size_t w = 0; w < count; w++)
      rho[w * ANGLES + i] = (double)at[w];
  }
  return hetab_specular_save(ctx, path, lambda_um ? lambda_um : primaries_um, count, !lambda_um,
                             rho, overwrite);
}

/* Readers would add a delta that is another table's. */
static hetab_status check_none(hetab_context *ctx, const char *path) {
  if (access(path, F_OK) != 0)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_EXISTS,
                    "'%s' exists: readers would take it for the specular delta of the output, "
                    "which it is not; move it away, or give another output",
                    path);
}

/* The file beside the input, if there is one, beside the output. */
static hetab_status copy_csv(hetab_context *ctx, const hetab_convert_source *source,
                             const char *path, int overwrite) {
  HETAB_FREED char *from = hetab_specular_path(ctx, source->path), *text = NULL;
  size_t size = 0;
  HETAB_NEED(from);
  FILE *file;
  (void)hetab_input_stream(ctx, from, HETAB_INPUT_TABLE, &file);
  ssize_t read = file ? getdelim(&text, &size, '\0', file) : -1;
  if (file)
    fclose(file);
  return read > 0 ? hetab_text_save(ctx, path, text, (size_t)read, overwrite)
                  : check_none(ctx, path);
}

static double largest_specular(const hetab_convert_source *source, float *rho) {
  float largest = 0;
  for (int i = 0; i < ANGLES; i++) {
    const float wi[3] = {(float)sin(i * M_PI / 180), 0, (float)cos(i * M_PI / 180)};
    hetab_lookup_albedo(source->table, NULL, 1, wi, NULL, rho);
    for (size_t c = 0; c < source->channels_in; c++)
      largest = fmaxf(largest, rho[c]);
  }
  return (double)largest;
}

/* What the file beside the output is called; NULL: HDF5 has none, or the one beside the input is
 * that one. */
static hetab_status path_beside(hetab_context *ctx, const hetab_convert_source *source,
                                hetab_format format, const char *path, char **name) {
  *name = NULL;
  if (format == HETAB_FORMAT_H5)
    return HETAB_OK;
  char *to = hetab_specular_path(ctx, path), *from = hetab_specular_path(ctx, source->path);
  hetab_status status = to && from ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK && (source->format == HETAB_FORMAT_H5 || !hetab_same_file(to, from))) {
    *name = to;
    to = NULL;
  }
  free(to);
  free(from);
  return status;
}

hetab_status hetab_convert_check_specular(hetab_context *ctx, const hetab_convert_source *source,
                                          hetab_format format, const char *path, int overwrite,
                                          double *largest) {
  HETAB_FREED char *name = NULL;
  float *rho = hetab_alloc(ctx, source->channels_in, sizeof *rho);
  HETAB_NEED(rho);
  *largest = largest_specular(source, rho);
  free(rho);
  HETAB_TRY(path_beside(ctx, source, format, path, &name));
  if (name)
    HETAB_TRY(*largest > 0 ? hetab_output_check(ctx, name, overwrite) : check_none(ctx, name));
  return HETAB_OK;
}

hetab_status hetab_convert_save_specular(hetab_context *ctx, const hetab_convert_source *source,
                                         hetab_format format, const char *path, int overwrite,
                                         hetab_convert_report *report) {
  HETAB_FREED char *name = NULL;
  if (report->specular_max > 0)
    HETAB_TRY(path_beside(ctx, source, format, path, &name));
  if (!name)
    return HETAB_OK;
  return source->format == HETAB_FORMAT_H5 || hetab_lookup_wavelengths_um(source->table)
             ? write_csv(ctx, source, name, overwrite)
             : copy_csv(ctx, source, name, overwrite);
}
