#include <hetab/lookup.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/rgl.h>

#include "core/context.h"
#include "lookup/dense_source.h"
#include "lookup/half_sampler.h"
#include "lookup/lattice.h"
#include "lookup/merl_source.h"
#include "table/specular.h"
#include "table/table_format.h"

enum { BLOCK = 64 }; /* samples drawn before they are weighed */

struct hetab_lookup {
  size_t channels;
  double *lambda_um; /* NULL: linear sRGB */
  hetab_lattice lattice;
  hetab_merl *merl;         /* looked up by cell */
  hetab_dense_source dense; /* looked up by node */
  hetab_rgl *rgl;           /* evaluated and sampled by its own rules */
  hetab_half_sampler sampler;
  hetab_specular_table specular;
};

/* ---- evaluation ---------------------------------------------------------------------------- */

static int above(const float w[3]) {
  return w[2] > 0;
}

static void eval_one(const hetab_lookup *table, const float wi[3], const float wo[3],
                     float *value) {
  if (!above(wi) || !above(wo))
    memset(value, 0, table->channels * sizeof *value);
  else if (table->rgl)
    hetab_rgl_eval(table->rgl, wi, wo, value);
  else if (table->merl)
    hetab_merl_nearest(table->merl, wi, wo, value);
  else
    hetab_dense_source_nearest(&table->dense, wi, wo, value);
}

void hetab_lookup_eval_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                             const float (*wo)[3], float *value) {
  if (table->lattice.codes && !table->merl && !table->dense.values) {
    hetab_lattice_eval(&table->lattice, count, wi, wo, value);
    return;
  }
  for (size_t i = 0; i < count; i++)
    eval_one(table, wi[i], wo[i], value + i * table->channels);
}

void hetab_lookup_eval(const hetab_lookup *table, const float wi[3], const float wo[3],
                       float *value) {
  hetab_lookup_eval_batch(table, 1, (const float(*)[3])wi, (const float(*)[3])wo, value);
}

/* ---- opening ------------------------------------------------------------------------------- */

static void eval_table(const void *user, size_t count, const float (*wi)[3], const float (*wo)[3],
                       float *value) {
  hetab_lookup_eval_batch(user, count, wi, wo, value);
}

/* A file beside a table that holds the delta as a lobe is another table's. */
static hetab_status open_specular(hetab_context *ctx, const char *path, double cone,
                                  hetab_lookup *table) {
  table->specular.channels = table->channels;
  return cone > 0.0 ? HETAB_OK
                    : hetab_specular_beside(ctx, path, table->channels, table->lambda_um,
                                            &table->specular);
}

static hetab_status open_merl(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                              hetab_lookup *table) {
  hetab_merl_source source = {0};
  table->channels = HETAB_MERL_CHANNELS;
  HETAB_TRY(hetab_merl_load(ctx, path, &table->merl));
  double cone = hetab_merl_specular_cone(table->merl);
  if (rule == HETAB_LOOKUP_INTERPOLATE) {
    hetab_status status = hetab_merl_prepare(ctx, table->merl, &source);
    hetab_merl_free(table->merl);
    table->merl = NULL;
    if (status == HETAB_OK)
      status = hetab_lattice_create(ctx, table->channels, hetab_merl_at, &source, &table->lattice);
    hetab_merl_source_clear(&source);
    HETAB_TRY(status);
  }
  return open_specular(ctx, path, cone, table);
}

static hetab_status copy_wavelengths(hetab_context *ctx, const double *lambda_um,
                                     hetab_lookup *table) {
  table->lambda_um = hetab_alloc(ctx, table->channels, sizeof *table->lambda_um);
  if (!table->lambda_um)
    return HETAB_ERR_MEMORY;
  memcpy(table->lambda_um, lambda_um, table->channels * sizeof *lambda_um);
  return HETAB_OK;
}

static hetab_status read_h5(hetab_context *ctx, hetab_h5_table *h5, const char *path,
                            hetab_lookup_rule rule, hetab_lookup *table) {
  table->channels = hetab_h5_wavelength_count(h5);
  if (hetab_h5_wavelengths_um(h5))
    HETAB_TRY(copy_wavelengths(ctx, hetab_h5_wavelengths_um(h5), table));
  HETAB_TRY(hetab_specular_of_h5(ctx, h5, path, &table->specular));
  HETAB_TRY(hetab_dense_source_load(ctx, h5, path, &table->dense));
  if (rule == HETAB_LOOKUP_NEAREST)
    return HETAB_OK;
  hetab_dense_source_prepare(&table->dense);
  HETAB_TRY(hetab_lattice_create(ctx, table->channels, hetab_dense_source_at, &table->dense,
                                 &table->lattice));
  hetab_dense_source_clear(&table->dense);
  return HETAB_OK;
}

static hetab_status open_h5(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                            hetab_lookup *table) {
  hetab_h5_table *h5;
  HETAB_TRY(hetab_h5_open_any(ctx, path, &h5));
  hetab_status status = read_h5(ctx, h5, path, rule, table);
  hetab_h5_free(h5);
  return status;
}

