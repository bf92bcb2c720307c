#include <hetab/exr.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/colour.h"
#include "core/option_size.h"
#include "table/exr_layout.h"
#include "table/table_writer.h"

enum { RGB = 3, MOST_PARTS = 4096, MOST_SIDE = 1 << 20, MOST_TEXTURE = 16384 };

static const double MOST_BYTES = 4.0 * (1u << 30);
static const double MOST_HALF = 65504;

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

typedef struct exr_writer {
  hetab_table_writer base;
  hetab_exr_layout layout;
  hetab_exr_file *file;
  double (*weights)[RGB]; /* [bands], RGB: what a wavelength adds to the colour */
  held *parts;            /* [part_count] */
  size_t next_part;
  double held_bytes;
  float *rho;   /* [channel][theta_i], once it is known */
  float *atlas; /* [RGB][height][width] */
} exr_writer;

static double part_bytes(const exr_writer *w) {
  size_t size = w->layout.options.bands == HETAB_EXR_RGB ? sizeof(exact_sum) : sizeof(float);
  return (double)hetab_exr_numbers(&w->layout) * (double)size;
}

/* 0, but of an atlas. */
static size_t atlas_numbers(const exr_writer *w) {
  const hetab_exr_layout *layout = &w->layout;
  return hetab_exr_is_atlas(layout)
             ? layout->tiles_across * layout->tiles_down * hetab_exr_numbers(layout)
             : 0;
}

/* ---- limits -------------------------------------------------------------------------------- */

static hetab_status fail_memory(hetab_context *ctx, double bytes) {
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "the OpenEXR table would take %.1f GiB of memory, more than %.0f; choose fewer "
                    "angles or wavelengths, parts by theta_i, or an HDF5 table, which is not held",
                    bytes / (1u << 30), MOST_BYTES / (1u << 30));
}

static hetab_status check_atlas(hetab_context *ctx, const exr_writer *w) {
  size_t width = w->layout.tiles_across * w->layout.count[HETAB_PHI],
         height = w->layout.tiles_down * w->layout.count[HETAB_THETA_R];
  if (width <= MOST_TEXTURE && height <= MOST_TEXTURE)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "an OpenEXR atlas of %zu x %zu pixels is more than textures hold, %d a side; "
                    "choose fewer angles, or parts by theta_i",
                    width, height, MOST_TEXTURE);
}

static hetab_status check_parts(hetab_context *ctx, const exr_writer *w) {
  size_t height = w->layout.count[HETAB_THETA_R] *
                  (hetab_exr_by_wavelength(&w->layout) ? w->layout.count[HETAB_THETA_I] : 1);
  if (w->layout.part_count > MOST_PARTS)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "an OpenEXR table of %zu parts is more than readers stand; choose at most %d "
                      "%s, or an HDF5 table",
                      w->layout.part_count, MOST_PARTS,
                      hetab_exr_by_wavelength(&w->layout) ? "wavelengths" : "theta_i");
  if (height > MOST_SIDE)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "a part of the OpenEXR table would have %zu rows, more than %d; choose fewer "
                      "angles, or parts by theta_i",
                      height, MOST_SIDE);
  return HETAB_OK;
}

static hetab_status check_size(hetab_context *ctx, const exr_writer *w) {
  HETAB_TRY(hetab_exr_is_atlas(&w->layout) ? check_atlas(ctx, w) : check_parts(ctx, w));
  double bytes =
      part_bytes(w) * (hetab_exr_by_wavelength(&w->layout) ? (double)w->layout.part_count : 1) +
      (double)(atlas_numbers(w) * sizeof *w->atlas);
  return bytes > MOST_BYTES ? fail_memory(ctx, bytes) : HETAB_OK;
}

/* ---- slabs --------------------------------------------------------------------------------- */

static hetab_status open_part(hetab_context *ctx, exr_writer *w, held *part) {
  if (part->sums || part->values)
    return HETAB_OK;
  w->held_bytes += part_bytes(w);
  if (w->held_bytes > MOST_BYTES)
    return fail_memory(ctx, w->held_bytes);
  if (w->layout.options.bands == HETAB_EXR_RGB)
    part->sums = hetab_alloc(ctx, hetab_exr_numbers(&w->layout), sizeof *part->sums);
  else
    part->values = hetab_alloc(ctx, hetab_exr_numbers(&w->layout), sizeof *part->values);
  return part->sums || part->values ? HETAB_OK : HETAB_ERR_MEMORY;
}

static double entry(const exr_writer *w, const void *values, size_t i) {
  return w->layout.options.slabs == HETAB_DOUBLE ? ((const double *)values)[i]
                                                 : (double)((const float *)values)[i];
}

/* Knuth's: what the addition rounds off is found exactly. */
static void add(exact_sum *sum, double value) {
  double high = sum->high + value, part = high - sum->high;
  sum->low += (sum->high - (high - part)) + (value - part);
  sum->high = high;
}

