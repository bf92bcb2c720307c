/* The page: what is where, and how it looks. Lengths are in units of 1/1280 of its width. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/angle.h"
#include "core/context.h"
#include "model/colour.h"
#include "view/view_parts.h"

static const double pi = 3.14159265358979323846;

enum { UNITS = 1280, MARGIN = 44, HEAD = 112, CAPTION = 34, ROW_GAP = 38 };
enum { SPHERE_SIDE = 400, SPHERE_ALONE = UNITS - 2 * MARGIN, PLOT_HEIGHT = 400, PLOT_ALONE = 640 };
enum { AXIS_LEFT = 66, AXIS_BELOW = 52, MAP_GAP = 18, SCALE_WIDTH = 112, MAP_MOST = 520 };
enum { MAP_BELOW = 44, FOOT = 30 };

static const hetab_colour paper = {1, 1, 1}, dark = {0.11f, 0.13f, 0.15f},
                          grey = {0.42f, 0.45f, 0.49f}, faint = {0.88f, 0.89f, 0.91f},
                          stage = {0.075f, 0.08f, 0.095f}, white = {1, 1, 1};
static const hetab_colour curve_colours[HETAB_VIEW_MOST_THETA_I] = {
    {0.15f, 0.36f, 0.80f}, {0.05f, 0.56f, 0.50f}, {0.86f, 0.49f, 0.05f}, {0.80f, 0.14f, 0.24f}};

/* What drawing needs everywhere: pixels of a unit. */
typedef struct page {
  hetab_canvas *canvas;
  const hetab_view *view;
  double unit;
} page;

static int shows(const hetab_view *view, hetab_view_what what) {
  return view->what == HETAB_VIEW_ALL || view->what == what;
}

/* ---- sizes --------------------------------------------------------------------------------- */

static double map_units(const hetab_view *view) {
  double count = (double)view->theta_i_count;
  double room = UNITS - 2 * MARGIN - SCALE_WIDTH - (count - 1) * MAP_GAP;
  return fmin(room / count, MAP_MOST);
}

static double sphere_units(const hetab_view *view) {
  return view->what == HETAB_VIEW_SPHERE ? SPHERE_ALONE : SPHERE_SIDE;
}

static double plot_units(const hetab_view *view) {
  return view->what == HETAB_VIEW_LOBES ? PLOT_ALONE : PLOT_HEIGHT;
}

size_t hetab_page_map_side(const hetab_view *view) {
  return (size_t)lround(map_units(view) * view->width / UNITS);
}

size_t hetab_page_sphere_side(const hetab_view *view) {
  return (size_t)lround(sphere_units(view) * view->width / UNITS);
}

/* Where the row of maps begins. */
static double map_top(const hetab_view *view) {
  return view->what == HETAB_VIEW_ALL ? HEAD + CAPTION + PLOT_HEIGHT + ROW_GAP : HEAD;
}

static double page_units(const hetab_view *view) {
  if (shows(view, HETAB_VIEW_MAPS))
    return map_top(view) + CAPTION + map_units(view) + MAP_BELOW + FOOT;
  return HEAD + CAPTION + FOOT +
         (view->what == HETAB_VIEW_LOBES ? plot_units(view) : sphere_units(view));
}

/* ---- words --------------------------------------------------------------------------------- */

static void say(const page *p, double x, double y, double size, double align, hetab_colour colour,
                const char *text) {
  hetab_canvas_text(p->canvas, x * p->unit, y * p->unit, size * p->unit, align, colour, text);
}

/* A caption, and what follows it in grey. */
static void caption(const page *p, double x, double y, const char *text, const char *more) {
  say(p, x, y, 12, 0, dark, text);
  x += hetab_text_width(12, text) + 12;
  say(p, x, y, 10, 0, grey, more);
}

