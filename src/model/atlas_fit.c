#include "model/atlas_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HETAB_HOST
#include "kernels/hetab_lang.h"
#include "kernels/tables.h"
#include "model/model.h"
#include "model/polynomial.h"

void hetab_atlas_degrees(double tolerance, int vector_width, hetab_atlas *atlas) {
  double digits = -log10(tolerance);
  atlas->degree_x = digits <= 3.5 ? 8 : digits <= 5.8 ? 12 : digits <= 7.5 ? 16 : 24;
  /* 1/g is the sharpest dependence; from 1 to 1.5 its Chebyshev series falls by 9.9 a term */
  atlas->degree_g = (int)ceil(log(120.0 / tolerance) / log(9.9));
  atlas->pad_x = (atlas->degree_x + vector_width - 1) / vector_width * vector_width;
  atlas->pad_g = (atlas->degree_g + vector_width - 1) / vector_width * vector_width;
}

/* An atlas being made. */
typedef struct maker {
  hetab_context *ctx;
  hetab_atlas *atlas;
  double tolerance;
  hetab_fitter x, g; /* of degree_x and degree_g coefficients */
} maker;

/* Where ln h(g, x) has fallen to ln_h_end, or a little beyond. */
static double end_of_x(double g, double ln_h_end) {
  double low = 0, high = 1;
  while (hetab_ln_h(g, high) > ln_h_end)
    high *= 2;
  for (int i = 0; i < 12; i++) {
    double middle = 0.5 * (low + high);
    if (hetab_ln_h(g, middle) > ln_h_end)
      low = middle;
    else
      high = middle;
  }
  return high;
}

/* ln h at the nodes of [a, b]. */
static void sample_x(const maker *m, double g, double a, double b, double *values) {
  for (int k = 0; k < m->x.count; k++)
    values[k] = hetab_ln_h(g, 0.5 * (a + b) + 0.5 * (b - a) * m->x.node[k]);
}

/* Do degree_x coefficients reach the tolerance on [a, b] at this g? Judged by the last three. */
static int converges(const maker *m, double g, double a, double b) {
  double values[HETAB_MOST_DEGREE], c[HETAB_MOST_DEGREE];
  int count = m->x.count;
  sample_x(m, g, a, b, values);
  hetab_chebyshev(&m->x, values, c);
  return fabs(c[count - 1]) + fabs(c[count - 2]) + fabs(c[count - 3]) < m->tolerance;
}

/* One segment's tensor product: nodes in u and t, then powers of both. */
static void fit_segment(const maker *m, double g_centre, double g_half, double a, double b,
                        double *table) {
  double values[HETAB_MOST_DEGREE], c[HETAB_MOST_DEGREE][HETAB_MOST_DEGREE];
  for (int k = 0; k < m->g.count; k++) {
    sample_x(m, g_centre + g_half * m->g.node[k], a, b, values);
    hetab_chebyshev(&m->x, values, c[k]);
    hetab_to_powers(&m->x, c[k]);
  }
  for (int j = 0; j < m->x.count; j++) {
    double column[HETAB_MOST_DEGREE];
    for (int k = 0; k < m->g.count; k++)
      values[k] = c[k][j];
    hetab_chebyshev(&m->g, values, column);
    hetab_to_powers(&m->g, column);
    for (int k = 0; k < m->g.count; k++)
      table[k * m->atlas->pad_x + j] = column[k];
  }
}

static hetab_status add_segment(const maker *m, double g_centre, double g_half, double a,
                                double b) {
  hetab_atlas *atlas = m->atlas;
  size_t n = atlas->segment_count;
  size_t table = (size_t)atlas->degree_g * (size_t)atlas->pad_x;
  if ((n & (n - 1)) == 0) { /* full at powers of two */
    size_t room = n ? 2 * n : 1;
    double *segments = realloc(atlas->segments, room * HETAB_SEGMENT_REALS * sizeof(double));
    if (segments)
      atlas->segments = segments;
    double *coefficients = realloc(atlas->coefficients, room * table * sizeof(double));
    if (coefficients)
      atlas->coefficients = coefficients;
    if (!segments || !coefficients)
      return hetab_fail(m->ctx, HETAB_ERR_MEMORY, "out of memory for the series' polynomials");
  }
  double *head = atlas->segments + n * HETAB_SEGMENT_REALS;
  head[HETAB_SEGMENT_START] = a;
  head[HETAB_SEGMENT_CENTRE] = 0.5 * (a + b);
  head[HETAB_SEGMENT_SCALE] = 2.0 / (b - a);
  memset(atlas->coefficients + n * table, 0, table * sizeof(double));
  fit_segment(m, g_centre, g_half, a, b, atlas->coefficients + n * table);
  /* the largest constant apart, exactly, as a factor */
  head[HETAB_SEGMENT_H] = exp(atlas->coefficients[n * table]);
  atlas->coefficients[n * table] = 0.0;
  atlas->segment_count++;
  return HETAB_OK;
}