/* One theta_i row of a slab, whose entries begin at `from`; 0 if one of them is no float. */
static int add_row(exr_writer *w, held *part, const hetab_slab *slab, size_t theta_i, size_t from) {
  size_t block = hetab_exr_block(&w->layout),
         at = (hetab_exr_by_wavelength(&w->layout) ? theta_i : slab->wavelength) * block;
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

static void close_part(exr_writer *w, held *part) {
  if (part->sums || part->values)
    w->held_bytes -= part_bytes(w);
  free(part->sums);
  free(part->values);
  part->sums = NULL;
  part->values = NULL;
}

/* What is too large for half precision becomes its largest number. */
static void saturate(exr_writer *w, float *values, size_t count) {
  if (w->layout.options.element != HETAB_EXR_HALF)
    return;
  for (size_t i = 0; i < count; i++)
    if (fabs((double)values[i]) > MOST_HALF) {
      values[i] = copysignf((float)MOST_HALF, values[i]);
      w->base.saturated++;
    }
}

static hetab_status write_planes(hetab_context *ctx, exr_writer *w, size_t number,
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

/* One theta_i's pixels into the atlas. */
static hetab_status place_tile(hetab_context *ctx, exr_writer *w, size_t tile, float *values) {
  const hetab_exr_layout *layout = &w->layout;
  size_t width = layout->count[HETAB_PHI], height = layout->count[HETAB_THETA_R],
         column = tile % layout->tiles_across, row = tile / layout->tiles_across;
  saturate(w, values, hetab_exr_numbers(layout));
  if (w->base.saturated)
    return hetab_fail(ctx, HETAB_ERR_RANGE,
                      "'%s': values above %g are more than half floats hold; take floats "
                      "(--exr-type float)",
                      hetab_atomic_path(w->base.file), MOST_HALF);
  for (size_t i = 0; i < RGB * height; i++) {
    size_t y = (i / height * layout->tiles_down + row) * height + i % height;
    memcpy(w->atlas + (y * layout->tiles_across + column) * width, values + i * width,
           width * sizeof *values);
  }
  return HETAB_OK;
}

static hetab_status write_part(hetab_context *ctx, exr_writer *w, size_t number) {
  held *held = &w->parts[number];
  hetab_exr_part part = hetab_exr_table_part(&w->layout, number, "");
  if (held->sums &&
      !(held->values = hetab_alloc(ctx, hetab_exr_numbers(&w->layout), sizeof *held->values)))
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; held->sums && i < hetab_exr_numbers(&w->layout); i++)
    held->values[i] = (float)(held->sums[i].high + held->sums[i].low);
  hetab_status status = w->atlas ? place_tile(ctx, w, number, held->values)
                                 : write_planes(ctx, w, number, &part, held->values);
  close_part(w, held);
  return status;
}

static hetab_status write_slab(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_slab *slab) {
  exr_writer *w = (exr_writer *)writer;
  for (size_t i = 0; i < slab->theta_i_count; i++) {
    size_t theta_i = slab->theta_i_first + i;
    held *part = &w->parts[hetab_exr_by_wavelength(&w->layout) ? slab->wavelength : theta_i];
    HETAB_TRY(open_part(ctx, w, part));
    if (!add_row(w, part, slab, theta_i, i * hetab_exr_block(&w->layout)))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "an entry of theta_i %zu, wavelength %zu is NaN or too large for a float",
                        theta_i, slab->wavelength);
    part->rows_left--;
  }
  /* The format wants parts in their order. */
  while (w->next_part < w->layout.part_count && !w->parts[w->next_part].rows_left)
    HETAB_TRY(write_part(ctx, w, w->next_part++));
  return HETAB_OK;
}

/* ---- the rest ------------------------------------------------------------------------------ */

static hetab_status write_specular(hetab_context *ctx, hetab_table_writer *writer,
                                   const double *rho_s) {
  exr_writer *w = (exr_writer *)writer;
  size_t angles = w->layout.count[HETAB_THETA_I];
  double *sums = hetab_alloc(ctx, w->layout.channel_count * angles, sizeof *sums);
  if (!sums)
    return HETAB_ERR_MEMORY;
  for (size_t b = 0; b < w->layout.bands; b++)
    for (size_t c = 0; c < w->layout.channel_count; c++) {
      double weight = w->weights ? w->weights[b][c] : b == c;
      for (size_t i = 0; weight != 0 && i < angles; i++)
        sums[c * angles + i] += weight * rho_s[b * angles + i];
    }
  free(w->rho);
  w->rho = hetab_exr_floats(ctx, sums, w->layout.channel_count * angles);
  free(sums);
  return w->rho ? HETAB_OK : HETAB_ERR_MEMORY;
}

