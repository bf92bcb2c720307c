#include "view/lobe_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"

enum { NODES = HETAB_LOBE_NODES };

static const double pi = 3.14159265358979323846;
/* ln of the range of distances: lobes of 1e-4 in direction cosines are a hundredth of a degree. */
static const double grading = 10.5;
/* Luminance whose logarithm is kept, at least: 1/sr. */
static const double least = 1e-12;

double hetab_lobe_reach(double theta, double cos_psi) {
  double b = sin(theta) * cos_psi, c = cos(theta);
  return b + sqrt(b * b + c * c);
}

double hetab_lobe_place(double t) {
  return expm1(grading * t) / expm1(grading);
}

double hetab_lobe_place_slope(double t) {
  return grading * exp(grading * t) / expm1(grading);
}

/* The inverse, in nodes. */
static double node_of(double place) {
  return (NODES - 1) / grading * log1p(place * expm1(grading));
}

static void direction(const double q[2], float out[3]) {
  double z2 = 1 - q[0] * q[0] - q[1] * q[1];
  out[0] = (float)q[0];
  out[1] = (float)q[1];
  /* The model is 0 at 90 degrees sharp, of which no logarithm could be interpolated. */
  out[2] = (float)sqrt(fmax(z2, 4e-4));
}

/* Directions of all nodes of one angle. */
static void aim(double theta, int rays, float (*fixed)[3], float (*other)[3]) {
  for (int ray = 0; ray < rays; ray++) {
    double psi = pi * ray / (rays - 1), reach = hetab_lobe_reach(theta, cos(psi));
    for (int n = 0; n < NODES; n++) {
      double r = reach * hetab_lobe_place((double)n / (NODES - 1));
      double q[2] = {-sin(theta) + r * cos(psi), r * sin(psi)};
      size_t at = (size_t)(ray * NODES + n);
      direction(q, other[at]);
      fixed[at][0] = (float)sin(theta);
      fixed[at][1] = 0;
      fixed[at][2] = (float)cos(theta);
    }
  }
}

static hetab_lobe_node make_node(const float rgb[3]) {
  double y = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
  hetab_lobe_node node = {.log = (float)log(fmax(y, least))};
  for (int c = 0; c < 3; c++)
    node.ratio[c] = y > least ? (float)((double)rgb[c] / y) : 0;
  return node;
}

static hetab_status fill_angle(hetab_context *ctx, const hetab_view_source *source, double theta,
                               int rays, int fixed_is_wo, hetab_lobe_node *nodes) {
  size_t count = (size_t)rays * NODES;
  hetab_status status = HETAB_ERR_MEMORY;
  float(*memory)[3] = hetab_alloc(ctx, 3 * count, sizeof *memory);
  if (!memory)
    return status;
  float(*fixed)[3] = memory, (*other)[3] = memory + count, (*rgb)[3] = memory + 2 * count;
  aim(theta, rays, fixed, other);
  status = fixed_is_wo ? source->eval(ctx, source, count, (const float(*)[3])other,
                                      (const float(*)[3])fixed, rgb)
                       : source->eval(ctx, source, count, (const float(*)[3])fixed,
                                      (const float(*)[3])other, rgb);
  for (size_t i = 0; i < count && status == HETAB_OK; i++)
    nodes[i] = make_node(rgb[i]);
  free(memory);
  return status;
}

hetab_status hetab_lobe_table_create(hetab_context *ctx, const hetab_view_source *source,
                                     const double *theta, size_t count, int rays, int fixed_is_wo,
                                     hetab_lobe_table *table) {
  hetab_status status = HETAB_ERR_MEMORY;
  *table = (hetab_lobe_table){.count = count, .rays = rays};
  table->theta = hetab_alloc(ctx, count, sizeof *table->theta);
  table->nodes = hetab_alloc(ctx, count * (size_t)rays * NODES, sizeof *table->nodes);
  if (!table->theta || !table->nodes)
    goto done;
  memcpy(table->theta, theta, count * sizeof *theta);
  for (size_t i = 0; i < count; i++)
    HETAB_GOTO(fill_angle(ctx, source, theta[i], rays, fixed_is_wo,
                          table->nodes + i * (size_t)rays * NODES));
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

static void add_node(hetab_lobe_node *sum, const hetab_lobe_node *node, double weight) {
  sum->log += (float)weight * node->log;
  for (int c = 0; c < 3; c++)
    sum->ratio[c] += (float)weight * node->ratio[c];
}

/* The table's angle number i, at polar coordinates about its mirror point. */
static void add_angle(const hetab_lobe_table *table, size_t i, double r, double psi, double reach,
                      double weight, hetab_lobe_node *sum) {
  const hetab_lobe_node *nodes = table->nodes + i * (size_t)table->rays * NODES;
  double ray = psi / pi * (table->rays - 1), node = node_of(fmin(reach > 0 ? r / reach : 1, 1));
  int ray0 = ray < table->rays - 2 ? (int)ray : table->rays - 2,
      node0 = node < NODES - 2 ? (int)node : NODES - 2;
  double u = ray - ray0, v = node - node0;
  const hetab_lobe_node *corner = nodes + ray0 * NODES + node0;
  add_node(sum, corner, weight * (1 - u) * (1 - v));
  add_node(sum, corner + 1, weight * (1 - u) * v);
  add_node(sum, corner + NODES, weight * u * (1 - v));
  add_node(sum, corner + NODES + 1, weight * u * v);
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
