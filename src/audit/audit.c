#include <hetab/table.h>

#include "audit/audit_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/option_size.h"
#include "engine/sample.h"

static double or_default(double value, double otherwise) {
  return value > 0 ? value : otherwise;
}

hetab_status hetab_audit_options_take(hetab_context *ctx, const hetab_audit_options *options,
                                      hetab_audit_options *out) {
  HETAB_OPTIONS(ctx, hetab_audit_options, o, options);
  o.tolerance = or_default(o.tolerance, 1e-3);
  o.max_asymmetry = or_default(o.max_asymmetry, 1e-3);
  o.max_error = or_default(o.max_error, 0.25);
  o.max_missing = or_default(o.max_missing, 0.01);
  o.pairs = o.pairs ? o.pairs : 1000000;
  *out = o;
  return HETAB_OK;
}

hetab_status hetab_audit_new(hetab_context *ctx, hetab_audit_kind kind, const char *name,
                             hetab_audit **out) {
  hetab_audit *audit = *out = hetab_alloc(ctx, 1, sizeof *audit);
  HETAB_NEED(audit);
  audit->kind = kind;
  audit->separability = (double)NAN;
  audit->name = strdup(name);
  return audit->name ? HETAB_OK : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for a name");
}

hetab_status hetab_audit_size(hetab_context *ctx, hetab_audit *audit, size_t channels,
                              size_t incidences) {
  audit->channel_count = channels;
  audit->theta_count = incidences;
  audit->theta_i = hetab_alloc(ctx, incidences, sizeof *audit->theta_i);
  audit->energy = hetab_alloc(ctx, channels * incidences, sizeof *audit->energy);
  HETAB_NEED(audit->theta_i && audit->energy);
  for (size_t i = 0; i < channels * incidences; i++)
    audit->energy[i] = (hetab_energy){.fresnel = (double)NAN, .model = (double)NAN};
  return HETAB_OK;
}

void hetab_audit_whole_degrees(hetab_audit *audit) {
  for (size_t i = 0; i < audit->theta_count; i++)
    audit->theta_i[i] = hetab_radians((double)i);
}

void hetab_audit_free(hetab_audit *audit) {
  if (!audit)
    return;
  free(audit->name);
  free(audit->lambda_um);
  free(audit->theta_i);
  free(audit->energy);
  free(audit->bands);
  free(audit->against);
  free(audit->views);
  free(audit);
}

hetab_energy *hetab_audit_energy(const hetab_audit *audit, size_t channel, size_t theta) {
  return &audit->energy[channel * audit->theta_count + theta];
}

/* ---- checks -------------------------------------------------------------------------------- */

hetab_check *hetab_audit_add(hetab_audit *audit, const char *name, hetab_verdict verdict,
                             double value, double threshold, const char *format, ...) {
  hetab_check *check = &audit->checks[audit->check_count++];
  *check = (hetab_check){.name = name, .verdict = verdict, .value = value, .threshold = threshold};
  va_list args;
  va_start(args, format);
  vsnprintf(check->detail, sizeof check->detail, format, args);
  va_end(args);
  return check;
}

hetab_verdict hetab_audit_verdict(const hetab_audit *audit) {
  hetab_verdict worst = HETAB_PASS;
  for (size_t i = 0; i < audit->check_count; i++)
    worst = audit->checks[i].verdict > worst ? audit->checks[i].verdict : worst;
  return worst;
}

const hetab_check *hetab_audit_check(const hetab_audit *audit, const char *name) {
  for (size_t i = 0; i < audit->check_count; i++)
    if (strcmp(audit->checks[i].name, name) == 0)
      return &audit->checks[i];
  return NULL;
}

const char *hetab_audit_channel(const hetab_audit *audit, size_t channel, char text[24]) {
  static const char *const colours[] = {"red", "green", "blue"};
  if (!audit->lambda_um)
    return colours[channel % 3];
  snprintf(text, 24, "%.6g nm", 1000 * audit->lambda_um[channel]);
  return text;
}

/* rho_dh over its bound: how much is beyond the numerical error, where, and how often. */
typedef struct excess {
  double worst, error; /* rho_dh - bound; its error */
  size_t channel, theta, count, incidences;
  int known; /* the bound is, somewhere */
} excess;

static excess find_excess(const hetab_audit *audit, int over_fresnel, double allowed) {
  excess e = {.worst = -HUGE_VAL};
  for (size_t t = 0; t < audit->theta_count; t++) {
    int here = 0;
    for (size_t c = 0; c < audit->channel_count; c++) {
      const hetab_energy *energy = hetab_audit_energy(audit, c, t);
      double bound = over_fresnel ? energy->fresnel : 1, over = energy->dh - bound;
      if (isnan(bound))
        continue;
      e.known = 1;
      here |= over > energy->error + allowed;
      e.count += over > energy->error + allowed;
      if (over - energy->error > e.worst - e.error) {
        e.worst = over;
        e.error = energy->error;
        e.channel = c;
        e.theta = t;
      }
    }
    e.incidences += (size_t)here;
  }
  return e;
}

