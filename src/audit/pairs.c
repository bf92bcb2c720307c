#include "audit/pairs.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/number.h"
#include "core/random.h"
#include "engine/borrowed.h"
#include "engine/sample.h"

enum {
  MOST_CHANNELS = 3,
  LEVELS_PER_DECADE = 100,
  LOWEST_DECADE = -8
}; /* of relative errors: 1e-8 to 1e4 */

/* ---- sums ---------------------------------------------------------------------------------- */

static size_t level_of(double relative) {
  double level = (log10(fmax(relative, 1e-300)) - LOWEST_DECADE) * LEVELS_PER_DECADE;
  return level < 0 ? 0 : level < HETAB_ERROR_LEVELS ? (size_t)level : HETAB_ERROR_LEVELS - 1;
}

static void sum_add(hetab_error_sum *s, double value, double reference, double weight) {
  double error = value - reference;
  s->absolute += weight * fabs(error);
  s->bias += weight * error;
  s->reference += weight * reference;
  if (reference < HETAB_FLOOR_PER_SR)
    return;
  s->judged++;
  s->max = fmax(s->max, fabs(error) / reference);
  s->histogram[level_of(fabs(error) / reference)]++;
}

static void sum_merge(hetab_error_sum *to, const hetab_error_sum *from) {
  to->pairs += from->pairs;
  to->judged += from->judged;
  to->absolute += from->absolute;
  to->bias += from->bias;
  to->reference += from->reference;
  to->max = fmax(to->max, from->max);
  for (int i = 0; i < HETAB_ERROR_LEVELS; i++)
    to->histogram[i] += from->histogram[i];
}

/* The upper edge of the level, 2.3 % wide, below which that share of the errors lies. */
static double percentile(const hetab_error_sum *s, double share) {
  double wanted = share * (double)s->judged, seen = 0;
  for (int i = 0; i < HETAB_ERROR_LEVELS; i++)
    if ((seen += (double)s->histogram[i]) >= wanted)
      return fmin(pow(10, LOWEST_DECADE + (i + 1.0) / LEVELS_PER_DECADE), s->max);
  return s->max;
}

static hetab_table_error sum_result(const hetab_error_sum *s) {
  hetab_table_error e = {.pairs = s->pairs, .max = s->max};
  if (s->reference > 0) {
    e.relative_l1 = s->absolute / s->reference;
    e.bias = s->bias / s->reference;
  }
  e.p50 = percentile(s, 0.5);
  e.p95 = percentile(s, 0.95);
  e.p99 = percentile(s, 0.99);
  return e;
}

void hetab_pairs_finish(const hetab_pairs *pairs, hetab_against *against) {
  hetab_error_sum all = pairs->on_lobe;
  sum_merge(&all, &pairs->off_lobe);
  against->all = sum_result(&all);
  against->on_lobe = sum_result(&pairs->on_lobe);
  against->off_lobe = sum_result(&pairs->off_lobe);
  for (int bin = 0; bin < HETAB_ERROR_BINS; bin++)
    against->theta_i[bin] = sum_result(&pairs->theta_i[bin]);
  for (int i = 0; i < HETAB_ERROR_MAP; i++)
    for (int r = 0; r < HETAB_ERROR_MAP; r++) {
      const double *sums = pairs->map[i][r];
      against->map[i][r] = sums[1] > 0 ? sums[0] / sums[1] : (double)NAN;
    }
}

/* ---- drawing ------------------------------------------------------------------------------- */

/* An axis of directions: drawn values, ascending, with the density that each was drawn with. */
typedef struct drawn {
  size_t count;
  double *deg, *at, *density; /* degrees; sine of theta_r, or phi; per unit of `at` */
} drawn;

/* The q-th of `count` strata of [0, 1). */
static double stratum(uint64_t *random, size_t q, size_t count) {
  return ((double)q + hetab_random_unit(random)) / (double)count;
}

/* sin(theta_r): half as under uniform light, half within `reach` of sin(theta_i). */
static void draw_theta_r(uint64_t *random, double sin_i, double reach, drawn *d) {
  size_t half = d->count / 2;
  double low = fmax(sin_i - reach, 0), high = fmin(sin_i + reach, 1);
  for (size_t q = 0; q < d->count; q++)
    d->at[q] = q < half ? sqrt(stratum(random, q, half))
                        : low + (high - low) * stratum(random, q - half, d->count - half);
  hetab_sort(d->at, d->count);
  for (size_t q = 0; q < d->count; q++) {
    double s = d->at[q];
    d->density[q] = s + (s >= low && s <= high ? 0.5 / (high - low) : 0);
    d->deg[q] = asin(s) * 180 / M_PI;
  }
}

