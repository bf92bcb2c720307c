#include "lookup/half_sampler.h"

#include <math.h>
#include <stdlib.h>

enum {
  NODES = HETAB_SAMPLER_INCIDENCES,
  RINGS = HETAB_SAMPLER_RINGS,
  SECTORS = HETAB_SAMPLER_SECTORS,
  FINE = 4, /* points of a cell across rings, and along them */
  FINE_SECTORS = 2,
  COLUMNS = SECTORS * FINE_SECTORS,
  POINTS = RINGS * FINE * COLUMNS
};

static const float pi_f = 3.14159265358979f;
static const float cosine_share = 0.1f;

/* ---- frame --------------------------------------------------------------------------------- */

/* sin^2(theta_h) where a ring begins. */
static float ring_edge(float ring) {
  float u = ring / RINGS;
  return u * u * u * u;
}

/* Incidences are equally spaced in sqrt(cos(theta_i)), from grazing to normal: close together where
 * shadows begin; and about normal, where all is even in theta_i, linear in its square. */
static double cos_incidence(size_t node) {
  double root = (double)node / (NODES - 1);
  return fmax(root * root, 1e-4);
}

typedef struct between {
  size_t node;
  float fraction; /* towards the next */
} between;

static between incidence_of(float cos_i) {
  float x = sqrtf(fminf(fmaxf(cos_i, 0), 1)) * (NODES - 1);
  size_t node = x < NODES - 2 ? (size_t)x : NODES - 2;
  return (between){node, fminf(x - (float)node, 1)};
}

/* Unit vector along the incident direction's projection; x where there is none. */
static void azimuth_of(const float wi[3], float *x, float *y) {
  float length = sqrtf(wi[0] * wi[0] + wi[1] * wi[1]);
  *x = length > 1e-6f ? wi[0] / length : 1;
  *y = length > 1e-6f ? wi[1] / length : 0;
}

/* ---- making -------------------------------------------------------------------------------- */

typedef struct scratch {
  float (*wi)[3], (*wo)[3];
  double *weight; /* cos(theta_o) dwo: what a value counts */
  float *value;   /* [POINTS][channels] */
} scratch;

static hetab_status make_scratch(hetab_context *ctx, size_t channels, scratch *s) {
  s->wi = hetab_alloc(ctx, POINTS, sizeof *s->wi);
  s->wo = hetab_alloc(ctx, POINTS, sizeof *s->wo);
  s->weight = hetab_alloc(ctx, POINTS, sizeof *s->weight);
  s->value = hetab_alloc(ctx, POINTS, channels * sizeof *s->value);
  return s->wi && s->wo && s->weight && s->value ? HETAB_OK : HETAB_ERR_MEMORY;
}

static void clear_scratch(scratch *s) {
  free(s->wi);
  free(s->wo);
  free(s->weight);
  free(s->value);
}

/* Point p of the finer rings and sectors for the incidence in the plane y = 0. */
static void put_point(double cos_i, size_t p, scratch *s) {
  double fine = (double)(p / COLUMNS), low = fine / (RINGS * FINE);
  double high = (fine + 1) / (RINGS * FINE), middle = 0.5 * (low + high);
  double v = pow(middle, 4), width = pow(high, 4) - pow(low, 4);
  double phi = ((double)(p % COLUMNS) + 0.5) / COLUMNS * M_PI;
  double sin_i = sqrt(1 - cos_i * cos_i), side = sqrt(v), up = sqrt(1 - v);
  double h[3] = {side * cos(phi), side * sin(phi), up}, i_h = sin_i * h[0] + cos_i * up;
  double o[3] = {2 * i_h * h[0] - sin_i, 2 * i_h * h[1], 2 * i_h * up - cos_i};
  /* both signs of the azimuth; dh = dv dphi / (2 cos(theta_h)), dwo = 4 (wo.h) dh */
  double solid = 2 * width * M_PI / COLUMNS / (2 * up) * 4 * i_h;
  s->weight[p] = i_h > 0 && o[2] > 0 ? solid * o[2] : 0;
  for (int a = 0; a < 3; a++)
    s->wo[p][a] = (float)o[a];
  s->wi[p][0] = (float)sin_i;
  s->wi[p][1] = 0;
  s->wi[p][2] = (float)cos_i;
}

