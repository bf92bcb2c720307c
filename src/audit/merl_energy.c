/* dOmega_r = 4 (i.h) dOmega_h: rings of half vectors about the normal. What is looked up is made of
 * pieces (a truncating reader's cells, or the boxes that an interpolating one has between their
 * centres), and a ring goes from one to the next at azimuths known in closed form: where theta_d or
 * phi_d reach an edge, and at the horizon. Between those the integrand is smooth. Over theta_h,
 * too, panels end at edges; what is left there are kinks, where corners of pieces lie. */
#include "audit/merl_energy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "audit/merl_read.h"
#include "core/number.h"

enum { CHANNELS = HETAB_MERL_CHANNELS, GAUSS = 3 };
enum { ARCS = 16, CUTS = ARCS + HETAB_MERL_THETA_D + 2 * HETAB_MERL_PHI_D + 4 };
enum { PANELS = HETAB_MERL_THETA_H + 2 * HETAB_MERL_THETA_D + 3, MOST_PARTS = 8 };

static const double GAUSS_AT[GAUSS] = {-0.77459666924148338, 0, 0.77459666924148338};
static const double GAUSS_WEIGHT[GAUSS] = {5.0 / 9, 8.0 / 9, 5.0 / 9}; /* of 2 */

static const double NEAR_NORMAL = M_PI / 180;

/* Rounding of what is summed, relative. */
static const double ROUNDING = 1e-12;

/* The edges of the pieces along phi_d and theta_d. */
typedef struct edges {
  double cos_d[HETAB_MERL_THETA_D];
  double cos_p[HETAB_MERL_PHI_D], sin_p[HETAB_MERL_PHI_D];
} edges;

typedef struct light {
  const hetab_merl *merl;
  hetab_reading lookup;
  double s, c; /* sine and cosine of theta_i */
  edges edges;
} light;

/* What there is between two values of h, by two rules. */
typedef struct panel {
  double rho[CHANNELS], middle[CHANNELS];
} panel;

/* Of one ring: i.h = a cos(phi_h) + b. */
typedef struct ring {
  double h, sin_h, cos_h, a, b;
} ring;

/* A reader's pieces begin at whole cells, or half-way between cells' centres. */
static double first_edge(hetab_reading lookup) {
  return lookup == HETAB_READ_INTERPOLATE ? 0.5 : 0.0;
}

static void fill_edges(hetab_reading lookup, edges *e) {
  double first = first_edge(lookup);
  for (int i = 0; i < HETAB_MERL_THETA_D; i++)
    e->cos_d[i] = cos((i + first) / HETAB_MERL_THETA_D * M_PI_2);
  for (int i = 0; i < HETAB_MERL_PHI_D; i++) {
    e->cos_p[i] = cos((i + first) / HETAB_MERL_PHI_D * M_PI);
    e->sin_p[i] = sin((i + first) / HETAB_MERL_PHI_D * M_PI);
  }
}

/* ---- rings --------------------------------------------------------------------------------- */

static double theta_h_at(double h) {
  double u = h / HETAB_MERL_THETA_H;
  return u * u * M_PI_2;
}

static ring ring_at(const light *l, double h) {
  double theta_h = theta_h_at(h);
  ring r = {.h = h, .sin_h = sin(theta_h), .cos_h = cos(theta_h)};
  r.a = l->s * r.sin_h;
  r.b = l->c * r.cos_h;
  return r;
}

/* The azimuth from which on the viewer, 2 (i.h) h - i, is below the horizon. */
static double horizon_of(const light *l, const ring *r) {
  double cos_p = l->c / (2 * r->cos_h) - r->b;
  if (fabs(cos_p) >= r->a)
    return cos_p < 0 ? M_PI : 0;
  return acos(cos_p / r->a);
}

/* Where phi_d is that of an edge, or its opposite: s (sin(phi_h) cos p + cos_h cos(phi_h) sin p) =
 * c sin_h sin p. */
