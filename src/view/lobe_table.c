#include "view/lobe_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "model/colour.h"

static const double pi = 3.14159265358979323846;
/* ln of the range of distances: lobes of 1e-4 in direction cosines are a hundredth of a degree. */
static const double grading = 9.5;
/* Luminance whose logarithm is kept, at least: 1/sr. */
static const double least = 1e-12;

double hetab_lobe_reach(double theta, double cos_psi) {
  double b = sin(theta) * cos_psi, c = cos(theta);
  return b + sqrt(b * b + c * c);
}

/* Geometric from the mirror point, and quadratic at the horizon, where angles are the arc cosine of
 * distances: both ends are where the BRDF changes fast. */
static double geometric(double t) {
  return expm1(grading * t) / expm1(grading);
}

double hetab_lobe_place(double t) {
  double rest = 1 - geometric(t);
  return 1 - rest * rest;
}

double hetab_lobe_place_slope(double t) {
  return 2 * (1 - geometric(t)) * grading * exp(grading * t) / expm1(grading);
}

/* The inverse, in nodes. */
static double node_of(double place, int nodes) {
  double near = place / (1 + sqrt(1 - place)); /* 1 - sqrt(1 - place) */
  return (nodes - 1) / grading * log1p(near * expm1(grading));
}

static void direction(const double q[2], float out[3]) {
  double z2 = 1 - q[0] * q[0] - q[1] * q[1];
  out[0] = (float)q[0];
  out[1] = (float)q[1];
  /* The model is 0 at 90 degrees sharp, of which no logarithm could be interpolated. */
  out[2] = (float)sqrt(fmax(z2, 4e-4));
}

static size_t node_count(hetab_lobe_size size) {
  return (size_t)size.rays * (size_t)size.nodes;
}

/* Directions of all nodes of one angle. */
static void aim(double theta, hetab_lobe_size size, float (*fixed)[3], float (*other)[3]) {
  for (int ray = 0; ray < size.rays; ray++) {
    double psi = pi * ray / (size.rays - 1), reach = hetab_lobe_reach(theta, cos(psi));
    for (int n = 0; n < size.nodes; n++) {
      double r = reach * hetab_lobe_place((double)n / (size.nodes - 1));
      double q[2] = {-sin(theta) + r * cos(psi), r * sin(psi)};
      size_t at = (size_t)(ray * size.nodes + n);
      direction(q, other[at]);
      fixed[at][0] = (float)sin(theta);
      fixed[at][1] = 0;
      fixed[at][2] = (float)cos(theta);
    }
  }
}

static hetab_lobe_node make_node(const float rgb[3]) {
  double y = hetab_luminance(rgb);
  hetab_lobe_node node = {.log = (float)log(fmax(y, least))};
  for (int c = 0; c < 3; c++)
    node.ratio[c] = y > least ? (float)((double)rgb[c] / y) : 0;
  return node;
}

static hetab_status fill_angle(hetab_context *ctx, const hetab_view_source *source, double theta,
                               hetab_lobe_size size, int fixed_is_wo, hetab_lobe_node *nodes) {
  size_t count = node_count(size);
  hetab_status status = HETAB_ERR_MEMORY;
  HETAB_FREED float(*memory)[3] = hetab_alloc(ctx, 3 * count, sizeof *memory);
  if (!memory)
    return status;
  float(*fixed)[3] = memory, (*other)[3] = memory + count, (*rgb)[3] = memory + 2 * count;
  aim(theta, size, fixed, other);
  status = fixed_is_wo ? source->eval(ctx, source, count, (const float(*)[3])other,
                                      (const float(*)[3])fixed, rgb)
                       : source->eval(ctx, source, count, (const float(*)[3])fixed,
                                      (const float(*)[3])other, rgb);
  for (size_t i = 0; i < count && status == HETAB_OK; i++)
    nodes[i] = make_node(rgb[i]);
  return status;
}