/* What each cell reflects, of all channels; the albedo on the way. */
static double cell_masses(const scratch *s, size_t channels, double (*mass)[SECTORS],
                          float *albedo) {
  double total = 0, sums[RINGS][SECTORS] = {{0}};
  for (size_t c = 0; c < channels; c++) {
    double sum = 0;
    for (size_t p = 0; p < POINTS; p++) {
      double part = s->weight[p] * (double)s->value[p * channels + c];
      sums[p / (COLUMNS * FINE)][p % COLUMNS / FINE_SECTORS] += part;
      sum += part;
    }
    albedo[c] = (float)sum;
    total += sum;
  }
  for (int r = 0; r < RINGS; r++)
    for (int k = 0; k < SECTORS; k++)
      mass[r][k] = sums[r][k];
  return total;
}

/* A black table's directions: as the cosine's. */
static double cosine_masses(const scratch *s, double (*mass)[SECTORS]) {
  double total = 0;
  for (size_t p = 0; p < POINTS; p++) {
    mass[p / (COLUMNS * FINE)][p % COLUMNS / FINE_SECTORS] += s->weight[p];
    total += s->weight[p];
  }
  return total;
}

static void tabulate(double (*mass)[SECTORS], double total, hetab_incidence *out) {
  double reached = 0;
  for (int r = 0; r < RINGS; r++) {
    double width = (double)ring_edge((float)(r + 1)) - (double)ring_edge((float)r), ring = 0;
    for (int k = 0; k < SECTORS; k++)
      ring += mass[r][k];
    double part = 0;
    for (int k = 0; k < SECTORS; k++) {
      out->sector_cdf[r][k] = ring > 0 ? (float)(part / ring) : 0;
      out->density[r][k] = (float)(mass[r][k] / total / (2 * width * M_PI / SECTORS));
      part += mass[r][k];
    }
    out->sector_cdf[r][SECTORS] = 1;
    out->ring_cdf[r] = (float)(reached / total);
    reached += ring;
  }
  out->ring_cdf[RINGS] = 1;
}

static void fill_incidence(size_t node, hetab_eval_fn eval, const void *user, scratch *s,
                           hetab_half_sampler *sampler) {
  double mass[RINGS][SECTORS] = {{0}};
  for (size_t p = 0; p < POINTS; p++)
    put_point(cos_incidence(node), p, s);
  eval(user, POINTS, (const float(*)[3])s->wi, (const float(*)[3])s->wo, s->value);
  double total =
      cell_masses(s, sampler->channels, mass, sampler->albedo + node * sampler->channels);
  if (!(total > 0))
    total = cosine_masses(s, mass);
  tabulate(mass, total, &sampler->incidences[node]);
}

hetab_status hetab_sampler_create(hetab_context *ctx, size_t channels, hetab_eval_fn eval,
                                  const void *user, hetab_half_sampler *sampler) {
  scratch s = {0};
  *sampler = (hetab_half_sampler){.channels = channels};
  sampler->incidences = hetab_alloc(ctx, NODES, sizeof *sampler->incidences);
  sampler->albedo = hetab_alloc(ctx, NODES * channels, sizeof *sampler->albedo);
  hetab_status status = make_scratch(ctx, channels, &s);
  if (!sampler->incidences || !sampler->albedo)
    status = HETAB_ERR_MEMORY;
  for (size_t node = 0; node < NODES && status == HETAB_OK; node++) {
    fill_incidence(node, eval, user, &s, sampler);
    status = hetab_progress(ctx, (double)(node + 1), NODES);
  }
  clear_scratch(&s);
  return status;
}

void hetab_sampler_clear(hetab_half_sampler *sampler) {
  free(sampler->incidences);
  free(sampler->albedo);
  *sampler = (hetab_half_sampler){0};
}

/* ---- drawing ------------------------------------------------------------------------------- */

