#include <hetab/exr.h>

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "model/colour.h"
#include "table/exr_file.h"

enum { RGB = 3, MOST_PARTS = 4096, MOST_SIDE = 1 << 20 };

static const double most_bytes = 4.0 * (1u << 30);
static const double most_half = 65504;

typedef char name[HETAB_EXR_NAME];

/* A sum that does not depend, once rounded to a float, on the order of what is added: slabs come in
 * any, and the same table has to give the same file. */
typedef struct exact_sum {
  double high, low;
} exact_sum;

/* One part's pixels while they come in: R, G, B being summed up, or floats. */
typedef struct held {
  exact_sum *sums;
  float *values;
  size_t rows_left; /* of theta_i and wavelength that go into it */
} held;

struct hetab_exr_writer {
  hetab_exr_file *file;
  hetab_exr_options options;
  size_t bands, count[HETAB_AXIS_COUNT];
  double (*weights)[RGB]; /* [bands], RGB: what a wavelength adds to the colour */
  name *channel_names;    /* of the specular part, and of every part by theta_i */
  const char **channels;  /* the same as pointers */
  size_t channel_count;
  held *parts; /* [part_count] */
  size_t part_count, next_part;
  unsigned char *written; /* [wavelength][theta_i] */
  double held_bytes;
  float *rho; /* [channel][theta_i], once it is known */
  size_t saturated;
};

static int by_wavelength(const hetab_exr_writer *w) {
  return w->options.parts == HETAB_EXR_BY_WAVELENGTH;
}

/* Pixels of one channel of theta_i's part. */
static size_t block_size(const hetab_exr_writer *w) {
  return w->count[HETAB_THETA_R] * w->count[HETAB_PHI];
}

/* Numbers of a part: all of its channels. */
static size_t part_numbers(const hetab_exr_writer *w) {
  return block_size(w) * (by_wavelength(w) ? w->count[HETAB_THETA_I] : w->channel_count);
}

static double part_bytes(const hetab_exr_writer *w) {
  size_t size = w->options.bands == HETAB_EXR_RGB ? sizeof(exact_sum) : sizeof(float);
  return (double)part_numbers(w) * (double)size;
}

/* ---- names --------------------------------------------------------------------------------- */

/* The layout's form: six decimals after a comma, for a point separates layers. */
static void spectral_name(double lambda_um, name out) {
  snprintf(out, HETAB_EXR_NAME, "T.%.6fnm", 1e3 * lambda_um);
  char *point = strchr(out + 2, '.');
  if (point)
    *point = ',';
}

static hetab_status name_channels(hetab_context *ctx, hetab_exr_writer *w,
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

/* ---- limits -------------------------------------------------------------------------------- */

static hetab_status check_options(hetab_context *ctx, const hetab_exr_options *options) {
  if (options->parts == HETAB_EXR_BY_WAVELENGTH && options->bands == HETAB_EXR_RGB)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "parts by wavelength hold no colour; ask for spectral bands, or for parts by "
                      "theta_i");
  return HETAB_OK;
}

static hetab_status fail_memory(hetab_context *ctx, double bytes) {
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "the OpenEXR table would take %.1f GiB of memory, more than %.0f; choose fewer "
                    "angles or wavelengths, parts by theta_i, or an HDF5 table, which is not held",
                    bytes / (1u << 30), most_bytes / (1u << 30));
}

static hetab_status check_size(hetab_context *ctx, const hetab_exr_writer *w) {
  size_t height = w->count[HETAB_THETA_R] * (by_wavelength(w) ? w->count[HETAB_THETA_I] : 1);
  if (w->part_count > MOST_PARTS)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "an OpenEXR table of %zu parts is more than readers stand; choose at most %d "
                      "%s, or an HDF5 table",
                      w->part_count, MOST_PARTS, by_wavelength(w) ? "wavelengths" : "theta_i");
  if (height > MOST_SIDE)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "a part of the OpenEXR table would have %zu rows, more than %d; choose fewer "
                      "angles, or parts by theta_i",
                      height, MOST_SIDE);
  double bytes = part_bytes(w) * (by_wavelength(w) ? (double)w->part_count : 1);
  return bytes > most_bytes ? fail_memory(ctx, bytes) : HETAB_OK;
}

