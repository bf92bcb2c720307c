#include "view/canvas.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/context.h"

/* ---- coverage ------------------------------------------------------------------------------ */

static void empty_box(hetab_canvas *canvas) {
  canvas->left = canvas->width;
  canvas->top = canvas->height;
  canvas->right = canvas->bottom = -1;
}

hetab_status hetab_canvas_create(hetab_context *ctx, int width, int height, hetab_colour paper,
                                 hetab_canvas *canvas) {
  size_t count = (size_t)width * (size_t)height;
  *canvas = (hetab_canvas){.width = width, .height = height};
  empty_box(canvas);
  canvas->pixels = hetab_alloc(ctx, count, sizeof *canvas->pixels);
  canvas->coverage = hetab_alloc(ctx, count, sizeof *canvas->coverage);
  if (!canvas->pixels || !canvas->coverage) {
    hetab_canvas_clear(canvas);
    return HETAB_ERR_MEMORY;
  }
  for (size_t i = 0; i < count; i++)
    canvas->pixels[i] = paper;
  return HETAB_OK;
}

void hetab_canvas_clear(hetab_canvas *canvas) {
  free(canvas->pixels);
  free(canvas->coverage);
  *canvas = (hetab_canvas){0};
}

typedef struct area {
  int left, top, right, bottom;
} area;

/* The pixels that a shape may touch, on the page; the canvas's box grows by them. */
static area touch(hetab_canvas *canvas, double left, double top, double right, double bottom) {
  area a = {(int)fmax(floor(left) - 1, 0), (int)fmax(floor(top) - 1, 0),
            (int)fmin(ceil(right) + 1, canvas->width - 1),
            (int)fmin(ceil(bottom) + 1, canvas->height - 1)};
  canvas->left = a.left < canvas->left ? a.left : canvas->left;
  canvas->top = a.top < canvas->top ? a.top : canvas->top;
  canvas->right = a.right > canvas->right ? a.right : canvas->right;
  canvas->bottom = a.bottom > canvas->bottom ? a.bottom : canvas->bottom;
  return a;
}

/* outside: distance of the pixel's centre from the shape. */
static void cover(hetab_canvas *canvas, int x, int y, double outside) {
  float *here = &canvas->coverage[(size_t)y * (size_t)canvas->width + (size_t)x];
  float covered = (float)fmin(fmax(0.5 - outside, 0), 1);
  if (covered > *here)
    *here = covered;
}

static double segment_distance(double x, double y, double x0, double y0, double x1, double y1) {
  double dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy;
  double t = length2 > 0 ? ((x - x0) * dx + (y - y0) * dy) / length2 : 0;
  t = fmin(fmax(t, 0), 1);
  return hypot(x - x0 - t * dx, y - y0 - t * dy);
}

void hetab_canvas_segment(hetab_canvas *canvas, double x0, double y0, double x1, double y1,
                          double width) {
  double half = width / 2;
  area a = touch(canvas, fmin(x0, x1) - half, fmin(y0, y1) - half, fmax(x0, x1) + half,
                 fmax(y0, y1) + half);
  for (int y = a.top; y <= a.bottom; y++)
    for (int x = a.left; x <= a.right; x++)
      cover(canvas, x, y, segment_distance(x + 0.5, y + 0.5, x0, y0, x1, y1) - half);
}

void hetab_canvas_circle(hetab_canvas *canvas, double cx, double cy, double radius, double width) {
  double reach = radius + width / 2;
  area a = touch(canvas, cx - reach, cy - reach, cx + reach, cy + reach);
  for (int y = a.top; y <= a.bottom; y++)
    for (int x = a.left; x <= a.right; x++)
      cover(canvas, x, y, fabs(hypot(x + 0.5 - cx, y + 0.5 - cy) - radius) - width / 2);
}

void hetab_canvas_box(hetab_canvas *canvas, double left, double top, double width, double height,
                      double corner) {
  area a = touch(canvas, left, top, left + width, top + height);
  for (int y = a.top; y <= a.bottom; y++)
    for (int x = a.left; x <= a.right; x++) {
      double dx = fabs(x + 0.5 - left - width / 2) - width / 2 + corner;
      double dy = fabs(y + 0.5 - top - height / 2) - height / 2 + corner;
      cover(canvas, x, y, hypot(fmax(dx, 0), fmax(dy, 0)) + fmin(fmax(dx, dy), 0) - corner);
    }
}

void hetab_canvas_pixel(hetab_canvas *canvas, int x, int y, hetab_colour colour, double opacity) {
  if (x < 0 || y < 0 || x >= canvas->width || y >= canvas->height)
    return;
  hetab_colour *p = &canvas->pixels[(size_t)y * (size_t)canvas->width + (size_t)x];
  float a = (float)opacity;
  p->r += a * (colour.r - p->r);
  p->g += a * (colour.g - p->g);
  p->b += a * (colour.b - p->b);
}

