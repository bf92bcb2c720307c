/* Audits as one self-contained page. */
#include <math.h>
#include <stdlib.h>

#include "core/angle.h"
#include "core/number.h"
#include "audit_command.h"
#include "svg.h"

/* ---- channels ------------------------------------------------------------------------------ */

static const char *const channel_names[] = {"red", "green", "blue"};

/* Violet at 400 nm to red at 700 nm, or the channel's own. */
static const char *channel_colour(const hetab_audit *a, size_t channel, char text[48]) {
  static const double hues[] = {0, 130, 225};
  double hue = hues[channel % 3];
  if (a->lambda_um) {
    double first = a->lambda_um[0], range = a->lambda_um[a->channel_count - 1] - first;
    hue = range > 0 ? 280 * (1 - (a->lambda_um[channel] - first) / range) : 210;
  }
  snprintf(text, 48, "stroke:hsl(%.0f 70%% 52%%)", hue);
  return text;
}

static const char *channel_name(const hetab_audit *a, size_t channel, char text[24]) {
  if (!a->lambda_um)
    return channel_names[channel % 3];
  snprintf(text, 24, "%.6g nm", 1000 * a->lambda_um[channel]);
  return text;
}

/* ---- energy -------------------------------------------------------------------------------- */

static double largest_energy(const hetab_audit *a) {
  double most = 1;
  for (size_t i = 0; i < a->channel_count * a->theta_count; i++)
    most = fmax(most, a->energy[i].dh);
  return most;
}

static void energy_key(FILE *out, const hetab_audit *a) {
  char stroke[48], name[24];
  size_t step = a->channel_count > 5 ? (a->channel_count - 1) / 4 : 1;
  fputs("<div class=\"key\">", out);
  for (size_t c = 0; c < a->channel_count; c += step)
    svg_key(out, channel_colour(a, c, stroke), channel_name(a, c, name));
  svg_key(out, "stroke:var(--law)", "the law, 1");
  if (isfinite(a->energy[0].fresnel))
    fputs("<span>dashed: the polished material</span>", out);
  if (isfinite(a->energy[0].model))
    fputs("<span>dotted: the model without its specular delta</span>", out);
  fputs("</div>", out);
}

static void plot_energy(FILE *out, const hetab_audit *a) {
  char stroke[48], name[24], line[96];
  double top = fmin(largest_energy(a) * 1.05, 3), law[2] = {1, 1}, ends[2] = {0, M_PI_2};
  svg_plot p = {
      out, {"theta_i, degrees", 0, 90, 15, SVG_DEGREES}, {"rho_dh", 0, top, svg_step(top), 0}};
  svg_begin(&p, "Directional-hemispherical reflectance against incidence");
  for (size_t c = 0; c < a->channel_count; c++) {
    const hetab_energy *e = &a->energy[c * a->theta_count];
    size_t stride = sizeof *e / sizeof(double);
    channel_name(a, c, name);
    channel_colour(a, c, stroke);
    snprintf(line, sizeof line, "%s;stroke-dasharray:5 4;opacity:.55;stroke-width:1", stroke);
    svg_line(&p, a->theta_i, &e->fresnel, a->theta_count, stride, line, "polished material");
    snprintf(line, sizeof line, "%s;stroke-dasharray:1 3", stroke);
    svg_line(&p, a->theta_i, &e->model, a->theta_count, stride, line, "model");
    svg_line(&p, a->theta_i, &e->dh, a->theta_count, stride, stroke,
             a->lambda_um ? name : channel_names[c % 3]);
  }
  svg_line(&p, ends, law, 2, 1, "stroke:var(--law);stroke-width:1.2", "the law: 1");
  svg_end(&p);
}

_Static_assert(sizeof(hetab_energy) % sizeof(double) == 0, "read with a stride of doubles");

static size_t nearest_incidence(const hetab_audit *a, double theta_i) {
  size_t best = 0;
  for (size_t t = 1; t < a->theta_count; t++)
    if (fabs(a->theta_i[t] - theta_i) < fabs(a->theta_i[best] - theta_i))
      best = t;
  return best;
}

static const char *const view_strokes[HETAB_AUDIT_VIEWS] = {"stroke:var(--c0)", "stroke:var(--c1)",
                                                            "stroke:var(--c2)", "stroke:var(--c3)"};

enum { PLOT_POINTS = 512 }; /* more wavelengths than that are thinned out */

