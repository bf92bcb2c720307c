#include "svg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/angle.h"

enum { LEFT = 66, RIGHT = 20, TOP = 10, BOTTOM = 42, BORDER = 4 }; /* of points on the axes */
enum { INNER_WIDTH = SVG_WIDTH - LEFT - RIGHT, INNER_HEIGHT = SVG_HEIGHT - TOP - BOTTOM };

double svg_step(double range) {
  double rough = range / 5, power = pow(10, floor(log10(rough)));
  double mantissa = rough / power;
  return power * (mantissa < 1.5 ? 1 : mantissa < 3.5 ? 2 : mantissa < 7.5 ? 5 : 10);
}

static void begin_figure(FILE *stream, const char *caption, int width, int height) {
  fputs("<figure><figcaption>", stream);
  hetab_page_text(stream, caption);
  fprintf(stream, "</figcaption><svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"", width,
          height);
  hetab_page_text(stream, caption);
  fputs("\">", stream);
}

/* ---- axes ---------------------------------------------------------------------------------- */

/* 0 to 1 along the axis. */
static double along(const svg_axis *axis, double value) {
  if (axis->kind == SVG_LOG)
    return log(value / axis->from) / log(axis->to / axis->from);
  return (value - axis->from) / (axis->to - axis->from);
}

static double data_x(const svg_plot *p, double value) {
  return p->x.kind == SVG_DEGREES ? hetab_degrees(value) : value;
}

static double place_x(const svg_plot *p, double value) {
  return LEFT + INNER_WIDTH * along(&p->x, value);
}

static double place_y(const svg_plot *p, double value) {
  return TOP + INNER_HEIGHT * (1 - along(&p->y, value));
}

static double next_tick(const svg_axis *axis, double value) {
  return axis->kind == SVG_LOG ? value * pow(10, axis->step) : value + axis->step;
}

static double first_tick(const svg_axis *axis) {
  if (axis->kind == SVG_LOG)
    return pow(10, axis->step * ceil(log10(axis->from) / axis->step - 1e-9));
  return axis->step * ceil(axis->from / axis->step - 1e-9);
}

static void tick_label(FILE *stream, const svg_axis *axis, double value) {
  if (axis->kind == SVG_LOG)
    fprintf(stream, "10<tspan dy=\"-4\" font-size=\"9\">%.0f</tspan>", log10(value));
  else
    fprintf(stream, "%.6g", fabs(value) < 1e-9 * axis->step ? 0 : value);
}

static void draw_ticks(const svg_plot *p) {
  double end = p->x.to + 1e-9 * fabs(p->x.to);
  for (double x = first_tick(&p->x); x <= end; x = next_tick(&p->x, x)) {
    double at = place_x(p, x);
    fprintf(p->stream,
            "<path class=\"grid\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" "
            "text-anchor=\"middle\">",
            at, TOP, TOP + INNER_HEIGHT, at, TOP + INNER_HEIGHT + 16);
    tick_label(p->stream, &p->x, x);
    fputs("</text>", p->stream);
  }
  end = p->y.to + 1e-9 * fabs(p->y.to);
  for (double y = first_tick(&p->y); y <= end; y = next_tick(&p->y, y)) {
    double at = place_y(p, y);
    fprintf(p->stream,
            "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" "
            "text-anchor=\"end\">",
            LEFT, at, LEFT + INNER_WIDTH, LEFT - 6, at + 4);
    tick_label(p->stream, &p->y, y);
    fputs("</text>", p->stream);
  }
}

void svg_begin(const svg_plot *p, const char *caption) {
  begin_figure(p->stream, caption, SVG_WIDTH, SVG_HEIGHT);
  draw_ticks(p);
  fprintf(p->stream, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", LEFT + INNER_WIDTH / 2,
          SVG_HEIGHT - 8);
  hetab_page_text(p->stream, p->x.label);
  fprintf(p->stream,
          "</text><text transform=\"translate(13 %d) rotate(-90)\" text-anchor=\"middle\">",
          TOP + INNER_HEIGHT / 2);
  hetab_page_text(p->stream, p->y.label);
  fprintf(p->stream,
          "</text><svg x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" viewBox=\"%d %d %d %d\">",
          LEFT - BORDER, TOP - BORDER, INNER_WIDTH + 2 * BORDER, INNER_HEIGHT + 2 * BORDER,
          LEFT - BORDER, TOP - BORDER, INNER_WIDTH + 2 * BORDER, INNER_HEIGHT + 2 * BORDER);
}

void svg_end(const svg_plot *p) {
  fputs("</svg></svg></figure>\n", p->stream);
}

/* ---- lines --------------------------------------------------------------------------------- */

static void end_line(FILE *stream, const char *style, const char *title) {
  fprintf(stream, "\" style=\"%s\"><title>", style);
  hetab_page_text(stream, title);
  fputs("</title></path>", stream);
}

