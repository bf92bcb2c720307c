#include "audit/table_audit.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "audit/views.h"
#include "core/number.h"

void hetab_audit_structure(hetab_audit *audit) {
  char dims[96] = "";
  for (int i = 0; i < 4 && audit->dims[i]; i++) {
    size_t used = strlen(dims);
    snprintf(dims + used, sizeof dims - used, "%s%zu", i ? " x " : "", audit->dims[i]);
  }
  hetab_audit_add(audit, "structure", HETAB_PASS, (double)audit->bytes, 0, "%s %s, %llu bytes",
                  dims, audit->dims[1] ? "entries" : "channels", audit->bytes);
}

/* How much of the model's specular part there is: beside the table, or in what the lookup gives
 * back beyond the model's dd + ud. */
static double specular_share(const hetab_audit *audit, const double *specular) {
  double more = 0, wanted = 0;
  for (size_t c = 0; c < audit->channel_count; c++) {
    double white = 0, before = 0;
    for (size_t t = 0; t < audit->theta_count; t++) {
      const hetab_energy *e = hetab_audit_energy(audit, c, t);
      double next =
          t + 1 < audit->theta_count ? (audit->theta_i[t] + audit->theta_i[t + 1]) / 2.0 : M_PI_2;
      double s = sin(next);
      white += (s * s - before) * (audit->against->specular_apart ? e->specular : e->dd - e->model);
      before = s * s;
    }
    more += white;
    wanted += specular[c];
  }
  return wanted > 0 ? fmax(0, fmin(1, more / wanted)) : 1;
}

static void judge_specular(const hetab_audit_options *o, hetab_audit *audit) {
  const hetab_against *a = audit->against;
  double missing = a->specular_hh * (1 - a->specular_in_table);
  hetab_audit_add(audit, "specular", missing > o->max_missing ? HETAB_WARN : HETAB_PASS, missing,
                  o->max_missing,
                  "%.3g of white-sky reflectance is missing: the specular delta reflects %.3g, of "
                  "which %.0f %% is %s",
                  missing, a->specular_hh, 100 * a->specular_in_table,
                  a->specular_apart ? "beside the BRDF" : "in the table");
}

void hetab_audit_judge_against(const hetab_audit_options *o, const double *specular,
                               hetab_audit *audit) {
  hetab_against *a = audit->against;
  for (size_t c = 0; c < audit->channel_count; c++)
    a->specular_hh += specular[c] / (double)audit->channel_count;
  a->specular_in_table = specular_share(audit, specular);
  const hetab_table_error *e = &a->all;
  bool folded = audit->specular_cone > 0.0;
  hetab_audit_add(audit, "table_error",
                  e->relative_l1 > o->max_error && !folded ? HETAB_FAIL
                  : e->relative_l1 > o->max_error / 4      ? HETAB_WARN
                                                           : HETAB_PASS,
                  e->relative_l1, o->max_error,
                  "relative L1 %.3g %% over %zu pairs, bias %+.3g %%, median %s %%, 95th "
                  "percentile %.3g %%, on the lobe L1 %.3g %%%s",
                  100 * e->relative_l1, e->pairs, 100 * e->bias,
                  hetab_two_digits(100 * e->p50).text, 100 * e->p95, 100 * a->on_lobe.relative_l1,
                  folded ? "; the delta, in the table as a lobe, counts as error" : "");
  judge_specular(o, audit);
}

/* ---- tables that are read as a whole ------------------------------------------------------- */

typedef struct reader {
  hetab_pair_fn table;
  const void *user;
  size_t first, channel; /* of those read together, the one that is looked at */
} reader;

static double read_view(const void *user, double theta_i, double theta_r, double phi) {
  const reader *r = user;
  double channels[3];
  r->table(r->user, r->first, theta_i, theta_r, phi, channels);
  return channels[r->channel];
}

static hetab_status open_model(hetab_context *ctx, const hetab_audit_options *o, hetab_audit *audit,
                               hetab_model *model) {
  size_t count = audit->channel_count;
  if (!audit->lambda_um)
    return hetab_model_of_colour(ctx, o, model);
  HETAB_FREED hetab_band *bands = hetab_alloc(ctx, count, sizeof *bands);
  HETAB_NEED(bands);
  for (size_t b = 0; b < count; b++)
    bands[b].lambda_um = audit->lambda_um[b];
  return hetab_model_of_bands(ctx, o->against, 0.0, 0.0, bands, count, model);
}

static hetab_status add_pairs(hetab_context *ctx, hetab_engine *engine,
                              const hetab_audit_options *o, const hetab_model *model,
                              const reader *r, size_t count, hetab_audit *audit,
                              hetab_pairs *pairs) {
  size_t together = audit->lambda_um ? 1 : count;
  double work = pairs->progress, step = work * (double)together / (double)count;
  pairs->progress_step = step;
  pairs->progress_total = 2.0 * work;
  for (size_t first = 0; first < count; first += together, pairs->progress += step)
    HETAB_TRY(hetab_pairs_add(ctx, engine, model, first, together,
                              o->pairs * together / count + (together < count), r->table, r->user,
                              pairs));
  return HETAB_OK;
}

static hetab_status compare(hetab_context *ctx, hetab_engine *engine, const hetab_audit_options *o,
                            const hetab_model *model, const reader *r, double work,
                            hetab_audit *audit) {
  HETAB_FREED double *specular = hetab_alloc(ctx, audit->channel_count, sizeof *specular);
  HETAB_FREED hetab_pairs *pairs = hetab_alloc(ctx, 1, sizeof *pairs);
  audit->against = hetab_alloc(ctx, 1, sizeof *audit->against);
  hetab_status status = specular && pairs && audit->against ? HETAB_OK : HETAB_ERR_MEMORY;
  audit->sigma0_um = model->sigma0_um;
  audit->tau_um = model->tau_um;
  if (status == HETAB_OK) {
    pairs->random = o->seed;
    pairs->progress = work;
    hetab_hush hush = hetab_hush_begin(ctx);
    status = hetab_model_energy(ctx, engine, model, audit, specular);
    hetab_hush_end(ctx, hush);
  }
  if (status == HETAB_OK)
    status = add_pairs(ctx, engine, o, model, r, audit->channel_count, audit, pairs);
  if (status == HETAB_OK) {
    hetab_pairs_finish(pairs, audit->against);
    for (size_t i = 0; i < audit->channel_count * audit->theta_count; i++)
      audit->against->specular_apart |= audit->energy[i].specular > 0.0;
    hetab_audit_judge_against(o, specular, audit);
    hetab_check_fresnel(audit, o->max_excess);
  }
  return status;
}

hetab_status hetab_audit_compare(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_audit_options *o, hetab_pair_fn table,
                                 const void *user, double work, hetab_audit *audit) {
  size_t view = audit->view_channel;
  reader r = {table, user, audit->lambda_um ? view : 0, audit->lambda_um ? 0 : view};
  HETAB_ENDS(hetab_model_clear) hetab_model model = {0};
  if (o->against && !o->no_reference) {
    HETAB_TRY(open_model(ctx, o, audit, &model));
    HETAB_TRY(compare(ctx, engine, o, &model, &r, work, audit));
  }
  if (o->views)
    HETAB_TRY(hetab_views_of_table(ctx, audit, read_view, &r));
  if (o->views && model.bands)
    HETAB_TRY(hetab_views_of_model(ctx, engine, model.sigma0_um, model.tau_um, model.bands,
                                   model.weights + view * model.band_count, model.band_count,
                                   audit));
  return HETAB_OK;
}
