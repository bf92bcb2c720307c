/* Roughness as one self-contained page. */
#include <math.h>
#include <stdlib.h>

#include "roughness_command.h"
#include "svg.h"

static const char raw_stroke[] = "stroke:var(--c0)";
static const char small_stroke[] = "stroke:var(--c1)";
static const char gaussian_stroke[] = "stroke:var(--law);stroke-dasharray:5 4;stroke-width:1.2";
static const char exponential_stroke[] = "stroke:var(--c2);stroke-dasharray:2 3;stroke-width:1.4";

/* ---- the scan in two ----------------------------------------------------------------------- */

/* A curve of at most 2 * BUCKETS points: the lowest and the highest of each stretch. */
enum { BUCKETS = 900 };
typedef struct curve {
  double x[2 * BUCKETS], y[2 * BUCKETS];
  size_t count;
} curve;

static void thin(const double *y, const double *less, size_t count, double spacing_um, curve *c) {
  size_t stride = count / BUCKETS + 1;
  c->count = 0;
  for (size_t from = 0; from < count; from += stride) {
    double low = (double)NAN, high = (double)NAN;
    for (size_t i = from; i < count && i < from + stride; i++) {
      double value = less ? y[i] - less[i] : y[i];
      low = fmin(low, value);
      high = fmax(high, value);
    }
    c->x[c->count] = c->x[c->count + 1] = (double)from * spacing_um;
    c->y[c->count++] = low;
    c->y[c->count++] = high;
  }
}

static double largest(const curve *c) {
  double most = 1e-9;
  for (size_t i = 0; i < c->count; i++)
    if (isfinite(c->y[i]))
      most = fmax(most, fabs(c->y[i]));
  return most;
}

static svg_plot scan_plot(FILE *out, double length_um, double most) {
  return (svg_plot){out,
                    {"x, um", 0, length_um, svg_step(length_um), 0},
                    {"height, um", -1.05 * most, 1.05 * most, svg_step(2 * most), 0}};
}

static void plot_split(FILE *out, const hetab_roughness *r) {
  double spacing = r->scans[r->small.scans[0].scan].spacing_um;
  double length = (double)r->split_count * spacing;
  static curve c; /* 30 kB */
  thin(r->split_levelled_um, NULL, r->split_count, spacing, &c);
  svg_plot p = scan_plot(out, length, largest(&c));
  svg_begin(&p, "The first scan, levelled, and its large-scale component");
  svg_line(&p, c.x, c.y, c.count, 1, "stroke:var(--c0);stroke-width:1;opacity:.8", "levelled");
  thin(r->split_line_um, NULL, r->split_count, spacing, &c);
  svg_line(&p, c.x, c.y, c.count, 1, "stroke:var(--law);stroke-width:1.6", "mean line");
  svg_end(&p);
  thin(r->split_levelled_um, r->split_line_um, r->split_count, spacing, &c);
  p = scan_plot(out, length, largest(&c));
  svg_begin(&p, "Its small-scale component (end zones dimmed)");
  svg_line(&p, c.x, c.y, c.count, 1, "stroke:var(--c1);stroke-width:1;opacity:.35", "end zones");
  for (size_t i = 0; i < c.count; i++)
    if (c.x[i] < 0.5 * r->cutoff_um || c.x[i] > length - 0.5 * r->cutoff_um)
      c.y[i] = (double)NAN;
  svg_line(&p, c.x, c.y, c.count, 1, "stroke:var(--c1);stroke-width:1", "small scale");
  svg_end(&p);
}

/* ---- distribution and autocorrelation ------------------------------------------------------ */

static void histogram_line(const svg_plot *p, const hetab_component *c, const char *stroke,
                           const char *title) {
  double x[2 * HETAB_HISTOGRAM_BINS], y[2 * HETAB_HISTOGRAM_BINS];
  double width = 10.0 / HETAB_HISTOGRAM_BINS;
  for (int i = 0; i < HETAB_HISTOGRAM_BINS; i++) {
    x[2 * i] = -5 + i * width;
    x[2 * i + 1] = x[2 * i] + width;
    y[2 * i] = y[2 * i + 1] = c->histogram[i];
  }
  svg_line(p, x, y, 2 * HETAB_HISTOGRAM_BINS, 1, stroke, title);
}