/* ---- attributes ---------------------------------------------------------------------------- */

/* Every part's; as floats, for OpenEXR has no vectors of doubles. */
typedef struct axis_values {
  float *wavelength_nm, *n, *k, *diffuse, *deg[HETAB_AXIS_COUNT];
} axis_values;

static float *to_floats(hetab_context *ctx, const double *values, size_t count) {
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
    if (!(axes->deg[a] = to_floats(ctx, hetab_grid_deg(grid, a), hetab_grid_count(grid, a))))
      return HETAB_ERR_MEMORY;
  return HETAB_OK;
}

/* Their values come with hetab_exr_set_error. */
static const char *const error_names[] = {"error_max_rel", "error_p99_rel",
                                          "error_rms_rel", "error_max_abs_below_floor",
                                          "error_samples", "error_compared"};
enum { ERRORS = sizeof error_names / sizeof *error_names };

static void put_surface(const hetab_exr_writer *w, const hetab_surface *surface) {
  hetab_exr_file *file = w->file;
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
  for (int i = 0; i < ERRORS; i++)
    hetab_exr_put_double(file, error_names[i], NAN);
}

static void put_axes(const hetab_exr_writer *w, const axis_values *axes) {
  hetab_exr_put_vector(w->file, "wavelength_nm", axes->wavelength_nm, w->bands);
  hetab_exr_put_vector(w->file, "n", axes->n, w->bands);
  hetab_exr_put_vector(w->file, "k", axes->k, w->bands);
  hetab_exr_put_vector(w->file, "uniform_diffuse", axes->diffuse, w->bands);
  hetab_exr_put_vector(w->file, "theta_i_deg", axes->deg[HETAB_THETA_I], w->count[HETAB_THETA_I]);
  hetab_exr_put_vector(w->file, "theta_r_deg", axes->deg[HETAB_THETA_R], w->count[HETAB_THETA_R]);
  hetab_exr_put_vector(w->file, "phi_deg", axes->deg[HETAB_PHI], w->count[HETAB_PHI]);
  if (w->options.bands == HETAB_EXR_RGB)
    hetab_exr_put_chromaticities(w->file);
  else
    hetab_exr_put_text(w->file, "spectralLayoutVersion", "1.0");
}

/* ---- the layout ---------------------------------------------------------------------------- */

static hetab_exr_part table_part(const hetab_exr_writer *w, size_t i, const char *title) {
  int one = by_wavelength(w);
  size_t rows = w->count[HETAB_THETA_R] * (one ? w->count[HETAB_THETA_I] : 1);
  return (hetab_exr_part){.name = title,
                          .width = (int)w->count[HETAB_PHI],
                          .height = (int)rows,
                          .channels = one ? w->channels + i : w->channels,
                          .channel_count = one ? 1 : (int)w->channel_count,
                          .half = w->options.element == HETAB_EXR_HALF};
}

static hetab_exr_part specular_part(const hetab_exr_writer *w) {
  return (hetab_exr_part){.name = "specular_reflectance",
                          .width = (int)w->count[HETAB_THETA_I],
                          .height = 1,
                          .channels = w->channels,
                          .channel_count = (int)w->channel_count,
                          .half = w->options.element == HETAB_EXR_HALF};
}

/* What the parts are counted by, in the units of their names; free() it. */
static double *part_values(hetab_context *ctx, const hetab_exr_writer *w,
                           const hetab_surface *surface, const hetab_grid *grid) {
  double *values = hetab_alloc(ctx, w->part_count, sizeof *values);
  for (size_t i = 0; values && i < w->part_count; i++)
    values[i] = by_wavelength(w) ? 1e3 * hetab_surface_bands(surface)[i].lambda_um
                                 : hetab_grid_deg(grid, HETAB_THETA_I)[i];
  return values;
}

static void put_table_part(hetab_exr_writer *w, const hetab_exr_part *part, double value) {
  hetab_exr_file_part(w->file, part, part->width, part->height);
  hetab_exr_put_double(w->file, by_wavelength(w) ? "part_wavelength_nm" : "part_theta_i_deg",
                       value);
  hetab_exr_put_text(w->file, "units", "1/sr");
  hetab_exr_put_text(w->file, "quantity",
                     by_wavelength(w)
                         ? "BRDF, directional-diffuse plus uniform-diffuse, no cosine factor; row: "
                           "theta_i * count of theta_r + theta_r, column: phi"
                         : "BRDF, directional-diffuse plus uniform-diffuse, no cosine factor; row: "
                           "theta_r, column: phi");
}

