#include <hetab/lookup.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/rgl.h>

#include "core/context.h"
#include "lookup/dense_source.h"
#include "lookup/half_sampler.h"
#include "lookup/lattice.h"
#include "lookup/merl_source.h"
#include "rgl/rgl_look.h"
#include "table/specular.h"
#include "table/table_format.h"

enum { BLOCK = 128 }; /* pairs that are dealt with together */

struct hetab_lookup {
  size_t channels;
  double *lambda_um; /* NULL: linear sRGB */
  hetab_band_axis axis;
  hetab_lattice lattice;
  hetab_merl *merl;         /* looked up by cell */
  hetab_dense_source dense; /* looked up by node */
  hetab_rgl *rgl;           /* evaluated and sampled by its own rules */
  hetab_half_sampler sampler;
  hetab_specular_table specular;
  double specular_cone;                  /* > 0: the delta is in the values, as a lobe that wide */
  float delta[HETAB_SAMPLER_INCIDENCES]; /* of the samples, at an incidence */
};

/* ---- evaluation ---------------------------------------------------------------------------- */

static bool above(const float w[3]) {
  return w[2] > 0;
}

static const float *asked_of(const hetab_lookup_query *query) {
  return query ? query->lambda_um : NULL;
}

static size_t width_of(const hetab_lookup *table, const hetab_lookup_query *query) {
  return asked_of(query) ? query->lambda_count : table->channels;
}

/* The places of some of a path's wavelengths. */
static void places_of(const hetab_lookup *table, const hetab_lookup_query *query, size_t path,
                      size_t first, hetab_band_places *places) {
  size_t left = query->lambda_count - first;
  hetab_band_places_of(&table->axis, query->lambda_um + path * query->lambda_count + first,
                       left < HETAB_BANDS_AT_ONCE ? left : HETAB_BANDS_AT_ONCE, places);
}

/* Without a lattice; pdf only of RGL tables, whose work it shares. */
static void eval_one(const hetab_lookup *table, const float wi[3], const float wo[3],
                     const hetab_band_places *places, float *value, float *pdf) {
  if (table->rgl)
    hetab_rgl_look(table->rgl, wi, wo, places, value, pdf);
  else if (!above(wi) || !above(wo))
    memset(value, 0, (places ? places->count : table->channels) * sizeof *value);
  else if (table->merl)
    hetab_merl_nearest(table->merl, wi, wo, value);
  else
    hetab_band_values(places, table->channels, hetab_dense_source_nearest(&table->dense, wi, wo),
                      value);
}

/* Up to BLOCK pairs, at places or, NULL, all channels; value's rows are `width` long. */
static void eval_at(const hetab_lookup *table, size_t count, const float *wi, const float *wo,
                    const hetab_band_places *places, size_t width, float *value, float *pdf) {
  if (table->lattice.codes && places)
    hetab_lattice_eval_places(&table->lattice, count, wi, wo, places, width, value);
  else if (table->lattice.codes)
    hetab_lattice_eval(&table->lattice, count, wi, wo, value);
  else
    for (size_t i = 0; i < count; i++)
      eval_one(table, wi + 3 * i, wo + 3 * i, places ? &places[i] : NULL, value + i * width,
               pdf ? &pdf[i] : NULL);
}

static void eval_block(const hetab_lookup *table, const hetab_lookup_query *query, size_t path,
                       size_t count, const float *wi, const float *wo, float *value, float *pdf) {
  hetab_band_places places[BLOCK];
  size_t width = width_of(table, query);
  if (!asked_of(query)) {
    eval_at(table, count, wi, wo, NULL, width, value, pdf);
    return;
  }
  if (!table->lambda_um)
    memset(value, 0, count * width * sizeof *value);
  for (size_t first = 0; first < width && table->lambda_um; first += HETAB_BANDS_AT_ONCE) {
    for (size_t i = 0; i < count; i++)
      places_of(table, query, path + i, first, &places[i]);
    eval_at(table, count, wi, wo, places, width, value + first, pdf);
  }
}

/* The part of the samples that is the delta's. */
static float delta_share(const hetab_lookup *table, const hetab_lookup_query *query, float cos_i) {
  float share = 0;
  if (table->specular.count && !(query && query->without_delta))
    hetab_sampler_between(table->delta, 1, cos_i, NULL, &share);
  return share;
}

static float pdf_of(const hetab_lookup *table, const float wi[3], const float wo[3]) {
  float pdf = 0;
  if (table->rgl)
    hetab_rgl_look(table->rgl, wi, wo, NULL, NULL, &pdf);
  else
    pdf = hetab_sampler_pdf(&table->sampler, wi, wo);
  return pdf;
}