static void plot_spectrum(FILE *out, const hetab_audit *a) {
  static const double incidences[HETAB_AUDIT_VIEWS] = {0, 30, 60, 80};
  char line[96], title[48];
  if (!a->lambda_um || a->channel_count < 2)
    return;
  size_t last = a->channel_count - 1, step = last / PLOT_POINTS + 1, count = last / step + 1;
  double nm[PLOT_POINTS], top = fmin(largest_energy(a) * 1.05, 3);
  for (size_t i = 0; i < count; i++)
    nm[i] = 1000 * a->lambda_um[i * step];
  svg_plot p = {out,
                {"wavelength, nm", 1000 * a->lambda_um[0], 1000 * a->lambda_um[last],
                 svg_step(1000 * (a->lambda_um[last] - a->lambda_um[0])), 0},
                {"rho_dh", 0, top, svg_step(top), 0}};
  svg_begin(&p, "Spectrum at 0\u00b0, 30\u00b0, 60\u00b0, 80\u00b0 incidence (dashed: polished)");
  for (int i = 0; i < HETAB_AUDIT_VIEWS; i++) {
    size_t t = nearest_incidence(a, hetab_radians(incidences[i]));
    const hetab_energy *e = &a->energy[t];
    size_t stride = step * a->theta_count * sizeof *e / sizeof(double);
    snprintf(title, sizeof title, "theta_i %.4g deg", hetab_degrees(a->theta_i[t]));
    snprintf(line, sizeof line, "%s;stroke-dasharray:5 4;opacity:.6", view_strokes[i]);
    svg_line(&p, nm, &e->fresnel, count, stride, line, "polished material");
    svg_line(&p, nm, &e->dh, count, stride, view_strokes[i], title);
  }
  svg_end(&p);
}

/* ---- lobes --------------------------------------------------------------------------------- */

enum { DECADES = 6 }; /* of logarithmic plots, below the peak */

static double peak_of(const hetab_audit_view *view) {
  double peak = 0;
  for (int i = 0; i < HETAB_AUDIT_LOBE; i++)
    peak = fmax(peak, isfinite(view->lobe[i]) ? view->lobe[i] : 0);
  return peak;
}

static void plot_cartesian(FILE *out, const hetab_audit *a, int log_scale) {
  double deg[HETAB_AUDIT_LOBE], peak = 1e-30;
  char dashed[96], title[48];
  for (int i = 0; i < HETAB_AUDIT_LOBE; i++)
    deg[i] = -90 + 0.5 * i;
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++)
    peak = fmax(peak, peak_of(&a->views[v]));
  double top = log_scale ? pow(10, ceil(log10(peak))) : 1.05 * peak;
  svg_plot p = {out,
                {"theta_r, degrees (light from the left)", -90, 90, 30, 0},
                {"BRDF, 1/sr", log_scale ? top * pow(10, -DECADES) : 0, top,
                 log_scale ? 1 : svg_step(top), (svg_axis_kind)log_scale}};
  svg_begin(&p, log_scale ? "Lobes in the plane of incidence, logarithmic"
                          : "Lobes in the plane of incidence, linear");
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    snprintf(title, sizeof title, "theta_i %g deg", hetab_degrees(a->views[v].theta_i));
    snprintf(dashed, sizeof dashed, "%s;stroke-dasharray:2 3;opacity:.8", view_strokes[v]);
    svg_line(&p, deg, a->views[v].model, HETAB_AUDIT_LOBE, 1, dashed, "model");
    svg_line(&p, deg, a->views[v].lobe, HETAB_AUDIT_LOBE, 1, view_strokes[v], title);
  }
  svg_end(&p);
}

static double polar_radius(double value, double peak, int log_scale) {
  double relative = peak > 0 ? value / peak : 0;
  if (!log_scale)
    return relative;
  return relative > 0 ? fmax(0, 1 + log10(relative) / DECADES) : 0;
}

static void plot_polar(FILE *out, const hetab_audit *a, int log_scale) {
  static const char *const linear[] = {".25", ".5", ".75", "1"};
  static const char *const decades[] = {"1e-4", "1e-2", "1"};
  char title[48];
  svg_polar_begin(out,
                  log_scale ? "Lobes, polar, logarithmic, each over its peak"
                            : "Lobes, polar, linear, each over its peak",
                  log_scale ? decades : linear, log_scale ? 3 : 4);
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    double radius[HETAB_AUDIT_LOBE], peak = peak_of(&a->views[v]);
    for (int i = 0; i < HETAB_AUDIT_LOBE; i++)
      radius[i] = polar_radius(a->views[v].lobe[i], peak, log_scale);
    snprintf(title, sizeof title, "theta_i %g deg", hetab_degrees(a->views[v].theta_i));
    svg_polar_line(out, radius, HETAB_AUDIT_LOBE, view_strokes[v], title);
  }
  svg_polar_end(out);
}