hetab_status hetab_lobe_table_create(hetab_context *ctx, const hetab_view_source *source,
                                     const double *theta, size_t count, hetab_lobe_size size,
                                     int fixed_is_wo, hetab_lobe_table *table) {
  hetab_status status = HETAB_ERR_MEMORY;
  *table = (hetab_lobe_table){.count = count, .size = size};
  table->theta = hetab_alloc(ctx, count, sizeof *table->theta);
  table->nodes = hetab_alloc(ctx, count * node_count(size), sizeof *table->nodes);
  if (!table->theta || !table->nodes)
    goto done;
  memcpy(table->theta, theta, count * sizeof *theta);
  for (size_t i = 0; i < count; i++)
    HETAB_GOTO(
        fill_angle(ctx, source, theta[i], size, fixed_is_wo, table->nodes + i * node_count(size)));
  return HETAB_OK;
done:
  hetab_lobe_table_clear(table);
  return status;
}

void hetab_lobe_table_clear(hetab_lobe_table *table) {
  free(table->theta);
  free(table->nodes);
  *table = (hetab_lobe_table){0};
}

/* ---- interpolation ------------------------------------------------------------------------- */

/* A ray: a cubic through four nodes (Catmull and Rom's) for the logarithm, a line for the colour.
 */
static void add_ray(const hetab_lobe_node *nodes, int count, double node, double weight,
                    hetab_lobe_node *sum) {
  int k = node < count - 2 ? (int)node : count - 2;
  double t = node - k;
  double before = (double)nodes[k > 0 ? k - 1 : 0].log, from = (double)nodes[k].log;
  double to = (double)nodes[k + 1].log, after = (double)nodes[k + 2 < count ? k + 2 : k + 1].log;
  double slope0 = k > 0 ? (to - before) / 2 : to - from;
  double slope1 = k + 2 < count ? (after - from) / 2 : to - from;
  double t2 = t * t, t3 = t2 * t;
  sum->log += (float)(weight * ((2 * t3 - 3 * t2 + 1) * from + (t3 - 2 * t2 + t) * slope0 +
                                (3 * t2 - 2 * t3) * to + (t3 - t2) * slope1));
  for (int c = 0; c < 3; c++)
    sum->ratio[c] +=
        (float)(weight * ((1 - t) * (double)nodes[k].ratio[c] + t * (double)nodes[k + 1].ratio[c]));
}

/* The table's angle number i, at polar coordinates about its mirror point. */
static void add_angle(const hetab_lobe_table *table, size_t i, double r, double psi, double reach,
                      double weight, hetab_lobe_node *sum) {
  const hetab_lobe_node *nodes = table->nodes + i * node_count(table->size);
  int count = table->size.nodes;
  double ray = psi / pi * (table->size.rays - 1);
  double node = node_of(fmin(reach > 0 ? r / reach : 1, 1), count);
  int ray0 = ray < table->size.rays - 2 ? (int)ray : table->size.rays - 2;
  double u = ray - ray0;
  add_ray(nodes + ray0 * count, count, node, weight * (1 - u), sum);
  add_ray(nodes + (ray0 + 1) * count, count, node, weight * u, sum);
}

void hetab_lobe_table_eval(const hetab_lobe_table *table, double theta, const double q[2],
                           float rgb[3]) {
  size_t i = 0;
  while (i + 2 < table->count && table->theta[i + 1] <= theta)
    i++;
  size_t next = i + 1 < table->count ? i + 1 : i;
  double span = table->theta[next] - table->theta[i];
  double w = span > 0 ? fmin(fmax((theta - table->theta[i]) / span, 0), 1) : 0;
  double x = q[0] + sin(theta), y = fabs(q[1]), r = hypot(x, y), psi = atan2(y, x);
  double reach = hetab_lobe_reach(theta, r > 0 ? x / r : 1);
  hetab_lobe_node sum = {0};
  add_angle(table, i, r, psi, reach, 1 - w, &sum);
  if (w > 0)
    add_angle(table, next, r, psi, reach, w, &sum);
  double luminance = exp((double)sum.log);
  for (int c = 0; c < 3; c++)
    rgb[c] = (float)(luminance * (double)sum.ratio[c]);
}
