#include "audit/repair.h"

#include <math.h>

/* Smaller corrections are rounding, not repair. */
static const double counts_from = 1e-6;

static int note_change(double before, double after, hetab_repair_report *report) {
  double change = fabs(after - before), larger = fmax(fabs(before), fabs(after));
  double relative = larger > 0 ? change / larger : 0;
  report->max_change_abs = fmax(report->max_change_abs, change);
  report->max_change_rel = fmax(report->max_change_rel, relative);
  return relative > counts_from;
}

static int is_good(double value) {
  return isfinite(value) && value >= 0;
}

static double neighbours_mean(const double *row, size_t count, size_t at) {
  double sum = 0, found = 0;
  for (size_t p = at; p-- > 0;)
    if (is_good(row[p])) {
      sum += row[p];
      found++;
      break;
    }
  for (size_t p = at + 1; p < count; p++)
    if (is_good(row[p])) {
      sum += row[p];
      found++;
      break;
    }
  return found > 0 ? sum / found : 0;
}

void hetab_repair_row(double *row, size_t count, hetab_repair_report *report) {
  report->entries += count;
  for (size_t p = 0; p < count; p++) {
    if (is_good(row[p]))
      continue;
    double after = isfinite(row[p]) ? 0 : neighbours_mean(row, count, p);
    report->clamped += isfinite(row[p]) != 0;
    report->replaced += isfinite(row[p]) == 0;
    note_change(isfinite(row[p]) ? row[p] : 0, after, report);
    row[p] = after;
  }
}

void hetab_repair_pair(double *a, double *b, hetab_repair_report *report) {
  double mean = 0.5 * *a + 0.5 * *b;
  if (*a == *b)
    return;
  report->symmetrised += (size_t)note_change(*a, mean, report);
  report->symmetrised += (size_t)note_change(*b, mean, report);
  *a = *b = mean;
}

double hetab_repair_scale(double found, double allowed, hetab_repair_report *report) {
  if (!(found > allowed))
    return 1;
  double scale = fmax(allowed, 0) / found;
  report->scaled_incidences++;
  report->smallest_scale = fmin(report->smallest_scale, scale);
  return scale;
}