static void view_key(FILE *out, const hetab_audit *a) {
  char text[48], name[24];
  fputs("<div class=\"key\">", out);
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++) {
    snprintf(text, sizeof text, "theta_i %g\u00b0", hetab_degrees(a->views[v].theta_i));
    svg_key(out, view_strokes[v], text);
  }
  fprintf(out, "<span>at %s%s</span></div>", channel_name(a, a->view_channel, name),
          a->against ? "; dotted: the model" : "");
}

/* ---- maps ---------------------------------------------------------------------------------- */

static void plot_hemisphere(FILE *out, const hetab_audit_view *view) {
  enum { CELLS = HETAB_AUDIT_MAP * HETAB_AUDIT_MAP };
  unsigned char levels[CELLS];
  const float *values = &view->map[0][0];
  double peak = 0;
  char caption[64];
  for (int i = 0; i < CELLS; i++)
    peak = fmax(peak, isfinite(values[i]) ? (double)values[i] : 0);
  for (int i = 0; i < CELLS; i++) {
    double at = 1 + log10(fmax((double)values[i], 1e-300) / peak) / DECADES;
    levels[i] =
        isfinite(values[i]) ? (unsigned char)(1 + fmax(0, at) * (HETAB_PAGE_LEVELS - 2)) : 0;
  }
  snprintf(caption, sizeof caption, "theta_i %g\u00b0, peak %.3g / sr",
           hetab_degrees(view->theta_i), peak);
  svg_map(out, levels, HETAB_AUDIT_MAP, HETAB_AUDIT_MAP, caption, "across the plane",
          "light side \u2190 \u2192 mirror side");
}

static void plot_hemispheres(FILE *out, const hetab_audit *a) {
  fputs(
      "<h3>The hemisphere on a square of equal solid angles</h3><p>Shirley and Chiu's concentric "
      "map: the normal in the middle, the horizon along the border. Colours are logarithmic, each "
      "map from its own peak down.</p>",
      out);
  svg_scale(out, "10<sup>-6</sup>", "peak");
  fputs("<div class=\"maps\">", out);
  for (int v = 0; v < HETAB_AUDIT_VIEWS; v++)
    plot_hemisphere(out, &a->views[v]);
  fputs("</div>\n", out);
}

/* 1e-4 to 1 of relative L1, light from below to above. */
static void plot_error_map(FILE *out, const hetab_against *against) {
  unsigned char levels[HETAB_ERROR_MAP * HETAB_ERROR_MAP];
  for (int row = 0; row < HETAB_ERROR_MAP; row++)
    for (int column = 0; column < HETAB_ERROR_MAP; column++) {
      double l1 = against->map[HETAB_ERROR_MAP - 1 - row][column];
      double at = fmin(1, fmax(0, 1 + log10(fmax(l1, 1e-9)) / 4));
      levels[row * HETAB_ERROR_MAP + column] =
          isfinite(l1) ? (unsigned char)(1 + at * (HETAB_PAGE_LEVELS - 2)) : 0;
    }
  svg_scale(out, "10<sup>-4</sup>", "1");
  fputs("<div class=\"maps\">", out);
  svg_map(out, levels, HETAB_ERROR_MAP, HETAB_ERROR_MAP, "Relative L1 error",
          "theta_i, 0 to 90\u00b0", "theta_r, 0 to 90\u00b0");
  fputs("</div>\n", out);
}

/* ---- tables -------------------------------------------------------------------------------- */

static void error_row(FILE *out, const char *name, const hetab_table_error *e) {
  fprintf(out,
          "<tr><td>%s</td><td>%zu</td><td>%.3g %%</td><td>%+.3g %%</td><td>%s %%</td><td>%.3g "
          "%%</td><td>%.3g %%</td><td>%.3g %%</td></tr>",
          name, e->pairs, 100 * e->relative_l1, 100 * e->bias, hetab_two_digits(100 * e->p50).text,
          100 * e->p95, 100 * e->p99, 100 * e->max);
}

static void write_error(FILE *out, const hetab_against *against) {
  char name[48];
  fputs("<h3>Table error as a renderer sees it</h3><div class=\"wide\"><table><tr><th>pairs"
        "</th><th>count</th><th>relative L1</th><th>bias</th><th>median</th><th>95th</th><th>99th"
        "</th><th>max</th></tr>",
        out);
  error_row(out, "all", &against->all);
  error_row(out, "on the lobe", &against->on_lobe);
  error_row(out, "off the lobe", &against->off_lobe);
  for (int i = 0; i < HETAB_ERROR_BINS; i++) {
    snprintf(name, sizeof name, "theta_i %d\u2013%d\u00b0", 10 * i, 10 * i + 10);
    error_row(out, name, &against->theta_i[i]);
  }
  fputs("</table></div>\n", out);
  plot_error_map(out, against);
}