void svg_line(const svg_plot *p, const double *x, const double *y, size_t count, size_t y_stride,
              const char *style, const char *title) {
  int drawing = 0;
  fputs("<path class=\"line\" d=\"", p->stream);
  for (size_t i = 0; i < count; i++) {
    double value = y[i * y_stride];
    int good = isfinite(value) && (p->y.kind != SVG_LOG || value > 0);
    if (good) /* far outside is outside; keep the numbers short */
      fprintf(p->stream, "%c%.1f %.1f", drawing ? 'L' : 'M', place_x(p, data_x(p, x[i])),
              fmax(-999, fmin(999, place_y(p, value))));
    drawing = good;
  }
  end_line(p->stream, style, title);
}

/* ---- bands and points ---------------------------------------------------------------------- */

/* Kept near the axes; what is not positive on a logarithmic one lies below. */
static double clamped_y(const svg_plot *p, double value) {
  double at = p->y.kind == SVG_LOG && !(value > 0) ? 999 : place_y(p, value);
  return isfinite(at) ? fmax(-999, fmin(999, at)) : 999;
}

void svg_band(const svg_plot *p, const double *x, const double *low, const double *high,
              size_t count, size_t stride, const char *style, const char *title) {
  fputs("<path class=\"band\" d=\"", p->stream);
  for (size_t i = 0; i < count; i++)
    fprintf(p->stream, "%c%.1f %.1f", i ? 'L' : 'M', place_x(p, data_x(p, x[i])),
            clamped_y(p, high[i * stride]));
  for (size_t i = count; i-- > 0;)
    fprintf(p->stream, "L%.1f %.1f", place_x(p, data_x(p, x[i])), clamped_y(p, low[i * stride]));
  putc('Z', p->stream);
  end_line(p->stream, style, title);
}

void svg_point(const svg_plot *p, double x, double y, double radius, const char *style,
               const char *title) {
  if (!isfinite(x) || !isfinite(y) || (p->y.kind == SVG_LOG && !(y > 0)))
    return;
  double at_x = place_x(p, data_x(p, x)), at_y = place_y(p, y);
  if (at_x < LEFT || at_x > LEFT + INNER_WIDTH || at_y < TOP || at_y > TOP + INNER_HEIGHT)
    return;
  fprintf(p->stream, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" style=\"%s\"><title>", at_x, at_y,
          radius, style);
  hetab_page_text(p->stream, title);
  fputs("</title></circle>", p->stream);
}

/* ---- half circles -------------------------------------------------------------------------- */

enum { POLAR_RADIUS = 180, POLAR_HEIGHT = 232, CENTRE_X = SVG_WIDTH / 2, CENTRE_Y = 206 };

static void polar_place(double radius, double angle, double *x, double *y) {
  *x = CENTRE_X + POLAR_RADIUS * radius * sin(angle);
  *y = CENTRE_Y - POLAR_RADIUS * radius * cos(angle);
}

void svg_polar_begin(FILE *stream, const char *caption, const char *const rings[], int ring_count) {
  double x, y;
  begin_figure(stream, caption, SVG_WIDTH, POLAR_HEIGHT);
  for (int i = 1; i <= ring_count; i++) {
    double r = POLAR_RADIUS * (double)i / ring_count;
    fprintf(stream,
            "<path class=\"grid\" d=\"M%.1f %dA%.1f %.1f 0 0 1 %.1f %d\"/><text x=\"%.1f\" "
            "y=\"%d\" text-anchor=\"middle\" font-size=\"10\">%s</text>",
            CENTRE_X - r, CENTRE_Y, r, r, CENTRE_X + r, CENTRE_Y, CENTRE_X + r, CENTRE_Y + 15,
            rings[i - 1]);
  }
  for (int deg = -90; deg <= 90; deg += 30) {
    polar_place(1, deg * M_PI / 180, &x, &y);
    fprintf(stream, "<path class=\"grid\" d=\"M%d %dL%.1f %.1f\"/>", CENTRE_X, CENTRE_Y, x, y);
    polar_place(1.08, deg * M_PI / 180, &x, &y);
    if (abs(deg) < 90)
      fprintf(stream, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%d\u00b0</text>", x,
              y + 4, deg);
  }
}

void svg_polar_line(FILE *stream, const double *radius, size_t count, const char *style,
                    const char *title) {
  int drawing = 0;
  fputs("<path class=\"line\" d=\"", stream);
  for (size_t i = 0; i < count; i++) {
    double x, y, angle = M_PI * ((double)i / (double)(count - 1) - 0.5);
    polar_place(radius[i], angle, &x, &y);
    if (isfinite(radius[i]))
      fprintf(stream, "%c%.1f %.1f", drawing ? 'L' : 'M', x, y);
    drawing = isfinite(radius[i]) != 0;
  }
  end_line(stream, style, title);
}