void hetab_lookup_eval(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                       const float *wi, const float *wo, float *value, float *pdf) {
  size_t width = width_of(table, query);
  if (table->lattice.codes && value && !asked_of(query)) { /* the most common call, at once */
    hetab_lattice_eval(&table->lattice, count, wi, wo, value);
    value = NULL;
  }
  for (size_t first = 0; first < count && (value || pdf); first += BLOCK) {
    size_t block = count - first < BLOCK ? count - first : BLOCK;
    const float *i = wi + 3 * first, *o = wo + 3 * first;
    if (value)
      eval_block(table, query, first, block, i, o, value + first * width, pdf ? pdf + first : NULL);
    for (size_t k = 0; k < block && pdf; k++) {
      if (!value || !table->rgl)
        pdf[first + k] = pdf_of(table, i + 3 * k, o + 3 * k);
      pdf[first + k] *= 1 - delta_share(table, query, i[3 * k + 2]);
    }
  }
}

/* ---- opening ------------------------------------------------------------------------------- */

static void eval_table(const void *user, size_t count, const float *wi, const float *wo,
                       float *value) {
  hetab_lookup_eval(user, NULL, count, wi, wo, value, NULL);
}

static void weigh(const void *user, const float wi[3], const float u[2], float *weight) {
  hetab_lookup_drawn drawn;
  const hetab_lookup_query query = {.without_delta = 1};
  hetab_lookup_sample(user, &query, 1, wi, u, u, &drawn, weight);
}

/* At each of the sampler's incidences, of all channels together. */
static hetab_status share_samples(hetab_context *ctx, hetab_lookup *table) {
  HETAB_FREED float *rho = hetab_alloc(ctx, table->channels, sizeof *rho);
  HETAB_NEED(rho);
  for (size_t i = 0; i < HETAB_SAMPLER_INCIDENCES; i++) {
    const float *albedo = table->sampler.albedo + i * table->channels;
    double delta = 0, rest = 0;
    hetab_specular_at(&table->specular, (float)hetab_sampler_cos_i(i), NULL, rho);
    for (size_t c = 0; c < table->channels; c++) {
      delta += (double)rho[c];
      rest += (double)albedo[c];
    }
    table->delta[i] = delta > 0 ? (float)(delta / (delta + rest)) : 0;
  }
  return HETAB_OK;
}

/* A file beside a table that holds the delta as a lobe is another table's. */
static hetab_status open_specular(hetab_context *ctx, const char *path, double cone,
                                  hetab_lookup *table) {
  table->specular.channels = table->channels;
  table->specular_cone = cone;
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
  HETAB_NEED(table->lambda_um);
  memcpy(table->lambda_um, lambda_um, table->channels * sizeof *lambda_um);
  table->axis = hetab_band_axis_of(table->lambda_um, table->channels);
  return HETAB_OK;
}

