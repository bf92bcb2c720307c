/* The audit of a surface: what its reflectances say. */
#include <math.h>
#include <stdlib.h>

#include "audit/audit_internal.h"
#include "audit/surface_values.h"
#include "audit/views.h"
#include "surface/surface_parts.h"

/* Rounding of the specular and diffuse parts, which are closed forms in double. */
static const double closed_form_error = 1e-12;

/* ---- energy -------------------------------------------------------------------------------- */

static hetab_status fill_energy(hetab_context *ctx, hetab_engine *engine,
                                const hetab_surface *surface, hetab_audit *audit) {
  size_t count = audit->channel_count * audit->theta_count;
  HETAB_FREED hetab_reflectance *rho = hetab_alloc(ctx, count, sizeof *rho);
  hetab_status status =
      rho ? hetab_reflectance_dh(ctx, engine, surface, audit->theta_i, audit->theta_count, 0, rho)
          : HETAB_ERR_MEMORY;
  for (size_t i = 0; i < count && status == HETAB_OK; i++)
    audit->energy[i] = (hetab_energy){.dh = rho[i].dh,
                                      .error = rho[i].dd.error + closed_form_error,
                                      .dd = rho[i].dd.value,
                                      .specular = rho[i].specular,
                                      .ud = rho[i].ud,
                                      .fresnel = rho[i].fresnel,
                                      .model = (double)NAN};
  return status;
}

/* ---- bands --------------------------------------------------------------------------------- */

/* The number that was given for the band, in its unit. */
static double given_a(const hetab_surface *surface, size_t band) {
  return surface->diffuse_is_brdf ? surface->bands[band].diffuse_brdf
                                  : surface->bands[band].diffuse_brdf * M_PI;
}

/* The room that is left for a uniform-diffuse part. What the integral may be off by is taken from
 * it: a number that is promised to conserve energy must. */
static void fill_band(const hetab_audit *audit, const hetab_surface *surface, size_t band,
                      hetab_band_audit *out) {
  double without = 0, room = HUGE_VAL, room_fresnel = HUGE_VAL;
  for (size_t t = 0; t < audit->theta_count; t++) {
    const hetab_energy *e = hetab_audit_energy(audit, band, t);
    double rest = e->dd + e->specular;
    without = fmax(without, rest);
    room = fmin(room, 1 - rest - e->error);
    room_fresnel = fmin(room_fresnel, e->fresnel - rest - e->error);
    if (e->dh > 0)
      out->specular_share = fmax(out->specular_share, e->specular / e->dh);
    out->grazing = e->dh / e->fresnel - 1;
  }
  out->a = given_a(surface, band);
  out->a_is_brdf = surface->diffuse_is_brdf;
  out->max_a_reflectance = room;
  out->max_a_brdf = room / M_PI;
  out->max_a_fresnel = room_fresnel;
  out->dh_if_brdf = without + M_PI * out->a;
  out->dh_if_reflectance = without + out->a;
}

/* ---- checks -------------------------------------------------------------------------------- */

static void check_values(hetab_audit *audit) {
  hetab_cells *cells = &audit->cells;
  size_t bad = cells->nan + cells->infinite + cells->negative;
  for (size_t b = 0; b < audit->channel_count; b++) {
    const hetab_band_audit *band = &audit->bands[b];
    cells->min =
        cells->min > 0 && band->min > 0 ? fmin(cells->min, band->min) : fmax(cells->min, band->min);
    cells->max = fmax(cells->max, band->max);
  }
  hetab_audit_add(audit, "negative", bad ? HETAB_FAIL : HETAB_PASS, (double)bad, 0,
                  "%zu of %zu computed values NaN, infinite or negative; above 0 they span %.3g to "
                  "%.3g / sr, %.1f decades",
                  bad, cells->total, cells->min, cells->max,
                  cells->min > 0 ? log10(cells->max / cells->min) : 0.0);
}

static void check_reciprocity(hetab_audit *audit, double allowed, const char *where) {
  const hetab_symmetry *s = &audit->reciprocity;
  hetab_audit_add(audit, "reciprocity", s->max_rel > allowed ? HETAB_FAIL : HETAB_PASS, s->max_rel,
                  allowed,
                  "f(i, r) against f(r, i) as computed: at most %.2g relative, %.2g on "
                  "average%s%s",
                  s->max_rel, s->mean_rel, *where ? "; most at " : "", where);
}

static void check_specular(hetab_audit *audit) {
  size_t band = 0;
  char channel[24];
  for (size_t b = 1; b < audit->channel_count; b++)
    if (audit->bands[b].specular_share > audit->bands[band].specular_share)
      band = b;
  double share = audit->bands[band].specular_share;
  hetab_audit_add(audit, "specular", HETAB_PASS, share, 1,
                  "the specular delta carries at most %.3g %% of rho_dh (%s): tables without it "
                  "lack that",
                  100 * share, hetab_audit_channel(audit, band, channel));
}

