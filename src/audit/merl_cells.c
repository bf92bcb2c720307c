#include "audit/merl_cells.h"

#include <math.h>
#include <stdio.h>

#include "table/merl_frame.h"

enum { CHANNELS = HETAB_MERL_CHANNELS, ROW = HETAB_MERL_PHI_D, WHERE = 128 };

_Static_assert(HETAB_MERL_THETA_H == HETAB_MERL_THETA_D, "fill_edges fills both at once");

static const char *const colours[CHANNELS] = {"red", "green", "blue"};

/* Measured tables are noisy and corner-sampled ones out of step by a cell: up to this, relative, on
 * average a broken symmetry is worth a word, not a failure. */
static const double noticeable = 0.01;

/* Cosines and sines at the cells' edges. */
typedef struct edges {
  double cos_h[HETAB_MERL_THETA_H + 1], sin_h[HETAB_MERL_THETA_H + 1];
  double cos_d[HETAB_MERL_THETA_D + 1], sin_d[HETAB_MERL_THETA_D + 1];
  double cos_p[HETAB_MERL_PHI_D + 1]; /* absolute */
} edges;

typedef struct survey {
  const hetab_merl *merl;
  edges edges;
  hetab_audit *audit;
  char finite[WHERE], negative[WHERE], horizon[WHERE], isotropy[WHERE], bilateral[WHERE];
} survey;

static double value_at(const hetab_merl *merl, int channel, size_t cell) {
  return hetab_merl_channel_const(merl, channel)[cell];
}

static int is_marked(const hetab_merl *merl, size_t cell) {
  for (int c = 0; c < CHANNELS; c++)
    if (value_at(merl, c, cell) != -1)
      return 0;
  return 1;
}

/* "; first at theta_h 30, theta_d 2, phi_d 90 (cells), red". The first find stays. */
static void note(char where[WHERE], size_t cell, const char *channel, double value) {
  if (!*where)
    snprintf(where, WHERE, "; first at cell theta_h %zu, theta_d %zu, phi_d %zu%s%s: %g",
             cell / ROW / HETAB_MERL_THETA_D, cell / ROW % HETAB_MERL_THETA_D, cell % ROW,
             *channel ? ", " : "", channel, value);
}

/* ---- numbers ------------------------------------------------------------------------------- */

static void survey_values(survey *s, size_t cell) {
  hetab_cells *cells = &s->audit->cells;
  for (int c = 0; c < CHANNELS; c++) {
    double value = value_at(s->merl, c, cell);
    cells->total++;
    cells->nan += isnan(value) != 0;
    cells->infinite += isinf(value) != 0;
    if (!isfinite(value)) {
      note(s->finite, cell, colours[c], value);
    } else if (value < 0) {
      cells->negative++;
      note(s->negative, cell, colours[c], value);
    } else if (value > 0) {
      cells->min = cells->min > 0 ? fmin(cells->min, value) : value;
      cells->max = fmax(cells->max, value);
    }
  }
}

static void fill_edges(edges *e) {
  for (int i = 0; i <= HETAB_MERL_THETA_H; i++) {
    hetab_half_diff at = hetab_merl_angles((hetab_merl_place){i, i, 0.0});
    e->cos_h[i] = cos(at.theta_h);
    e->sin_h[i] = sin(at.theta_h);
    e->cos_d[i] = cos(at.theta_d);
    e->sin_d[i] = sin(at.theta_d);
  }
  for (int i = 0; i <= ROW; i++)
    e->cos_p[i] = fabs(cos((double)i / ROW * M_PI));
}

/* 1: every direction pair of the cell is above the horizon, -1: none, 0: some. The smaller cosine
 * is cos h cos d - sin h sin d |cos p|: extreme at the cell's corners, for p = 90 deg is one. */
static int horizon_side(const edges *e, size_t cell) {
  size_t h = cell / ROW / HETAB_MERL_THETA_D, d = cell / ROW % HETAB_MERL_THETA_D, p = cell % ROW;
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (size_t corner = 0; corner < 8; corner++) {
    size_t i = h + (corner & 1), j = d + (corner >> 1 & 1), k = p + (corner >> 2);
    double cosine = e->cos_h[i] * e->cos_d[j] - e->sin_h[i] * e->sin_d[j] * e->cos_p[k];
    least = fmin(least, cosine);
    most = fmax(most, cosine);
  }
  return least > 1e-12 ? 1 : most < -1e-12 ? -1 : 0;
}

