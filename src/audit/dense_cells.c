#include "audit/dense_cells.h"

#include <math.h>
#include <stdio.h>

typedef struct entry {
  size_t i, r, p;
} entry;

static double deg_at(const hetab_dense_table *t, hetab_axis axis, size_t index) {
  return hetab_grid_deg(t->grid, axis)[index];
}

/* "; first at theta_i 30, theta_r 45, phi 180 deg, 550 nm: nan" */
static void note(const hetab_dense_table *t, const hetab_audit *audit, size_t wavelength, entry e,
                 const char *word, char where[HETAB_DENSE_WHERE]) {
  char channel[24];
  snprintf(where, HETAB_DENSE_WHERE, "; %s at theta_i %.6g, theta_r %.6g, phi %.6g deg, %s: %g",
           word, deg_at(t, HETAB_THETA_I, e.i), deg_at(t, HETAB_THETA_R, e.r),
           deg_at(t, HETAB_PHI, e.p), hetab_audit_channel(audit, wavelength, channel),
           *hetab_dense_table_at(t, e.i, e.r, e.p));
}

static void survey_value(const hetab_dense_table *t, size_t wavelength, entry e, hetab_audit *audit,
                         hetab_dense_survey *s) {
  hetab_cells *cells = &audit->cells;
  double value = *hetab_dense_table_at(t, e.i, e.r, e.p);
  cells->total++;
  if (value > 0 && isfinite(value)) {
    cells->min = cells->min > 0 ? fmin(cells->min, value) : value;
    cells->max = fmax(cells->max, value);
    return;
  }
  cells->nan += isnan(value) != 0;
  cells->infinite += isinf(value) != 0;
  cells->negative += value < 0 && isfinite(value);
  char *where = !isfinite(value) ? s->finite : value < 0 ? s->negative : NULL;
  if (where && !*where)
    note(t, audit, wavelength, e, "first", where);
}

/* The entry's reciprocal one; NaN where the table has none. */
static double exchanged(const hetab_dense_table *t, entry e, int same_axes) {
  if (same_axes)
    return *hetab_dense_table_at(t, e.r, e.i, e.p);
  double theta_i = deg_at(t, HETAB_THETA_I, e.i), theta_r = deg_at(t, HETAB_THETA_R, e.r);
  if (theta_r < deg_at(t, HETAB_THETA_I, 0) || theta_i < deg_at(t, HETAB_THETA_R, 0) ||
      theta_r > deg_at(t, HETAB_THETA_I, t->count[HETAB_THETA_I] - 1) ||
      theta_i > deg_at(t, HETAB_THETA_R, t->count[HETAB_THETA_R] - 1))
    return (double)NAN;
  return hetab_dense_table_read(t, hetab_radians(theta_r), hetab_radians(theta_i),
                                hetab_radians(deg_at(t, HETAB_PHI, e.p)));
}

static void survey_pair(const hetab_dense_table *t, size_t wavelength, entry e, int same_axes,
                        hetab_audit *audit, hetab_dense_survey *s) {
  double a = *hetab_dense_table_at(t, e.i, e.r, e.p), b = exchanged(t, e, same_axes);
  int worst;
  if (!isfinite(a) || !isfinite(b))
    return;
  hetab_symmetry_add(&audit->reciprocity, s->reciprocity, a, b, &worst);
  if (worst)
    note(t, audit, wavelength, e, "most", s->non_reciprocal);
}

/* Seen from the normal, or towards it, phi must not matter. */
static void survey_normal(const hetab_dense_table *t, size_t wavelength, entry e,
                          hetab_audit *audit, hetab_dense_survey *s) {
  int worst, normal = deg_at(t, HETAB_THETA_I, e.i) == 0 || deg_at(t, HETAB_THETA_R, e.r) == 0;
  double first = *hetab_dense_table_at(t, e.i, e.r, 0);
  double value = *hetab_dense_table_at(t, e.i, e.r, e.p);
  if (!normal || e.p == 0 || !isfinite(first) || !isfinite(value))
    return;
  hetab_symmetry_add(&audit->isotropy, s->isotropy, value, first, &worst);
  if (worst)
    note(t, audit, wavelength, e, "most", s->anisotropic);
}

void hetab_dense_survey_add(const hetab_dense_table *t, size_t wavelength, hetab_audit *audit,
                            hetab_dense_survey *s) {
  int same_axes = hetab_dense_table_same_axes(t);
  entry e;
  for (e.i = 0; e.i < t->count[HETAB_THETA_I]; e.i++)
    for (e.r = 0; e.r < t->count[HETAB_THETA_R]; e.r++)
      for (e.p = 0; e.p < t->count[HETAB_PHI]; e.p++) {
        survey_value(t, wavelength, e, audit, s);
        if (!same_axes || e.r < e.i)
          survey_pair(t, wavelength, e, same_axes, audit, s);
        survey_normal(t, wavelength, e, audit, s);
      }
}

static void judge_symmetry(const char *name, const hetab_symmetry *symmetry, double allowed,
                           const char *what, const char *where, hetab_audit *audit) {
  if (!symmetry->compared)
    hetab_audit_add(audit, name, HETAB_PASS, 0, allowed, "nothing to compare: %s", what);
  else
    hetab_audit_add(audit, name, symmetry->max_rel > allowed ? HETAB_FAIL : HETAB_PASS,
                    symmetry->max_rel, allowed,
                    "%s: at most %.2g relative, %.2g on average; %.2g, %.2g / sr%s", what,
                    symmetry->max_rel, symmetry->mean_rel, symmetry->max_abs, symmetry->mean_abs,
                    symmetry->max_rel > 0 ? where : "");
}

void hetab_dense_survey_judge(const hetab_dense_table *t, double max_asymmetry, hetab_audit *audit,
                              hetab_dense_survey *s) {
  const hetab_cells *n = &audit->cells;
  size_t infinite = n->nan + n->infinite;
  hetab_symmetry_finish(&audit->reciprocity, s->reciprocity);
  hetab_symmetry_finish(&audit->isotropy, s->isotropy);
  hetab_audit_add(audit, "finite", infinite ? HETAB_FAIL : HETAB_PASS, (double)infinite, 0,
                  "%zu NaN and %zu infinite values of %zu%s", n->nan, n->infinite, n->total,
                  s->finite);
  hetab_audit_add(audit, "negative", n->negative ? HETAB_FAIL : HETAB_PASS, (double)n->negative, 0,
                  "%zu negative values; the others span %.3g to %.3g / sr%s", n->negative, n->min,
                  n->max, s->negative);
  judge_symmetry("reciprocity", &audit->reciprocity, max_asymmetry,
                 hetab_dense_table_same_axes(t) ? "f(i, r) against f(r, i)"
                                                : "f(i, r) against f(r, i) looked up",
                 s->non_reciprocal, audit);
  judge_symmetry("isotropy", &audit->isotropy, max_asymmetry, "along phi at the normal",
                 s->anisotropic, audit);
  hetab_audit_add(audit, "bilateral", HETAB_PASS, 0, 0,
                  "held by the format: phi is in 0 to 180 deg, for both sides");
}
