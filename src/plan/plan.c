#include <hetab/plan.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/merl.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/number.h"
#include "plan/plan_make.h"
#include "plan/probe.h"
#include "plan/scene.h"

/* Of a default HDF5 table, and what a core writes of it in a second. */
static const double DENSE_ENTRIES = 90.0 * 90 * 181, DENSE_RATE = 75e6, DENSE_START = 0.1;
static const double MERL_BYTES = 12.0 + 3 * 8.0 * HETAB_MERL_CELLS, MERL_SECONDS = 0.32,
                    FOLD_SECONDS = 0.2;
static const double LARGEST_ERROR = 0.3;

typedef struct job {
  const hetab_scene *scene;
  hetab_plan *plan;
  hetab_probe *probes;
} job;

/* ---- sizes --------------------------------------------------------------------------------- */

static hetab_status size_rgl(hetab_context *ctx, const hetab_scene *scene, const hetab_probe *p,
                             double table_error, hetab_plan_item *item) {
  double cone = item->delta == HETAB_DELTA_FOLDED ? scene->specular_cone : 0.0;
  hetab_choose_wavelengths(&p->counts, table_error, item);
  double *lambda_um = hetab_alloc(ctx, item->wavelengths, sizeof *lambda_um); /* of a size alone */
  const hetab_rgl_source source = {.channels = item->wavelengths,
                                   .wavelengths_um = p->counts.choices ? lambda_um : NULL,
                                   .specular_cone_deg = hetab_degrees(cone),
                                   .description = p->description};
  hetab_rgl_report r;
  hetab_status status = lambda_um ? hetab_rgl_forecast_at(ctx, &p->forecast, &source,
                                                          table_error - item->wavelength_error, &r)
                                  : HETAB_ERR_MEMORY;
  free(lambda_um);
  HETAB_TRY(status);
  item->theta_i_count = r.theta_i_count;
  item->resolution = r.resolution;
  item->bytes = r.bytes;
  item->error_l1 = r.error_l1 + item->wavelength_error;
  /* The trial, and the nodes: against the forecast's, which were 20,000 evaluations. */
  item->seconds =
      p->fixed +
      p->seconds * (3.1 + 5.2e-5 * (double)(r.theta_i_count * r.resolution * r.resolution));
  return HETAB_OK;
}

static void size_merl(const hetab_probe *p, hetab_plan_item *item) {
  item->wavelengths = 3;
  item->bytes = (size_t)MERL_BYTES;
  item->seconds =
      p->fixed + MERL_SECONDS + (item->delta == HETAB_DELTA_FOLDED ? FOLD_SECONDS : 0.0);
  item->error_l1 = p->error_l1;
}

/* Linear between nodes: the error goes with the square of their spacing. */
static void size_dense(const hetab_scene *scene, const hetab_probe *p, double table_error,
                       const hetab_surface *surface, hetab_plan_item *item) {
  const double spare = 0.7, closest = 1.0, widest = 5.0;
  size_t bands = hetab_surface_band_count(surface);
  item->spacing_deg = fmin(fmax(sqrt(spare * table_error / p->error_l1), closest), widest);
  double entries = hetab_scene_entries(scene, item->spacing_deg);
  bool hdf5 = scene->consumer == HETAB_CONSUMER_HDF5;
  bool half = !hdf5 && hetab_wanted_element(table_error) == HETAB_EXR_HALF;
  item->wavelengths = hdf5 ? bands : 3;
  item->bytes = (size_t)((half ? 2.0 : 4.0) * entries * (double)item->wavelengths);
  item->seconds = DENSE_START + entries * (double)bands / DENSE_RATE;
  item->error_l1 = p->error_l1 * item->spacing_deg * item->spacing_deg;
}

/* All items at one error; the bytes of all. */
static hetab_status size_all(hetab_context *ctx, const job *job, double table_error) {
  hetab_plan *plan = job->plan;
  plan->table_error = table_error;
  plan->bytes = plan->seconds = 0.0;
  for (size_t i = 0; i < plan->count; i++) {
    hetab_plan_item *item = &plan->items[i];
    if (item->kind != HETAB_PLAN_TABLE)
      continue;
    if (hetab_wants_rgl(job->scene))
      HETAB_TRY(size_rgl(ctx, job->scene, &job->probes[i], table_error, item));
    else if (job->scene->consumer == HETAB_CONSUMER_MERL)
      size_merl(&job->probes[i], item);
    else
      size_dense(job->scene, &job->probes[i], table_error, job->scene->surfaces[i], item);
    plan->bytes += (double)item->bytes;
    plan->seconds += item->seconds;
  }
  return HETAB_OK;
}