static void write_bands(FILE *out, const hetab_audit *a) {
  if (!a->bands)
    return;
  fputs("<h3>Wavelengths</h3><div class=\"wide\"><table><tr><th>nm</th><th>a</th><th>largest a, "
        "1/sr</th><th>as reflectance</th><th>below polished</th><th>rho_dh, a in 1/sr</th><th>a as "
        "reflectance</th><th>specular share</th><th>at grazing</th><th>max, 1/sr</th></tr>",
        out);
  for (size_t c = 0; c < a->channel_count; c++) {
    const hetab_band_audit *b = &a->bands[c];
    fprintf(out,
            "<tr><td>%.6g</td><td>%.4g%s</td><td>%.4g</td><td>%.4g</td><td>%.4g</td><td>%.4g</td>"
            "<td>%.4g</td><td>%.3g %%</td><td>%+.3g %%</td><td>%.4g</td></tr>",
            1000 * a->lambda_um[c], b->a, b->a_is_brdf ? " / sr" : "", b->max_a_brdf,
            b->max_a_reflectance, b->max_a_fresnel, b->dh_if_brdf, b->dh_if_reflectance,
            100 * b->specular_share, 100 * b->grazing, b->max);
  }
  fputs("</table></div>\n", out);
}

static void write_checks(FILE *out, const hetab_audit *a) {
  fputs("<div class=\"checks\">", out);
  for (size_t i = 0; i < a->check_count; i++) {
    const hetab_check *c = &a->checks[i];
    const char *verdict = hetab_verdict_name(c->verdict);
    fprintf(out,
            "<div><span class=\"b %s\">%s</span><span>%s</span><span class=\"n\">%.4g</span><span "
            "class=\"d\">",
            verdict, verdict, c->name, c->value);
    hetab_page_text(out, c->detail);
    fputs("</span></div>", out);
  }
  fputs("</div>\n", out);
}

static void write_parameters(FILE *out, const hetab_audit *a) {
  fprintf(out, "<p>%s", hetab_audit_kind_name(a->kind));
  if (a->kind != HETAB_AUDIT_SURFACE)
    fprintf(out, ", lookup: %s", hetab_reading_name(a->lookup));
  if (a->sigma0_um > 0)
    fprintf(out, ", sigma0 %.6g \u00b5m, tau %.6g \u00b5m", a->sigma0_um, a->tau_um);
  if (a->channel_count && a->lambda_um)
    fprintf(out, ", %zu wavelengths, %.6g to %.6g nm", a->channel_count, 1000 * a->lambda_um[0],
            1000 * a->lambda_um[a->channel_count - 1]);
  fputs("</p>\n", out);
}

static void write_plots(FILE *out, const hetab_audit *a) {
  fputs("<h3>Energy</h3><div class=\"plots\">", out);
  plot_energy(out, a);
  plot_spectrum(out, a);
  fputs("</div>", out);
  energy_key(out, a);
  if (!a->views)
    return;
  fputs("<h3>Lobes</h3><div class=\"plots\">", out);
  for (int log_scale = 0; log_scale < 2; log_scale++) {
    plot_cartesian(out, a, log_scale);
    plot_polar(out, a, log_scale);
  }
  fputs("</div>", out);
  view_key(out, a);
  plot_hemispheres(out, a);
}

static void write_result(FILE *out, const audit_result *result) {
  const hetab_audit *a = result->audit;
  const char *verdict = hetab_verdict_name(hetab_audit_verdict(a));
  fputs("<section><h2>", out);
  hetab_page_text(out, result->input);
  fprintf(out, " <span class=\"b %s\">%s</span></h2>\n", verdict, verdict);
  write_parameters(out, a);
  write_checks(out, a);
  if (a->channel_count)
    write_plots(out, a);
  if (a->against)
    write_error(out, a->against);
  write_bands(out, a);
  fputs("</section>\n", out);
}

void audit_html(FILE *out, const audit_report *report) {
  size_t counts[3];
  audit_worst(report, counts);
  hetab_page_begin(out, "hetab audit", "hetab audit", "");
  fprintf(out, "<p>hetab %s: %zu pass, %zu warn, %zu fail</p>\n", hetab_version(),
          counts[HETAB_PASS], counts[HETAB_WARN], counts[HETAB_FAIL]);
  for (size_t i = 0; i < report->count; i++)
    write_result(out, &report->results[i]);
  hetab_page_end(out);
}
