/* Fits as a page: measurement and fit in the plane of incidence and over the hemisphere. */
#include <math.h>

#include "core/angle.h"
#include "cli.h"
#include "fit_command.h"
#include "svg.h"

enum { MOST_VIEWS = 3, MOST_INCIDENCES = 9, DECADES = 4, SIDE = 61 };

static const char *const strokes[MOST_VIEWS] = {"stroke:var(--c0)", "stroke:var(--c2)",
                                                "stroke:var(--c1)"};

/* A wavelength of a fit that is shown, with the fit's curves at the incidences shown. */
typedef struct view {
  const hetab_fit *fit;
  size_t band;              /* of the fit */
  hetab_prediction *curves; /* NULL: the fit has no surface */
} view;

typedef struct page {
  FILE *out;
  const fit_report *report;
  view views[MOST_VIEWS];
  size_t view_count;
  double theta_i[MOST_INCIDENCES];
  size_t incidence_count;
  double tolerance; /* of an incidence */
} page;

/* ---- what is shown ------------------------------------------------------------------------- */

static double view_um(const view *v) {
  return v->fit->lambda_um[v->band];
}

/* The fitted wavelength nearest to one. */
static view nearest_view(const fit_report *report, double lambda_um) {
  view best = {.fit = report->fits[0]};
  for (size_t f = 0; f < report->count; f++)
    for (size_t b = 0; b < report->fits[f]->bands; b++) {
      view v = {.fit = report->fits[f], .band = b};
      if (fabs(view_um(&v) - lambda_um) < fabs(view_um(&best) - lambda_um))
        best = v;
    }
  return best;
}

static void choose_views(page *p) {
  static const double wanted_um[MOST_VIEWS] = {0.45, 0.55, 0.65};
  for (int i = 0; i < MOST_VIEWS; i++) {
    view v = nearest_view(p->report, wanted_um[i]);
    int known = 0;
    for (size_t k = 0; k < p->view_count; k++)
      known |= p->views[k].fit == v.fit && p->views[k].band == v.band;
    if (!known)
      p->views[p->view_count++] = v;
  }
}

/* Evenly out of the fit's. */
static void choose_incidences(page *p) {
  const hetab_fit *fit = p->report->fits[0];
  size_t count = fit->incidence_count;
  p->incidence_count = count < MOST_INCIDENCES ? count : MOST_INCIDENCES;
  for (size_t i = 0; i < p->incidence_count; i++) {
    size_t place = p->incidence_count < 2 ? 0 : i * (count - 1) / (p->incidence_count - 1);
    p->theta_i[i] = fit->incidences[place].theta_i;
  }
}

static double from_incidence(const hetab_fit *fit, double theta_i) {
  double least = M_PI_2;
  for (size_t i = 0; i < fit->incidence_count; i++)
    least = fmin(least, fabs(fit->incidences[i].theta_i - theta_i));
  return least;
}

/* Where there are too many incidences each of the fit's stands for 5 degrees of them. */
static void find_tolerance(page *p) {
  const hetab_fit *fit = p->report->fits[0];
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  p->tolerance = hetab_radians(0.1);
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++)
    if (fit->used[i * fit->bands] && from_incidence(fit, pairs[i].theta_i) > hetab_radians(0.1))
      p->tolerance = hetab_radians(2.5);
}

static int is_at(const page *p, const hetab_directions *pair, double theta_i) {
  return fabs(pair->theta_i - theta_i) <= p->tolerance;
}

/* By the printed equations: a few thousand values, and no device. */
static hetab_status draw_curves(hetab_context *ctx, hetab_engine *engine, page *p) {
  for (size_t i = 0; i < p->view_count; i++) {
    view *v = &p->views[i];
    double lambda_um = view_um(v);
    hetab_predict_options options = {.theta_i = p->theta_i,
                                     .theta_i_count = p->incidence_count,
                                     .lambda_um = &lambda_um,
                                     .lambda_count = 1,
                                     .step = hetab_radians(1.0)};
    hetab_status status = HETAB_OK;
    if (v->fit->surface && p->incidence_count)
      status = hetab_predict(ctx, engine, v->fit->surface, &options, &v->curves);
    if (status != HETAB_OK)
      return status;
  }
  return HETAB_OK;
}

