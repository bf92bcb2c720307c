/* A text of heights while it is read. */
#pragma once

#include <hetab/roughness.h>
#include "core/csv.h"

enum { SCAN_X, SCAN_Y, SCAN_Z, SCAN_ROLES };

typedef struct scan_column {
  size_t column; /* of the file */
  int role;
  double unit; /* um */
} scan_column;

typedef struct text_scan {
  hetab_csv csv;
  const hetab_heights_options *options;
  double place_unit, height_unit; /* those given, um; 0: none */
  scan_column *taken;             /* [count]: x if has_x, y if has_y, then heights */
  size_t count;
  bool has_x, has_y;
  double *values; /* [rows][count] */
  size_t rows, room;
  char note[256];
} text_scan;

/* The column of that name (without case and unit) or number from 1, or HETAB_CSV_ABSENT. */
size_t scan_find_column(const hetab_csv *csv, const char *name, size_t length);

/* What the lines above the rows say, in the words of Gwyddion's, SPIP's, Attocube's, Nova's,
 * Lyncée's and Wyko's exports: the heights' unit, um (0: nothing), and how far the columns and the
 * rows of a map lie apart (false: nothing). */
double scan_height_unit(const text_scan *t);
bool scan_map_pitch(const text_scan *t, double pitch_um[2]);