/* ", from 80 to 89 deg": the range of incidences at which the bound is broken. */
static void broken_range(const hetab_audit *audit, int over_fresnel, double allowed, char *text,
                         size_t size) {
  double first = (double)NAN, last = (double)NAN;
  for (size_t t = 0; t < audit->theta_count; t++)
    for (size_t c = 0; c < audit->channel_count; c++) {
      const hetab_energy *energy = hetab_audit_energy(audit, c, t);
      if (!(energy->dh - (over_fresnel ? energy->fresnel : 1) > energy->error + allowed))
        continue;
      first = isnan(first) ? hetab_degrees(audit->theta_i[t]) : first;
      last = hetab_degrees(audit->theta_i[t]);
    }
  snprintf(text, size, first == last ? ", at %.4g deg" : ", within %.4g to %.4g deg", first, last);
}

static void check_bound(hetab_audit *audit, const char *name, int over_fresnel,
                        hetab_verdict broken, double allowed) {
  char channel[24], range[64] = "";
  excess e = find_excess(audit, over_fresnel, allowed);
  if (!e.known)
    return;
  const hetab_energy *at = hetab_audit_energy(audit, e.channel, e.theta);
  if (e.count)
    broken_range(audit, over_fresnel, allowed, range, sizeof range);
  hetab_check *check = hetab_audit_add(
      audit, name, e.count ? broken : HETAB_PASS, at->dh, at->dh - e.worst + allowed,
      "rho_dh %.6g of %s %.6g at theta_i %.4g deg, %s", at->dh,
      over_fresnel ? "the polished material's" : "at most", at->dh - e.worst,
      hetab_degrees(audit->theta_i[e.theta]), hetab_audit_channel(audit, e.channel, channel));
  check->error = e.error;
  size_t used = strlen(check->detail);
  if (e.count)
    snprintf(check->detail + used, sizeof check->detail - used,
             "; too much in %zu of %zu values, %zu incidences%s", e.count,
             audit->theta_count * audit->channel_count, e.incidences, range);
}

void hetab_check_energy(hetab_audit *audit, double max_excess) {
  check_bound(audit, "energy", 0, HETAB_FAIL, max_excess);
}

void hetab_check_fresnel(hetab_audit *audit, double max_excess) {
  check_bound(audit, "fresnel", 1, HETAB_WARN, max_excess);
}

/* ---- symmetry ------------------------------------------------------------------------------ */

void hetab_symmetry_add(hetab_symmetry *s, double sums[2], double a, double b, int *is_worst) {
  double difference = fabs(a - b), larger = fmax(fabs(a), fabs(b));
  double relative = larger >= HETAB_FLOOR_PER_SR ? difference / larger : 0;
  s->compared++;
  s->mean_abs += difference;
  s->mean_rel += relative;
  s->max_abs = fmax(s->max_abs, difference);
  *is_worst = relative > s->max_rel;
  s->max_rel = fmax(s->max_rel, relative);
  sums[0] += (a - b) * (a - b);
  sums[1] += (a + b) * (a + b);
}

void hetab_symmetry_finish(hetab_symmetry *s, const double sums[2]) {
  if (!s->compared)
    return;
  s->mean_abs /= (double)s->compared;
  s->mean_rel /= (double)s->compared;
  s->norm = sums[0] + sums[1] > 0 ? sqrt(sums[0] / (sums[0] + sums[1])) : 0;
}

/* ---- progress ------------------------------------------------------------------------------ */

hetab_hush hetab_hush_begin(hetab_context *ctx) {
  hetab_hush hush = {ctx->progress};
  ctx->progress = NULL;
  return hush;
}

void hetab_hush_end(hetab_context *ctx, hetab_hush hush) {
  ctx->progress = hush.fn;
}

/* ---- names --------------------------------------------------------------------------------- */

const char *hetab_verdict_name(hetab_verdict verdict) {
  static const char *const names[] = {"PASS", "WARN", "FAIL"};
  return names[verdict];
}

const char *hetab_audit_kind_name(hetab_audit_kind kind) {
  static const hetab_format formats[] = {[HETAB_AUDIT_MERL] = HETAB_FORMAT_MERL,
                                         [HETAB_AUDIT_H5] = HETAB_FORMAT_H5,
                                         [HETAB_AUDIT_RGL] = HETAB_FORMAT_RGL};
  return kind == HETAB_AUDIT_SURFACE ? "surface" : hetab_format_word(formats[kind]);
}

const char *hetab_reading_name(hetab_reading lookup) {
  static const char *const names[] = {"default", "truncate", "interpolate"};
  return names[lookup];
}