static double measured_at(const page *p, const view *v, size_t pair) {
  const hetab_measurements *m = p->report->measurements;
  return hetab_measurements_values(
      m)[pair * hetab_measurements_wavelength_count(m) + v->fit->band_of[v->band]];
}

static double model_at(const view *v, size_t pair) {
  return v->fit->model[pair * v->fit->bands + v->band];
}

/* ---- the plane of incidence ---------------------------------------------------------------- */

/* theta_r with the sign of the mirror's side, NaN outside the plane. */
static double plane_theta_r(const hetab_directions *pair) {
  if (pair->phi >= hetab_radians(179.5))
    return pair->theta_r;
  return pair->phi <= hetab_radians(0.5) || pair->theta_r == 0.0 ? -pair->theta_r : (double)NAN;
}

static double top_of(const page *p, const view *v, size_t incidence) {
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  double top = 0;
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++)
    if (is_at(p, &pairs[i], p->theta_i[incidence]) && isfinite(plane_theta_r(&pairs[i])))
      top = fmax(top, measured_at(p, v, i));
  for (size_t k = 0; v->curves && k < v->curves->theta_r_count; k++)
    top = fmax(top, v->curves->curves[incidence].f[k].nominal);
  return top > 0 ? top : 1;
}

static void draw_points(const svg_plot *plot, const page *p, const view *v, size_t incidence) {
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  char title[80];
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++) {
    if (!is_at(p, &pairs[i], p->theta_i[incidence]))
      continue;
    int used = v->fit->used[i * v->fit->bands + v->band];
    snprintf(title, sizeof title, "measured %.4g, fit %.4g%s", measured_at(p, v, i), model_at(v, i),
             used ? "" : ", not used");
    svg_point(plot, plane_theta_r(&pairs[i]), measured_at(p, v, i), 3,
              used ? "fill:var(--fg)" : "fill:var(--card);stroke:var(--fg)", title);
  }
}

static void plot_plane(const page *p, const view *v, size_t incidence, int log_scale) {
  enum { STRIDE = sizeof(hetab_bounds) / sizeof(double) };
  double top = top_of(p, v, incidence), end = log_scale ? pow(10, ceil(log10(top))) : top;
  char caption[96];
  svg_plot plot = {p->out,
                   {"theta_r, degrees (light from the left)", -90, 90, 30, SVG_DEGREES},
                   {"BRDF, 1/sr", log_scale ? end * pow(10, -DECADES) : 0,
                    log_scale ? end : 1.05 * end, log_scale ? 1 : svg_step(end),
                    (svg_axis_kind)log_scale}};
  snprintf(caption, sizeof caption, "theta_i %.4g\u00b0, %s", hetab_degrees(p->theta_i[incidence]),
           log_scale ? "logarithmic" : "linear");
  svg_begin(&plot, caption);
  if (v->curves)
    svg_line(&plot, v->curves->theta_r, &v->curves->curves[incidence].f->nominal,
             v->curves->theta_r_count, STRIDE, "stroke:var(--c1)", "fit");
  draw_points(&plot, p, v, incidence);
  svg_end(&plot);
}

/* ---- hemispheres --------------------------------------------------------------------------- */

/* The measured pair of an incidence whose view is nearest to direction cosines (x towards the
 * mirror's side, y across); (size_t)-1 if none is nearer than the usual distance of neighbours. */
static size_t nearest_pair(const page *p, const view *v, double theta_i, double x, double y) {
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  double least = 0.2 * 0.2;
  size_t best = (size_t)-1;
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++) {
    if (!is_at(p, &pairs[i], theta_i) || isnan(measured_at(p, v, i)))
      continue;
    double dx = x + sin(pairs[i].theta_r) * cos(pairs[i].phi);
    double dy = fabs(y) - sin(pairs[i].theta_r) * sin(pairs[i].phi);
    if (dx * dx + dy * dy < least) {
      least = dx * dx + dy * dy;
      best = i;
    }
  }
  return best;
}