/* Cut to what fits beside the margins. */
static void draw_head(const page *p) {
  char title[sizeof p->view->title];
  double size = 24, room = UNITS - 2 * MARGIN;
  snprintf(title, sizeof title, "%s", p->view->title);
  size *= fmin(1, room / fmax(hetab_text_width(size, title), 1));
  say(p, MARGIN, 56, size, 0, dark, title);
  size = 11.5 * fmin(1, room / fmax(hetab_text_width(11.5, p->view->subtitle), 1));
  say(p, MARGIN, 84, size, 0, grey, p->view->subtitle);
}

/* ---- the sphere ---------------------------------------------------------------------------- */

static double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

/* Straight up to the knee, then a long shoulder, as smooth, that keeps the shape of highlights. */
static double shoulder(double x) {
  const double knee = 0.5, over = x - knee;
  return over <= 0 ? x : knee + (1 - knee) * over / (over + 1 - knee);
}

static hetab_colour develop(const float rgb[3], double gain) {
  double v[3], most = 1e-12;
  for (int c = 0; c < 3; c++) {
    v[c] = fmax((double)rgb[c] * gain, 0);
    most = fmax(most, v[c]);
  }
  double scale = shoulder(most) / most;
  return (hetab_colour){(float)encode_srgb(v[0] * scale), (float)encode_srgb(v[1] * scale),
                        (float)encode_srgb(v[2] * scale)};
}

static void draw_sphere(const page *p, double left, double top) {
  const hetab_view *view = p->view;
  size_t side = view->sphere_side;
  double half = (double)side / 2, radius = HETAB_SPHERE_RADIUS * (double)side;
  int x0 = (int)lround(left * p->unit), y0 = (int)lround((top + CAPTION) * p->unit);
  caption(p, left, top + 16, "Sphere", "two white lights and a dome");
  hetab_canvas_box(p->canvas, x0, y0, (double)side, (double)side, 10 * p->unit);
  hetab_canvas_ink(p->canvas, stage, 1);
  for (size_t i = 0; i < side * side; i++) {
    int x = (int)(i % side), y = (int)(i / side);
    double covered = radius - hypot(x + 0.5 - half, y + 0.5 - half) + 0.5;
    covered = fmin(fmax(covered, 0), 1);
    if (covered > 0)
      hetab_canvas_pixel(p->canvas, x0 + x, y0 + y,
                         develop(view->sphere[i], exp2(view->exposure) / covered), covered);
  }
}

/* ---- lobes --------------------------------------------------------------------------------- */

typedef struct plot {
  double left, top, right, bottom;  /* units */
  int decade_from, decade_to, step; /* of the vertical axis */
} plot;

static double plot_x(const plot *f, double deg) {
  return f->left + (f->right - f->left) * (deg + 90) / 180;
}

static double plot_y(const plot *f, double log10_value) {
  double t = (log10_value - f->decade_from) / (f->decade_to - f->decade_from);
  return f->bottom - (f->bottom - f->top) * t;
}

/* From the highest lobe down to the lowest value, but at most 8 decades. */
static void choose_decades(const hetab_view *view, plot *f) {
  double most = -HUGE_VAL, least = HUGE_VAL;
  for (size_t k = 0; k < view->theta_i_count; k++)
    for (size_t i = 0; i < HETAB_LOBE_POINTS; i++) {
      double y = hetab_luminance(view->lobes[k][i]);
      if (y > 0) {
        most = fmax(most, log10(y));
        least = fmin(least, log10(y));
      }
    }
  if (!(most > -HUGE_VAL))
    most = least = 0;
  f->decade_to = (int)floor(most + 0.1) + 1;
  f->decade_from = (int)fmax(floor(least), f->decade_to - 8);
  f->step = f->decade_to - f->decade_from > 5 ? 2 : 1;
}