static hetab_status read_h5(hetab_context *ctx, hetab_h5_table *h5, const char *path,
                            hetab_lookup_rule rule, hetab_lookup *table) {
  table->channels = hetab_h5_wavelength_count(h5);
  if (hetab_h5_wavelengths_um(h5))
    HETAB_TRY(copy_wavelengths(ctx, hetab_h5_wavelengths_um(h5), table));
  HETAB_TRY(hetab_specular_of_h5(ctx, h5, path, &table->specular));
  table->specular_cone = hetab_specular_cone_of_h5(ctx, h5);
  bool nearest = rule == HETAB_LOOKUP_NEAREST;
  HETAB_TRY(hetab_dense_source_load(ctx, h5, path, !nearest, &table->dense));
  if (nearest)
    return HETAB_OK;
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
  HETAB_NEED(table);
  hetab_status status = open_file(ctx, path, rule, table);
  if (status == HETAB_OK)
    status = table->rgl
                 ? hetab_sampler_create_albedo(ctx, table->channels, weigh, table, &table->sampler)
                 : hetab_sampler_create(ctx, table->channels, eval_table, table, &table->sampler);
  if (status == HETAB_OK)
    status = share_samples(ctx, table);
  *out = table;
  HETAB_MADE(hetab_lookup, out, status);
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

double hetab_lookup_specular_cone(const hetab_lookup *table) {
  return table->specular_cone;
}

size_t hetab_lookup_negative(const hetab_lookup *table) {
  return table->rgl ? hetab_rgl_negative(table->rgl) : 0;
}

const double *hetab_lookup_wavelengths_um(const hetab_lookup *table) {
  return table->lambda_um;
}

/* ---- sampling ------------------------------------------------------------------------------ */

static void draw(const hetab_lookup *table, const float wi[3], float uc, const float u[2],
                 hetab_lookup_drawn *drawn) {
  if (!table->rgl) {
    drawn->pdf = hetab_sampler_draw(&table->sampler, wi, uc, u, drawn->wo, &drawn->lobe);
  } else {
    drawn->pdf = above(wi) ? hetab_rgl_sample(table->rgl, wi, u, drawn->wo) : 0;
    drawn->lobe = HETAB_LOOKUP_GLOSSY;
  }
}

static void draw_lobe(const hetab_lookup *table, const hetab_lookup_query *query, const float wi[3],
                      float uc, const float u[2], hetab_lookup_drawn *drawn) {
  float share = delta_share(table, query, wi[2]);
  *drawn = (hetab_lookup_drawn){.lobe = HETAB_LOOKUP_NONE};
  if (uc < share) {
    *drawn = (hetab_lookup_drawn){{-wi[0], -wi[1], wi[2]}, share, HETAB_LOOKUP_SPECULAR};
    return;
  }
  draw(table, wi, fminf((uc - share) / (1 - share), 0.99999994f), u, drawn);
  drawn->pdf *= 1 - share;
  if (!(drawn->pdf > 0 && above(drawn->wo)))
    *drawn = (hetab_lookup_drawn){.lobe = HETAB_LOOKUP_NONE};
}

static void specular_at(const hetab_lookup *table, const hetab_lookup_query *query, size_t path,
                        float cos_i, float *value) {
  hetab_band_places places;
  if (!asked_of(query)) {
    hetab_specular_at(&table->specular, cos_i, NULL, value);
    return;
  }
  memset(value, 0, query->lambda_count * sizeof *value);
  for (size_t k = 0; k < query->lambda_count && table->lambda_um; k += HETAB_BANDS_AT_ONCE) {
    places_of(table, query, path, k, &places);
    hetab_specular_at(&table->specular, cos_i, &places, value + k);
  }
}

void hetab_lookup_sample(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                         const float *wi, const float *uc, const float *u,
                         hetab_lookup_drawn *drawn, float *weight) {
  size_t width = width_of(table, query);
  float wo[BLOCK][3];
  for (size_t first = 0; first < count; first += BLOCK) {
    size_t block = count - first < BLOCK ? count - first : BLOCK;
    for (size_t k = 0; k < block; k++) {
      size_t i = first + k;
      draw_lobe(table, query, wi + 3 * i, uc[i], u + 2 * i, &drawn[i]);
      memcpy(wo[k], drawn[i].wo, sizeof wo[k]);
    }
    eval_block(table, query, first, block, wi + 3 * first, wo[0], weight + first * width, NULL);
    for (size_t i = first; i < first + block; i++) {
      float scale = drawn[i].pdf > 0 ? drawn[i].wo[2] / drawn[i].pdf : 0;
      if (drawn[i].lobe == HETAB_LOOKUP_SPECULAR) {
        specular_at(table, query, i, wi[3 * i + 2], weight + i * width);
        scale = 1 / drawn[i].pdf;
      }
      for (size_t c = 0; c < width; c++)
        weight[i * width + c] *= scale;
    }
  }
}

/* ---- reflectances -------------------------------------------------------------------------- */

static void albedo_at(const hetab_lookup *table, const hetab_lookup_query *query, size_t path,
                      float cos_i, float *value) {
  hetab_band_places places;
  const float *rows = table->sampler.albedo;
  if (!asked_of(query)) {
    hetab_sampler_between(rows, table->channels, cos_i, NULL, value);
    return;
  }
  memset(value, 0, query->lambda_count * sizeof *value);
  for (size_t k = 0; k < query->lambda_count && table->lambda_um; k += HETAB_BANDS_AT_ONCE) {
    places_of(table, query, path, k, &places);
    hetab_sampler_between(rows, table->channels, cos_i, &places, value + k);
  }
}

void hetab_lookup_albedo(const hetab_lookup *table, const hetab_lookup_query *query, size_t count,
                         const float *wi, float *albedo, float *specular) {
  size_t width = width_of(table, query);
  for (size_t i = 0; i < count; i++) {
    if (albedo)
      albedo_at(table, query, i, wi[3 * i + 2], albedo + i * width);
    if (specular)
      specular_at(table, query, i, wi[3 * i + 2], specular + i * width);
  }
}