/* phi: half anywhere, half within `reach` of the mirror side. */
static void draw_phi(uint64_t *random, double reach, drawn *d) {
  size_t half = d->count / 2;
  for (size_t q = 0; q < d->count; q++)
    d->at[q] = q < half ? M_PI * stratum(random, q, half)
                        : M_PI - reach * stratum(random, q - half, d->count - half);
  hetab_sort(d->at, d->count);
  for (size_t q = 0; q < d->count; q++) {
    d->density[q] = 0.5 / M_PI + (M_PI - d->at[q] <= reach ? 0.5 / reach : 0);
    d->deg[q] = d->at[q] * 180 / M_PI;
  }
}

/* Grids ascend strictly: what rounding has made equal is moved apart. */
static void separate(drawn *d, double top) {
  for (size_t q = 1; q < d->count; q++)
    if (d->deg[q] <= d->deg[q - 1])
      d->deg[q] = nextafter(d->deg[q - 1], HUGE_VAL);
  for (size_t q = d->count; q-- > 0; top = nextafter(d->deg[q], 0))
    d->deg[q] = fmin(d->deg[q], top);
}

/* ---- one theta_i --------------------------------------------------------------------------- */

typedef struct sheet {
  hetab_context *ctx;
  hetab_engine *engine;
  const hetab_model *model;
  size_t first, channels, first_band, bands; /* of the table; of the model */
  hetab_pair_fn table;
  const void *user;
  hetab_pairs *pairs;
  hetab_surface *surface;
  hetab_grid *grid;
  drawn theta_r, phi;
  double theta_i;
  double *reference; /* [channel][theta_r][phi] */
} sheet;

/* Standard deviation of the lobe in the plane of direction cosines, at the middle band: the model
 * is a mixture over m, about g, of Gaussians of variance 2m / (2 pi tau / lambda)^2 an axis. */
static double lobe_width(const sheet *s) {
  const hetab_band *band = &s->model->bands[s->first_band + s->bands / 2];
  double wave = 2 * M_PI / band->lambda_um, cosine = cos(s->theta_i);
  double g = 4 * wave * wave * s->model->sigma0_um * s->model->sigma0_um * cosine * cosine;
  return sqrt(2 * fmax(g, 1)) / (wave * s->model->tau_um);
}

static hetab_status mix_slab(hetab_context *ctx, void *user, const hetab_slab *slab) {
  sheet *s = user;
  size_t count = s->theta_r.count * s->phi.count;
  for (size_t c = 0; c < s->channels; c++) {
    double weight =
        s->model->weights[(s->first + c) * s->model->band_count + s->first_band + slab->wavelength];
    double *to = s->reference + c * count;
    for (size_t i = 0; i < count && weight != 0; i++)
      to[i] += weight * hetab_slab_value(s->engine, slab->values, i);
  }
  return HETAB_OK;
}

static hetab_status evaluate_model(sheet *s) {
  hetab_tabulate_options options = {.samples = HETAB_NO_SAMPLES};
  double deg = s->theta_i * 180 / M_PI;
  memset(s->reference, 0, s->channels * s->theta_r.count * s->phi.count * sizeof *s->reference);
  HETAB_TRY(hetab_grid_set_values(s->ctx, s->grid, HETAB_THETA_I, &deg, 1));
  HETAB_TRY(
      hetab_grid_set_values(s->ctx, s->grid, HETAB_THETA_R, s->theta_r.deg, s->theta_r.count));
  HETAB_TRY(hetab_grid_set_values(s->ctx, s->grid, HETAB_PHI, s->phi.deg, s->phi.count));
  hetab_hush hush = hetab_hush_begin(s->ctx);
  hetab_status status =
      hetab_tabulate(s->ctx, s->engine, s->surface, s->grid, &options, mix_slab, s, NULL);
  hetab_hush_end(s->ctx, hush);
  return status;
}

static size_t bin_of(double radians, int bins) {
  int bin = (int)(radians / M_PI_2 * bins);
  return (size_t)(bin < bins ? bin : bins - 1);
}

