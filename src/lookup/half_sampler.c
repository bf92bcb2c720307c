#include "lookup/half_sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/each.h"

enum {
  NODES = HETAB_SAMPLER_INCIDENCES,
  RINGS = HETAB_SAMPLER_RINGS,
  SECTORS = HETAB_SAMPLER_SECTORS,
  FINE = 4, /* points of a cell across rings, and along them */
  FINE_SECTORS = 2,
  COLUMNS = SECTORS * FINE_SECTORS,
  BLOCK = FINE * COLUMNS, /* a ring's points */
  SQUARE = 48             /* samples along either side */
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
double hetab_sampler_cos_i(size_t node) {
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

/* What a job of all incidences shares: half vectors of the points, by ring and column. */
typedef struct making {
  hetab_half_sampler *sampler;
  hetab_eval_fn eval; /* NULL: 1, for a black table's directions are the cosine's */
  hetab_weigh_fn weigh;
  const void *user;
  float side[RINGS * FINE], up[RINGS * FINE], solid[RINGS * FINE];
  float cosine[COLUMNS], sine[COLUMNS];
  float *scratch; /* [workers][scratch_size()] */
} making;

static size_t scratch_size(size_t channels) {
  return (BLOCK + 1) * channels;
}

static void make_points(making *m) {
  for (int r = 0; r < RINGS * FINE; r++) {
    double low = (double)r / (RINGS * FINE), high = (double)(r + 1) / (RINGS * FINE);
    double v = pow(0.5 * (low + high), 4), width = pow(high, 4) - pow(low, 4);
    m->side[r] = (float)sqrt(v);
    m->up[r] = (float)sqrt(1.0 - v);
    /* both signs of the azimuth; dh = dv dphi / (2 cos(theta_h)), dwo = 4 (wo.h) dh */
    m->solid[r] = (float)(2.0 * width * M_PI / COLUMNS / (2.0 * sqrt(1.0 - v)) * 4.0);
  }
  for (int c = 0; c < COLUMNS; c++) {
    m->cosine[c] = (float)cos((c + 0.5) / COLUMNS * M_PI);
    m->sine[c] = (float)sin((c + 0.5) / COLUMNS * M_PI);
  }
}

/* A ring's directions for wi in the plane y = 0, and cos(theta_o) dwo: what a value counts. */
static void put_block(const making *m, int ring, const float wi[3], float (*wis)[3], float (*wo)[3],
                      float *weight) {
  for (int p = 0; p < BLOCK; p++) {
    int r = ring * FINE + p / COLUMNS, c = p % COLUMNS;
    float h[3] = {m->side[r] * m->cosine[c], m->side[r] * m->sine[c], m->up[r]};
    float along = wi[0] * h[0] + wi[2] * h[2];
    for (int a = 0; a < 3; a++) {
      wis[p][a] = wi[a];
      wo[p][a] = 2 * along * h[a] - wi[a];
    }
    weight[p] = along > 0 && wo[p][2] > 0 ? m->solid[r] * along * wo[p][2] : 0;
  }
}

/* Adds up a sector's points, cell[channels]; returns the sum over channels. */
static double cell_mass(const float *weight, const float *value, size_t channels, int sector,
                        float *cell) {
  double sum = 0;
  memset(cell, 0, channels * sizeof *cell);
  for (int f = 0; f < FINE * FINE_SECTORS; f++) {
    int p = f / FINE_SECTORS * COLUMNS + sector * FINE_SECTORS + f % FINE_SECTORS;
    const float *v = value + (size_t)p * channels;
    for (size_t c = 0; c < channels && weight[p] > 0; c++)
      cell[c] += weight[p] * v[c];
  }
  for (size_t c = 0; c < channels; c++)
    sum += (double)cell[c];
  return sum;
}

/* What each cell reflects, of all channels; the albedo on the way. */
static double cell_masses(const making *m, size_t node, hetab_eval_fn eval, float *scratch,
                          double (*mass)[SECTORS]) {
  size_t channels = m->sampler->channels;
  double cos_i = hetab_sampler_cos_i(node), total = 0;
  const float wi[3] = {(float)sqrt(1 - cos_i * cos_i), 0, (float)cos_i};
  float wis[BLOCK][3], wo[BLOCK][3], weight[BLOCK], *cell = scratch + BLOCK * channels;
  float *albedo = m->sampler->albedo + node * channels;
  for (int r = 0; r < RINGS; r++) {
    put_block(m, r, wi, wis, wo, weight);
    for (size_t i = 0; i < BLOCK * channels && !eval; i++)
      scratch[i] = 1;
    if (eval)
      eval(m->user, BLOCK, wis[0], wo[0], scratch);
    for (int k = 0; k < SECTORS; k++) {
      total += mass[r][k] = cell_mass(weight, scratch, channels, k, cell);
      for (size_t c = 0; c < channels && eval; c++)
        albedo[c] += cell[c];
    }
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

static void fill_incidence(void *user, size_t node, int worker) {
  const making *m = user;
  double mass[RINGS][SECTORS];
  float *scratch = m->scratch + (size_t)worker * scratch_size(m->sampler->channels);
  double total = cell_masses(m, node, m->eval, scratch, mass);
  if (!(total > 0))
    total = cell_masses(m, node, NULL, scratch, mass);
  tabulate(mass, total, &m->sampler->incidences[node]);
}

/* The mean weight of samples that cover the square evenly. */
static void fill_albedo(void *user, size_t node, int worker) {
  const making *m = user;
  size_t channels = m->sampler->channels;
  float *weight = m->scratch + (size_t)worker * scratch_size(channels), *sum = weight + channels;
  float *albedo = m->sampler->albedo + node * channels;
  double cos_i = hetab_sampler_cos_i(node);
  const float wi[3] = {(float)sqrt(1 - cos_i * cos_i), 0, (float)cos_i};
  for (int row = 0; row < SQUARE; row++) {
    memset(sum, 0, channels * sizeof *sum);
    for (int column = 0; column < SQUARE; column++) {
      const float u[2] = {((float)column + 0.5f) / SQUARE, ((float)row + 0.5f) / SQUARE};
      m->weigh(m->user, wi, u, weight);
      for (size_t c = 0; c < channels; c++)
        sum[c] += weight[c];
    }
    for (size_t c = 0; c < channels; c++)
      albedo[c] += sum[c] / (SQUARE * SQUARE);
  }
}

static hetab_status make(hetab_context *ctx, making *m, hetab_piece_fn fill) {
  size_t channels = m->sampler->channels;
  m->sampler->albedo = hetab_alloc(ctx, NODES * channels, sizeof(float));
  m->scratch =
      hetab_alloc(ctx, (size_t)hetab_worker_count() * scratch_size(channels), sizeof *m->scratch);
  hetab_status status = HETAB_ERR_MEMORY;
  if (m->sampler->albedo && m->scratch)
    status = hetab_each(ctx, NODES, fill, m);
  free(m->scratch);
  return status;
}

hetab_status hetab_sampler_create(hetab_context *ctx, size_t channels, hetab_eval_fn eval,
                                  const void *user, hetab_half_sampler *sampler) {
  making m = {.sampler = sampler, .eval = eval, .user = user};
  *sampler = (hetab_half_sampler){.channels = channels};
  sampler->incidences = hetab_alloc(ctx, NODES, sizeof *sampler->incidences);
  HETAB_NEED(sampler->incidences);
  make_points(&m);
  return make(ctx, &m, fill_incidence);
}

hetab_status hetab_sampler_create_albedo(hetab_context *ctx, size_t channels, hetab_weigh_fn weigh,
                                         const void *user, hetab_half_sampler *sampler) {
  making m = {.sampler = sampler, .weigh = weigh, .user = user};
  *sampler = (hetab_half_sampler){.channels = channels};
  return make(ctx, &m, fill_albedo);
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

float hetab_sampler_draw(const hetab_half_sampler *sampler, const float wi[3], float uc,
                         const float u[2], float wo[3], hetab_lookup_lobe *lobe) {
  between at = incidence_of(wi[2]);
  *lobe = choose(&uc, cosine_share) ? HETAB_LOOKUP_DIFFUSE : HETAB_LOOKUP_GLOSSY;
  if (*lobe == HETAB_LOOKUP_DIFFUSE)
    draw_cosine(u[0], u[1], wo);
  else
    draw_half(&sampler->incidences[at.node + (size_t)choose(&uc, at.fraction)], wi, u[0], u[1], wo);
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

void hetab_sampler_between(const float *rows, size_t channels, float cos_i,
                           const hetab_band_places *places, float *value) {
  between at = incidence_of(cos_i);
  const float *low = rows + at.node * channels, *high = low + channels;
  size_t count = places ? places->count : channels;
  float upper[HETAB_BANDS_AT_ONCE];
  if (places) {
    hetab_band_values(places, channels, low, value);
    hetab_band_values(places, channels, high, upper);
    low = value;
    high = upper;
  }
  for (size_t c = 0; c < count; c++)
    value[c] = cos_i > 0 ? low[c] + at.fraction * (high[c] - low[c]) : 0;
}
