#include "table/exr_layout.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"
#include "core/context.h"

enum { RGB = 3 };

bool hetab_exr_by_wavelength(const hetab_exr_layout *w) {
  return w->options.parts == HETAB_EXR_BY_WAVELENGTH;
}

bool hetab_exr_is_atlas(const hetab_exr_layout *w) {
  return w->options.parts == HETAB_EXR_ATLAS;
}

size_t hetab_exr_block(const hetab_exr_layout *w) {
  return w->count[HETAB_THETA_R] * w->count[HETAB_PHI];
}

size_t hetab_exr_numbers(const hetab_exr_layout *w) {
  return hetab_exr_block(w) *
         (hetab_exr_by_wavelength(w) ? w->count[HETAB_THETA_I] : w->channel_count);
}

/* ---- names --------------------------------------------------------------------------------- */

/* The layout's form: six decimals after a comma, for a point separates layers. */
static void spectral_name(double lambda_um, char out[HETAB_EXR_NAME]) {
  snprintf(out, HETAB_EXR_NAME, "T.%.6fnm", 1e3 * lambda_um);
  char *point = strchr(out + 2, '.');
  if (point)
    *point = ',';
}

static hetab_status name_channels(hetab_context *ctx, hetab_exr_layout *w,
                                  const hetab_band *bands) {
  static const char *const rgb[RGB] = {"R", "G", "B"};
  int spectral = w->options.bands == HETAB_EXR_SPECTRAL;
  w->channel_count = spectral ? w->bands : RGB;
  w->channel_names = hetab_alloc(ctx, w->channel_count, sizeof *w->channel_names);
  w->channels = hetab_alloc(ctx, w->channel_count, sizeof *w->channels);
  if (!w->channel_names || !w->channels)
    return HETAB_ERR_MEMORY;
  for (size_t c = 0; c < w->channel_count; c++) {
    if (spectral)
      spectral_name(bands[c].lambda_um, w->channel_names[c]);
    else
      strcpy(w->channel_names[c], rgb[c]);
    w->channels[c] = w->channel_names[c];
    if (c && strcmp(w->channels[c], w->channels[c - 1]) == 0)
      return hetab_fail(ctx, HETAB_ERR_RANGE,
                        "two wavelengths are both named %s in OpenEXR; keep them 1e-6 nm apart",
                        w->channels[c]);
  }
  return HETAB_OK;
}

/* ---- the layout's life ---------------------------------------------------------------------- */

static hetab_status check_options(hetab_context *ctx, const hetab_exr_options *options) {
  if (options->parts == HETAB_EXR_BY_WAVELENGTH && options->bands == HETAB_EXR_RGB)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "parts by wavelength hold no colour; ask for spectral bands, or for parts by "
                      "theta_i");
  if (options->parts == HETAB_EXR_ATLAS && options->bands == HETAB_EXR_SPECTRAL)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "an atlas holds R, G and B; ask for RGB bands, or for parts by wavelength");
  return HETAB_OK;
}

/* The number of tiles beside each other that makes an atlas a square, or a little wider. */
static void lay_tiles(hetab_exr_layout *w) {
  size_t tiles = hetab_exr_is_atlas(w) ? w->part_count : 1;
  double square = sqrt((double)(tiles * w->count[HETAB_THETA_R]) / (double)w->count[HETAB_PHI]);
  w->tiles_across = (size_t)fmin(ceil(square), (double)tiles);
  w->tiles_down = (tiles + w->tiles_across - 1) / w->tiles_across;
}

hetab_status hetab_exr_layout_make(hetab_context *ctx, const hetab_surface *surface,
                                   const hetab_grid *grid, const hetab_exr_options *options,
                                   hetab_exr_layout *w) {
  HETAB_TRY(check_options(ctx, options));
  w->options = *options;
  w->bands = hetab_surface_band_count(surface);
  for (hetab_axis a = 0; a < HETAB_AXIS_COUNT; a++)
    w->count[a] = hetab_grid_count(grid, a);
  w->part_count = hetab_exr_by_wavelength(w) ? w->bands : w->count[HETAB_THETA_I];
  lay_tiles(w);
  return name_channels(ctx, w, hetab_surface_bands(surface));
}

void hetab_exr_layout_clear(hetab_exr_layout *w) {
  free(w->channel_names);
  free(w->channels);
}

/* ---- attributes ---------------------------------------------------------------------------- */

/* The first part's; as floats, for OpenEXR has no vectors of doubles. */
typedef struct axis_values {
  float *wavelength_nm, *n, *k, *diffuse, *deg[HETAB_AXIS_COUNT];
} axis_values;

float *hetab_exr_floats(hetab_context *ctx, const double *values, size_t count) {
  float *floats = hetab_alloc(ctx, count, sizeof *floats);
  for (size_t i = 0; floats && i < count; i++)
    floats[i] = (float)values[i];
  return floats;
}

