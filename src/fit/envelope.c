/* The model's extremes over an interval of roughness: a scan of all samples, then a search about
 * the best. In ln sigma0 and ln tau, where the model has no feature much narrower than 1. */
#include <hetab/predict.h>

#include <math.h>
#include <stdlib.h>

#include "core/context.h"

enum { LEVELS = 7, STENCIL = 8, FEWEST = 17, MOST = 65, BATCH = 1 << 16 };
static const double sample_distance = 0.1; /* in the logarithm */

/* One side of the rectangle, u in [0, 1]. */
typedef struct side {
  hetab_interval interval;
  size_t samples; /* 1: no interval */
} side;

typedef struct envelope {
  hetab_context *ctx;
  hetab_engine *engine;
  side sigma0, tau;
  hetab_bounded quantity;
  hetab_point *points; /* [capacity] that are evaluated together, and what comes back */
  hetab_value *values;
  size_t capacity;
} envelope;

/* The best sample of a direction so far, above (sign 1) or below (-1). */
typedef struct extreme {
  double u[2];
  double value, sign;
  double fall[2]; /* to the worst neighbour, at the last level but one and at the last */
} extreme;

static double at(const side *s, double own, double u) {
  if (s->samples == 1)
    return own;
  if (u <= 0 || u >= 1) /* the ends exactly */
    return u <= 0 ? s->interval.low : s->interval.high;
  return s->interval.low * pow(s->interval.high / s->interval.low, u);
}

static hetab_point moved(const envelope *e, const hetab_point *point, const double u[2]) {
  hetab_point p = *point;
  p.sigma0_um = at(&e->sigma0, point->sigma0_um, u[0]);
  p.tau_um = at(&e->tau, point->tau_um, u[1]);
  return p;
}

static hetab_status evaluate(envelope *e, size_t count) {
  return hetab_evaluate(e->ctx, e->engine, e->points, count, e->values);
}

static double value_of(const envelope *e, size_t i) {
  return e->quantity == HETAB_BOUNDED_TOTAL ? e->values[i].total : e->values[i].specular;
}

/* ---- scanning ------------------------------------------------------------------------------ */

static double fraction(const side *s, size_t i) {
  return s->samples > 1 ? (double)i / (double)(s->samples - 1) : 0;
}

static size_t sample_count(const envelope *e) {
  return e->sigma0.samples * e->tau.samples;
}

static void place_of(const envelope *e, size_t sample, double u[2]) {
  u[0] = fraction(&e->sigma0, sample / e->tau.samples);
  u[1] = fraction(&e->tau, sample % e->tau.samples);
}

static void take(extreme *x, double value, const double u[2]) {
  if (x->sign * value > x->sign * x->value) {
    x->value = value;
    x->u[0] = u[0];
    x->u[1] = u[1];
  }
}

/* extremes[count][2]: the lowest and the highest sample of each point. */
static hetab_status scan(envelope *e, const hetab_point *points, size_t count, extreme *extremes) {
  size_t samples = sample_count(e);
  double u[2];
  for (size_t i = 0; i < count * samples; i++) {
    place_of(e, i % samples, u);
    e->points[i] = moved(e, &points[i / samples], u);
  }
  HETAB_TRY(evaluate(e, count * samples));
  for (size_t i = 0; i < count; i++) {
    extremes[2 * i] = (extreme){.value = HUGE_VAL, .sign = -1};
    extremes[2 * i + 1] = (extreme){.value = -HUGE_VAL, .sign = 1};
    for (size_t s = 0; s < samples; s++) {
      place_of(e, s, u);
      take(&extremes[2 * i], value_of(e, i * samples + s), u);
      take(&extremes[2 * i + 1], value_of(e, i * samples + s), u);
    }
  }
  return HETAB_OK;
}

/* ---- refining ------------------------------------------------------------------------------ */

/* On a line the neighbours are two, in a rectangle eight. */
static size_t stencil_of(const envelope *e) {
  return e->sigma0.samples > 1 && e->tau.samples > 1 ? STENCIL : 2;
}

/* The neighbours of the best sample, at a distance that halves with every level. */
static void neighbour(const envelope *e, const extreme *x, int which, double scale, double u[2]) {
  static const int steps[STENCIL][2] = {{-1, 0},  {1, 0},  {0, -1}, {0, 1},
                                        {-1, -1}, {-1, 1}, {1, -1}, {1, 1}};
  if (e->sigma0.samples == 1)
    which += 2;
  const side *sides[2] = {&e->sigma0, &e->tau};
  for (int i = 0; i < 2; i++) {
    double step = sides[i]->samples > 1 ? scale / (double)(sides[i]->samples - 1) : 0;
    u[i] = fmin(1, fmax(0, x->u[i] + step * steps[which][i]));
  }
}

