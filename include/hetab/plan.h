/* Only what a scene needs: a scene's surfaces, its renderer and the error that nobody sees make a
 * plan, from the model and small trials, before any table is computed.
 *
 * Scene, YAML (unknown keys are errors; failures name the file, the line and the key):
 *
 *   surfaces: [BBQAL1, mine.yml, {name: gold, sigma0_um: 0.4, tau_um: 2.5, index: Au}]
 *   sweep:                      # every combination of lists, ranges and numbers
 *     index: [Al, Cu]
 *     sigma0_um: {from: 0.05, to: 1, count: 20, spacing: log}   # or slope: sigma0 / tau
 *     tau_um: [2, 5, 10]
 *     diffuse_reflectance: 0    # pi * BRDF
 *   consumer: mitsuba-rgb       # mitsuba-spectral, pbrt, merl, hdf5, exr, lookup
 *   table_error: 0.01           # relative L1 as the renderer sees it
 *   energy_error: 0.003         # what may be left out, of all that is reflected
 *   max_theta_i_deg: 90         # the incidences that occur
 *   max_theta_r_deg: 90         # and the views; both bound the grids of HDF5 and OpenEXR
 *   specular_cone_deg: 4        # > 0: the delta becomes a lobe in the table; 0: never
 *   memory_mb: 20               # optional: 10^6 bytes, all tables together
 *   output: tables              # optional: the batch's folder
 *
 * The cone is 4 degrees for pbrt and MERL, which have no other place for the delta, else 0. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_consumer {
  HETAB_MITSUBA_RGB,
  HETAB_MITSUBA_SPECTRAL,
  HETAB_PBRT,
  HETAB_CONSUMER_MERL,
  HETAB_CONSUMER_HDF5,
  HETAB_CONSUMER_EXR,
  HETAB_CONSUMER_LOOKUP
} hetab_consumer;

const char *hetab_consumer_name(hetab_consumer consumer); /* "mitsuba-rgb" */

/* Threads: once loaded, it does not change and may be shared. */
typedef struct hetab_scene hetab_scene;

hetab_status hetab_scene_load(hetab_context *ctx, const char *path, hetab_scene **out);
void hetab_scene_free(hetab_scene *scene);                /* NULL is fine */
const char *hetab_scene_output(const hetab_scene *scene); /* its folder; NULL: none */
size_t hetab_scene_surface_count(const hetab_scene *scene);
const hetab_surface *hetab_scene_surface(const hetab_scene *scene, size_t i);
hetab_consumer hetab_scene_consumer(const hetab_scene *scene);

/* What a surface needs. */
typedef enum hetab_plan_kind {
  HETAB_PLAN_TABLE,  /* a table of its own */
  HETAB_PLAN_SHARED, /* the table of item `shares` */
  HETAB_PLAN_MIRROR, /* the delta is all: the renderer's smooth conductor */
  HETAB_PLAN_PLAIN   /* the renderer's Beckmann conductor, alpha = 2 sigma0 / tau */
} hetab_plan_kind;

/* Who carries the delta. */
typedef enum hetab_delta {
  HETAB_DELTA_LEFT_OUT, /* nobody: it is below energy_error */
  HETAB_DELTA_BESIDE,   /* /specular_reflectance, a part of the .exr, or NAME.specular.csv */
  HETAB_DELTA_MATERIAL, /* Mitsuba's material `he_torrance`, from NAME.specular.csv */
  HETAB_DELTA_FOLDED    /* the table, as a lobe */
} hetab_delta;

enum { HETAB_PLAIN_ANGLES = 3 };

typedef struct hetab_plan_item {
  hetab_plan_kind kind;
  hetab_delta delta;
  size_t shares;
  int diffuse;            /* the uniform-diffuse term is needed */
  double delta_share;     /* the delta's largest part of what is reflected, up to max_theta_i */
  double energy_left_out; /* of all that is reflected, what the plan leaves out */
  double plain_error;     /* relative L1 of the renderer's Beckmann conductor: the largest of */
  double plain_errors[HETAB_PLAIN_ANGLES]; /* those at plain_theta_i; 0: not asked for */
  double plain_theta_i[HETAB_PLAIN_ANGLES];
  size_t wavelengths;               /* in the table: 3 for linear sRGB */
  double wavelength_error;          /* relative L1 of reading between them: a part of error_l1 */
  size_t theta_i_count, resolution; /* RGL */
  double spacing_deg;               /* HDF5 and OpenEXR: of the grid's nodes */
  size_t bytes;                     /* of the table's file; .bsdf and MERL exactly */
  double seconds;                   /* of one core */
  /* Expected; of MERL for a reader that truncates, of HDF5 and OpenEXR for one that is linear
   * between the nodes, which stand 1 to 5 degrees apart: never closer, whatever was asked for. */
  double error_l1;
} hetab_plan_item;

struct hetab_rgl_forecast; /* what the trials of an RGL table found */

typedef struct hetab_plan {
  size_t count;
  hetab_plan_item *items;               /* in the scene's order */
  struct hetab_rgl_forecast *forecasts; /* [count], of RGL tables */
  double table_error; /* the common error that the budget leaves; what was asked for, without */
  double asked_error;
  double memory_bytes;               /* the budget; 0: none */
  double bytes, seconds;             /* in all */
  double dense_bytes, dense_seconds; /* 31-band dense HDF5 tables of all surfaces */
} hetab_plan;

/* HETAB_ERR_RANGE: no error below 0.3 meets the budget; the message names the surfaces that cost
 * most. Progress counts surfaces. The plan of a scene without surfaces is empty. */
hetab_status hetab_plan_create(hetab_context *ctx, const hetab_scene *scene, hetab_plan **out);
/* The same, kept as plan.json in the folder: of a scene that has not changed it is only read.
 * Processes that plan for one folder at the same time divide the work: share_start, 0 to 1, is
 * where this one begins; the first plan that is written is everybody's. */
hetab_status hetab_plan_open(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share_start, hetab_plan **out);
void hetab_plan_free(hetab_plan *plan); /* NULL is fine */

HETAB_END
