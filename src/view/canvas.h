/* A page to draw on: filled shapes, lines of any width and text, antialiased. x to the right, y
 * downwards, pixel centres at halves; colours are sRGB values in [0, 1]. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

typedef struct hetab_colour {
  float r, g, b;
} hetab_colour;

typedef struct hetab_canvas {
  int width, height;
  hetab_colour *pixels; /* [height][width] */
  float *coverage;      /* of what is being drawn, in the box below; else 0 */
  int left, top, right, bottom;
} hetab_canvas;

hetab_status hetab_canvas_create(hetab_context *ctx, int width, int height, hetab_colour paper,
                                 hetab_canvas *canvas);
void hetab_canvas_clear(hetab_canvas *canvas);

/* Shapes add up to one coverage; ink() lays the colour on what they cover. */
void hetab_canvas_segment(hetab_canvas *canvas, double x0, double y0, double x1, double y1,
                          double width);
void hetab_canvas_circle(hetab_canvas *canvas, double x, double y, double radius, double width);
/* With round corners. */
void hetab_canvas_box(hetab_canvas *canvas, double x, double y, double width, double height,
                      double corner);
void hetab_canvas_ink(hetab_canvas *canvas, hetab_colour colour, double opacity);
/* Blends one pixel; off the page is fine. */
void hetab_canvas_pixel(hetab_canvas *canvas, int x, int y, hetab_colour colour, double opacity);

/* text in UTF-8, its baseline at y, capitals `size` high; align: 0 x is its left end, 0.5 its
 * middle, 1 its right end. Characters that the font does not have are drawn as '?'. */
void hetab_canvas_text(hetab_canvas *canvas, double x, double y, double size, double align,
                       hetab_colour colour, const char *text);
double hetab_text_width(double size, const char *text);
/* 10 to a power. */
void hetab_canvas_decade(hetab_canvas *canvas, double x, double y, double size, double align,
                         hetab_colour colour, int power);

/* The strokes of a character, or NULL: see font.c. */
const char *hetab_glyph(unsigned character);
