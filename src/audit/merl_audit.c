/* The audit of a MERL table. */
#include <math.h>
#include <stdlib.h>

#include "audit/merl_cells.h"
#include "audit/merl_energy.h"
#include "audit/merl_read.h"
#include "audit/pairs.h"
#include "audit/table_audit.h"
#include "audit/views.h"

enum { CHANNELS = HETAB_MERL_CHANNELS, GREEN = 1 };

typedef struct reader {
  const hetab_merl *merl;
  hetab_reading lookup;
} reader;

static void read_pair(const void *user, double theta_i, double theta_r, double phi,
                      double *channels) {
  const reader *r = user;
  hetab_merl_read(r->merl, r->lookup,
                  hetab_merl_place_of(hetab_half_diff_of(theta_i, theta_r, phi)), channels);
}

static double read_view(const void *user, double theta_i, double theta_r, double phi) {
  double rgb[CHANNELS];
  read_pair(user, theta_i, theta_r, phi, rgb);
  return rgb[GREEN];
}

/* Both halves of the work, the energy and the comparison, count as all the cells. */
static const double cells = (double)CHANNELS * HETAB_MERL_CELLS;

static hetab_status fill_energy(hetab_context *ctx, const reader *r, const hetab_audit_options *o,
                                hetab_audit *audit) {
  double total = o->against && !o->no_reference ? 2 * cells : cells;
  for (size_t t = 0; t < audit->theta_count; t++) {
    double rho[CHANNELS], error[CHANNELS];
    hetab_merl_energy(r->merl, r->lookup, audit->theta_i[t], o->tolerance, rho, error);
    for (size_t c = 0; c < CHANNELS; c++) {
      hetab_energy *e = hetab_audit_energy(audit, c, t);
      e->dh = e->dd = rho[c];
      e->error = error[c];
    }
    HETAB_TRY(hetab_progress(ctx, cells * (double)(t + 1) / (double)audit->theta_count, total));
  }
  return HETAB_OK;
}

static hetab_status compare(hetab_context *ctx, hetab_engine *engine, const reader *r,
                            const hetab_audit_options *o, const hetab_model *model,
                            hetab_audit *audit) {
  double specular[CHANNELS];
  hetab_pairs *pairs = hetab_alloc(ctx, 1, sizeof *pairs);
  audit->against = hetab_alloc(ctx, 1, sizeof *audit->against);
  hetab_status status = pairs && audit->against ? HETAB_OK : HETAB_ERR_MEMORY;
  audit->sigma0_um = model->sigma0_um;
  audit->tau_um = model->tau_um;
  if (status == HETAB_OK) {
    pairs->random = o->seed;
    pairs->progress = pairs->progress_step = cells;
    pairs->progress_total = 2 * cells;
    hetab_hush hush = hetab_hush_begin(ctx);
    status = hetab_model_energy(ctx, engine, model, audit, specular);
    hetab_hush_end(ctx, hush);
  }
  if (status == HETAB_OK)
    status = hetab_pairs_add(ctx, engine, model, 0, CHANNELS, o->pairs, read_pair, r, pairs);
  if (status == HETAB_OK) {
    hetab_pairs_finish(pairs, audit->against);
    hetab_audit_judge_against(o, specular, audit);
  }
  free(pairs);
  return status;
}

static hetab_status compare_and_view(hetab_context *ctx, hetab_engine *engine, const reader *r,
                                     const hetab_audit_options *o, hetab_audit *audit) {
  hetab_model model = {0};
  hetab_status status = HETAB_OK;
  if (o->against && !o->no_reference) {
    HETAB_GOTO(hetab_model_of_colour(ctx, o, &model));
    HETAB_GOTO(compare(ctx, engine, r, o, &model, audit));
    hetab_check_fresnel(audit, o->max_excess);
  }
  if (o->views)
    HETAB_GOTO(hetab_views_of_table(ctx, audit, read_view, r));
  if (o->views && model.bands)
    HETAB_GOTO(hetab_views_of_model(ctx, engine, model.sigma0_um, model.tau_um, model.bands,
                                    model.weights + GREEN * model.band_count, model.band_count,
                                    audit));
done:
  hetab_model_clear(&model);
  return status;
}

hetab_status hetab_audit_merl(hetab_context *ctx, hetab_engine *engine, const char *path,
                              const hetab_audit_options *o, hetab_audit *audit) {
  static const size_t dims[4] = {CHANNELS, HETAB_MERL_THETA_H, HETAB_MERL_THETA_D,
                                 HETAB_MERL_PHI_D};
  hetab_merl *merl = NULL;
  hetab_status opened = hetab_merl_load_raw(ctx, path, &merl);
  for (int i = 0; i < 4 && opened == HETAB_OK; i++)
    audit->dims[i] = dims[i];
  hetab_status status = hetab_audit_structure(ctx, opened, audit);
  if (status != HETAB_OK || !merl)
    return status;
  reader r = {merl, o->lookup};
  HETAB_GOTO(hetab_audit_size(ctx, audit, CHANNELS, HETAB_AUDIT_INCIDENCES));
  hetab_audit_whole_degrees(audit);
  audit->view_channel = GREEN;
  hetab_audit_merl_cells(merl, audit);
  HETAB_GOTO(fill_energy(ctx, &r, o, audit));
  hetab_check_energy(audit, o->max_excess);
  HETAB_GOTO(compare_and_view(ctx, engine, &r, o, audit));
done:
  hetab_merl_free(merl);
  return status;
}