static hetab_status open_rgl(hetab_context *ctx, const char *path, hetab_lookup *table) {
  HETAB_TRY(hetab_rgl_load(ctx, path, &table->rgl));
  const double *lambda_um = hetab_rgl_wavelengths_um(table->rgl);
  table->channels = hetab_rgl_channel_count(table->rgl);
  if (lambda_um)
    HETAB_TRY(copy_wavelengths(ctx, lambda_um, table));
  return open_specular(ctx, path, hetab_rgl_specular_cone(table->rgl), table);
}

static hetab_status open_file(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                              hetab_lookup *table) {
  hetab_format format;
  HETAB_TRY(hetab_format_of(ctx, path, &format));
  if (format == HETAB_FORMAT_H5)
    return open_h5(ctx, path, rule, table);
  return format == HETAB_FORMAT_RGL ? open_rgl(ctx, path, table)
                                    : open_merl(ctx, path, rule, table);
}

hetab_status hetab_lookup_open(hetab_context *ctx, const char *path, hetab_lookup_rule rule,
                               hetab_lookup **out) {
  *out = NULL;
  hetab_lookup *table = hetab_alloc(ctx, 1, sizeof *table);
  if (!table)
    return HETAB_ERR_MEMORY;
  hetab_status status = open_file(ctx, path, rule, table);
  if (status == HETAB_OK)
    status = hetab_sampler_create(ctx, table->channels, eval_table, table, &table->sampler);
  if (status == HETAB_OK)
    *out = table;
  else
    hetab_lookup_free(table);
  return status;
}

void hetab_lookup_free(hetab_lookup *table) {
  if (!table)
    return;
  free(table->lambda_um);
  hetab_lattice_clear(&table->lattice);
  hetab_merl_free(table->merl);
  hetab_dense_source_clear(&table->dense);
  hetab_rgl_free(table->rgl);
  hetab_sampler_clear(&table->sampler);
  hetab_specular_clear(&table->specular);
  free(table);
}

size_t hetab_lookup_channel_count(const hetab_lookup *table) {
  return table->channels;
}

size_t hetab_lookup_negative(const hetab_lookup *table) {
  return table->rgl ? hetab_rgl_negative(table->rgl) : 0;
}

const double *hetab_lookup_wavelengths_um(const hetab_lookup *table) {
  return table->lambda_um;
}

/* ---- sampling ------------------------------------------------------------------------------ */

static float draw(const hetab_lookup *table, const float wi[3], const float u[2], float wo[3]) {
  if (!table->rgl)
    return hetab_sampler_draw(&table->sampler, wi, u, wo);
  return above(wi) ? hetab_rgl_sample(table->rgl, wi, u, wo) : 0;
}

static float drawn_or_none(const hetab_lookup *table, const float wi[3], const float u[2],
                           float wo[3]) {
  float density = draw(table, wi, u, wo);
  if (density > 0 && above(wo))
    return density;
  memset(wo, 0, 3 * sizeof *wo);
  return 0;
}

void hetab_lookup_sample_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                               const float (*u)[2], float (*wo)[3], float *density, float *weight) {
  size_t channels = table->channels;
  for (size_t first = 0; first < count; first += BLOCK) {
    size_t end = count - first < BLOCK ? count : first + BLOCK;
    for (size_t i = first; i < end; i++)
      density[i] = drawn_or_none(table, wi[i], u[i], wo[i]);
    hetab_lookup_eval_batch(table, end - first, wi + first, (const float(*)[3])wo + first,
                            weight + first * channels);
    for (size_t i = first; i < end; i++) {
      float scale = density[i] > 0 ? wo[i][2] / density[i] : 0;
      for (size_t c = 0; c < channels; c++)
        weight[i * channels + c] *= scale;
    }
  }
}

float hetab_lookup_sample(const hetab_lookup *table, const float wi[3], const float u[2],
                          float wo[3], float *weight) {
  float density;
  hetab_lookup_sample_batch(table, 1, (const float(*)[3])wi, (const float(*)[2])u, (float(*)[3])wo,
                            &density, weight);
  return density;
}

float hetab_lookup_pdf(const hetab_lookup *table, const float wi[3], const float wo[3]) {
  if (!above(wi) || !above(wo))
    return 0;
  return table->rgl ? hetab_rgl_pdf(table->rgl, wi, wo)
                    : hetab_sampler_pdf(&table->sampler, wi, wo);
}

/* ---- reflectances -------------------------------------------------------------------------- */

void hetab_lookup_albedo(const hetab_lookup *table, const float wi[3], float *value) {
  hetab_sampler_albedo(&table->sampler, wi, value);
}

void hetab_lookup_specular(const hetab_lookup *table, const float wi[3], float *value) {
  hetab_specular_at(&table->specular, wi[2], value);
}

/* ---- many ---------------------------------------------------------------------------------- */

void hetab_lookup_pdf_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                            const float (*wo)[3], float *density) {
  for (size_t i = 0; i < count; i++)
    density[i] = hetab_lookup_pdf(table, wi[i], wo[i]);
}

void hetab_lookup_albedo_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                               float *value) {
  for (size_t i = 0; i < count; i++)
    hetab_lookup_albedo(table, wi[i], value + i * table->channels);
}

void hetab_lookup_specular_batch(const hetab_lookup *table, size_t count, const float (*wi)[3],
                                 float *value) {
  for (size_t i = 0; i < count; i++)
    hetab_lookup_specular(table, wi[i], value + i * table->channels);
}