static void free_axes(axis_values *axes) {
  free(axes->wavelength_nm);
  for (int a = 0; a < HETAB_AXIS_COUNT; a++)
    free(axes->deg[a]);
}

static hetab_status make_axes(hetab_context *ctx, const hetab_surface *surface,
                              const hetab_grid *grid, axis_values *axes) {
  size_t count = hetab_surface_band_count(surface);
  const hetab_band *bands = hetab_surface_bands(surface);
  float *spectra = axes->wavelength_nm = hetab_alloc(ctx, 4 * count, sizeof *spectra);
  if (!spectra)
    return HETAB_ERR_MEMORY;
  axes->n = spectra + count;
  axes->k = spectra + 2 * count;
  axes->diffuse = spectra + 3 * count;
  for (size_t i = 0; i < count; i++) {
    axes->wavelength_nm[i] = (float)(1e3 * bands[i].lambda_um);
    axes->n[i] = (float)bands[i].n;
    axes->k[i] = (float)bands[i].k;
    axes->diffuse[i] = (float)bands[i].diffuse_brdf;
  }
  for (hetab_axis a = 0; a < HETAB_AXIS_COUNT; a++)
    if (!(axes->deg[a] = hetab_exr_floats(ctx, hetab_grid_deg(grid, a), hetab_grid_count(grid, a))))
      return HETAB_ERR_MEMORY;
  return HETAB_OK;
}

/* Their values come with hetab_exr_patch_errors(). */
static const char *const error_names[] = {
    "error_max_sampled",         "error_share_above", "error_p99_rel", "error_rms_rel",
    "error_max_abs_below_floor", "error_samples",     "error_compared"};
enum { ERRORS = sizeof error_names / sizeof *error_names };

static void put_surface(hetab_exr_file *file, const hetab_exr_layout *w,
                        const hetab_surface *surface) {
  const hetab_exr_options *o = &w->options;
  hetab_exr_put_text(file, "surface", hetab_surface_name(surface));
  hetab_exr_put_double(file, "sigma0_um", hetab_surface_sigma0_um(surface));
  hetab_exr_put_double(file, "tau_um", hetab_surface_tau_um(surface));
  hetab_exr_put_text(file, "index_source", hetab_index_source(hetab_surface_index(surface)));
  hetab_exr_put_text(file, "hetab_version", hetab_version());
  hetab_exr_put_text(file, "method", hetab_method_name(o->method));
  hetab_exr_put_text(file, "precision", hetab_precision_name(o->slabs));
  hetab_exr_put_text(file, "device", o->device ? o->device : "");
  hetab_exr_put_double(file, "tolerance", o->tolerance);
  hetab_exr_put_text(file, "specular_delta",
                     o->specular_cone > 0.0 ? "folded into the BRDF" : "not in the BRDF");
  if (o->specular_cone > 0.0)
    hetab_exr_put_double(file, "specular_cone_deg", hetab_degrees(o->specular_cone));
  for (int i = 0; i < ERRORS; i++)
    hetab_exr_put_double(file, error_names[i], (double)NAN);
}

static void put_axes(hetab_exr_file *file, const hetab_exr_layout *w, const axis_values *axes) {
  hetab_exr_put_vector(file, "wavelength_nm", axes->wavelength_nm, w->bands);
  hetab_exr_put_vector(file, "n", axes->n, w->bands);
  hetab_exr_put_vector(file, "k", axes->k, w->bands);
  hetab_exr_put_vector(file, "uniform_diffuse", axes->diffuse, w->bands);
  hetab_exr_put_vector(file, "theta_i_deg", axes->deg[HETAB_THETA_I], w->count[HETAB_THETA_I]);
  hetab_exr_put_vector(file, "theta_r_deg", axes->deg[HETAB_THETA_R], w->count[HETAB_THETA_R]);
  hetab_exr_put_vector(file, "phi_deg", axes->deg[HETAB_PHI], w->count[HETAB_PHI]);
}

/* What the format, or the spectral layout, wants in every part. */
static void put_colour(hetab_exr_file *file, const hetab_exr_layout *w) {
  if (w->options.bands == HETAB_EXR_RGB)
    hetab_exr_put_chromaticities(file);
  else
    hetab_exr_put_text(file, "spectralLayoutVersion", "1.0");
}

/* ---- the layout ---------------------------------------------------------------------------- */