static size_t add_phi_cuts(const light *l, const ring *r, double end, double *cuts) {
  size_t count = 0;
  for (int i = 0; i < HETAB_MERL_PHI_D; i++) {
    double sin_p = l->edges.sin_p[i], cos_p = l->edges.cos_p[i], along = r->cos_h * sin_p;
    double right = l->c * r->sin_h * sin_p, most = l->s * hypot(cos_p, along);
    if (!(right < most))
      continue;
    double turn = atan2(along, cos_p), angle = asin(right / most);
    double at[2] = {angle - turn, M_PI - angle - turn};
    for (int k = 0; k < 2; k++)
      if (at[k] > 0 && at[k] < end)
        cuts[count++] = at[k];
  }
  return count;
}

/* The azimuths in [0, end] between which all is smooth, in order. */
static size_t cuts_of(const light *l, const ring *r, double end, double cuts[CUTS]) {
  size_t count = add_phi_cuts(l, r, end, cuts);
  for (int i = 0; i < HETAB_MERL_THETA_D; i++) {
    double cos_at = l->edges.cos_d[i] - r->b;
    if (fabs(cos_at) < r->a && r->a * cos(end) < cos_at)
      cuts[count++] = acos(cos_at / r->a);
  }
  for (int i = 0; i <= ARCS; i++) /* and short enough for the rule */
    cuts[count++] = end * i / ARCS;
  hetab_sort(cuts, count);
  return count;
}

/* Both half vectors at +-phi_h, whose share of the light is `weight`. */
static void add_pair(const light *l, const ring *r, double cos_p, double sin_p, double weight,
                     double sum[CHANNELS]) {
  double theta_d = acos(fmin(r->a * cos_p + r->b, 1));
  double phi_d = atan2(l->s * sin_p, l->s * cos_p * r->cos_h - l->c * r->sin_h);
  for (int side = -1; side <= 1; side += 2) {
    hetab_merl_place place = {r->h, HETAB_MERL_THETA_D * theta_d / M_PI_2,
                              side * HETAB_MERL_PHI_D * phi_d / M_PI};
    double rgb[CHANNELS];
    hetab_merl_read(l->merl, l->lookup, place, rgb);
    for (int c = 0; c < CHANNELS; c++)
      sum[c] += weight * rgb[c];
  }
}

/* The primitive of 4 (i.h) mu_r over phi_h. */
static double weight_up_to(const light *l, const ring *r, double phi_h) {
  double sin_p = sin(phi_h), cos_p = cos(phi_h);
  return 4 * (r->cos_h * r->a * r->a * (phi_h + sin_p * cos_p) +
              r->a * (4 * r->cos_h * r->b - l->c) * sin_p +
              r->b * (2 * r->cos_h * r->b - l->c) * phi_h);
}

/* A truncating reader sees one value from one cut to the next. */
static void add_cells(const light *l, const ring *r, const double *cuts, size_t count,
                      double sum[CHANNELS]) {
  double before = weight_up_to(l, r, cuts[0]);
  for (size_t i = 1; i < count; i++) {
    double middle = 0.5 * (cuts[i - 1] + cuts[i]), after = weight_up_to(l, r, cuts[i]);
    add_pair(l, r, cos(middle), sin(middle), after - before, sum);
    before = after;
  }
}

static void add_boxes(const light *l, const ring *r, const double *cuts, size_t count,
                      double sum[CHANNELS]) {
  for (size_t i = 1; i < count; i++) {
    double half = 0.5 * (cuts[i] - cuts[i - 1]);
    for (int g = 0; g < GAUSS; g++) {
      double phi_h = cuts[i - 1] + half * (1 + GAUSS_AT[g]), cos_p = cos(phi_h);
      double i_h = r->a * cos_p + r->b, mu_r = 2 * i_h * r->cos_h - l->c;
      add_pair(l, r, cos_p, sin(phi_h), GAUSS_WEIGHT[g] * half * 4 * i_h * mu_r, sum);
    }
  }
}

/* The integral around the ring, per unit of h. */
static void integrate_ring(const light *l, double h, double sum[CHANNELS]) {
  double cuts[CUTS];
  ring r = ring_at(l, h);
  double end = horizon_of(l, &r);
  double per_h = r.sin_h * M_PI * h / (HETAB_MERL_THETA_H * HETAB_MERL_THETA_H);
  size_t count = end > 0 ? cuts_of(l, &r, end, cuts) : 0;
  memset(sum, 0, CHANNELS * sizeof *sum);
  if (count > 0)
    (l->lookup == HETAB_READ_INTERPOLATE ? add_boxes : add_cells)(l, &r, cuts, count, sum);
  for (int c = 0; c < CHANNELS; c++)
    sum[c] *= per_h;
}