/* The message lists the three largest tables. */
static hetab_status fail_budget(hetab_context *ctx, const job *job) {
  const hetab_plan *plan = job->plan;
  char names[3 * 160] = "";
  size_t length = 0, taken[3] = {plan->count, plan->count, plan->count};
  for (int n = 0; n < 3; n++) {
    size_t best = plan->count;
    for (size_t i = 0; i < plan->count; i++)
      if (i != taken[0] && i != taken[1] && plan->items[i].kind == HETAB_PLAN_TABLE &&
          (best == plan->count || plan->items[i].bytes > plan->items[best].bytes))
        best = i;
    if ((taken[n] = best) == plan->count)
      break;
    length += (size_t)snprintf(names + length, sizeof names - length, "%s%s (%s MB)", n ? ", " : "",
                               hetab_surface_name(job->scene->surfaces[best]),
                               hetab_two_digits(1e-6 * (double)plan->items[best].bytes).text);
  }
  char how[80] = "tables of this consumer have one size: they";
  if (job->scene->consumer != HETAB_CONSUMER_MERL)
    snprintf(how, sizeof how, "at an error of %g, the largest that is allowed, the tables",
             LARGEST_ERROR);
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "memory_mb %g is too little: %s take %s MB together; the largest are %s; allow "
                    "more, or leave surfaces out",
                    1e-6 * plan->memory_bytes, how, hetab_two_digits(1e-6 * plan->bytes).text,
                    names);
}

/* One error for all: whatever else the budget is split into, some surface's error is larger. */
static hetab_status fit_budget(hetab_context *ctx, const job *job) {
  hetab_plan *plan = job->plan;
  double low = plan->asked_error, high = LARGEST_ERROR;
  HETAB_TRY(size_all(ctx, job, low));
  if (plan->memory_bytes == 0.0 || plan->bytes <= plan->memory_bytes)
    return HETAB_OK;
  HETAB_TRY(size_all(ctx, job, high));
  if (plan->bytes > plan->memory_bytes)
    return fail_budget(ctx, job);
  for (int i = 0; i < 40; i++) {
    double middle = sqrt(low * high);
    HETAB_TRY(size_all(ctx, job, middle));
    if (plan->bytes <= plan->memory_bytes)
      high = middle;
    else
      low = middle;
  }
  return size_all(ctx, job, high);
}

/* ---- tables that several surfaces share ---------------------------------------------------- */

static bool same_bands(const hetab_surface *a, const hetab_surface *b) {
  size_t count = hetab_surface_band_count(a);
  return count == hetab_surface_band_count(b) &&
         memcmp(hetab_surface_bands(a), hetab_surface_bands(b), count * sizeof(hetab_band)) == 0;
}

static double slope(const hetab_surface *s) {
  return hetab_surface_sigma0_um(s) / hetab_surface_tau_um(s);
}

/* 1/g at the longest wavelength and 80 degrees, where g is least. */
static double inverse_g(const hetab_surface *s) {
  double lambda_um = hetab_surface_bands(s)[hetab_surface_band_count(s) - 1].lambda_um;
  double phase = 4.0 * M_PI * hetab_surface_sigma0_um(s) / lambda_um * cos(80.0 / 180.0 * M_PI);
  return 1.0 / (phase * phase);
}

/* Of one material: a lobe that is wider by a small part d differs by at most 2 d, relative L1. For
 * large g only the slope matters: h is off its limit by about 1.1 / g. */
static double difference(const hetab_surface *a, const hetab_surface *b) {
  double of_slope = 2.0 * fabs(log(slope(a) / slope(b)));
  double of_size = 4.0 * fabs(log(hetab_surface_sigma0_um(a) / hetab_surface_sigma0_um(b)));
  return of_slope + fmin(of_size, 1.5 * fabs(inverse_g(a) - inverse_g(b)));
}