void svg_polar_end(FILE *stream) {
  fputs("</svg></figure>\n", stream);
}

/* ---- maps ---------------------------------------------------------------------------------- */

/* All squares of one level, runs of a row in one, as one path. */
static void draw_level(FILE *stream, const unsigned char *levels, int rows, int columns,
                       int level) {
  int any = 0;
  for (int row = 0; row < rows; row++)
    for (int from = 0, to; from < columns; from = to) {
      for (to = from + 1;
           to < columns && levels[row * columns + to] == levels[row * columns + from]; to++)
        ;
      if (levels[row * columns + from] != level)
        continue;
      if (!any++)
        fprintf(stream, "<path class=\"m%d\" d=\"", level);
      fprintf(stream, "M%d %dh%dv1h-%dz", from, row, to - from, to - from);
    }
  if (any)
    fputs("\"/>", stream);
}

void svg_map(FILE *stream, const unsigned char *levels, int rows, int columns, const char *caption,
             const char *left, const char *bottom) {
  enum { SIDE = 200, EDGE = 24 };
  begin_figure(stream, caption, SIDE + EDGE, SIDE + EDGE);
  fprintf(stream,
          "<svg x=\"%d\" y=\"0\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" "
          "shape-rendering=\"crispEdges\">",
          EDGE, SIDE, SIDE, columns, rows);
  for (int level = 0; level < HETAB_PAGE_LEVELS; level++)
    draw_level(stream, levels, rows, columns, level);
  fprintf(stream, "</svg><text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", EDGE + SIDE / 2,
          SIDE + 17);
  hetab_page_text(stream, bottom);
  fprintf(stream, "</text><text transform=\"translate(15 %d) rotate(-90)\" text-anchor=\"middle\">",
          SIDE / 2);
  hetab_page_text(stream, left);
  fputs("</text></svg></figure>\n", stream);
}

/* ---- discs --------------------------------------------------------------------------------- */

enum { DISC = 200, DISC_EDGE = 20 };

static void draw_polar_grid(FILE *stream) {
  static const int rings_deg[] = {30, 60, 90};
  const int centre = DISC_EDGE + DISC / 2;
  for (int i = 0; i < 3; i++)
    fprintf(stream, "<circle class=\"ring\" cx=\"%d\" cy=\"%d\" r=\"%.1f\"/>", centre, centre,
            DISC / 2 * sin(rings_deg[i] * M_PI / 180));
  fprintf(stream, "<path class=\"ring\" d=\"M%d %dh%dM%d %dv%d\"/>", DISC_EDGE, centre, DISC,
          centre, DISC_EDGE, DISC);
}

void svg_disc(FILE *stream, const unsigned char *levels, int side, const char *caption) {
  const int whole = DISC + 2 * DISC_EDGE, centre = whole / 2;
  begin_figure(stream, caption, whole, whole);
  fprintf(stream,
          "<svg x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" "
          "shape-rendering=\"crispEdges\">",
          DISC_EDGE, DISC_EDGE, DISC, DISC, side, side);
  for (int level = 0; level < HETAB_PAGE_LEVELS; level++)
    draw_level(stream, levels, side, side, level);
  fputs("</svg>", stream);
  draw_polar_grid(stream);
  fprintf(stream,
          "<text x=\"%d\" y=\"13\" text-anchor=\"middle\">90\u00b0</text><text "
          "transform=\"translate(12 %d) rotate(-90)\" text-anchor=\"middle\">light</text><text "
          "transform=\"translate(%d %d) rotate(90)\" text-anchor=\"middle\">mirror</text>",
          centre, centre, whole - 12, centre);
  fputs("</svg></figure>\n", stream);
}

/* ---- keys ---------------------------------------------------------------------------------- */

void svg_scale(FILE *stream, const char *low, const char *high) {
  fprintf(
      stream,
      "<div class=\"scale\"><span>%s</span><svg viewBox=\"0 0 %d 1\" preserveAspectRatio=\"none\">",
      low, HETAB_PAGE_LEVELS - 1);
  for (int level = 1; level < HETAB_PAGE_LEVELS; level++)
    fprintf(stream, "<path class=\"m%d\" d=\"M%d 0h1v1h-1z\"/>", level, level - 1);
  fprintf(stream, "</svg><span>%s</span></div>", high);
}

void svg_key(FILE *stream, const char *stroke, const char *text) {
  const char *colour = strchr(stroke, ':') + 1;
  fprintf(stream, "<span><i style=\"border-color:%.*s\"></i>", (int)strcspn(colour, ";"), colour);
  hetab_page_text(stream, text);
  fputs("</span>", stream);
}
