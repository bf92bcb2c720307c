/* The audit of a table that is looked up by <hetab/lookup.h>: what a renderer gets of it, whatever
 * the format. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/lookup.h>

#include "audit/table_audit.h"
#include "core/number.h"
#include "core/random.h"

/* Of an incidence: directions drawn by Fibonacci lattices, most by the table's own samples, the
 * others from the cosine, which misses nothing; and how often, each time shifted at random, for the
 * error. */
enum { REPLICAS = 16, SAMPLED = 610, COSINE = 144, DRAWN = SAMPLED + COSINE };
enum { SAMPLED_STEP = 377, COSINE_STEP = 89 }; /* the numbers before them */

/* The delta is counted for itself. */
static const hetab_lookup_query WITHOUT_DELTA = {.without_delta = 1};

/* Standard errors of a mean of REPLICAS that are allowed for: beyond them lie 2 in 100,000, and
 * there may be thousands of incidences and channels. */
static const double CERTAIN = 6.0;
/* Float arithmetic of the look-ups, relative. */
static const double ROUNDING = 1e-5;
/* Formats that interpolate are as far from reciprocal as from what they tabulate: twice the usual
 * table error, in the same L1. */
static const double NOTICEABLE = 0.02;

/* Of pairs that should be equal: the integrals of |a - b| and of a under uniform light. */
typedef struct comparison {
  hetab_symmetry *symmetry;
  double sums[2], difference, all, worst_theta_i;
} comparison;

typedef struct job {
  hetab_context *ctx;
  const hetab_audit_options *options;
  hetab_audit *audit;
  hetab_lookup *table;
  uint64_t random;
  float *value, *other, *mirrored; /* [channel] */
  double *rho;                     /* [channel][REPLICAS] */
  comparison reciprocity, bilateral;
} job;

/* ---- directions ---------------------------------------------------------------------------- */

/* What rounding leaves of a cosine at 90 degrees is 0: nothing is seen there. */
static float cosine(double theta) {
  return theta < M_PI_2 ? (float)cos(theta) : 0.0f;
}

static void vectors(double theta_i, double theta_r, double phi, float wi[3], float wo[3]) {
  wi[0] = (float)sin(theta_i);
  wi[1] = 0.0f;
  wi[2] = cosine(theta_i);
  wo[0] = (float)(sin(theta_r) * cos(phi));
  wo[1] = (float)(sin(theta_r) * sin(phi));
  wo[2] = cosine(theta_r);
}

static void read_pair(const void *user, size_t first, double theta_i, double theta_r, double phi,
                      double *channels) {
  const job *j = user;
  bool spectral = j->audit->lambda_um != NULL;
  float wi[3], wo[3], value[3], lambda_um = spectral ? (float)j->audit->lambda_um[first] : 0.0f;
  const hetab_lookup_query query = {.lambda_um = &lambda_um, .lambda_count = 1};
  vectors(theta_i, theta_r, phi, wi, wo);
  hetab_lookup_eval(j->table, spectral ? &query : NULL, 1, wi, wo, value, NULL);
  for (size_t c = 0; c < (spectral ? 1 : j->audit->channel_count); c++)
    channels[c] = (double)value[c];
}

static float fraction(double x) {
  return fminf((float)(x - floor(x)), 0.99999994f);
}

/* The k-th of DRAWN. */
static void draw(job *j, int k, const double shift[3], const float wi[3], float wo[3]) {
  int at = k < SAMPLED ? k : k - SAMPLED, count = k < SAMPLED ? SAMPLED : COSINE;
  int step = k < SAMPLED ? SAMPLED_STEP : COSINE_STEP;
  float uc = fraction(shift[2] + at * M_SQRT2),
        u[2] = {fraction(shift[0] + (double)at / count),
                fraction(shift[1] + (double)(at * step % count) / count)};
  hetab_lookup_drawn drawn;
  if (k < SAMPLED) {
    hetab_lookup_sample(j->table, &WITHOUT_DELTA, 1, wi, &uc, u, &drawn, j->value);
    memcpy(wo, drawn.wo, sizeof drawn.wo);
    return;
  }
  double sine = sqrt((double)u[0]), phi = 2.0 * M_PI * (double)u[1];
  wo[0] = (float)(sine * cos(phi));
  wo[1] = (float)(sine * sin(phi));
  wo[2] = sqrtf(1.0f - u[0]);
}

