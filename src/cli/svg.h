/* Plots as inline SVG. Colours are CSS classes and variables of core/html_page.c. */
#pragma once

#include <stddef.h>
#include <stdio.h>

#include "core/html_page.h"

enum { SVG_WIDTH = 420, SVG_HEIGHT = 290 };

typedef enum svg_axis_kind {
  SVG_LINEAR,
  SVG_LOG,
  SVG_DEGREES /* of data in radians */
} svg_axis_kind;

typedef struct svg_axis {
  const char *label;
  double from, to, step; /* ticks every step; logarithmic: every step decades */
  svg_axis_kind kind;
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
/* The area between low[i * stride] and high[i * stride], clipped to the axes. */
void svg_band(const svg_plot *plot, const double *x, const double *low, const double *high,
              size_t count, size_t stride, const char *style, const char *title);
/* A dot; nothing where a coordinate is not finite or off the axes. */
void svg_point(const svg_plot *plot, double x, double y, double radius, const char *style,
               const char *title);
void svg_end(const svg_plot *plot);

/* A half circle of directions, theta_r from -90 to 90 degrees: radius[count] in [0, 1]. */
void svg_polar_begin(FILE *stream, const char *caption, const char *const rings[], int ring_count);
void svg_polar_line(FILE *stream, const double *radius, size_t count, const char *style,
                    const char *title);
void svg_polar_end(FILE *stream);

/* Squares coloured by level 0 (nothing) ... HETAB_PAGE_LEVELS - 1, [row][column]. */
void svg_map(FILE *stream, const unsigned char *levels, int rows, int columns, const char *caption,
             const char *left, const char *bottom);

/* The hemisphere from above, as a disc: rows and columns are direction cosines from -1 to 1, the
 * mirror side to the right; levels as above, 0 what is not known, SVG_OUTSIDE what is no direction.
 */
enum { SVG_OUTSIDE = 255 };
void svg_disc(FILE *stream, const unsigned char *levels, int side, const char *caption);
/* The colours of the levels, between two words of HTML. */
void svg_scale(FILE *stream, const char *low, const char *high);
/* A line of a colour ("stroke:...") and what it stands for. */
void svg_key(FILE *stream, const char *stroke, const char *text);

/* A round step for about five ticks over a range. */
double svg_step(double range);