/* Segments from x = 0 on, each as long as converges where h is sharpest, at the panel's smallest
 * g; lengths by trial, doubling and halving from the last one. */
static hetab_status build_panel(const maker *m, double g_low, double g_high, double *panel) {
  const hetab_atlas *atlas = m->atlas;
  double end = fmax(end_of_x(g_low, atlas->ln_h_end), end_of_x(g_high, atlas->ln_h_end));
  double a = 0, length = end;
  panel[HETAB_PANEL_FIRST] = (double)atlas->segment_count;
  panel[HETAB_PANEL_CENTRE] = 0.5 * (g_low + g_high);
  panel[HETAB_PANEL_SCALE] = 2.0 / (g_high - g_low);
  panel[HETAB_PANEL_X_END] = end;
  panel[HETAB_PANEL_START] = g_low;
  while (a < end) {
    double b = fmin(a + 1.5 * length, end);
    while (!converges(m, g_low, a, b) && b - a > 1e-4 * end)
      b = a + 0.7 * (b - a);
    length = b - a;
    HETAB_TRY(add_segment(m, panel[HETAB_PANEL_CENTRE], 0.5 * (g_high - g_low), a, b));
    a = end - b < 1e-9 * end ? end : b;
  }
  panel[HETAB_PANEL_COUNT] = (double)atlas->segment_count - panel[HETAB_PANEL_FIRST];
  return HETAB_OK;
}

static double panel_start(int number) {
  return ldexp(number & 1 ? 1.5 : 1.0, (number >> 1) - 127);
}

hetab_status hetab_atlas_build(hetab_context *ctx, double g_min, double g_max, double tolerance,
                               hetab_atlas *atlas) {
  atlas->first_panel = hetab_panel_number(g_min);
  atlas->panel_count = (size_t)(hetab_panel_number(g_max) - atlas->first_panel) + 1;
  atlas->panels = hetab_alloc(ctx, atlas->panel_count, HETAB_PANEL_REALS * sizeof(double));
  HETAB_NEED(atlas->panels);
  maker m = {.ctx = ctx, .atlas = atlas, .tolerance = tolerance};
  hetab_fitter_make(atlas->degree_x, &m.x);
  hetab_fitter_make(atlas->degree_g, &m.g);
  for (int p = 0; p < (int)atlas->panel_count; p++)
    HETAB_TRY(build_panel(&m, panel_start(atlas->first_panel + p),
                          panel_start(atlas->first_panel + p + 1),
                          atlas->panels + p * HETAB_PANEL_REALS));
  return HETAB_OK;
}

hetab_status hetab_atlas_transpose(hetab_context *ctx, const hetab_atlas *atlas, double **out) {
  size_t nx = (size_t)atlas->degree_x, ng = (size_t)atlas->degree_g;
  size_t pad_x = (size_t)atlas->pad_x, pad_g = (size_t)atlas->pad_g;
  *out = hetab_alloc(ctx, atlas->segment_count, nx * pad_g * sizeof **out);
  HETAB_NEED(*out);
  for (size_t s = 0; s < atlas->segment_count; s++)
    for (size_t j = 0; j < nx; j++)
      for (size_t k = 0; k < ng; k++)
        (*out)[(s * nx + j) * pad_g + k] = atlas->coefficients[(s * ng + k) * pad_x + j];
  return HETAB_OK;
}

void hetab_atlas_clear(hetab_atlas *atlas) {
  free(atlas->panels);
  free(atlas->segments);
  free(atlas->coefficients);
  *atlas = (hetab_atlas){0};
}