/* More than the polished material at grazing is the model's own excess; less is its shadowing. */
static void check_grazing(hetab_audit *audit, double allowed) {
  size_t most = 0, least = 0, last = audit->theta_count - 1;
  for (size_t b = 1; b < audit->channel_count; b++) {
    most = audit->bands[b].grazing > audit->bands[most].grazing ? b : most;
    least = audit->bands[b].grazing < audit->bands[least].grazing ? b : least;
  }
  const hetab_energy *e = hetab_audit_energy(audit, most, last);
  double excess = audit->bands[most].grazing, error = e->error / e->fresnel;
  hetab_check *check = hetab_audit_add(
      audit, "grazing", excess > error + allowed ? HETAB_WARN : HETAB_PASS, excess, allowed,
      "at %.4g deg rho_dh is %+.3g to %+.3g %% off the polished material's",
      hetab_degrees(audit->theta_i[last]), 100 * audit->bands[least].grazing, 100 * excess);
  check->error = error;
}

static void check_diffuse(hetab_audit *audit) {
  size_t band = 0;
  char channel[24];
  for (size_t b = 1; b < audit->channel_count; b++)
    if (audit->bands[b].max_a_reflectance < audit->bands[band].max_a_reflectance)
      band = b;
  const hetab_band_audit *w = &audit->bands[band];
  double given = w->a_is_brdf ? M_PI * w->a : w->a;
  hetab_audit_add(audit, "diffuse", given > w->max_a_reflectance ? HETAB_FAIL : HETAB_PASS, given,
                  w->max_a_reflectance,
                  "a = %.4g %s; at most %.4g / sr = %.4g as reflectance conserves energy (%s); "
                  "read as 1/sr rho_dh reaches %.4g, as reflectance %.4g",
                  w->a, w->a_is_brdf ? "/ sr" : "(reflectance)", w->max_a_brdf,
                  w->max_a_reflectance, hetab_audit_channel(audit, band, channel), w->dh_if_brdf,
                  w->dh_if_reflectance);
}

/* ---- the audit ----------------------------------------------------------------------------- */

static hetab_status prepare(hetab_context *ctx, const hetab_surface *surface, hetab_audit *audit) {
  size_t bands = hetab_surface_band_count(surface);
  HETAB_TRY(hetab_audit_size(ctx, audit, bands, HETAB_AUDIT_INCIDENCES));
  hetab_audit_whole_degrees(audit);
  audit->lambda_um = hetab_alloc(ctx, bands, sizeof *audit->lambda_um);
  audit->bands = hetab_alloc(ctx, bands, sizeof *audit->bands);
  HETAB_NEED(audit->lambda_um && audit->bands);
  for (size_t b = 0; b < bands; b++)
    audit->lambda_um[b] = hetab_surface_bands(surface)[b].lambda_um;
  audit->sigma0_um = hetab_surface_sigma0_um(surface);
  audit->tau_um = hetab_surface_tau_um(surface);
  audit->view_channel = bands / 2;
  return HETAB_OK;
}

static hetab_status fill(hetab_context *ctx, hetab_engine *engine, const hetab_surface *surface,
                         const hetab_audit_options *o, hetab_audit *audit) {
  char where[HETAB_WHERE] = "";
  HETAB_TRY(prepare(ctx, surface, audit));
  HETAB_TRY(fill_energy(ctx, engine, surface, audit));
  HETAB_TRY(hetab_surface_values(ctx, engine, surface, audit, where));
  for (size_t b = 0; b < audit->channel_count; b++)
    fill_band(audit, surface, b, &audit->bands[b]);
  hetab_check_energy(audit, o->max_excess);
  hetab_check_fresnel(audit, o->max_excess);
  check_values(audit);
  check_reciprocity(audit, o->max_asymmetry, where);
  check_specular(audit);
  check_grazing(audit, o->max_excess);
  check_diffuse(audit);
  return o->views ? hetab_views_of_surface(ctx, engine, surface, audit) : HETAB_OK;
}

hetab_status hetab_audit_surface(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_surface *surface, const hetab_audit_options *options,
                                 hetab_audit **out) {
  hetab_audit_options o;
  hetab_audit *audit;
  *out = NULL;
  HETAB_TRY(hetab_audit_options_take(ctx, options, &o));
  hetab_status status =
      hetab_audit_new(ctx, HETAB_AUDIT_SURFACE, hetab_surface_name(surface), &audit);
  if (status == HETAB_OK)
    status = fill(ctx, engine, surface, &o, audit);
  *out = audit;
  HETAB_MADE(hetab_audit, out, status);
}