/* ---- symmetry ------------------------------------------------------------------------------ */

static void compare(job *j, comparison *c, const float *other, double theta_i, double weight) {
  int worst;
  for (size_t k = 0; k < j->audit->channel_count; k++) {
    double a = (double)j->value[k], b = (double)other[k];
    hetab_symmetry_add(c->symmetry, c->sums, a, b, &worst);
    if (worst)
      c->worst_theta_i = theta_i;
    c->difference += weight * fabs(a - b);
    c->all += weight * a;
  }
}

static void survey_values(job *j) {
  hetab_cells *cells = &j->audit->cells;
  for (size_t c = 0; c < j->audit->channel_count; c++) {
    double value = (double)j->value[c];
    cells->total++;
    cells->nan += isnan(value) != 0;
    cells->infinite += isinf(value) != 0;
    if (!(value > 0.0 && isfinite(value)))
      continue;
    cells->min = cells->min > 0.0 ? fmin(cells->min, value) : value;
    cells->max = fmax(cells->max, value);
  }
}

/* With wo's share of the hemisphere, times its cosine. */
static void survey(job *j, double theta_i, const float wi[3], const float wo[3], double share) {
  double weight = share * sin(theta_i) * cos(theta_i);
  const float across[3] = {wo[0], -wo[1], wo[2]};
  survey_values(j);
  hetab_lookup_eval(j->table, NULL, 1, wo, wi, j->other, NULL);
  hetab_lookup_eval(j->table, NULL, 1, wi, across, j->mirrored, NULL);
  compare(j, &j->reciprocity, j->other, theta_i, weight);
  compare(j, &j->bilateral, j->mirrored, theta_i, weight);
}

static void judge_symmetry(job *j, const char *name, const char *what, comparison *c) {
  double least = fmax(j->options->max_asymmetry, NOTICEABLE);
  double found = c->all > 0.0 ? c->difference / c->all : 0.0;
  hetab_symmetry_finish(c->symmetry, c->sums);
  hetab_audit_add(j->audit, name, found > least ? HETAB_WARN : HETAB_PASS, found, least,
                  "%s as looked up: relative L1 %s %%; pairs differ by %.2g relative on average, "
                  "at most %.2g, at theta_i %.4g deg",
                  what, hetab_two_digits(100.0 * found).text, c->symmetry->mean_rel,
                  c->symmetry->max_rel, hetab_degrees(c->worst_theta_i));
}

/* ---- energy -------------------------------------------------------------------------------- */

/* One replica of the integrals of f cos(theta_r), by the density of both ways to draw. */
static void integrate(job *j, size_t theta, int replica) {
  double theta_i = j->audit->theta_i[theta];
  double shift[3];
  float wi[3], wo[3], pdf;
  vectors(theta_i, 0.0, 0.0, wi, wo);
  for (int i = 0; i < 3; i++)
    shift[i] = hetab_random_unit(&j->random);
  for (int k = 0; k < DRAWN; k++) {
    draw(j, k, shift, wi, wo);
    if (!(wo[2] > 0.0f))
      continue;
    hetab_lookup_eval(j->table, &WITHOUT_DELTA, 1, wi, wo, j->value, &pdf);
    double share = (double)wo[2] / (SAMPLED * (double)pdf + COSINE * (double)wo[2] / M_PI);
    for (size_t c = 0; c < j->audit->channel_count; c++)
      j->rho[c * REPLICAS + (size_t)replica] += share * (double)j->value[c];
    if (replica == 0)
      survey(j, theta_i, wi, wo, share);
  }
}

static void set_energy(const double rho[REPLICAS], double specular, hetab_energy *e) {
  double mean = 0.0, square = 0.0;
  for (int i = 0; i < REPLICAS; i++)
    mean += rho[i] / REPLICAS;
  for (int i = 0; i < REPLICAS; i++)
    square += (rho[i] - mean) * (rho[i] - mean);
  e->dd = mean;
  e->specular = specular;
  e->dh = mean + specular;
  e->error = CERTAIN * sqrt(square / (REPLICAS * (REPLICAS - 1))) + ROUNDING * e->dh;
}