static void plot_histogram(FILE *out, const hetab_roughness *r) {
  double x[HETAB_HISTOGRAM_BINS + 1], normal[HETAB_HISTOGRAM_BINS + 1], top = 0.42;
  for (int i = 0; i <= HETAB_HISTOGRAM_BINS; i++) {
    x[i] = -5 + 10.0 * i / HETAB_HISTOGRAM_BINS;
    normal[i] = exp(-0.5 * x[i] * x[i]) / sqrt(2 * M_PI);
  }
  for (int i = 0; i < HETAB_HISTOGRAM_BINS; i++)
    top = fmax(top, 1.05 * fmax(r->raw.histogram[i], r->small.histogram[i]));
  svg_plot p = {out, {"height over sigma", -5, 5, 1, 0}, {"density", 0, top, svg_step(top), 0}};
  svg_begin(&p, "Distribution of heights (dashed: normal)");
  histogram_line(&p, &r->raw, raw_stroke, "unfiltered");
  if (r->small.count)
    histogram_line(&p, &r->small, small_stroke, "small scale");
  svg_line(&p, x, normal, HETAB_HISTOGRAM_BINS + 1, 1, gaussian_stroke, "normal");
  svg_end(&p);
}

static void plot_correlation(FILE *out, const hetab_component *c, const char *caption,
                             const char *stroke) {
  double x[HETAB_CORRELATION_LAGS], gaussian[HETAB_CORRELATION_LAGS],
      exponential[HETAB_CORRELATION_LAGS], low = -0.2;
  for (int i = 0; i < HETAB_CORRELATION_LAGS; i++) {
    x[i] = i * c->lag_step_um;
    double ratio = x[i] / c->tau_um.mean;
    gaussian[i] = exp(-ratio * ratio);
    exponential[i] = exp(-ratio);
    low = fmin(low, c->correlation[i] - 0.05);
  }
  double end = x[HETAB_CORRELATION_LAGS - 1];
  svg_plot p = {out, {"lag, um", 0, end, svg_step(end), 0}, {"autocorrelation", low, 1.02, 0.2, 0}};
  svg_begin(&p, caption);
  svg_line(&p, x, gaussian, HETAB_CORRELATION_LAGS, 1, gaussian_stroke, "Gaussian");
  svg_line(&p, x, exponential, HETAB_CORRELATION_LAGS, 1, exponential_stroke, "exponential");
  svg_line(&p, x, c->correlation, HETAB_CORRELATION_LAGS, 1, stroke, "measured, mean of the scans");
  svg_end(&p);
}

enum { PLOT_POINTS = 512 }; /* the library tries fewer cut-offs */

static void plot_cutoffs(FILE *out, const hetab_roughness *r) {
  const hetab_cutoff_scan *s = &r->cutoff_scan;
  const hetab_cutoff_trial *first = s->trials;
  double top = 0, chosen[2] = {r->cutoff_um, r->cutoff_um};
  size_t stride = sizeof *first / sizeof(double);
  double x[PLOT_POINTS];
  size_t count = s->count < PLOT_POINTS ? s->count : PLOT_POINTS;
  for (size_t i = 0; i < count; i++) {
    top = fmax(top, 1.1 * fmax(first[i].slope, first[i].smooth));
    x[i] = first[i].cutoff_um;
  }
  double ends[2] = {0, top};
  svg_plot p = {out,
                {"cut-off, um", first[0].cutoff_um, first[count - 1].cutoff_um, 1, 1},
                {"sigma / tau", 0, top, svg_step(top), 0}};
  svg_begin(&p, r->small.count
                    ? "Slope against cut-off (dashed: two Gaussian scales; upright: chosen)"
                    : "Slope against cut-off (dashed: two Gaussian scales; none is chosen)");
  svg_line(&p, x, &first->slope, count, stride, small_stroke, "measured");
  svg_line(&p, x, &first->smooth, count, stride, gaussian_stroke, "two Gaussian scales");
  if (r->small.count)
    svg_line(&p, chosen, ends, 2, 1, "stroke:var(--c2)", "chosen");
  svg_end(&p);
}

