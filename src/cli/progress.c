#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/clock.h"
#include "core/printable.h"
#include "numbers.h"
#include "signals.h"

enum { BAR_CELLS = 24 };
static const double redraw_seconds = 0.1;

static struct {
  int visible; /* standard error is a terminal that can redraw a line */
  int drawn;   /* there is something to clear */
  char label[32];
  const char *unit;         /* of what is counted */
  double start, last, done; /* done: at the last call, to see a new run of progress begin */
} bar;

static int terminal_columns(void) {
  struct winsize size;
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col ? size.ws_col : 80;
}

static void draw(const char *text) {
  fprintf(stderr, "\r%.*s\033[K", terminal_columns() - 1, text);
  bar.drawn = 1;
}

static void draw_bar(double fraction, double rate, double left) {
  char cells[BAR_CELLS + 1], speed[16], line[160];
  memset(cells, '.', BAR_CELLS);
  memset(cells, '#', (size_t)(fraction * BAR_CELLS));
  cells[BAR_CELLS] = 0;
  cli_si(rate, speed, sizeof speed);
  long seconds = lround(fmin(left, 359999));
  snprintf(line, sizeof line, "%s %3.0f%% [%s] %s %s/s  %ld:%02ld:%02ld left", bar.label,
           floor(100 * fraction), cells, speed, bar.unit, seconds / 3600, seconds / 60 % 60,
           seconds % 60);
  draw(line);
}

static int on_progress(void *user, double done, double total) {
  (void)user;
  double t = hetab_seconds();
  if (done < bar.done)
    bar.start = t;
  bar.done = done;
  if (bar.visible && t - bar.last >= redraw_seconds && done > 0 && total > 0) {
    double rate = done / fmax(t - bar.start, 1e-9);
    draw_bar(fmin(done / total, 1), rate, fmax(total - done, 0) / rate);
    bar.last = t;
  }
  return cli_signal();
}

int cli_progress_visible(void) {
  return bar.visible;
}

void cli_progress_begin(const char *label, int quiet) {
  cli_progress_count(label, "entries", quiet);
}

void cli_progress_count(const char *label, const char *unit, int quiet) {
  const char *terminal = getenv("TERM");
  int dumb = !terminal || strcmp(terminal, "dumb") == 0;
  bar.visible = !quiet && !dumb && isatty(STDERR_FILENO);
  snprintf(bar.label, sizeof bar.label, "%s", label);
  hetab_make_printable(&(hetab_printable){0}, bar.label, strlen(bar.label), "");
  bar.unit = unit;
  bar.start = bar.last = hetab_seconds();
  bar.done = 0.0;
  if (bar.visible)
    draw(bar.label);
}

void cli_progress_watch(hetab_context *ctx) {
  hetab_set_progress(ctx, on_progress, NULL);
}

void cli_progress_end(void) {
  if (bar.drawn)
    fputs("\r\033[K", stderr);
  bar.drawn = bar.visible = 0;
}
