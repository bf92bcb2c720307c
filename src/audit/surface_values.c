/* The values that tables of a surface would hold: signs, range and reciprocity as computed. */
#include "audit/surface_values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { THETAS = HETAB_AUDIT_INCIDENCES, PHIS = 91, ROW = THETAS * PHIS };

typedef struct collector {
  hetab_audit *audit;
  hetab_precision precision;
  double **values;   /* [band][theta_i][theta_r][phi], while it is being filled */
  size_t *rows_left; /* [band] */
  double sums[2];
  char *where; /* of the worst reciprocity */
} collector;

static void take_value(hetab_audit *audit, hetab_band_audit *band, double value) {
  hetab_cells *cells = &audit->cells;
  cells->total++;
  cells->nan += isnan(value) != 0;
  cells->infinite += isinf(value) != 0;
  cells->negative += value < 0;
  if (!(value > 0) || !isfinite(value))
    return;
  band->min = band->min > 0 ? fmin(band->min, value) : value;
  band->max = fmax(band->max, value);
}

static void compare_directions(collector *c, size_t band, const double *values) {
  for (size_t i = 0; i < THETAS; i++)
    for (size_t r = 0; r < i; r++)
      for (size_t p = 0; p < PHIS; p++) {
        int worst;
        char channel[24];
        hetab_symmetry_add(&c->audit->reciprocity, c->sums, values[(i * THETAS + r) * PHIS + p],
                           values[(r * THETAS + i) * PHIS + p], &worst);
        if (worst)
          snprintf(c->where, HETAB_WHERE, "theta %zu and %zu deg, phi %zu deg, %s", i, r, 2 * p,
                   hetab_audit_channel(c->audit, band, channel));
      }
}

static void finish_band(collector *c, size_t band) {
  const double *values = c->values[band];
  for (size_t i = 0; i < (size_t)THETAS * ROW; i++)
    take_value(c->audit, &c->audit->bands[band], values[i]);
  compare_directions(c, band, values);
  free(c->values[band]);
  c->values[band] = NULL;
}

/* Slabs come in any order: a band is judged when its last row is there. */
static hetab_status take_slab(hetab_context *ctx, void *user, const hetab_slab *slab) {
  collector *c = user;
  double **values = &c->values[slab->wavelength];
  size_t count = slab->theta_i_count * ROW;
  if (!*values && !(*values = hetab_alloc(ctx, (size_t)THETAS * ROW, sizeof **values)))
    return HETAB_ERR_MEMORY;
  double *to = *values + slab->theta_i_first * ROW;
  for (size_t i = 0; i < count; i++)
    to[i] = c->precision == HETAB_DOUBLE ? ((const double *)slab->values)[i]
                                         : (double)((const float *)slab->values)[i];
  c->rows_left[slab->wavelength] -= slab->theta_i_count;
  if (!c->rows_left[slab->wavelength])
    finish_band(c, slab->wavelength);
  return HETAB_OK;
}

static hetab_status make_grid(hetab_context *ctx, hetab_grid **grid) {
  HETAB_TRY(hetab_grid_create(ctx, grid));
  HETAB_TRY(hetab_grid_set_axis(ctx, *grid, HETAB_THETA_I, "0:89:90"));
  HETAB_TRY(hetab_grid_set_axis(ctx, *grid, HETAB_THETA_R, "0:89:90"));
  return hetab_grid_set_axis(ctx, *grid, HETAB_PHI, "0:180:91");
}

hetab_status hetab_surface_values(hetab_context *ctx, hetab_engine *engine,
                                  const hetab_surface *surface, hetab_audit *audit,
                                  char where[HETAB_WHERE]) {
  size_t bands = audit->channel_count;
  collector c = {.audit = audit, .precision = hetab_engine_precision(engine), .where = where};
  hetab_tabulate_options options = {.samples = HETAB_NO_SAMPLES};
  hetab_grid *grid = NULL;
  hetab_status status = HETAB_ERR_MEMORY;
  c.values = hetab_alloc(ctx, bands, sizeof *c.values);
  c.rows_left = hetab_alloc(ctx, bands, sizeof *c.rows_left);
  if (!c.values || !c.rows_left)
    goto done;
  for (size_t i = 0; i < bands; i++)
    c.rows_left[i] = THETAS;
  HETAB_GOTO(make_grid(ctx, &grid));
  HETAB_GOTO(hetab_tabulate(ctx, engine, surface, grid, &options, take_slab, &c, NULL));
  hetab_symmetry_finish(&audit->reciprocity, c.sums);
done:
  for (size_t i = 0; c.values && i < bands; i++)
    free(c.values[i]);
  free(c.values);
  free(c.rows_left);
  hetab_grid_free(grid);
  return status;
}
