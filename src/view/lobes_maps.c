/* Lobes and hemisphere maps. */
#include <math.h>
#include <stdlib.h>

#include "core/context.h"
#include "view/pictures.h"

static const double pi = 3.14159265358979323846;

/* ---- lobes --------------------------------------------------------------------------------- */

static const double steepest = 89.5;

static int compare(const void *a, const void *b) {
  float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

/* Every half degree but 90, where the model is 0 and tables divide by a cosine; and 60 each way
 * from the mirror direction at steps that grow from 0.01. */
static void place_lobe(double theta_i_deg, float *theta_r_deg) {
  enum { EVEN = 359, NEAR = (HETAB_LOBE_POINTS - EVEN) / 2 };
  for (int i = 0; i < EVEN; i++)
    theta_r_deg[i] = (float)(0.5 * i - steepest);
  for (int i = 0; i < 2 * NEAR; i++) {
    double offset = 0.01 * expm1(0.12 * (i / 2 + 1)) / expm1(0.12) * (i % 2 ? 1 : -1);
    theta_r_deg[EVEN + i] = (float)fmin(fmax(theta_i_deg + offset, -steepest), steepest);
  }
  qsort(theta_r_deg, HETAB_LOBE_POINTS, sizeof *theta_r_deg, compare);
}

hetab_status hetab_view_make_lobe(hetab_context *ctx, const hetab_view_source *source,
                                  double theta_i, float *theta_r_deg, float (*rgb)[3]) {
  float wi[HETAB_LOBE_POINTS][3], wo[HETAB_LOBE_POINTS][3];
  place_lobe(theta_i * 180 / pi, theta_r_deg);
  for (int i = 0; i < HETAB_LOBE_POINTS; i++) {
    double theta_r = (double)theta_r_deg[i] * pi / 180;
    wi[i][0] = (float)-sin(theta_i);
    wi[i][1] = wo[i][1] = 0;
    wi[i][2] = (float)cos(theta_i);
    wo[i][0] = (float)sin(theta_r);
    wo[i][2] = (float)cos(theta_r);
  }
  return source->eval(ctx, source, HETAB_LOBE_POINTS, (const float(*)[3])wi, (const float(*)[3])wo,
                      rgb);
}

static const hetab_lobe_size map_size = {49, 128};

/* ---- maps ---------------------------------------------------------------------------------- */

/* Lambert's equal-area projection: radius sqrt(2) sin(theta / 2). */
static int map_direction(double x, double y, double *theta, double *azimuth) {
  double r2 = x * x + y * y;
  *theta = 2 * asin(fmin(sqrt(r2 / 2), 1));
  *azimuth = atan2(y, x);
  return r2 <= 1;
}

hetab_status hetab_view_make_map(hetab_context *ctx, const hetab_view_source *source,
                                 double theta_i, size_t side, float (*rgb)[3]) {
  hetab_lobe_table table;
  HETAB_TRY(hetab_lobe_table_create(ctx, source, &theta_i, 1, map_size, 0, &table));
  for (size_t i = 0; i < side * side; i++) {
    double theta, azimuth, half = (double)side / 2;
    double x = ((double)(i % side) + 0.5 - half) / half,
           y = (half - (double)(i / side) - 0.5) / half;
    rgb[i][0] = rgb[i][1] = rgb[i][2] = 0;
    if (!map_direction(x, y, &theta, &azimuth))
      continue;
    /* The table has the light at azimuth 0 and the mirror at 180 degrees. */
    const double q[2] = {-sin(theta) * cos(azimuth), sin(theta) * sin(azimuth)};
    hetab_lobe_table_eval(&table, theta_i, q, rgb[i]);
  }
  hetab_lobe_table_clear(&table);
  return HETAB_OK;
}
