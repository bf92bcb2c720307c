/* What is known of a scene's surfaces before the error is: small trials, on all cores, and by all
 * processes that plan for one folder at the same time.
 *
 * Surfaces come in chunks. A chunk that is done is a file in FOLDER/plan.parts, whole; who plans
 * starts at its own share's first chunk, goes round, and reads those that are there already: each
 * chunk is done once, but for those that two do at the same moment; a lost process loses its last
 * chunk. */
#pragma once

#include "plan/terms.h"
#include "rgl/rgl_build.h"

typedef struct hetab_probe {
  hetab_rgl_forecast forecast;
  hetab_plan_counts counts; /* of wavelengths, of spectra */
  double fixed, seconds;    /* of making the model; of the forecast */
  double error_l1;          /* of a table that is no RGL: at a spacing of 1 degree */
  char description[256];
} hetab_probe;

/* Of spectra, the wavelengths of the smallest table; 3 of linear sRGB. */
void hetab_choose_wavelengths(const hetab_plan_counts *counts, double table_error,
                              hetab_plan_item *item);

/* Fills probes[scene's surfaces], and kinds and terms of the items. folder: where parts are kept;
 * NULL: nowhere. share: 0 to 1, where to begin. */
hetab_status hetab_probe_all(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share, hetab_plan_item *items, hetab_probe *probes);
/* Once the plan is written. */
void hetab_probe_forget(const char *folder);