enum { NOT_KNOWN = -1, NO_DIRECTION = -2 };

/* The pair that colours each pixel of a disc. */
static void find_pairs(const page *p, const view *v, double theta_i, long pairs[SIDE * SIDE]) {
  for (int row = 0; row < SIDE; row++)
    for (int column = 0; column < SIDE; column++) {
      double x = (2 * column + 1.0) / SIDE - 1, y = 1 - (2 * row + 1.0) / SIDE;
      long *pair = &pairs[row * SIDE + column];
      *pair = NO_DIRECTION;
      if (x * x + y * y > 1)
        continue;
      size_t nearest = nearest_pair(p, v, theta_i, x, y);
      *pair = nearest == (size_t)-1 ? NOT_KNOWN : (long)nearest;
    }
}

/* The measured values of an incidence, DECADES below the largest at least. */
static void find_range(const page *p, const view *v, double theta_i, double range[2]) {
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  range[0] = HUGE_VAL;
  range[1] = 0;
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++) {
    double value = measured_at(p, v, i);
    if (!is_at(p, &pairs[i], theta_i) || !(value > 0))
      continue;
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
  }
  range[0] = fmax(range[0], range[1] * pow(10, -DECADES));
}

static unsigned char level_of(double value, const double range[2]) {
  double at = log(fmax(value, range[0]) / range[0]) / log(range[1] / range[0]);
  return (unsigned char)(1 + fmin(1, at) * (HETAB_PAGE_LEVELS - 2));
}

static void plot_disc(const page *p, const view *v, const long *pairs, const double range[2],
                      int fitted, double theta_i) {
  unsigned char levels[SIDE * SIDE];
  char caption[96];
  for (int i = 0; i < SIDE * SIDE; i++) {
    size_t pair = (size_t)pairs[i];
    levels[i] = pairs[i] == NO_DIRECTION ? SVG_OUTSIDE
                : pairs[i] == NOT_KNOWN
                    ? 0
                    : level_of(fitted ? model_at(v, pair) : measured_at(p, v, pair), range);
  }
  snprintf(caption, sizeof caption, "%.4g\u00b0 %s, %.2g to %.2g / sr", hetab_degrees(theta_i),
           fitted ? "fit" : "measured", range[0], range[1]);
  svg_disc(p->out, levels, SIDE, caption);
}

static int is_hemisphere(const page *p) {
  const hetab_directions *pairs = hetab_measurements_pairs(p->report->measurements);
  for (size_t i = 0; i < hetab_measurements_pair_count(p->report->measurements); i++)
    if (isnan(plane_theta_r(&pairs[i])))
      return 1;
  return 0;
}

static void plot_hemispheres(const page *p, const view *v) {
  long pairs[SIDE * SIDE];
  double range[2];
  fputs("<h3>Over the hemisphere</h3><p>Seen from above: the distance from the centre is "
        "sin(theta_r), the rings are 30\u00b0, 60\u00b0 and 90\u00b0. Each direction has the "
        "colour of the nearest measured one, and the fit that of its value there; colours are "
        "logarithmic over the measured range.</p>",
        p->out);
  svg_scale(p->out, "lowest", "highest");
  fputs("<div class=\"maps\">", p->out);
  for (size_t i = 0; i < p->incidence_count; i++) {
    find_range(p, v, p->theta_i[i], range);
    if (!(range[1] > range[0]))
      continue;
    find_pairs(p, v, p->theta_i[i], pairs);
    for (int fitted = 0; fitted < 2; fitted++)
      plot_disc(p, v, pairs, range, fitted, p->theta_i[i]);
  }
  fputs("</div>\n", p->out);
}

static void write_view(const page *p, const view *v) {
  fprintf(p->out,
          "<section><h2>%.6g nm</h2><h3>In the plane of incidence</h3><div class=\"plots\">",
          1000 * view_um(v));
  for (size_t i = 0; i < p->incidence_count; i++)
    for (int log_scale = 0; log_scale < 2; log_scale++)
      plot_plane(p, v, i, log_scale);
  fputs("</div><div class=\"key\"><span>dots: measured, hollow where not used</span>", p->out);
  svg_key(p->out, "stroke:var(--c1)", "fit");
  fputs("</div>\n", p->out);
  if (is_hemisphere(p))
    plot_hemispheres(p, v);
  fputs("</section>\n", p->out);
}

