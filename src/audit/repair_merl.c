#include <hetab/merl.h>

#include <math.h>

#include "audit/merl_energy.h"
#include "audit/repair.h"
#include "table/merl_frame.h"

HETAB_HANDLE(hetab_merl)

/* A cell is read at a range of incidences: what one scale leaves over, the next round takes. */
enum {
  CHANNELS = HETAB_MERL_CHANNELS,
  ROW = HETAB_MERL_PHI_D,
  INCIDENCES = HETAB_AUDIT_INCIDENCES,
  MOST_ROUNDS = 12
};
static const double accuracy = 1e-4;

typedef struct scales {
  double at[CHANNELS][INCIDENCES + 1]; /* at every degree; that of 89 again at 90 */
  int any;
} scales;

/* Marked cells stay out of it: they are all -1, and rows are mended channel by channel. */
static int is_marked(hetab_merl *merl, size_t cell) {
  for (int c = 0; c < CHANNELS; c++)
    if (hetab_merl_channel(merl, c)[cell] != -1)
      return 0;
  return 1;
}

/* Rows are cut at marked cells. */
static void mend_cells(hetab_merl *merl, hetab_repair_report *report) {
  for (size_t row = 0; row < HETAB_MERL_CELLS; row += ROW)
    for (size_t first = 0, end; first < ROW; first = end + 1) {
      for (end = first; end < ROW && !is_marked(merl, row + end); end++)
        ;
      for (int c = 0; c < CHANNELS && end > first; c++)
        hetab_repair_row(hetab_merl_channel(merl, c) + row + first, end - first, report);
    }
}

static hetab_status find_scales(hetab_context *ctx, const hetab_merl *merl, hetab_reading lookup,
                                scales *s, hetab_repair_report *report) {
  s->any = 0;
  for (int t = 0; t < INCIDENCES; t++) {
    HETAB_TRY(hetab_progress(ctx, t, INCIDENCES));
    double rho[CHANNELS], error[CHANNELS];
    hetab_merl_energy(merl, lookup, t * M_PI / 180, accuracy, rho, error);
    for (int c = 0; c < CHANNELS; c++) {
      s->at[c][t] = hetab_repair_scale(rho[c], 1 - error[c], report);
      s->any |= s->at[c][t] < 1;
    }
  }
  for (int c = 0; c < CHANNELS; c++)
    s->at[c][INCIDENCES] = s->at[c][INCIDENCES - 1];
  return HETAB_OK;
}

/* The smaller of the two whole degrees about an angle. */
static double scale_at(const double *at, double cosine) {
  double deg = acos(fmin(fmax(cosine, 0), 1)) * 180 / M_PI;
  int low = (int)fmin(deg, INCIDENCES - 1);
  return fmin(at[low], at[low + 1]);
}

static void scale_cell(hetab_merl *merl, const scales *s, size_t cell) {
  hetab_merl_pair pair;
  hetab_merl_pair_of(hetab_merl_middle(cell), &pair);
  for (int c = 0; c < CHANNELS; c++) {
    double *value = &hetab_merl_channel(merl, c)[cell];
    *value *= fmin(scale_at(s->at[c], pair.mu_i), scale_at(s->at[c], pair.mu_r));
  }
}

static hetab_status conserve_energy(hetab_context *ctx, hetab_merl *merl, hetab_reading lookup,
                                    hetab_repair_report *report) {
  scales s = {.any = 1};
  double product = 1;
  hetab_repair_report first = *report;
  for (int round = 0; round < MOST_ROUNDS; round++) {
    hetab_repair_report now = {.smallest_scale = 1};
    HETAB_TRY(find_scales(ctx, merl, lookup, &s, &now));
    if (!s.any)
      break;
    product *= now.smallest_scale;
    first.scaled_incidences =
        round ? first.scaled_incidences : first.scaled_incidences + now.scaled_incidences;
    for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++)
      if (!is_marked(merl, cell))
        scale_cell(merl, &s, cell);
  }
  first.smallest_scale = product;
  *report = first;
  return HETAB_OK;
}

hetab_status hetab_repair_merl(hetab_context *ctx, const char *path, const char *out_path,
                               hetab_reading lookup, int scale_energy, int overwrite,
                               hetab_repair_report *report) {
  HETAB_ENDS(hetab_merl_end) hetab_merl *merl = NULL;
  HETAB_TRY(hetab_merl_load_raw(ctx, path, &merl));
  mend_cells(merl, report);
  HETAB_TRY(scale_energy ? conserve_energy(ctx, merl, lookup, report) : HETAB_OK);
  return hetab_merl_save(ctx, merl, out_path, overwrite);
}