static hetab_status fill_energy(job *j) {
  hetab_audit *audit = j->audit;
  double drawn = (double)audit->theta_count * REPLICAS * DRAWN;
  double total = j->options->against && !j->options->no_reference ? 2.0 * drawn : drawn;
  for (size_t t = 0; t < audit->theta_count; t++) {
    float wi[3], normal[3];
    memset(j->rho, 0, audit->channel_count * REPLICAS * sizeof *j->rho);
    for (int i = 0; i < REPLICAS; i++)
      integrate(j, t, i);
    vectors(audit->theta_i[t], 0.0, 0.0, wi, normal);
    hetab_lookup_albedo(j->table, NULL, 1, wi, NULL, j->value);
    for (size_t c = 0; c < audit->channel_count; c++)
      set_energy(j->rho + c * REPLICAS, (double)j->value[c], hetab_audit_energy(audit, c, t));
    HETAB_TRY(hetab_progress(j->ctx, drawn * (double)(t + 1) / (double)audit->theta_count, total));
  }
  return HETAB_OK;
}

/* ---- the audit ----------------------------------------------------------------------------- */

static void judge(job *j) {
  hetab_audit *audit = j->audit;
  hetab_cells *n = &audit->cells;
  size_t infinite = n->nan + n->infinite;
  n->negative = hetab_lookup_negative(j->table);
  hetab_audit_add(audit, "finite", infinite ? HETAB_FAIL : HETAB_PASS, (double)infinite, 0.0,
                  "%zu NaN and %zu infinite values of %zu looked up; the file holds none", n->nan,
                  n->infinite, n->total);
  hetab_audit_add(audit, "negative", n->negative ? HETAB_WARN : HETAB_PASS, (double)n->negative,
                  0.0,
                  "%zu negative numbers in the file, all small, are taken as 0; looked up, values "
                  "span %.3g to %.3g / sr",
                  n->negative, n->min, n->max);
  judge_symmetry(j, "reciprocity", "f(i, r) against f(r, i)", &j->reciprocity);
  hetab_audit_add(audit, "isotropy", HETAB_PASS, 0.0, 0.0,
                  "held by the format: the light has no azimuth of its own");
  judge_symmetry(j, "bilateral", "both sides of the plane of incidence", &j->bilateral);
  hetab_check_energy(audit, j->options->max_excess);
}

static hetab_status prepare(job *j) {
  hetab_audit *audit = j->audit;
  const double *lambda_um = hetab_lookup_wavelengths_um(j->table);
  size_t channels = audit->dims[0];
  HETAB_TRY(hetab_audit_size(j->ctx, audit, channels, HETAB_AUDIT_INCIDENCES));
  hetab_audit_whole_degrees(audit);
  audit->view_channel = channels / 2;
  audit->specular_cone = hetab_lookup_specular_cone(j->table);
  j->rho = hetab_alloc(j->ctx, channels * REPLICAS, sizeof *j->rho);
  j->value = hetab_alloc(j->ctx, 3 * channels, sizeof *j->value);
  if (lambda_um)
    audit->lambda_um = hetab_alloc(j->ctx, channels, sizeof *audit->lambda_um);
  if (!j->rho || !j->value || (lambda_um && !audit->lambda_um))
    return HETAB_ERR_MEMORY;
  if (lambda_um)
    memcpy(audit->lambda_um, lambda_um, channels * sizeof *lambda_um);
  j->other = j->value + channels;
  j->mirrored = j->other + channels;
  j->reciprocity.symmetry = &audit->reciprocity;
  j->bilateral.symmetry = &audit->bilateral;
  j->random = j->options->seed;
  return HETAB_OK;
}

hetab_status hetab_audit_lookup(hetab_context *ctx, hetab_engine *engine, const char *path,
                                const hetab_audit_options *o, hetab_audit *audit) {
  job j = {.ctx = ctx, .options = o, .audit = audit};
  hetab_status status;
  HETAB_TRY(hetab_lookup_open(ctx, path, HETAB_LOOKUP_INTERPOLATE, &j.table));
  audit->dims[0] = hetab_lookup_channel_count(j.table);
  hetab_audit_structure(audit);
  HETAB_GOTO(prepare(&j));
  HETAB_GOTO(fill_energy(&j));
  judge(&j);
  HETAB_GOTO(hetab_audit_compare(ctx, engine, o, read_pair, &j,
                                 (double)audit->theta_count * REPLICAS * DRAWN, audit));
done:
  free(j.rho);
  free(j.value);
  hetab_lookup_free(j.table);
  return status;
}