static hetab_status write_report(hetab_context *ctx, hetab_table_writer *writer,
                                 const hetab_report *report) {
  exr_writer *w = (exr_writer *)writer;
  hetab_exr_patch_errors(w->file, &report->error);
  return HETAB_OK;
}

/* The delta's reflectance is in the header, which has waited for it. */
static hetab_status write_atlas(hetab_context *ctx, exr_writer *w) {
  static const char *const names[RGB] = {"specular_reflectance_R", "specular_reflectance_G",
                                         "specular_reflectance_B"};
  hetab_exr_part whole = hetab_exr_table_part(&w->layout, 0, "");
  size_t angles = w->layout.count[HETAB_THETA_I];
  for (size_t c = 0; c < RGB; c++)
    hetab_exr_put_vector(w->file, names[c], w->rho + c * angles, angles);
  HETAB_TRY(hetab_exr_file_begin(ctx, w->file));
  return write_planes(ctx, w, 0, &whole, w->atlas);
}

static hetab_status finish(hetab_context *ctx, hetab_table_writer *writer) {
  exr_writer *w = (exr_writer *)writer;
  if (w->atlas) {
    HETAB_TRY(write_atlas(ctx, w));
    return hetab_exr_file_finish(ctx, w->file);
  }
  hetab_exr_part part = hetab_exr_specular_part(&w->layout);
  HETAB_TRY(write_planes(ctx, w, w->layout.part_count, &part, w->rho));
  return hetab_exr_file_finish(ctx, w->file);
}

static void clear(hetab_table_writer *writer) {
  exr_writer *w = (exr_writer *)writer;
  for (size_t i = 0; w->parts && i < w->layout.part_count; i++)
    close_part(w, &w->parts[i]);
  hetab_exr_file_free(w->file);
  hetab_exr_layout_clear(&w->layout);
  free(w->parts);
  free(w->weights);
  free(w->rho);
  free(w->atlas);
}

/* ---- creation ------------------------------------------------------------------------------ */

static hetab_status weigh(hetab_context *ctx, exr_writer *w, const hetab_band *bands) {
  hetab_status status;
  double *lambda_um = hetab_alloc(ctx, w->layout.bands, sizeof *lambda_um);
  w->weights = hetab_alloc(ctx, w->layout.bands, sizeof *w->weights);
  if (!lambda_um || !w->weights)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  for (size_t b = 0; b < w->layout.bands; b++)
    lambda_um[b] = bands[b].lambda_um;
  HETAB_GOTO(hetab_srgb_weights(ctx, lambda_um, w->layout.bands, w->weights));
done:
  free(lambda_um);
  return status;
}

static hetab_status make_parts(hetab_context *ctx, exr_writer *w, const hetab_surface *surface) {
  const hetab_exr_layout *layout = &w->layout;
  HETAB_TRY(check_size(ctx, w));
  if (layout->options.bands == HETAB_EXR_RGB)
    HETAB_TRY(weigh(ctx, w, hetab_surface_bands(surface)));
  w->parts = hetab_alloc(ctx, layout->part_count, sizeof *w->parts);
  if (hetab_exr_is_atlas(layout))
    w->atlas = hetab_alloc(ctx, atlas_numbers(w), sizeof *w->atlas);
  w->held_bytes = (double)(atlas_numbers(w) * sizeof *w->atlas);
  if (!w->parts || (hetab_exr_is_atlas(layout) && !w->atlas))
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < layout->part_count; i++)
    w->parts[i].rows_left =
        hetab_exr_by_wavelength(layout) ? layout->count[HETAB_THETA_I] : layout->bands;
  return HETAB_OK;
}

hetab_status hetab_exr_create(hetab_context *ctx, const char *path, const hetab_surface *surface,
                              const hetab_grid *grid, const hetab_exr_options *options,
                              hetab_table_writer **out) {
  static const hetab_table_class class = {write_slab, write_specular, write_report, finish, clear};
  hetab_status status;
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_exr_options, own, options);
  exr_writer *w = hetab_alloc(ctx, 1, sizeof *w);
  if (!w)
    return HETAB_ERR_MEMORY;
  w->base.class = &class;
  HETAB_GOTO(hetab_exr_layout_make(ctx, surface, grid, &own, &w->layout));
  HETAB_GOTO(make_parts(ctx, w, surface));
  HETAB_GOTO(hetab_table_begin(ctx, &w->base, &class, path, own.overwrite, w->layout.bands, grid));
  HETAB_GOTO(hetab_exr_file_create(ctx, w->base.file, &w->file));
  HETAB_GOTO(hetab_exr_put_header(ctx, w->file, &w->layout, surface, grid));
  if (!w->atlas)
    HETAB_GOTO(hetab_exr_file_begin(ctx, w->file));
  *out = &w->base;
  return HETAB_OK;
done:
  hetab_table_abort(&w->base);
  return status;
}