/* The cell of x in cdf[count + 1], and in *x how far into it. */
static int find(const float *cdf, int count, float *x) {
  int low = 0;
  for (int step = count; step > 1;) {
    step = (step + 1) / 2;
    int next = low + step;
    low = next < count && cdf[next] <= *x ? next : low;
  }
  float width = cdf[low + 1] - cdf[low];
  *x = width > 0 ? fminf(fmaxf((*x - cdf[low]) / width, 0), 1) : 0.5f;
  return low;
}

/* u < share: 1, and u stretched over [0, 1) either way. */
static int choose(float *u, float share) {
  int chosen = *u < share;
  *u = chosen ? *u / share : (*u - share) / (1 - share);
  *u = fminf(fmaxf(*u, 0), 0.99999994f);
  return chosen;
}

static void draw_cosine(float u, float v, float wo[3]) {
  float side = sqrtf(u), phi = 2 * pi_f * v;
  wo[0] = side * cosf(phi);
  wo[1] = side * sinf(phi);
  wo[2] = sqrtf(1 - u);
}

static void draw_half(const hetab_incidence *incidence, const float wi[3], float u, float v,
                      float wo[3]) {
  float x, y, sign = choose(&v, 0.5f) ? 1 : -1;
  int ring = find(incidence->ring_cdf, RINGS, &u);
  int sector = find(incidence->sector_cdf[ring], SECTORS, &v);
  float low = ring_edge((float)ring), high = ring_edge((float)(ring + 1));
  float v_h = low + u * (high - low), phi = ((float)sector + v) * (pi_f / SECTORS);
  float side = sqrtf(v_h), along = side * cosf(phi), across = sign * side * sinf(phi);
  azimuth_of(wi, &x, &y);
  float h[3] = {along * x - across * y, along * y + across * x, sqrtf(1 - v_h)};
  float twice = 2 * (wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2]);
  for (int a = 0; a < 3; a++)
    wo[a] = twice * h[a] - wi[a];
}

float hetab_sampler_draw(const hetab_half_sampler *sampler, const float wi[3], const float u[2],
                         float wo[3]) {
  float first = u[0];
  between at = incidence_of(wi[2]);
  if (choose(&first, cosine_share)) {
    draw_cosine(first, u[1], wo);
  } else {
    size_t node = at.node + (size_t)choose(&first, at.fraction);
    draw_half(&sampler->incidences[node], wi, first, u[1], wo);
  }
  return hetab_sampler_pdf(sampler, wi, wo);
}

float hetab_sampler_pdf(const hetab_half_sampler *sampler, const float wi[3], const float wo[3]) {
  if (!(wi[2] > 0 && wo[2] > 0))
    return 0;
  float s[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]}, x, y;
  float lateral2 = s[0] * s[0] + s[1] * s[1], length2 = lateral2 + s[2] * s[2];
  int ring = (int)fminf(sqrtf(sqrtf(lateral2 / length2)) * RINGS, RINGS - 1);
  azimuth_of(wi, &x, &y);
  float along = s[0] * x + s[1] * y, across = s[1] * x - s[0] * y;
  int sector = (int)fminf(atan2f(fabsf(across), along) * (SECTORS / pi_f), SECTORS - 1);
  between at = incidence_of(wi[2]);
  const hetab_incidence *i = &sampler->incidences[at.node];
  float low = i[0].density[ring][sector], high = i[1].density[ring][sector];
  /* dv dphi = 2 cos(theta_h) dh, dh = dwo / (4 (wo.h)) */
  float lobe = (low + at.fraction * (high - low)) * s[2] / length2;
  return cosine_share * wo[2] / pi_f + (1 - cosine_share) * lobe;
}

void hetab_sampler_albedo(const hetab_half_sampler *sampler, const float wi[3], float *value) {
  size_t channels = sampler->channels;
  between at = incidence_of(wi[2]);
  const float *low = sampler->albedo + at.node * channels, *high = low + channels;
  for (size_t c = 0; c < channels; c++)
    value[c] = wi[2] > 0 ? low[c] + at.fraction * (high[c] - low[c]) : 0;
}