typedef struct ranked {
  const hetab_surface *surface;
  size_t item;
} ranked;

static int by_slope(const void *a, const void *b) {
  double slope_a = slope(((const ranked *)a)->surface);
  double slope_b = slope(((const ranked *)b)->surface);
  return (slope_a < slope_b) - (slope_a > slope_b);
}

/* Descending in slope: what could share stands close by. The batch measures it. */
static hetab_status share(hetab_context *ctx, const job *job) {
  hetab_plan *plan = job->plan;
  double allowed = 0.3 * plan->asked_error;
  ranked *order = hetab_alloc(ctx, plan->count, sizeof *order);
  if (!order)
    return HETAB_ERR_MEMORY;
  for (size_t i = 0; i < plan->count; i++)
    order[i] = (ranked){job->scene->surfaces[i], i};
  qsort(order, plan->count, sizeof *order, by_slope);
  for (size_t n = 1; n < plan->count; n++)
    for (size_t m = n; m-- > 0;) {
      hetab_plan_item *item = &plan->items[order[n].item], *other = &plan->items[order[m].item];
      if (2.0 * log(slope(order[m].surface) / slope(order[n].surface)) > allowed)
        break;
      if (item->kind == HETAB_PLAN_TABLE && other->kind == HETAB_PLAN_TABLE &&
          item->delta == other->delta &&
          difference(order[n].surface, order[m].surface) <= allowed &&
          same_bands(order[n].surface, order[m].surface)) {
        item->kind = HETAB_PLAN_SHARED;
        item->shares = order[m].item;
        break;
      }
    }
  free(order);
  return HETAB_OK;
}

/* ---- the interface ------------------------------------------------------------------------- */

static void against_dense(const hetab_scene *scene, hetab_plan *plan) {
  for (size_t i = 0; i < plan->count; i++) {
    double entries = DENSE_ENTRIES * (double)hetab_surface_band_count(scene->surfaces[i]);
    plan->dense_bytes += 4.0 * entries;
    plan->dense_seconds += DENSE_START + entries / DENSE_RATE;
  }
}

static hetab_status make(hetab_context *ctx, job *job, const char *folder, double share_start) {
  hetab_plan *plan = job->plan;
  if (!plan->count)
    return HETAB_OK;
  HETAB_TRY(hetab_probe_all(ctx, job->scene, folder, share_start, plan->items, job->probes));
  for (size_t i = 0; i < plan->count; i++)
    plan->forecasts[i] = job->probes[i].forecast;
  HETAB_TRY(share(ctx, job));
  against_dense(job->scene, plan);
  return fit_budget(ctx, job);
}

hetab_status hetab_plan_make(hetab_context *ctx, const hetab_scene *scene, const char *folder,
                             double share_start, hetab_plan **out) {
  job job = {.scene = scene};
  *out = NULL;
  job.plan = hetab_alloc(ctx, 1, sizeof *job.plan);
  if (!job.plan)
    return HETAB_ERR_MEMORY;
  job.plan->count = scene->count;
  job.plan->asked_error = job.plan->table_error = scene->table_error;
  job.plan->memory_bytes = scene->memory_bytes;
  job.plan->items = hetab_alloc(ctx, scene->count, sizeof *job.plan->items);
  job.plan->forecasts = hetab_alloc(ctx, scene->count, sizeof *job.plan->forecasts);
  job.probes = hetab_alloc(ctx, scene->count, sizeof *job.probes);
  hetab_status status = job.plan->items && job.plan->forecasts && job.probes
                            ? make(ctx, &job, folder, share_start)
                            : HETAB_ERR_MEMORY;
  free(job.probes);
  if (status == HETAB_OK)
    *out = job.plan;
  else
    hetab_plan_free(job.plan);
  return status;
}

hetab_status hetab_plan_create(hetab_context *ctx, const hetab_scene *scene, hetab_plan **out) {
  return hetab_plan_make(ctx, scene, NULL, 0.0, out);
}

void hetab_plan_free(hetab_plan *plan) {
  if (!plan)
    return;
  free(plan->items);
  free(plan->forecasts);
  free(plan);
}