static void put_specular_part(hetab_exr_writer *w) {
  hetab_exr_part part = specular_part(w), display = table_part(w, 0, "");
  hetab_exr_file_part(w->file, &part, display.width, display.height);
  hetab_exr_put_text(w->file, "units", "1");
  hetab_exr_put_text(w->file, "quantity",
                     "reflectance of the specular delta, for unit irradiance; column: theta_i");
}

static hetab_status lay_out(hetab_context *ctx, hetab_exr_writer *w, const hetab_surface *surface,
                            const hetab_grid *grid) {
  hetab_status status = HETAB_ERR_MEMORY;
  axis_values axes = {0};
  double *values = part_values(ctx, w, surface, grid);
  if (!values)
    goto done;
  HETAB_GOTO(make_axes(ctx, surface, grid, &axes));
  for (size_t i = 0; i <= w->part_count; i++) {
    name title;
    hetab_exr_part_name(by_wavelength(w) ? "wavelength_" : "theta_i_",
                        by_wavelength(w) ? "nm" : "deg", values, w->part_count,
                        i < w->part_count ? i : 0, title);
    hetab_exr_part part = table_part(w, i, title);
    if (i < w->part_count)
      put_table_part(w, &part, values[i]);
    else
      put_specular_part(w);
    put_surface(w, surface);
    put_axes(w, &axes);
  }
  status = hetab_exr_file_begin(ctx, w->file);
done:
  free(values);
  free_axes(&axes);
  return status;
}

/* ---- creation ------------------------------------------------------------------------------ */

static hetab_status weigh(hetab_context *ctx, hetab_exr_writer *w, const hetab_band *bands) {
  hetab_status status;
  double *lambda_um = hetab_alloc(ctx, w->bands, sizeof *lambda_um);
  w->weights = hetab_alloc(ctx, w->bands, sizeof *w->weights);
  if (!lambda_um || !w->weights)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  for (size_t b = 0; b < w->bands; b++)
    lambda_um[b] = bands[b].lambda_um;
  HETAB_GOTO(hetab_srgb_weights(ctx, lambda_um, w->bands, w->weights));
done:
  free(lambda_um);
  return status;
}

static hetab_status make_writer(hetab_context *ctx, hetab_exr_writer *w,
                                const hetab_surface *surface, const hetab_grid *grid,
                                const hetab_exr_options *options) {
  const hetab_band *bands = hetab_surface_bands(surface);
  w->options = *options;
  w->bands = hetab_surface_band_count(surface);
  for (hetab_axis a = 0; a < HETAB_AXIS_COUNT; a++)
    w->count[a] = hetab_grid_count(grid, a);
  w->part_count = by_wavelength(w) ? w->bands : w->count[HETAB_THETA_I];
  HETAB_TRY(name_channels(ctx, w, bands));
  HETAB_TRY(check_size(ctx, w));
  if (options->bands == HETAB_EXR_RGB)
    HETAB_TRY(weigh(ctx, w, bands));
  w->parts = hetab_alloc(ctx, w->part_count, sizeof *w->parts);
  w->written = hetab_alloc(ctx, w->bands * w->count[HETAB_THETA_I], 1);
  if (!w->parts || !w->written)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < w->part_count; i++)
    w->parts[i].rows_left = by_wavelength(w) ? w->count[HETAB_THETA_I] : w->bands;
  return HETAB_OK;
}

hetab_status hetab_exr_create(hetab_context *ctx, const char *path, const hetab_surface *surface,
                              const hetab_grid *grid, const hetab_exr_options *options,
                              hetab_exr_writer **out) {
  hetab_status status;
  *out = NULL;
  HETAB_TRY(check_options(ctx, options));
  hetab_exr_writer *w = hetab_alloc(ctx, 1, sizeof *w);
  if (!w)
    return HETAB_ERR_MEMORY;
  HETAB_GOTO(make_writer(ctx, w, surface, grid, options));
  HETAB_GOTO(hetab_exr_file_create(ctx, path, options->overwrite, &w->file));
  HETAB_GOTO(lay_out(ctx, w, surface, grid));
  *out = w;
  return HETAB_OK;
done:
  hetab_exr_abort(w);
  return status;
}