static void survey_horizon(survey *s, size_t cell, int marked) {
  int side = horizon_side(&s->edges, cell);
  if (marked && side > 0) {
    s->audit->cells.invalid_above++;
    note(s->horizon, cell, "invalid", -1);
  } else if (!marked && side < 0) {
    s->audit->cells.valid_below++;
  }
}

/* ---- symmetry ------------------------------------------------------------------------------ */

static void compare(survey *s, hetab_symmetry *symmetry, double sums[2], size_t a, size_t b,
                    char where[WHERE]) {
  int worst;
  for (int c = 0; c < CHANNELS; c++) {
    double x = value_at(s->merl, c, a), y = value_at(s->merl, c, b);
    if (!(x >= 0 && y >= 0 && isfinite(x) && isfinite(y)))
      continue;
    hetab_symmetry_add(symmetry, sums, x, y, &worst);
    if (worst) {
      *where = '\0';
      note(where, a, colours[c], x);
    }
  }
}

/* phi_d and 180 - phi_d mirror the light and the viewer in the plane through the half vector. */
static void survey_bilateral(survey *s) {
  double sums[2] = {0};
  for (size_t row = 0; row < HETAB_MERL_CELLS; row += ROW)
    for (size_t p = 0; p < ROW / 2; p++)
      compare(s, &s->audit->bilateral, sums, row + p, row + ROW - 1 - p, s->bilateral);
  hetab_symmetry_finish(&s->audit->bilateral, sums);
}

/* Where the half vector is the normal, phi_d turns both directions about it: nothing may change. */
static void survey_isotropy(survey *s) {
  double sums[2] = {0};
  for (size_t d = 0; d < HETAB_MERL_THETA_D; d++)
    for (size_t p = 0; p < ROW / 2; p++)
      compare(s, &s->audit->isotropy, sums, d * ROW + p, d * ROW + p + ROW / 2, s->isotropy);
  hetab_symmetry_finish(&s->audit->isotropy, sums);
}

/* ---- the checks ---------------------------------------------------------------------------- */

static void judge_numbers(survey *s) {
  const hetab_cells *n = &s->audit->cells;
  size_t infinite = n->nan + n->infinite, wrong = n->invalid_above + n->valid_below;
  hetab_audit_add(s->audit, "finite", infinite ? HETAB_FAIL : HETAB_PASS, (double)infinite, 0,
                  "%zu NaN and %zu infinite values of %zu%s", n->nan, n->infinite, n->total,
                  s->finite);
  hetab_audit_add(s->audit, "negative", n->negative ? HETAB_FAIL : HETAB_PASS, (double)n->negative,
                  0, "%zu negative values that are not the mark -1 of all channels%s", n->negative,
                  s->negative);
  hetab_audit_add(s->audit, "horizon", wrong ? HETAB_WARN : HETAB_PASS, (double)wrong, 0,
                  "%zu cells marked invalid above the horizon, %zu not marked below it%s",
                  n->invalid_above, n->valid_below, s->horizon);
}

static void judge_symmetry(survey *s) {
  const hetab_symmetry *i = &s->audit->isotropy, *b = &s->audit->bilateral;
  hetab_audit_add(s->audit, "reciprocity", HETAB_PASS, 0, 0,
                  "held by the format: phi_d and phi_d + 180 deg are one cell");
  hetab_audit_add(s->audit, "isotropy", i->mean_rel > noticeable ? HETAB_WARN : HETAB_PASS,
                  i->mean_rel, noticeable,
                  "at theta_h = 0 phi_d must not matter: differences %.2g on average, at most %.2g "
                  "relative%s",
                  i->mean_rel, i->max_rel, i->mean_rel > noticeable ? s->isotropy : "");
  hetab_audit_add(s->audit, "bilateral", b->mean_rel > noticeable ? HETAB_WARN : HETAB_PASS,
                  b->mean_rel, noticeable,
                  "phi_d against 180 - phi_d: %.2g on average, at most %.2g relative%s",
                  b->mean_rel, b->max_rel, b->max_rel > noticeable ? s->bilateral : "");
}

void hetab_audit_merl_cells(const hetab_merl *merl, hetab_audit *audit) {
  survey s = {.merl = merl, .audit = audit};
  fill_edges(&s.edges);
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++) {
    int marked = is_marked(merl, cell);
    if (!marked)
      survey_values(&s, cell);
    survey_horizon(&s, cell, marked);
  }
  survey_bilateral(&s);
  survey_isotropy(&s);
  judge_numbers(&s);
  judge_symmetry(&s);
}