static void draw_axes(const page *p, const plot *f) {
  char text[16];
  for (int deg = -90; deg <= 90; deg += 30) {
    double x = plot_x(f, deg);
    hetab_canvas_segment(p->canvas, x * p->unit, f->top * p->unit, x * p->unit, f->bottom * p->unit,
                         p->unit);
  }
  for (int d = f->decade_from; d <= f->decade_to; d++)
    hetab_canvas_segment(p->canvas, f->left * p->unit, plot_y(f, d) * p->unit, f->right * p->unit,
                         plot_y(f, d) * p->unit, p->unit);
  hetab_canvas_ink(p->canvas, faint, 1);
  for (int deg = -90; deg <= 90; deg += 30) {
    snprintf(text, sizeof text, "%d°", deg);
    say(p, plot_x(f, deg), f->bottom + 20, 10, 0.5, dark, text);
  }
  for (int d = f->decade_to; d >= f->decade_from; d -= f->step)
    hetab_canvas_decade(p->canvas, (f->left - 10) * p->unit, (plot_y(f, d) + 5) * p->unit,
                        10 * p->unit, 1, dark, d);
  say(p, (f->left + f->right) / 2, f->bottom + 42, 10, 0.5, grey,
      "θᵣ, negative on the side of the light");
}

/* Where the value is not positive, or below the axis, the line rests on the axis. */
static void draw_curve(const page *p, const plot *f, size_t k) {
  double last_x = 0, last_y = 0;
  for (size_t i = 0; i < HETAB_LOBE_POINTS; i++) {
    double value = hetab_luminance(p->view->lobes[k][i]);
    double x = plot_x(f, (double)p->view->lobe_theta_r_deg[k][i]) * p->unit;
    double y = plot_y(f, fmax(value > 0 ? log10(value) : -HUGE_VAL, f->decade_from)) * p->unit;
    double floor_y = f->bottom * p->unit;
    if (i && (y < floor_y || last_y < floor_y))
      hetab_canvas_segment(p->canvas, last_x, last_y, x, y, 2.2 * p->unit);
    last_x = x;
    last_y = y;
  }
  hetab_canvas_ink(p->canvas, curve_colours[k], 1);
}

static void draw_mirror_line(const page *p, const plot *f, size_t k) {
  double x = plot_x(f, hetab_degrees(p->view->theta_i[k])) * p->unit, dash = 4 * p->unit;
  for (double y = f->top * p->unit; y < f->bottom * p->unit; y += 2.5 * dash)
    hetab_canvas_segment(p->canvas, x, y, x, fmin(y + dash, f->bottom * p->unit), p->unit);
  hetab_canvas_ink(p->canvas, curve_colours[k], 0.6);
}

/* From the right end of the caption's line. */
static void draw_legend(const page *p, const plot *f, double y) {
  double x = f->right;
  for (size_t k = p->view->theta_i_count; k-- > 0;) {
    char text[32];
    snprintf(text, sizeof text, "θᵢ %.4g°", hetab_degrees(p->view->theta_i[k]));
    say(p, x, y, 10, 1, dark, text);
    x -= hetab_text_width(10, text) + 8;
    hetab_canvas_segment(p->canvas, (x - 18) * p->unit, (y - 5) * p->unit, x * p->unit,
                         (y - 5) * p->unit, 3 * p->unit);
    hetab_canvas_ink(p->canvas, curve_colours[k], 1);
    x -= 18 + 20;
  }
}

static void draw_lobes(const page *p, double left, double top) {
  plot f = {.left = left + AXIS_LEFT, .top = top + CAPTION, .right = UNITS - MARGIN};
  f.bottom = top + CAPTION + plot_units(p->view) - AXIS_BELOW;
  choose_decades(p->view, &f);
  caption(p, left, top + 16, "Lobes", p->view->colour ? "luminance, 1/sr" : "BRDF, 1/sr");
  draw_legend(p, &f, top + 16);
  draw_axes(p, &f);
  for (size_t k = 0; k < p->view->theta_i_count; k++)
    draw_mirror_line(p, &f, k);
  for (size_t k = 0; k < p->view->theta_i_count; k++)
    draw_curve(p, &f, k);
}

