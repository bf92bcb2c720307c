/* Predictions as one self-contained page. */
#include <math.h>
#include <string.h>

#include "core/angle.h"
#include "predict_command.h"
#include "svg.h"

enum { DECADES = 5 }; /* of logarithmic plots, below the peak */

/* Blue at the normal to red at grazing. */
static void colour_of(const predict_report *r, size_t incidence, const char *what, char text[48]) {
  double last = r->theta_i_count > 1 ? (double)(r->theta_i_count - 1) : 1;
  snprintf(text, 48, "%s:hsl(%.0f 75%% 44%%)", what, 215 - 205 * (double)incidence / last);
}

/* Of all that is drawn of the curve. */
static double highest(const predict_report *r, size_t index) {
  double top = 0;
  for (size_t i = 0; i < r->prediction->theta_r_count; i++) {
    top = fmax(top, r->prediction->curves[index].f[i].high);
    if (r->with_tau)
      top = fmax(top, r->with_tau->curves[index].f[i].high);
  }
  return top;
}

static double highest_point(const hetab_prediction *p, size_t curve) {
  double top = 0;
  for (size_t i = 0; i < p->point_count; i++)
    if (p->points[i].curve == curve && p->points[i].in_plane)
      top = fmax(top, p->points[i].measured);
  return top;
}

static svg_plot plot_to(FILE *out, double top, int log_scale) {
  double end = top > 0 ? top : 1;
  if (log_scale)
    end = pow(10, ceil(log10(end)));
  return (svg_plot){out,
                    {"theta_r, degrees (light from the left)", -90, 90, 30, SVG_DEGREES},
                    {"BRDF, 1/sr", log_scale ? end * pow(10, -DECADES) : 0,
                     log_scale ? end : 1.05 * end, log_scale ? 1 : svg_step(end),
                     (svg_axis_kind)log_scale}};
}

static void draw_curve(const svg_plot *plot, const predict_report *r, size_t index) {
  enum { STRIDE = sizeof(hetab_bounds) / sizeof(double) };
  const hetab_prediction *p = r->prediction;
  const hetab_prediction_curve *curve = &p->curves[index];
  char style[96], title[64];
  snprintf(title, sizeof title, "theta_i %.4g deg, %.6g nm", hetab_degrees(curve->theta_i),
           1000 * curve->lambda_um);
  colour_of(r, index % r->theta_i_count, "fill", style);
  svg_band(plot, p->theta_r, &curve->f->low, &curve->f->high, p->theta_r_count, STRIDE, style,
           title);
  colour_of(r, index % r->theta_i_count, "stroke", style);
  svg_line(plot, p->theta_r, &curve->f->nominal, p->theta_r_count, STRIDE, style, title);
  if (!r->with_tau)
    return;
  strcat(style, ";stroke-dasharray:4 3;stroke-width:1");
  const hetab_bounds *f = r->with_tau->curves[index].f;
  svg_line(plot, p->theta_r, &f->low, p->theta_r_count, STRIDE, style, title);
  svg_line(plot, p->theta_r, &f->high, p->theta_r_count, STRIDE, style, title);
}

/* Filled: within the bounds. */
static void draw_points(const svg_plot *plot, const predict_report *r, size_t curve) {
  const hetab_prediction *p = r->prediction;
  char title[96];
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_predicted_point *point = &p->points[i];
    if (point->curve != curve || !point->in_plane)
      continue;
    snprintf(title, sizeof title, "measured %.4g, predicted %.4g (%.4g to %.4g)", point->measured,
             point->f.nominal, point->f.low, point->f.high);
    svg_point(plot, point->plane_theta_r, point->measured, 3,
              point->side ? "fill:var(--card);stroke:var(--fail);stroke-width:1.4"
                          : "fill:var(--fg)",
              title);
  }
}

/* ---- sections ------------------------------------------------------------------------------ */

static void plot_all(FILE *out, const predict_report *r, size_t wavelength, int log_scale) {
  size_t first = wavelength * r->theta_i_count;
  double top = 0;
  for (size_t i = 0; i < r->theta_i_count; i++)
    top = fmax(top, highest(r, first + i));
  svg_plot plot = plot_to(out, top, log_scale);
  svg_begin(&plot, log_scale ? "All incidences, logarithmic" : "All incidences, linear");
  for (size_t i = 0; i < r->theta_i_count; i++)
    draw_curve(&plot, r, first + i);
  svg_end(&plot);
}

static void plot_one(FILE *out, const predict_report *r, size_t index, int log_scale) {
  const hetab_prediction_curve *curve = &r->prediction->curves[index];
  char caption[96];
  svg_plot plot =
      plot_to(out, fmax(highest(r, index), highest_point(r->prediction, index)), log_scale);
  snprintf(caption, sizeof caption, "theta_i %.4g\u00b0, %s", hetab_degrees(curve->theta_i),
           log_scale ? "logarithmic" : "linear");
  svg_begin(&plot, caption);
  draw_curve(&plot, r, index);
  draw_points(&plot, r, index);
  svg_end(&plot);
}

