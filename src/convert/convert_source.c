#include "convert/convert_source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <hetab/merl.h>

#include "convert/mend.h"
#include "core/held_files.h"
#include "model/colour.h"
#include "table/table_format.h"

HETAB_HANDLE(hetab_merl)

/* ---- opening ------------------------------------------------------------------------------- */

/* The mended table as a file that only this process sees, for as long as it takes to open it. */
static hetab_status open_mended(hetab_context *ctx, const hetab_merl *merl,
                                hetab_convert_source *source) {
  const char *folder = getenv("TMPDIR");
  char path[4096];
  hetab_held_files held;
  snprintf(path, sizeof path, "%s/hetab-%d", folder && *folder ? folder : "/tmp", (int)getpid());
  hetab_atomic_hold(ctx, &held);
  hetab_status status = hetab_merl_save(ctx, merl, path, 1);
  if (status == HETAB_OK)
    status = hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &source->table);
  hetab_atomic_drop(ctx, &held);
  return status;
}

/* A table with holes is read without them. */
static hetab_status open_merl(hetab_context *ctx, hetab_convert_source *source) {
  HETAB_ENDS(hetab_merl_end) hetab_merl *merl = NULL;
  HETAB_TRY(hetab_merl_load_raw(ctx, source->path, &merl));
  source->filled = hetab_merl_holes(merl);
  HETAB_TRY(source->filled ? hetab_merl_mend(ctx, source->path, merl) : HETAB_OK);
  return source->filled
             ? open_mended(ctx, merl, source)
             : hetab_lookup_open(ctx, source->path, HETAB_LOOKUP_INTERPOLATE, &source->table);
}

/* RGL tables, for their f. */
static hetab_status open_rgl(hetab_context *ctx, hetab_convert_source *source) {
  HETAB_TRY(hetab_lookup_open(ctx, source->path, HETAB_LOOKUP_INTERPOLATE, &source->table));
  HETAB_TRY(hetab_rgl_load(ctx, source->path, &source->rgl));
  return hetab_rgl_smooth_create(ctx, source->rgl, &source->smooth);
}

static hetab_status choose_channels(hetab_context *ctx, int srgb, hetab_convert_source *source) {
  source->channels_in = source->channels = hetab_lookup_channel_count(source->table);
  source->lambda_um = hetab_lookup_wavelengths_um(source->table);
  if (!srgb || !source->lambda_um)
    return HETAB_OK;
  source->weights = hetab_alloc(ctx, source->channels_in, sizeof *source->weights);
  HETAB_NEED(source->weights);
  HETAB_TRY(hetab_xyz_weights(ctx, source->lambda_um, source->channels_in, source->weights));
  source->channels = 3;
  source->lambda_um = NULL;
  return HETAB_OK;
}

hetab_status hetab_convert_open(hetab_context *ctx, const char *path, int srgb,
                                hetab_convert_source *source) {
  *source = (hetab_convert_source){.path = path};
  hetab_status status = hetab_format_of(ctx, path, &source->format);
  if (status == HETAB_OK)
    status = source->format == HETAB_FORMAT_MERL ? open_merl(ctx, source)
             : source->format == HETAB_FORMAT_RGL
                 ? open_rgl(ctx, source)
                 : hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &source->table);
  if (status == HETAB_OK)
    status = choose_channels(ctx, srgb, source);
  if (status == HETAB_OK)
    source->specular_cone = hetab_lookup_specular_cone(source->table);
  if (status != HETAB_OK)
    hetab_convert_close(source);
  return status;
}

void hetab_convert_close(hetab_convert_source *source) {
  hetab_lookup_free(source->table);
  hetab_rgl_smooth_clear(&source->smooth);
  hetab_rgl_free(source->rgl);
  source->rgl = NULL;
  free(source->weights);
  source->table = NULL;
  source->weights = NULL;
}

/* ---- values -------------------------------------------------------------------------------- */

