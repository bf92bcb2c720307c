#include "audit/table_audit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "audit/dense_table.h"

hetab_status hetab_audit_structure(hetab_context *ctx, hetab_status opened, hetab_audit *audit) {
  if (opened == HETAB_ERR_PARSE) {
    hetab_audit_add(audit, "structure", HETAB_FAIL, (double)audit->bytes, 0, "%s",
                    hetab_error_message(ctx));
    return HETAB_OK;
  }
  HETAB_TRY(opened);
  char dims[96] = "";
  for (int i = 0; i < 4 && audit->dims[i]; i++) {
    size_t used = strlen(dims);
    snprintf(dims + used, sizeof dims - used, "%s%zu", i ? " x " : "", audit->dims[i]);
  }
  hetab_audit_add(audit, "structure", HETAB_PASS, (double)audit->bytes, 0, "%s entries, %llu bytes",
                  dims, audit->bytes);
  return HETAB_OK;
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
  hetab_audit_add(
      audit, "specular", missing > o->max_missing ? HETAB_WARN : HETAB_PASS, missing,
      o->max_missing,
      "%.3g of white-sky reflectance is missing: of the specular delta's %.3g, %.0f %% is "
      "%s",
      missing, a->specular_hh, 100 * a->specular_in_table,
      a->specular_apart ? "in the file, beside the BRDF" : "in the table");
}

void hetab_audit_judge_against(const hetab_audit_options *o, const double *specular,
                               hetab_audit *audit) {
  hetab_against *a = audit->against;
  for (size_t c = 0; c < audit->channel_count; c++)
    a->specular_hh += specular[c] / (double)audit->channel_count;
  a->specular_in_table = specular_share(audit, specular);
  const hetab_table_error *e = &a->all;
  hetab_audit_add(audit, "table_error",
                  e->relative_l1 > o->max_error       ? HETAB_FAIL
                  : e->relative_l1 > o->max_error / 4 ? HETAB_WARN
                                                      : HETAB_PASS,
                  e->relative_l1, o->max_error,
                  "relative L1 %.3g %% over %zu pairs, bias %+.3g %%, median %.2g %%, 95th "
                  "percentile %.3g %%, on the lobe L1 %.3g %%",
                  100 * e->relative_l1, e->pairs, 100 * e->bias, 100 * e->p50, 100 * e->p95,
                  100 * a->on_lobe.relative_l1);
  judge_specular(o, audit);
}