_Static_assert(sizeof(hetab_cutoff_trial) % sizeof(double) == 0, "read with a stride of doubles");

/* ---- tables -------------------------------------------------------------------------------- */

static void table_row(FILE *out, const char *name, const double values[ROUGHNESS_FIELDS]) {
  fputs("<tr><td>", out);
  hetab_page_text(out, name);
  fputs("</td>", out);
  for (int f = 0; f < ROUGHNESS_FIELDS; f++)
    fprintf(out, "<td>%.4g</td>", values[f]);
  fputs("</tr>\n", out);
}

static void write_component(FILE *out, const hetab_roughness *r, const hetab_component *c) {
  double rows[5][ROUGHNESS_FIELDS];
  static const char *const names[5] = {"average", "deviation", "standard error", "95 % from",
                                       "95 % to"};
  fputs("<div class=\"wide\"><table><tr><th>scan</th>", out);
  for (int f = 0; f < ROUGHNESS_FIELDS; f++) {
    hetab_average a = roughness_average(c, f);
    const double values[5] = {a.mean, a.deviation, a.error, a.low, a.high};
    for (int i = 0; i < 5; i++)
      rows[i][f] = values[i];
    fprintf(out, "<th>%s</th>", roughness_fields[f].title);
  }
  fputs("</tr>\n", out);
  for (size_t i = 0; i < c->count && i < 200; i++) {
    double values[ROUGHNESS_FIELDS];
    for (int f = 0; f < ROUGHNESS_FIELDS; f++)
      values[f] = roughness_estimate(&c->scans[i], f).value;
    table_row(out, r->scans[c->scans[i].scan].name, values);
  }
  for (int i = 0; i < 5; i++)
    if (i != 1 || c->count > 1)
      table_row(out, names[i], rows[i]);
  fputs("</table></div><p>", out);
  if (c->count > 1)
    fprintf(out, "Non-uniformity of sigma: %.3f. ", c->non_uniformity);
  fputs("sigma/tau is the report's slope; rms slope is that of first differences.</p>\n", out);
}

static void write_notes(FILE *out, const hetab_roughness *r) {
  if (!r->note_count)
    fputs("<p>Nothing speaks against the model's assumptions.</p>", out);
  fputs("<ul>", out);
  for (size_t i = 0; i < r->note_count; i++) {
    fputs("<li>", out);
    hetab_page_text(out, r->notes[i]);
    fputs("</li>\n", out);
  }
  fputs("</ul>\n", out);
}

static void write_plots(FILE *out, const hetab_roughness *r) {
  fputs("<div class=\"plots\">", out);
  if (r->small.count)
    plot_split(out, r);
  plot_histogram(out, r);
  plot_correlation(out, &r->raw, "Autocorrelation, unfiltered", raw_stroke);
  if (r->small.count)
    plot_correlation(out, &r->small, "Autocorrelation, small scale", small_stroke);
  if (r->cutoff_scan.count)
    plot_cutoffs(out, r);
  fputs("</div><div class=\"key\">", out);
  svg_key(out, raw_stroke, "unfiltered");
  if (r->small.count)
    svg_key(out, small_stroke, "small scale");
  svg_key(out, gaussian_stroke, "normal, Gaussian exp(-(r/tau)\u00b2)");
  svg_key(out, exponential_stroke, "exponential exp(-r/tau)");
  fputs("</div>\n", out);
}

void roughness_html(FILE *out, const hetab_roughness *r) {
  hetab_page_begin(out, "hetab roughness", "hetab roughness", "");
  fprintf(out, "<p>hetab %s: %zu scan%s</p>\n", hetab_version(), r->count,
          r->count == 1 ? "" : "s");
  write_notes(out, r);
  write_plots(out, r);
  fputs("<h2>Unfiltered, levelled</h2>", out);
  write_component(out, r, &r->raw);
  if (r->small.count) {
    fprintf(out, "<h2>Small scale, %s filter, cut-off %.4g \u00b5m</h2>",
            hetab_filter_name(r->filter), r->cutoff_um);
    write_component(out, r, &r->small);
  }
  hetab_page_end(out);
}