/* ---- over theta_h -------------------------------------------------------------------------- */

/* Gauss's rule of order 3, and the midpoint rule, whose node it has. */
static void add_panel(const light *l, double from, double to, panel *p) {
  double rings[GAUSS][CHANNELS], half = 0.5 * (to - from);
  for (int i = 0; i < GAUSS; i++)
    integrate_ring(l, from + half * (1 + GAUSS_AT[i]), rings[i]);
  for (int c = 0; c < CHANNELS; c++) {
    for (int i = 0; i < GAUSS; i++)
      p->rho[c] += GAUSS_WEIGHT[i] * half * rings[i][c];
    p->middle[c] += 2 * half * rings[GAUSS / 2][c];
  }
}

static panel panel_of(const light *l, double from, double to, int parts) {
  panel p = {{0}, {0}};
  double width = (to - from) / parts;
  for (int i = 0; i < parts && width > 0; i++)
    add_panel(l, from + i * width, from + (i + 1) * width, &p);
  return p;
}

/* h of theta_h. */
static double h_at(double theta_h) {
  return HETAB_MERL_THETA_H * sqrt(theta_h / M_PI_2);
}

/* The ends of the panels over h, in order: edges of the pieces; where the horizon begins to cut
 * rings, and where it has cut all of them; and near normal incidence, where rings run along the
 * edges of theta_d and cross them all at once, the theta_h at which they do. */
static size_t panels_of(const light *l, double theta_i, double ends[PANELS]) {
  double first = first_edge(l->lookup), last = h_at(M_PI_4 + theta_i / 2);
  size_t count = 0, kept = 0;
  ends[count++] = 0;
  ends[count++] = h_at(M_PI_4 - theta_i / 2);
  ends[count++] = last;
  for (int i = 0; i < HETAB_MERL_THETA_H; i++)
    ends[count++] = i + first;
  for (int i = 0; i < HETAB_MERL_THETA_D && theta_i < NEAR_NORMAL; i++) {
    double theta_d = (i + first) / HETAB_MERL_THETA_D * M_PI_2;
    ends[count++] = h_at(fabs(theta_d - theta_i));
    ends[count++] = h_at(theta_d + theta_i);
  }
  hetab_sort(ends, count);
  while (kept < count && ends[kept] <= last)
    kept++;
  return kept;
}

/* rho and error from panels cut into so many parts, which `panels` hold afterwards, and the largest
 * error. The difference from the rule before, of half as many parts (at first the midpoint rule),
 * is that one's error, several times that of the value. Differences add up as magnitudes. */
static double refine(const light *l, const double *ends, size_t count, int parts, panel *panels,
                     double rho[CHANNELS], double error[CHANNELS]) {
  double worst = 0;
  memset(rho, 0, CHANNELS * sizeof *rho);
  memset(error, 0, CHANNELS * sizeof *error);
  for (size_t i = 0; i + 1 < count; i++) {
    panel p = panel_of(l, ends[i], ends[i + 1], parts);
    for (int c = 0; c < CHANNELS; c++) {
      rho[c] += p.rho[c];
      error[c] += fabs(p.rho[c] - (parts > 1 ? panels[i].rho[c] : p.middle[c]));
    }
    panels[i] = p;
  }
  for (int c = 0; c < CHANNELS; c++)
    worst = fmax(worst, error[c] += ROUNDING * rho[c]);
  return worst;
}

/* All panels are refined alike: to leave out those whose two rules agree would be to pick those
 * that agree by luck. */
void hetab_merl_energy(const hetab_merl *merl, hetab_reading lookup, double theta_i,
                       double tolerance, double rho[3], double error[3]) {
  light l = {.merl = merl, .lookup = lookup, .s = sin(theta_i), .c = cos(theta_i)};
  double ends[PANELS];
  panel panels[PANELS];
  size_t count = panels_of(&l, theta_i, ends);
  int parts = 1;
  fill_edges(lookup, &l.edges);
  while (refine(&l, ends, count, parts, panels, rho, error) > tolerance && parts < MOST_PARTS)
    parts *= 2;
}