/* Kept off the horizon by a hundredth of a degree, where tables hold nothing. The steeper direction
 * first, so that both orders of a pair are the same to the last bit. */
static void set_directions(const hetab_directions *pair, float wi[3], float wo[3]) {
  const double most = M_PI_2 * (1 - 1.0 / 9000);
  double i = fmin(fmin(pair->theta_i, pair->theta_r), most);
  double r = fmin(fmax(pair->theta_i, pair->theta_r), most);
  wi[0] = (float)sin(i);
  wi[1] = 0;
  wi[2] = (float)cos(i);
  wo[0] = (float)(sin(r) * cos(pair->phi));
  wo[1] = (float)(sin(r) * sin(pair->phi));
  wo[2] = (float)cos(r);
}

size_t hetab_convert_channels(const hetab_convert_source *source, const float *in, double *out) {
  double xyz[3] = {0};
  size_t clamped = 0;
  for (size_t c = 0; c < source->channels_in && !source->weights; c++)
    out[c] = (double)in[c];
  if (!source->weights)
    return 0;
  for (size_t b = 0; b < source->channels_in; b++)
    for (int c = 0; c < 3; c++)
      xyz[c] += source->weights[b][c] * (double)in[b];
  hetab_xyz_to_srgb(xyz, out);
  for (int c = 0; c < 3; c++)
    if (out[c] < 0) {
      out[c] = 0;
      clamped++;
    }
  return clamped;
}

enum { BLOCK = 256 };

/* RGL tables: the mean of both orders, since what they are converted to is taken as reciprocal;
 * other[channels_in]. */
static void read_block(const hetab_convert_source *source, size_t count, const float (*wi)[3],
                       const float (*wo)[3], float *values, float *other) {
  size_t channels = source->channels_in;
  if (!source->rgl)
    hetab_lookup_eval(source->table, NULL, count, wi[0], wo[0], values, NULL);
  for (size_t i = 0; i < count && source->rgl; i++) {
    hetab_rgl_smooth_eval(&source->smooth, wi[i], wo[i], values + i * channels);
    const float mirrored[3] = {wo[i][0], -wo[i][1], wo[i][2]};
    hetab_rgl_smooth_eval(&source->smooth, mirrored, wi[i], other);
    for (size_t c = 0; c < channels; c++)
      values[i * channels + c] = 0.5f * (values[i * channels + c] + other[c]);
  }
}

hetab_status hetab_convert_values(hetab_context *ctx, void *user, const hetab_directions *pairs,
                                  size_t count, double *values) {
  hetab_convert_source *source = user;
  float wi[BLOCK][3], wo[BLOCK][3];
  HETAB_FREED float *in = hetab_alloc(ctx, BLOCK + 1, source->channels_in * sizeof *in);
  HETAB_NEED(in);
  for (size_t first = 0; first < count; first += BLOCK) {
    size_t block = count - first < BLOCK ? count - first : BLOCK;
    HETAB_TRY(hetab_go_on(ctx, 0));
    for (size_t i = 0; i < block; i++)
      set_directions(&pairs[first + i], wi[i], wo[i]);
    read_block(source, block, (const float(*)[3])wi, (const float(*)[3])wo, in,
               in + BLOCK * source->channels_in);
    for (size_t i = 0; i < block; i++)
      source->clamped += hetab_convert_channels(source, in + i * source->channels_in,
                                                values + (first + i) * source->channels);
  }
  return HETAB_OK;
}

hetab_status hetab_convert_specular(hetab_context *ctx, const hetab_convert_source *source,
                                    double theta_i, double *value) {
  const float wi[3] = {(float)sin(theta_i), 0, (float)fmax(cos(theta_i), 0)};
  HETAB_FREED float *in = hetab_alloc(ctx, source->channels_in, sizeof *in);
  HETAB_NEED(in);
  hetab_lookup_albedo(source->table, NULL, 1, wi, NULL, in);
  hetab_convert_channels(source, in, value);
  return HETAB_OK;
}