static hetab_status refine_once(envelope *e, const hetab_point *points, size_t count,
                                extreme *extremes, double scale) {
  size_t stencil = stencil_of(e);
  double u[2];
  for (size_t i = 0; i < 2 * count * stencil; i++) {
    neighbour(e, &extremes[i / stencil], (int)(i % stencil), scale, u);
    e->points[i] = moved(e, &points[i / stencil / 2], u);
  }
  HETAB_TRY(evaluate(e, 2 * count * stencil));
  for (size_t i = 0; i < 2 * count; i++) {
    extreme *x = &extremes[i], before = *x;
    double worst = x->value;
    for (size_t s = 0; s < stencil; s++) {
      double value = value_of(e, i * stencil + s);
      neighbour(e, &before, (int)s, scale, u);
      take(x, value, u);
      worst = x->sign * value < x->sign * worst ? value : worst;
    }
    x->fall[0] = x->fall[1];
    x->fall[1] = fabs(x->value - worst);
  }
  return HETAB_OK;
}

/* What may lie between the samples of the last level. At an extreme inside, the fall is quadratic
 * in the distance, four times as large at twice of it, and a parabola rises above its best sample
 * by no more than a quarter of its second difference. At an end the fall is linear and nothing is
 * missed: twice the fall takes that part away. */
static double missed(const extreme *x) {
  return fabs(x->fall[0] - 2 * x->fall[1]) / 4;
}

static hetab_bounds bounds_of(double nominal, const extreme *pair) {
  double low = fmin(nominal, pair[0].value), high = fmax(nominal, pair[1].value);
  return (hetab_bounds){nominal, low, high, fmax(missed(&pair[0]), missed(&pair[1]))};
}

static hetab_status bound_batch(envelope *e, const hetab_point *points, size_t count,
                                extreme *extremes, hetab_bounds *out) {
  double scale = 1;
  HETAB_TRY(scan(e, points, count, extremes));
  for (int level = 0; level < LEVELS && sample_count(e) > 1; level++)
    HETAB_TRY(refine_once(e, points, count, extremes, scale /= 2));
  for (size_t i = 0; i < count; i++)
    e->points[i] = points[i];
  HETAB_TRY(evaluate(e, count));
  for (size_t i = 0; i < count; i++)
    out[i] = bounds_of(value_of(e, i), &extremes[2 * i]);
  return HETAB_OK;
}

/* ---- the whole ----------------------------------------------------------------------------- */

static hetab_status side_of(hetab_context *ctx, const hetab_interval *interval, const char *what,
                            side *out) {
  double low = interval->low, high = interval->high;
  *out = (side){*interval, 1};
  if (low == 0 && high == 0)
    return HETAB_OK;
  if (!(low > 0 && high >= low && isfinite(high)))
    return hetab_fail(
        ctx, HETAB_ERR_ARGUMENT,
        "%s: no interval from %g to %g um: give two lengths above 0, the smaller first", what, low,
        high);
  double wanted = ceil(log(high / low) / sample_distance) + 1;
  out->samples = high == low ? 2 : (size_t)fmin(MOST, fmax(FEWEST, wanted));
  return HETAB_OK;
}

static hetab_status bound_all(envelope *e, const hetab_point *points, size_t count,
                              hetab_bounds *out) {
  size_t samples = sample_count(e), most = 2 * stencil_of(e);
  most = samples > most ? samples : most;
  size_t batch = BATCH / most ? BATCH / most : 1;
  if (batch > count)
    batch = count;
  extreme *extremes = hetab_alloc(e->ctx, 2 * batch, sizeof *extremes);
  e->points = hetab_alloc(e->ctx, batch * most, sizeof *e->points);
  e->values = hetab_alloc(e->ctx, batch * most, sizeof *e->values);
  hetab_status status = extremes && e->points && e->values ? HETAB_OK : HETAB_ERR_MEMORY;
  for (size_t first = 0; first < count && status == HETAB_OK; first += batch) {
    size_t now = count - first < batch ? count - first : batch;
    status = bound_batch(e, points + first, now, extremes, out + first);
  }
  free(extremes);
  free(e->points);
  free(e->values);
  return status;
}

hetab_status hetab_envelope(hetab_context *ctx, hetab_engine *engine, const hetab_point *points,
                            size_t count, const hetab_roughness_bounds *bounds,
                            hetab_bounded quantity, hetab_bounds *out) {
  envelope e = {.ctx = ctx, .engine = engine, .quantity = quantity};
  HETAB_TRY(side_of(ctx, &bounds->sigma0_um, "sigma0", &e.sigma0));
  HETAB_TRY(side_of(ctx, &bounds->tau_um, "tau", &e.tau));
  return count ? bound_all(&e, points, count, out) : HETAB_OK;
}
