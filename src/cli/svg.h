/* Plots as inline SVG. Colours are CSS classes and variables of the page (audit_html_style.c). */
#ifndef HETAB_CLI_SVG_H
#define HETAB_CLI_SVG_H

#include <stddef.h>
#include <stdio.h>

enum { SVG_WIDTH = 420, SVG_HEIGHT = 290 };

typedef struct svg_axis {
  const char *label;
  double from, to, step; /* ticks every step; logarithmic: every step decades */
  int log;
} svg_axis;

typedef struct svg_plot {
  FILE *stream;
  svg_axis x, y;
} svg_plot;

/* A figure with a caption and axes; lines are clipped to them. */
void svg_begin(const svg_plot *plot, const char *caption);
/* Points that are not finite, or not positive on a logarithmic axis, break the line. `style` is the
 * inside of a style attribute; `title` what a pointer over it shows. */
void svg_line(const svg_plot *plot, const double *x, const double *y, size_t count, size_t y_stride,
              const char *style, const char *title);
void svg_end(const svg_plot *plot);

/* A half circle of directions, theta_r from -90 to 90 degrees: radius[count] in [0, 1]. */
void svg_polar_begin(FILE *stream, const char *caption, const char *const rings[], int ring_count);
void svg_polar_line(FILE *stream, const double *radius, size_t count, const char *style,
                    const char *title);
void svg_polar_end(FILE *stream);

/* Squares coloured by level 0 (nothing) ... SVG_LEVELS - 1, [row][column]. */
enum { SVG_LEVELS = 24 };
void svg_map(FILE *stream, const unsigned char *levels, int rows, int columns, const char *caption,
             const char *left, const char *bottom);

/* A round step for about five ticks over a range. */
double svg_step(double range);
/* Text with what HTML reserves escaped. */
void svg_text(FILE *stream, const char *text);

#endif