static void write_key(FILE *out, const predict_report *r) {
  char style[48], text[48];
  fputs("<div class=\"key\">", out);
  for (size_t i = 0; i < r->theta_i_count; i++) {
    colour_of(r, i, "stroke", style);
    snprintf(text, sizeof text, "theta_i %.4g\u00b0",
             hetab_degrees(r->prediction->curves[i].theta_i));
    svg_key(out, style, text);
  }
  fputs("<span>shaded: between the bounds</span>", out);
  if (r->with_tau)
    fputs("<span>dashed: bounds of the same slopes by tau</span>", out);
  if (r->measurements)
    fputs("<span>dots: measured, hollow where outside the bounds</span>", out);
  fputs("</div>\n", out);
}

static void write_wavelength(FILE *out, const predict_report *r, size_t wavelength) {
  size_t first = wavelength * r->theta_i_count;
  fprintf(out, "<section><h2>%.6g nm</h2>\n", 1000 * r->prediction->curves[first].lambda_um);
  write_key(out, r);
  fputs("<div class=\"plots\">", out);
  for (int log_scale = 0; log_scale < 2; log_scale++)
    plot_all(out, r, wavelength, log_scale);
  int scales = r->measurements ? 2 : 1; /* without points one curve alone is seen well enough */
  for (size_t i = 0; i < r->theta_i_count; i++)
    for (int log_scale = 0; log_scale < scales; log_scale++)
      plot_one(out, r, first + i, log_scale);
  fputs("</div></section>\n", out);
}

/* ---- tables -------------------------------------------------------------------------------- */

static void write_count(FILE *out, const char *where, const hetab_prediction_count *count) {
  if (count->points)
    fprintf(out,
            "<tr><td>%s</td><td>%zu</td><td>%zu (%.1f %%)</td><td>%zu</td><td>%zu</td>"
            "<td>%+.1f %%</td></tr>",
            where, count->points, count->within,
            100 * (double)count->within / (double)count->points, count->below, count->above,
            100 * count->bias);
}

static void write_counts(FILE *out, const predict_report *r) {
  if (!r->measurements)
    return;
  fputs("<h3>Measured points</h3><div class=\"wide\"><table><tr><th>where</th><th>points</th>"
        "<th>within the bounds</th><th>below</th><th>above</th><th>sum over that "
        "predicted, less 1</th></tr>",
        out);
  write_count(out, "incidence plane", &r->prediction->plane);
  write_count(out, "hemisphere", &r->prediction->hemisphere);
  fputs("</table></div><p>", out);
  hetab_page_text(out, hetab_measurements_name(r->measurements));
  if (r->accuracy > 0)
    fprintf(out, "; a measured value counts as within if it is so for an error of %.3g %%",
            100 * r->accuracy);
  fputs("</p>\n", out);
}

static void write_curves(FILE *out, const predict_report *r) {
  fputs("<h3>Peaks</h3><div class=\"wide\"><table><tr><th>nm</th><th>theta_i</th><th>peak at "
        "theta_r</th><th>f there, 1/sr</th><th>low</th><th>high</th><th>rho_s</th><th>low</th>"
        "<th>high</th></tr>",
        out);
  for (size_t i = 0; i < r->prediction->curve_count; i++) {
    const hetab_prediction_curve *c = &r->prediction->curves[i];
    size_t peak = 0;
    while (r->prediction->theta_r[peak] < c->peak)
      peak++;
    fprintf(out,
            "<tr><td>%.6g</td><td>%.4g\u00b0</td><td>%.4g\u00b0</td><td>%.4g</td><td>%.4g</td>"
            "<td>%.4g</td><td>%.3g</td><td>%.3g</td><td>%.3g</td></tr>",
            1000 * c->lambda_um, hetab_degrees(c->theta_i), hetab_degrees(c->peak),
            c->f[peak].nominal, c->f[peak].low, c->f[peak].high, predict_shown(c->specular.nominal),
            predict_shown(c->specular.low), predict_shown(c->specular.high));
  }
  fputs("</table></div>\n", out);
}

static void write_interval(FILE *out, const char *name, double value, hetab_interval interval) {
  fprintf(out, "%s %.5g \u00b5m", name, value);
  if (interval.high > interval.low)
    fprintf(out, " (%.5g to %.5g)", interval.low, interval.high);
}

void predict_html(FILE *out, const predict_report *r) {
  const hetab_prediction *p = r->prediction;
  hetab_page_begin(out, "hetab predict", "Predicted BRDF of ", hetab_surface_name(r->surface));
  fputs("<p>", out);
  write_interval(out, "sigma0", hetab_surface_sigma0_um(r->surface), p->bounds.sigma0_um);
  write_interval(out, ", tau", hetab_surface_tau_um(r->surface), p->bounds.tau_um);
  fprintf(out,
          "</p><p>Varied: %s. Bounds: the model's envelope over the whole interval; what it misses "
          "is below %.1g of the value. The specular delta is not in the curves: its reflectance is "
          "rho_s in the table. hetab %s</p>\n",
          predict_varied(p) ? predict_varied(p) : "nothing", p->error, hetab_version());
  write_counts(out, r);
  for (size_t w = 0; w < r->lambda_count; w++)
    write_wavelength(out, r, w);
  write_curves(out, r);
  hetab_page_end(out);
}
