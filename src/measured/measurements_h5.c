/* HDF5 tables of ours: of every axis no more nodes than a fit needs. */
#include <math.h>
#include <stdlib.h>

#include <hetab/table.h>

#include "measured/measurement_sheet.h"

/* One more than multiples: where the axes are the same, every theta_i has its mirror direction. */
enum { MOST_THETA_I = 10, MOST_THETA_R = 28, MOST_PHI = 13 };
static const size_t most[HETAB_AXIS_COUNT] = {MOST_THETA_I, MOST_THETA_R, MOST_PHI};
static const size_t most_bytes = (size_t)1 << 30; /* of one wavelength in memory */

typedef struct picked {
  hetab_h5_table *table;
  const hetab_grid *grid;
  size_t size[HETAB_AXIS_COUNT];  /* of the table */
  size_t count[HETAB_AXIS_COUNT]; /* of the nodes taken */
} picked;

/* The i-th node taken of an axis, its two ends among them. */
static size_t node(const picked *p, hetab_axis axis, size_t i) {
  if (p->count[axis] < 2)
    return 0;
  size_t steps = p->count[axis] - 1;
  return (2 * i * (p->size[axis] - 1) + steps) / (2 * steps);
}

static double radians(const picked *p, hetab_axis axis, size_t i) {
  return hetab_grid_deg(p->grid, axis)[node(p, axis, i)] * M_PI / 180;
}

/* Where one of the polar angles is 0 every azimuth is the same direction: the last is enough. */
static bool is_repeated(const picked *p, const size_t at[HETAB_AXIS_COUNT]) {
  bool normal = radians(p, HETAB_THETA_I, at[HETAB_THETA_I]) == 0 ||
                radians(p, HETAB_THETA_R, at[HETAB_THETA_R]) == 0;
  return normal && at[HETAB_PHI] + 1 < p->count[HETAB_PHI];
}

/* Calls `visit` for every direction taken, in one order. */
typedef hetab_status (*visit_fn)(const picked *p, const size_t at[HETAB_AXIS_COUNT], size_t index,
                                 void *user);

static hetab_status for_each(const picked *p, visit_fn visit, void *user) {
  size_t index = 0, at[HETAB_AXIS_COUNT];
  for (at[0] = 0; at[0] < p->count[0]; at[0]++)
    for (at[1] = 0; at[1] < p->count[1]; at[1]++)
      for (at[2] = 0; at[2] < p->count[2]; at[2]++)
        if (!is_repeated(p, at))
          HETAB_TRY(visit(p, at, index++, user));
  return HETAB_OK;
}

typedef struct slab {
  const double *values; /* of one wavelength, [theta_i][theta_r][phi] */
  double *out;          /* [direction][wavelengths] */
  size_t band, wavelengths;
  hetab_sheet *sheet;
} slab;

static hetab_status copy_value(const picked *p, const size_t at[HETAB_AXIS_COUNT], size_t index,
                               void *user) {
  slab *s = user;
  size_t entry = 0;
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++)
    entry = entry * p->size[axis] + node(p, axis, at[axis]);
  s->out[index * s->wavelengths + s->band] = s->values[entry];
  return HETAB_OK;
}

static hetab_status add_direction(const picked *p, const size_t at[HETAB_AXIS_COUNT], size_t index,
                                  void *user) {
  slab *s = user;
  hetab_measured_angles angles = {radians(p, HETAB_THETA_I, at[HETAB_THETA_I]), 0,
                                  radians(p, HETAB_THETA_R, at[HETAB_THETA_R]),
                                  radians(p, HETAB_PHI, at[HETAB_PHI])};
  return hetab_sheet_add(s->sheet, &angles, s->out + index * s->wavelengths);
}

static hetab_status read_values(hetab_sheet *sheet, const picked *p, double *slab_values, slab *s) {
  s->values = slab_values;
  for (s->band = 0; s->band < s->wavelengths; s->band++) {
    HETAB_TRY(hetab_h5_read(sheet->ctx, p->table, s->band, slab_values));
    HETAB_TRY(for_each(p, copy_value, s));
  }
  HETAB_TRY(hetab_sheet_begin(sheet, hetab_h5_wavelengths_um(p->table), s->wavelengths));
  return for_each(p, add_direction, s);
}

static hetab_status read_table(hetab_sheet *sheet, picked *p) {
  size_t entries = 1, taken = 1;
  p->grid = hetab_h5_grid(p->table);
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT; axis++) {
    p->size[axis] = hetab_grid_count(p->grid, axis);
    p->count[axis] = p->size[axis] < most[axis] ? p->size[axis] : most[axis];
    taken *= p->count[axis];
    if (p->size[axis] > most_bytes / sizeof(double) / entries)
      return hetab_sheet_fail(sheet,
                              "a wavelength of the table takes more than 1 GiB: give a table "
                              "with fewer angles");
    entries *= p->size[axis];
  }
  slab s = {.sheet = sheet, .wavelengths = hetab_h5_wavelength_count(p->table)};
  double *slab_values = hetab_alloc(sheet->ctx, entries, sizeof *slab_values);
  s.out = hetab_alloc(sheet->ctx, taken * s.wavelengths, sizeof *s.out);
  hetab_status status =
      slab_values && s.out ? read_values(sheet, p, slab_values, &s) : HETAB_ERR_MEMORY;
  free(slab_values);
  free(s.out);
  return status;
}

hetab_status hetab_measurements_read_h5(hetab_sheet *sheet) {
  picked p = {0};
  HETAB_TRY(hetab_h5_open(sheet->ctx, sheet->path, &p.table));
  hetab_status status = read_table(sheet, &p);
  hetab_h5_free(p.table);
  return status;
}