/* ---- maps ---------------------------------------------------------------------------------- */

/* Even steps of lightness in OKLab, from violet through red to a light yellow. */
static hetab_colour heat(double t) {
  double lightness = 0.14 + 0.82 * t, hue = (-75 + 180 * t) * pi / 180;
  double chroma = 0.17 * sqrt(fmax(sin(pi * (0.08 + 0.84 * t)), 0));
  double a = chroma * cos(hue), b = chroma * sin(hue);
  double l = pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  double m = pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  double s = pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  double rgb[3] = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                   -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                   -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
  for (int c = 0; c < 3; c++)
    rgb[c] = encode_srgb(fmin(fmax(rgb[c], 0), 1));
  return (hetab_colour){(float)rgb[0], (float)rgb[1], (float)rgb[2]};
}

/* Decades that the colours span. */
typedef struct scale {
  double from, to;
} scale;

/* Down from the brightest pixel: to the faintest, but 2 to 6 decades. */
static scale choose_scale(const hetab_view *view) {
  double most = 0, least = HUGE_VAL;
  size_t pixels = view->map_side * view->map_side;
  for (size_t k = 0; k < view->theta_i_count; k++)
    for (size_t i = 0; i < pixels; i++) {
      double y = hetab_luminance(view->maps[k][i]);
      most = fmax(most, y);
      if (y > 0)
        least = fmin(least, y);
    }
  if (!(most > 0))
    return (scale){-1, 0};
  double to = log10(most), from = fmin(fmax(log10(least), to - 6), to - 2);
  return (scale){from, to};
}

static hetab_colour colour_of(const scale *s, double value) {
  double level = value > 0 ? (log10(value) - s->from) / (s->to - s->from) : 0;
  return heat(fmin(fmax(level, 0), 1));
}

/* A dot or a ring that shows on light and dark. */
static void mark(const page *p, double x, double y, int ring) {
  double radius = (ring ? 7 : 4.5) * p->unit;
  if (ring)
    hetab_canvas_circle(p->canvas, x, y, radius, 3.2 * p->unit);
  else
    hetab_canvas_box(p->canvas, x - radius, y - radius, 2 * radius, 2 * radius, radius);
  hetab_canvas_ink(p->canvas, dark, 0.9);
  if (ring)
    hetab_canvas_circle(p->canvas, x, y, radius, 1.5 * p->unit);
  else
    hetab_canvas_box(p->canvas, x - 0.62 * radius, y - 0.62 * radius, 1.24 * radius, 1.24 * radius,
                     0.62 * radius);
  hetab_canvas_ink(p->canvas, white, 1);
}

static void draw_rings(const page *p, double cx, double cy, double radius) {
  for (int deg = 30; deg <= 60; deg += 30)
    hetab_canvas_circle(p->canvas, cx, cy, radius * sqrt(2) * sin(deg * pi / 360), p->unit);
  hetab_canvas_ink(p->canvas, white, 0.3);
  hetab_canvas_circle(p->canvas, cx, cy, radius, 1.2 * p->unit);
  hetab_canvas_ink(p->canvas, grey, 1);
}

static void draw_map(const page *p, size_t k, double left, double top, const scale *s) {
  const hetab_view *view = p->view;
  size_t side = view->map_side;
  int x0 = (int)lround(left * p->unit), y0 = (int)lround(top * p->unit);
  double half = (double)side / 2, cx = x0 + half, cy = y0 + half;
  double place = half * sqrt(2) * sin(0.5 * view->theta_i[k]);
  char text[32];
  for (size_t i = 0; i < side * side; i++) {
    int x = (int)(i % side), y = (int)(i / side);
    if (hypot(x + 0.5 - half, y + 0.5 - half) < half)
      hetab_canvas_pixel(p->canvas, x0 + x, y0 + y, colour_of(s, hetab_luminance(view->maps[k][i])),
                         1);
  }
  draw_rings(p, cx, cy, half);
  mark(p, cx - place, cy, 0);
  mark(p, cx + place, cy, 1);
  snprintf(text, sizeof text, "θᵢ %.4g°", hetab_degrees(view->theta_i[k]));
  say(p, cx / p->unit, top + map_units(view) + 24, 11, 0.5, dark, text);
}