/* ---- residuals ----------------------------------------------------------------------------- */

/* One fit stands for all its wavelengths. */
static size_t fits_shown(const page *p) {
  return p->report->count == 1 ? 1 : p->view_count;
}

static void plot_errors(const page *p) {
  double top = 0;
  char title[48];
  for (size_t k = 0; k < fits_shown(p); k++)
    for (size_t i = 0; i < p->views[k].fit->incidence_count; i++)
      top = fmax(top, 100 * p->views[k].fit->incidences[i].error);
  top = top > 0 ? top : 1;
  svg_plot plot = {p->out,
                   {"theta_i, degrees", 0, 90, 15, SVG_DEGREES},
                   {"E, %", 0, 1.05 * top, svg_step(top), 0}};
  svg_begin(&plot, "Residual by incidence");
  for (size_t k = 0; k < fits_shown(p); k++) {
    const hetab_fit *fit = p->views[k].fit;
    for (size_t i = 0; i < fit->incidence_count; i++) {
      const hetab_fit_incidence *in = &fit->incidences[i];
      double error = 100 * in->error;
      snprintf(title, sizeof title, "theta_i %.4g deg: E %.3g %%", hetab_degrees(in->theta_i),
               error);
      svg_point(&plot, in->theta_i, error, 3, "fill:var(--fg)", title);
      if (i > 0) {
        double x[2] = {in[-1].theta_i, in->theta_i}, y[2] = {100 * in[-1].error, error};
        svg_line(&plot, x, y, 2, 1, strokes[k], title);
      }
    }
  }
  svg_end(&plot);
}

/* The diffuse part, where there is one for each wavelength. */
static void plot_diffuse(const page *p) {
  const hetab_fit *first = p->report->fits[0], *last = p->report->fits[p->report->count - 1];
  double from = 1000 * first->lambda_um[0], to = 1000 * last->lambda_um[last->bands - 1], top = 0;
  if (!(to > from))
    return;
  for (size_t f = 0; f < p->report->count; f++)
    for (size_t b = 0; b < p->report->fits[f]->bands; b++)
      top = fmax(top, p->report->fits[f]->diffuse[b]);
  top = top > 0 ? top : 1;
  svg_plot plot = {p->out,
                   {"wavelength, nm", from, to, svg_step(to - from), 0},
                   {"a as a reflectance", 0, 1.05 * top, svg_step(top), 0}};
  svg_begin(&plot, "Diffuse part");
  for (size_t f = 0; f < p->report->count; f++) {
    const hetab_fit *fit = p->report->fits[f];
    for (size_t b = 0; b < fit->bands; b++) {
      char title[48];
      snprintf(title, sizeof title, "%.6g nm: %.4g", 1000 * fit->lambda_um[b], fit->diffuse[b]);
      svg_point(&plot, 1000 * fit->lambda_um[b], fit->diffuse[b], 3, "fill:var(--c1)", title);
    }
  }
  svg_end(&plot);
}

static void write_residual_key(const page *p) {
  char text[24];
  fputs("<div class=\"key\">", p->out);
  for (size_t k = 0; k < fits_shown(p) && p->report->count > 1; k++) {
    snprintf(text, sizeof text, "%.6g nm", 1000 * view_um(&p->views[k]));
    svg_key(p->out, strokes[k], text);
  }
  fputs("</div>", p->out);
}

static void write_incidences(const page *p, const hetab_fit *fit) {
  if (p->report->count > 1)
    fprintf(p->out, "<h3>%.6g nm</h3>", 1000 * fit->lambda_um[0]);
  fputs("<div class=\"wide\"><table><tr><th>theta_i</th><th>values</th><th>E</th><th>rms, 1/sr"
        "</th><th>bias, 1/sr</th><th>rho_dh</th><th>bound</th><th>margin</th><th>room for a</th>"
        "</tr>",
        p->out);
  for (size_t i = 0; i < fit->incidence_count; i++) {
    const hetab_fit_incidence *in = &fit->incidences[i];
    fprintf(p->out,
            "<tr><td>%.4g\u00b0</td><td>%zu</td><td>%.3g %%</td><td>%.3g</td><td>%+.2g</td>"
            "<td>%.5f</td><td>%.5f</td><td>%.2e</td><td>%.3g</td></tr>",
            hetab_degrees(in->theta_i), in->values, 100 * in->error, in->rms, in->bias, in->rho_dh,
            in->bound, in->margin, fmax(in->room, 0));
  }
  fputs("</table></div>\n", p->out);
}