/* Weighed as under uniform light: s / pi for each of two sides, over the density of the draw. */
static void compare_pair(sheet *s, size_t r, size_t p, double lobe) {
  double theta_r = s->theta_r.deg[r] * M_PI / 180, phi = s->phi.deg[p] * M_PI / 180;
  double sin_i = sin(s->theta_i), sin_r = s->theta_r.at[r], channels[MOST_CHANNELS];
  double weight = 2 * sin_r / M_PI / (s->theta_r.density[r] * s->phi.density[p]);
  double offset2 = sin_i * sin_i + sin_r * sin_r + 2 * sin_i * sin_r * cos(phi);
  hetab_error_sum *place = offset2 <= 4 * lobe * lobe ? &s->pairs->on_lobe : &s->pairs->off_lobe;
  double *map =
      s->pairs->map[bin_of(s->theta_i, HETAB_ERROR_MAP)][bin_of(theta_r, HETAB_ERROR_MAP)];
  int flip = (int)(hetab_random(&s->pairs->random) & 1); /* the other side of the plane */
  hetab_error_sum *bin = &s->pairs->theta_i[bin_of(s->theta_i, HETAB_ERROR_BINS)];
  place->pairs++;
  bin->pairs++;
  s->table(s->user, s->first, s->theta_i, theta_r, flip ? -phi : phi, channels);
  for (size_t c = 0; c < s->channels; c++) {
    /* out of gamut: tables hold 0 where a channel would be negative */
    double f = fmax(s->reference[(c * s->theta_r.count + r) * s->phi.count + p], 0);
    sum_add(place, channels[c], f, weight);
    sum_add(bin, channels[c], f, weight);
    map[0] += weight * fabs(channels[c] - f);
    map[1] += weight * f;
  }
}

static hetab_status run_sheet(sheet *s) {
  uint64_t *random = &s->pairs->random;
  double lobe = lobe_width(s), reach = fmin(4 * lobe, 1), sin_i = sin(s->theta_i);
  draw_theta_r(random, sin_i, reach, &s->theta_r);
  draw_phi(random, fmin(M_PI, reach / fmax(sin_i, 1e-3)), &s->phi);
  separate(&s->theta_r, 90);
  separate(&s->phi, 180);
  HETAB_TRY(evaluate_model(s));
  for (size_t r = 0; r < s->theta_r.count; r++)
    for (size_t p = 0; p < s->phi.count; p++)
      compare_pair(s, r, p, lobe);
  return HETAB_OK;
}

/* ---- all ----------------------------------------------------------------------------------- */

static hetab_status make_drawn(hetab_context *ctx, size_t count, drawn *d) {
  d->count = count;
  d->deg = hetab_alloc(ctx, 3 * count, sizeof *d->deg);
  d->at = d->deg + count;
  d->density = d->at + count;
  return d->deg ? HETAB_OK : HETAB_ERR_MEMORY;
}

hetab_status hetab_pairs_add(hetab_context *ctx, hetab_engine *engine, const hetab_model *model,
                             size_t first, size_t channels, size_t count, hetab_pair_fn table,
                             const void *user, hetab_pairs *pairs) {
  size_t side = (size_t)fmax(ceil(cbrt((double)count)), 2);
  bool own_bands = model->channel_count == model->band_count;
  size_t first_band = own_bands ? first : 0, bands = own_bands ? channels : model->band_count;
  sheet s = {.ctx = ctx,
             .model = model,
             .first = first,
             .channels = channels,
             .first_band = first_band,
             .bands = bands,
             .table = table,
             .user = user,
             .pairs = pairs};
  hetab_status status;
  HETAB_GOTO(hetab_engine_borrow_series(ctx, engine, &s.engine));
  HETAB_GOTO(make_drawn(ctx, side, &s.theta_r));
  HETAB_GOTO(make_drawn(ctx, side, &s.phi));
  HETAB_GOTO(hetab_grid_create(ctx, &s.grid));
  HETAB_GOTO(hetab_model_surface(ctx, model, first_band, bands, &s.surface));
  s.reference = hetab_alloc(ctx, channels * side * side, sizeof *s.reference);
  if (!s.reference)
    HETAB_GOTO(HETAB_ERR_MEMORY);
  for (size_t i = 0; i < side; i++) {
    s.theta_i = asin(sqrt(stratum(&pairs->random, i, side)));
    HETAB_GOTO(run_sheet(&s));
    HETAB_GOTO(
        hetab_progress(ctx, pairs->progress + pairs->progress_step * (double)(i + 1) / (double)side,
                       pairs->progress_total));
  }
done:
  hetab_engine_return(s.engine);
  free(s.reference);
  free(s.theta_r.deg);
  free(s.phi.deg);
  hetab_grid_free(s.grid);
  hetab_surface_free(s.surface);
  return status;
}