static void draw_scale(const page *p, double left, double top, double height, const scale *s) {
  int x0 = (int)lround(left * p->unit), x1 = (int)lround((left + 18) * p->unit);
  int y0 = (int)lround(top * p->unit), y1 = (int)lround((top + height) * p->unit);
  for (int y = y0; y < y1; y++)
    for (int x = x0; x < x1; x++)
      hetab_canvas_pixel(p->canvas, x, y, heat((y1 - y - 0.5) / (y1 - y0)), 1);
  for (int d = (int)ceil(s->from - 1e-9); d <= s->to + 1e-9; d++) {
    double y = y1 - (y1 - y0) * (d - s->from) / (s->to - s->from);
    hetab_canvas_segment(p->canvas, x1, y, x1 + 5 * p->unit, y, 1.2 * p->unit);
    hetab_canvas_ink(p->canvas, grey, 1);
    hetab_canvas_decade(p->canvas, x1 + 10 * p->unit, y + 5 * p->unit, 10 * p->unit, 0, dark, d);
  }
}

/* What the marks mean, at the right end of the caption's line. */
static void draw_map_key(const page *p, double right, double y) {
  const char *mirror = "mirror direction", *light = "light";
  say(p, right, y, 10, 1, grey, mirror);
  right -= hetab_text_width(10, mirror) + 16;
  mark(p, right * p->unit, (y - 4.5) * p->unit, 1);
  right -= 24;
  say(p, right, y, 10, 1, grey, light);
  right -= hetab_text_width(10, light) + 13;
  mark(p, right * p->unit, (y - 4.5) * p->unit, 0);
}

static void draw_maps(const page *p, double top) {
  const hetab_view *view = p->view;
  scale s = choose_scale(view);
  double side = map_units(view), count = (double)view->theta_i_count;
  double row = count * side + (count - 1) * MAP_GAP + SCALE_WIDTH;
  double left = fmax((UNITS - row) / 2, MARGIN);
  caption(p, MARGIN, top + 16, "Hemispheres",
          view->colour ? "luminance, 1/sr; equal-area discs, rings at θᵣ 30° and 60°"
                       : "BRDF, 1/sr; equal-area discs, rings at θᵣ 30° and 60°");
  draw_map_key(p, UNITS - MARGIN, top + 16);
  for (size_t k = 0; k < view->theta_i_count; k++)
    draw_map(p, k, left + (double)k * (side + MAP_GAP), top + CAPTION, &s);
  draw_scale(p, left + row - SCALE_WIDTH + 34, top + CAPTION, side, &s);
}

/* ---- all of it ----------------------------------------------------------------------------- */

hetab_status hetab_page_draw(hetab_context *ctx, const hetab_view *view, hetab_canvas *canvas) {
  page p = {.canvas = canvas, .view = view, .unit = (double)view->width / UNITS};
  int height = (int)ceil(page_units(view) * p.unit);
  HETAB_TRY(hetab_canvas_create(ctx, view->width, height, paper, canvas));
  draw_head(&p);
  if (view->sphere)
    draw_sphere(&p, MARGIN, HEAD);
  if (view->lobes[0])
    draw_lobes(&p, view->sphere ? MARGIN + SPHERE_SIDE + 40 : MARGIN, HEAD);
  if (view->maps[0])
    draw_maps(&p, map_top(view));
  return HETAB_OK;
}
