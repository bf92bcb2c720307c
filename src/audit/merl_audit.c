/* The audit of a MERL table. */
#include "audit/merl_cells.h"
#include "audit/merl_energy.h"
#include "audit/merl_read.h"
#include "audit/table_audit.h"

enum { CHANNELS = HETAB_MERL_CHANNELS, GREEN = 1 };

typedef struct reader {
  const hetab_merl *merl;
  hetab_reading lookup;
} reader;

static void read_pair(const void *user, size_t first, double theta_i, double theta_r, double phi,
                      double *channels) {
  const reader *r = user;
  hetab_merl_read(r->merl, r->lookup,
                  hetab_merl_place_of(hetab_half_diff_of(theta_i, theta_r, phi)), channels);
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

hetab_status hetab_audit_merl(hetab_context *ctx, hetab_engine *engine, const char *path,
                              const hetab_audit_options *o, hetab_audit *audit) {
  static const size_t dims[4] = {CHANNELS, HETAB_MERL_THETA_H, HETAB_MERL_THETA_D,
                                 HETAB_MERL_PHI_D};
  hetab_merl *merl = NULL;
  hetab_status status;
  HETAB_TRY(hetab_merl_load_raw(ctx, path, &merl));
  for (int i = 0; i < 4; i++)
    audit->dims[i] = dims[i];
  hetab_audit_structure(audit);
  reader r = {merl, o->lookup};
  HETAB_GOTO(hetab_audit_size(ctx, audit, CHANNELS, HETAB_AUDIT_INCIDENCES));
  hetab_audit_whole_degrees(audit);
  audit->view_channel = GREEN;
  audit->specular_cone = hetab_merl_specular_cone(merl);
  hetab_audit_merl_cells(merl, audit);
  HETAB_GOTO(fill_energy(ctx, &r, o, audit));
  hetab_check_energy(audit, o->max_excess);
  HETAB_GOTO(hetab_audit_compare(ctx, engine, o, read_pair, &r, cells, audit));
done:
  hetab_merl_free(merl);
  return status;
}
