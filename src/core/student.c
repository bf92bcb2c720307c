#include "core/student.h"

#include <math.h>

#include <hetab/types.h>

/* A table, then an expansion about the normal distribution's. */
double hetab_student_95(double freedom) {
  static const double table[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                 2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131};
  enum { LAST = sizeof table / sizeof *table };
  if (freedom >= LAST)
    return 1.95996 + 2.3723 / freedom + 2.82 / (freedom * freedom);
  int below = (int)fmax(freedom, 1);
  double above = below == LAST ? 2.131 : table[below];
  return table[below - 1] + (fmax(freedom, 1) - below) * (above - table[below - 1]);
}

double hetab_error_share_above(const hetab_error_stats *error) {
  return error->compared > 3 ? 3.0 / (double)error->compared : 1.0;
}