/* ---- slabs --------------------------------------------------------------------------------- */

static hetab_status check_slab(hetab_context *ctx, const hetab_exr_writer *w,
                               const hetab_slab *slab) {
  size_t rows = w->count[HETAB_THETA_I];
  if (slab->wavelength >= w->bands || slab->theta_i_first >= rows || !slab->theta_i_count ||
      slab->theta_i_count > rows - slab->theta_i_first)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "a slab of wavelength %zu, theta_i %zu and %zu more is not in the table of "
                      "%zu wavelengths and %zu theta_i",
                      slab->wavelength, slab->theta_i_first, slab->theta_i_count, w->bands, rows);
  for (size_t i = 0; i < slab->theta_i_count; i++)
    if (w->written[slab->wavelength * rows + slab->theta_i_first + i])
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "theta_i %zu of wavelength %zu is given twice to the OpenEXR table",
                        slab->theta_i_first + i, slab->wavelength);
  return HETAB_OK;
}

static hetab_status open_part(hetab_context *ctx, hetab_exr_writer *w, held *part) {
  if (part->sums || part->values)
    return HETAB_OK;
  w->held_bytes += part_bytes(w);
  if (w->held_bytes > most_bytes)
    return fail_memory(ctx, w->held_bytes);
  if (w->options.bands == HETAB_EXR_RGB)
    part->sums = hetab_alloc(ctx, part_numbers(w), sizeof *part->sums);
  else
    part->values = hetab_alloc(ctx, part_numbers(w), sizeof *part->values);
  return part->sums || part->values ? HETAB_OK : HETAB_ERR_MEMORY;
}

static double entry(const hetab_exr_writer *w, const void *values, size_t i) {
  return w->options.slabs == HETAB_DOUBLE ? ((const double *)values)[i]
                                          : (double)((const float *)values)[i];
}

/* Knuth's: what the addition rounds off is found exactly. */
static void add(exact_sum *sum, double value) {
  double high = sum->high + value, part = high - sum->high;
  sum->low += (sum->high - (high - part)) + (value - part);
  sum->high = high;
}

/* One theta_i row of a slab, whose entries begin at `from`; 0 if one of them is no float. */
static int add_row(hetab_exr_writer *w, held *part, const hetab_slab *slab, size_t theta_i,
                   size_t from) {
  size_t block = block_size(w), at = (by_wavelength(w) ? theta_i : slab->wavelength) * block;
  int bad = 0;
  for (size_t p = 0; p < block; p++) {
    double value = entry(w, slab->values, from + p);
    bad |= !(fabs(value) <= (double)FLT_MAX);
    if (part->values)
      part->values[at + p] = bad ? 0.0f : (float)value;
    else
      for (size_t c = 0; c < RGB; c++)
        add(&part->sums[c * block + p], w->weights[slab->wavelength][c] * value);
  }
  return !bad;
}

static void close_part(hetab_exr_writer *w, held *part) {
  if (part->sums || part->values)
    w->held_bytes -= part_bytes(w);
  free(part->sums);
  free(part->values);
  part->sums = NULL;
  part->values = NULL;
}

/* What is too large for half precision becomes its largest number. */
static void saturate(hetab_exr_writer *w, float *values, size_t count) {
  if (w->options.element != HETAB_EXR_HALF)
    return;
  for (size_t i = 0; i < count; i++)
    if (fabs((double)values[i]) > most_half) {
      values[i] = copysignf((float)most_half, values[i]);
      w->saturated++;
    }
}

static hetab_status write_planes(hetab_context *ctx, hetab_exr_writer *w, size_t number,
                                 const hetab_exr_part *part, float *values) {
  size_t plane = (size_t)part->width * (size_t)part->height;
  const float **planes = hetab_alloc(ctx, (size_t)part->channel_count, sizeof *planes);
  if (!planes)
    return HETAB_ERR_MEMORY;
  for (size_t c = 0; c < (size_t)part->channel_count; c++)
    planes[c] = values + c * plane;
  saturate(w, values, plane * (size_t)part->channel_count);
  hetab_status status = hetab_exr_file_write(ctx, w->file, (int)number, part, planes);
  free(planes);
  return status;
}