/* ---- parameters ---------------------------------------------------------------------------- */

static void write_estimates(const page *p, const hetab_fit *fit) {
  fprintf(p->out,
          "<p>E %.3g %% (weights: %s), rms %.3g / sr, constraint %s%s; stopped: %s</p><div "
          "class=\"wide\"><table><tr><th>parameter</th><th>nm</th><th>value</th><th>95 %% from</th>"
          "<th>to</th><th>ended</th></tr>",
          100 * fit->error, hetab_fit_weights_name(fit->weights), fit->rms,
          hetab_fit_constraint_name(fit->constraint),
          fit->on_constraint ? ", on which the fit ends" : "", hetab_fit_stop_name(fit->stop));
  for (size_t i = 0; i < fit->estimate_count; i++) {
    const hetab_fit_estimate *e = &fit->estimates[i];
    double lambda_um = e->lambda_um > 0 || fit->bands > 1 ? e->lambda_um : fit->lambda_um[0];
    fprintf(p->out, "<tr><td>%s</td><td>", hetab_fit_quantity_name(e->quantity));
    if (lambda_um > 0)
      fprintf(p->out, "%.6g", 1000 * lambda_um);
    fprintf(p->out, "</td><td>%.5g</td><td>%.5g</td><td>%.5g</td><td>%s%s</td></tr>", e->value,
            e->low, e->high, hetab_fit_end_name(e->end), e->undetermined ? ", not determined" : "");
  }
  fputs("</table></div>\n", p->out);
  for (size_t i = 0; i < fit->note_count; i++) {
    fputs("<p>", p->out);
    hetab_page_text(p->out, fit->notes[i]);
    fputs("</p>\n", p->out);
  }
}

static void write_fits(const page *p) {
  for (size_t k = 0; k < fits_shown(p); k++) {
    if (p->report->count > 1)
      fprintf(p->out, "<h3>%.6g nm</h3>", 1000 * view_um(&p->views[k]));
    write_estimates(p, p->views[k].fit);
  }
  fputs("<div class=\"plots\">", p->out);
  plot_errors(p);
  plot_diffuse(p);
  fputs("</div>", p->out);
  write_residual_key(p);
  for (size_t k = 0; k < fits_shown(p); k++)
    write_incidences(p, p->views[k].fit);
}

/* ---- the page ------------------------------------------------------------------------------ */

static void write_page(const page *p) {
  hetab_page_begin(p->out, "hetab fit", "Fit to ",
                   hetab_measurements_name(p->report->measurements));
  fprintf(p->out, "<p>hetab %s, %s</p>\n", hetab_version(), p->report->device);
  write_fits(p);
  for (size_t i = 0; i < p->view_count; i++)
    write_view(p, &p->views[i]);
  hetab_page_end(p->out);
}

hetab_status fit_html(hetab_context *ctx, FILE *stream, const fit_report *report) {
  page p = {.out = stream, .report = report};
  HETAB_ENDS(hetab_engine_end) hetab_engine *engine = NULL;
  hetab_engine_options options = {.precision = HETAB_DOUBLE, .method = HETAB_METHOD_LITERAL};
  choose_views(&p);
  choose_incidences(&p);
  find_tolerance(&p);
  hetab_status status = hetab_engine_create(ctx, &options, &engine);
  if (status == HETAB_OK)
    status = draw_curves(ctx, engine, &p);
  if (status == HETAB_OK)
    write_page(&p);
  for (size_t i = 0; i < p.view_count; i++)
    hetab_prediction_free(p.views[i].curves);
  return status;
}