hetab_exr_part hetab_exr_table_part(const hetab_exr_layout *w, size_t i, const char *title) {
  int one = hetab_exr_by_wavelength(w);
  size_t rows = w->count[HETAB_THETA_R] * (one ? w->count[HETAB_THETA_I] : w->tiles_down);
  return (hetab_exr_part){.name = title,
                          .width = (int)(w->tiles_across * w->count[HETAB_PHI]),
                          .height = (int)rows,
                          .channels = one ? w->channels + i : w->channels,
                          .channel_count = one ? 1 : (int)w->channel_count,
                          .half = w->options.element == HETAB_EXR_HALF};
}

hetab_exr_part hetab_exr_specular_part(const hetab_exr_layout *w) {
  return (hetab_exr_part){.name = "specular_reflectance",
                          .width = (int)w->count[HETAB_THETA_I],
                          .height = 1,
                          .channels = w->channels,
                          .channel_count = (int)w->channel_count,
                          .half = w->options.element == HETAB_EXR_HALF};
}

/* What the parts are counted by, in the units of their names; free() it. */
static double *part_values(hetab_context *ctx, const hetab_exr_layout *w,
                           const hetab_surface *surface, const hetab_grid *grid) {
  double *values = hetab_alloc(ctx, w->part_count, sizeof *values);
  for (size_t i = 0; values && i < w->part_count; i++)
    values[i] = hetab_exr_by_wavelength(w) ? 1e3 * hetab_surface_bands(surface)[i].lambda_um
                                           : hetab_grid_deg(grid, HETAB_THETA_I)[i];
  return values;
}

#define BRDF "BRDF, directional-diffuse plus uniform-diffuse, no cosine factor; "

static void put_table_part(hetab_exr_file *file, const hetab_exr_layout *w,
                           const hetab_exr_part *part, double value) {
  static const struct {
    const char *number, *quantity;
  } layouts[] = {
      [HETAB_EXR_BY_THETA_I] = {"part_theta_i_deg", BRDF "row: theta_r, column: phi"},
      [HETAB_EXR_BY_WAVELENGTH] = {"part_wavelength_nm",
                                   BRDF "row: theta_i * count of theta_r + theta_r, column: phi"},
      [HETAB_EXR_ATLAS] = {"tiles_across",
                           BRDF "a tile for each theta_i, row by row from the top left, "
                                "tiles_across in a row; in a tile row: theta_r, column: phi"}};
  hetab_exr_file_part(file, part, part->width, part->height);
  hetab_exr_put_double(file, layouts[w->options.parts].number, value);
  hetab_exr_put_text(file, "units", "1/sr");
  hetab_exr_put_text(file, "quantity", layouts[w->options.parts].quantity);
}

static void put_specular_part(hetab_exr_file *file, const hetab_exr_layout *w) {
  hetab_exr_part part = hetab_exr_specular_part(w), display = hetab_exr_table_part(w, 0, "");
  hetab_exr_file_part(file, &part, display.width, display.height);
  hetab_exr_put_text(file, "units", "1");
  hetab_exr_put_text(file, "quantity",
                     "reflectance of the specular delta, for unit irradiance; column: theta_i");
}

hetab_status hetab_exr_put_header(hetab_context *ctx, hetab_exr_file *file,
                                  const hetab_exr_layout *w, const hetab_surface *surface,
                                  const hetab_grid *grid) {
  hetab_status status = HETAB_ERR_MEMORY;
  axis_values axes = {0};
  size_t parts = hetab_exr_is_atlas(w) ? 1 : w->part_count + 1;
  double *values = part_values(ctx, w, surface, grid);
  if (!values)
    goto done;
  HETAB_GOTO(make_axes(ctx, surface, grid, &axes));
  for (size_t i = 0; i < parts; i++) {
    char title[HETAB_EXR_NAME];
    hetab_exr_part_name(hetab_exr_by_wavelength(w) ? "wavelength_" : "theta_i_",
                        hetab_exr_by_wavelength(w) ? "nm" : "deg", values, w->part_count,
                        i < w->part_count ? i : 0, title);
    hetab_exr_part part = hetab_exr_table_part(w, i, hetab_exr_is_atlas(w) ? "atlas" : title);
    if (i < w->part_count)
      put_table_part(file, w, &part, hetab_exr_is_atlas(w) ? (double)w->tiles_across : values[i]);
    else
      put_specular_part(file, w);
    put_colour(file, w);
    if (i > 0)
      continue;
    put_surface(file, w, surface);
    put_axes(file, w, &axes);
  }
  status = HETAB_OK;
done:
  free(values);
  free_axes(&axes);
  return status;
}

void hetab_exr_patch_errors(hetab_exr_file *file, const hetab_error_stats *error) {
  const double values[ERRORS] = {
      error->max_rel,       hetab_error_share_above(error), error->p99_rel,         error->rms_rel,
      error->max_abs_below, (double)error->samples,         (double)error->compared};
  for (int i = 0; i < ERRORS && error->samples; i++)
    hetab_exr_file_patch(file, error_names[i], values[i]);
}