static hetab_status write_part(hetab_context *ctx, hetab_exr_writer *w, size_t number) {
  held *held = &w->parts[number];
  hetab_exr_part part = table_part(w, number, "");
  if (held->sums && !(held->values = hetab_alloc(ctx, part_numbers(w), sizeof *held->values)))
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; held->sums && i < part_numbers(w); i++)
    held->values[i] = (float)(held->sums[i].high + held->sums[i].low);
  hetab_status status = write_planes(ctx, w, number, &part, held->values);
  close_part(w, held);
  return status;
}

hetab_status hetab_exr_write_slab(hetab_context *ctx, void *user, const hetab_slab *slab) {
  hetab_exr_writer *w = user;
  HETAB_TRY(check_slab(ctx, w, slab));
  for (size_t i = 0; i < slab->theta_i_count; i++) {
    size_t theta_i = slab->theta_i_first + i;
    held *part = &w->parts[by_wavelength(w) ? slab->wavelength : theta_i];
    HETAB_TRY(open_part(ctx, w, part));
    if (!add_row(w, part, slab, theta_i, i * block_size(w)))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "an entry of theta_i %zu, wavelength %zu is NaN or too large for a float",
                        theta_i, slab->wavelength);
    w->written[slab->wavelength * w->count[HETAB_THETA_I] + theta_i] = 1;
    part->rows_left--;
  }
  /* The format wants parts in their order. */
  while (w->next_part < w->part_count && !w->parts[w->next_part].rows_left)
    HETAB_TRY(write_part(ctx, w, w->next_part++));
  return HETAB_OK;
}

/* ---- the rest ------------------------------------------------------------------------------ */

hetab_status hetab_exr_write_specular(hetab_context *ctx, hetab_exr_writer *w,
                                      const double *rho_s) {
  size_t angles = w->count[HETAB_THETA_I];
  double *sums = hetab_alloc(ctx, w->channel_count * angles, sizeof *sums);
  if (!sums)
    return HETAB_ERR_MEMORY;
  for (size_t b = 0; b < w->bands; b++)
    for (size_t c = 0; c < w->channel_count; c++) {
      double weight = w->weights ? w->weights[b][c] : b == c;
      for (size_t i = 0; weight != 0 && i < angles; i++)
        sums[c * angles + i] += weight * rho_s[b * angles + i];
    }
  free(w->rho);
  w->rho = to_floats(ctx, sums, w->channel_count * angles);
  free(sums);
  return w->rho ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_exr_set_error(hetab_exr_writer *w, const hetab_error_stats *error) {
  const double values[ERRORS] = {error->max_rel,         error->p99_rel,
                                 error->rms_rel,         error->max_abs_below,
                                 (double)error->samples, (double)error->compared};
  for (int i = 0; i < ERRORS && error->samples; i++)
    hetab_exr_file_patch(w->file, error_names[i], values[i]);
}

size_t hetab_exr_saturated_count(const hetab_exr_writer *w) {
  return w->saturated;
}

static hetab_status finish(hetab_context *ctx, hetab_exr_writer *w) {
  hetab_exr_part part = specular_part(w);
  if (w->next_part < w->part_count || !w->rho)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "the OpenEXR table was not written: %zu of %zu parts%s are missing",
                      w->part_count - w->next_part, w->part_count,
                      w->rho ? "" : " and the specular reflectance");
  return write_planes(ctx, w, w->part_count, &part, w->rho);
}

hetab_status hetab_exr_commit(hetab_context *ctx, hetab_exr_writer *w) {
  hetab_status status = finish(ctx, w);
  if (status == HETAB_OK) {
    status = hetab_exr_file_commit(ctx, w->file);
    w->file = NULL;
  }
  hetab_exr_abort(w);
  return status;
}

void hetab_exr_abort(hetab_exr_writer *w) {
  if (!w)
    return;
  for (size_t i = 0; w->parts && i < w->part_count; i++)
    close_part(w, &w->parts[i]);
  hetab_exr_file_abort(w->file);
  free(w->parts);
  free(w->written);
  free(w->weights);
  free(w->channel_names);
  free(w->channels);
  free(w->rho);
  free(w);
}