void hetab_canvas_ink(hetab_canvas *canvas, hetab_colour colour, double opacity) {
  for (int y = canvas->top; y <= canvas->bottom; y++)
    for (int x = canvas->left; x <= canvas->right; x++) {
      float *here = &canvas->coverage[(size_t)y * (size_t)canvas->width + (size_t)x];
      if (*here > 0)
        hetab_canvas_pixel(canvas, x, y, colour, opacity * (double)*here);
      *here = 0;
    }
  empty_box(canvas);
}

/* ---- text ---------------------------------------------------------------------------------- */

/* Of the font's units. */
static const double cap_height = 8, gap = 2, space = 2.5, stroke = 0.92;
enum { BASELINE = 'd', CURVE_STEPS = 8 };

/* The next character of UTF-8 up to two bytes, or three; '?' for what is none. */
static unsigned next_character(const char **text) {
  const unsigned char *c = (const unsigned char *)*text;
  unsigned value = '?';
  int length = 1;
  if (c[0] < 0x80)
    value = c[0];
  else if ((c[0] & 0xe0) == 0xc0 && (c[1] & 0xc0) == 0x80) {
    value = (c[0] & 0x1fu) << 6 | (c[1] & 0x3fu);
    length = 2;
  } else if ((c[0] & 0xf0) == 0xe0 && (c[1] & 0xc0) == 0x80 && (c[2] & 0xc0) == 0x80) {
    value = (c[0] & 0xfu) << 12 | (c[1] & 0x3fu) << 6 | (c[2] & 0x3fu);
    length = 3;
  }
  *text += length;
  return value;
}

static const char *strokes_of(unsigned character) {
  const char *strokes = hetab_glyph(character);
  return strokes ? strokes : hetab_glyph('?');
}

/* To the next character's left end. */
static double advance(const char *strokes) {
  int right = 0;
  if (!*strokes)
    return space;
  for (const char *c = strokes; *c; c++)
    if (*c >= '0' && *c <= '9' && *c - '0' > right)
      right = *c - '0';
  return right + gap;
}

double hetab_text_width(double size, const char *text) {
  double units = -gap;
  while (*text)
    units += advance(strokes_of(next_character(&text)));
  return fmax(units, 0) * size / cap_height;
}

typedef struct point {
  double x, y;
} point;

/* Where a glyph's strokes go. */
typedef struct pen {
  hetab_canvas *canvas;
  double x, y, scale;
  point at, control; /* control: a bend that is yet to be made */
  int down, bending;
} pen;

static void line_to(pen *p, point to) {
  hetab_canvas_segment(p->canvas, p->x + p->at.x * p->scale, p->y - p->at.y * p->scale,
                       p->x + to.x * p->scale, p->y - to.y * p->scale, stroke * p->scale);
  p->at = to;
}

static void curve_to(pen *p, point to) {
  point from = p->at, c = p->control;
  for (int i = 1; i <= CURVE_STEPS; i++) {
    double t = (double)i / CURVE_STEPS, a = (1 - t) * (1 - t), b = 2 * t * (1 - t), d = t * t;
    line_to(p, (point){a * from.x + b * c.x + d * to.x, a * from.y + b * c.y + d * to.y});
  }
}

static void take_point(pen *p, point to, int bend) {
  if (!p->down) {
    p->at = to;
    p->down = 1;
  } else if (bend) {
    if (p->bending)
      curve_to(p, (point){(p->control.x + to.x) / 2, (p->control.y + to.y) / 2});
    p->control = to;
    p->bending = 1;
  } else {
    if (p->bending)
      curve_to(p, to);
    else
      line_to(p, to);
    p->bending = 0;
  }
}

static void draw_glyph(hetab_canvas *canvas, double x, double y, double scale,
                       const char *strokes) {
  pen p = {.canvas = canvas, .x = x, .y = y, .scale = scale};
  for (const char *c = strokes; *c;) {
    int bend = *c == '~';
    if (*c == ' ') {
      p.down = p.bending = 0;
      c++;
      continue;
    }
    c += bend;
    take_point(&p, (point){c[0] - '0', c[1] - BASELINE}, bend);
    c += 2;
  }
}

void hetab_canvas_text(hetab_canvas *canvas, double x, double y, double size, double align,
                       hetab_colour colour, const char *text) {
  double scale = size / cap_height;
  x -= align * hetab_text_width(size, text);
  while (*text) {
    const char *strokes = strokes_of(next_character(&text));
    draw_glyph(canvas, x, y, scale, strokes);
    x += scale * advance(strokes);
  }
  hetab_canvas_ink(canvas, colour, 1);
}

void hetab_canvas_decade(hetab_canvas *canvas, double x, double y, double size, double align,
                         hetab_colour colour, int power) {
  char exponent[16];
  snprintf(exponent, sizeof exponent, "%d", power);
  if (power == 0 || power == 1) {
    hetab_canvas_text(canvas, x, y, size, align, colour, power ? "10" : "1");
    return;
  }
  double base = hetab_text_width(size, "10"), gap_px = 0.15 * size;
  double width = base + gap_px + hetab_text_width(0.72 * size, exponent);
  x -= align * width;
  hetab_canvas_text(canvas, x, y, size, 0, colour, "10");
  hetab_canvas_text(canvas, x + base + gap_px, y - 0.55 * size, 0.72 * size, 0, colour, exponent);
}
