/* Batches: the tables of a plan in a folder, each with its record, one at a time. Who runs them, on
 * how many cores and machines, is the caller's: `hetab batch` starts a process a core.
 *
 * Folder: plan.json; of every surface NAME.json, its record, and NAME.bsdf, .binary, .h5 or .exr
 * with NAME.specular.csv where it has a table of its own; manifest.json, index.html; for the
 * renderer scene.xml, scene.py and he_torrance.py (Mitsuba), or scene.pbrt. */
#pragma once

#include <hetab/engine.h>
#include <hetab/plan.h>

HETAB_BEGIN

/* What a record says. */
typedef struct hetab_batch_result {
  double table_bytes; /* of the table; 0 without one */
  double bytes;       /* with what is beside it */
  double seconds; /* of the process, while it was made: of one core, where that has one thread */
  double error_l1, bias; /* RGL, measured, as in hetab_rgl_report; 0: none */
  double energy; /* RGL: the largest reflectance found, the delta beside the table with it */
  int fits;      /* the errors are what was asked for */
} hetab_batch_result;

/* Whether the surface's record and files are those that the plan asks for: by key, sizes and times;
 * with verify also by checksum. result may be NULL. */
int hetab_batch_done(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan, size_t i,
                     const char *folder, int verify, hetab_batch_result *result);
/* Makes the surface's table and record. *engine: NULL at first; made where a format needs one, and
 * the caller's to keep for the next and to free. Surfaces that share a table come after it. */
hetab_status hetab_batch_make(hetab_context *ctx, hetab_engine **engine, const hetab_scene *scene,
                              const hetab_plan *plan, size_t i, const char *folder,
                              hetab_batch_result *result);
/* The manifest, the overview and the renderer's scene of what is in the folder. */
hetab_status hetab_batch_finish(hetab_context *ctx, const hetab_scene *scene,
                                const hetab_plan *plan, const char *folder);

HETAB_END
