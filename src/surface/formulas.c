/* Source: M. N. Polyanskiy, "Dispersion formulas" of the refractiveindex.info database. The
 * coefficients there are numbered from 1: C1 is c[0] here. Wavelengths are in um.
 *
 *   1 Sellmeier    n^2 = 1 + C1 + sum C2 L^2 / (L^2 - C3^2)
 *   2 Sellmeier-2  n^2 = 1 + C1 + sum C2 L^2 / (L^2 - C3)
 *   3 Polynomial   n^2 = C1 + sum C2 L^C3
 *   4 RI.INFO      n^2 = C1 + C2 L^C3 / (L^2 - C4^C5) + C6 L^C7 / (L^2 - C8^C9) + sum C10 L^C11
 *   5 Cauchy       n   = C1 + sum C2 L^C3
 *   6 Gases        n   = 1 + C1 + sum C2 / (C3 - L^-2)
 *   7 Herzberger   n   = C1 + C2 / (L^2 - 0.028) + C3 / (L^2 - 0.028)^2 + C4 L^2 + C5 L^4 + ...
 *   8 Retro        (n^2 - 1) / (n^2 + 2) = C1 + C2 L^2 / (L^2 - C3) + C4 L^2
 *   9 Exotic       n^2 = C1 + C2 / (L^2 - C3) + C4 (L - C5) / ((L - C5)^2 + C6)
 */
#include "surface/formulas.h"

#include <math.h>

/* n^2; power is 2 (formula 1) or 1 (formula 2). */
static double sellmeier(const double *c, size_t count, double lambda, int power) {
  double square = lambda * lambda;
  double sum = 1 + c[0];
  for (size_t i = 1; i < count; i += 2)
    sum += c[i] * square / (square - (power == 2 ? c[i + 1] * c[i + 1] : c[i + 1]));
  return sum;
}

/* Sum of c[i] L^c[i+1] from i = first: formulas 3 and 5, the tail of 4. */
static double powers(const double *c, size_t first, size_t count, double lambda) {
  double sum = 0;
  for (size_t i = first; i < count; i += 2)
    sum += c[i] * pow(lambda, c[i + 1]);
  return sum;
}

/* n^2 */
static double refractive_index_info(const double *c, size_t count, double lambda) {
  double sum = c[0];
  for (size_t i = 1; i < count && i < 9; i += 4)
    sum += c[i] * pow(lambda, c[i + 1]) / (lambda * lambda - pow(c[i + 2], c[i + 3]));
  return sum + powers(c, 9, count, lambda);
}

static double gases(const double *c, size_t count, double lambda) {
  double sum = 1 + c[0];
  for (size_t i = 1; i < count; i += 2)
    sum += c[i] / (c[i + 1] - 1 / (lambda * lambda));
  return sum;
}

static double herzberger(const double *c, size_t count, double lambda) {
  double square = lambda * lambda;
  double pole = 1 / (square - 0.028);
  double sum = c[0] + c[1] * pole + c[2] * pole * pole;
  double power = square;
  for (size_t i = 3; i < count; i++, power *= square)
    sum += c[i] * power;
  return sum;
}

/* n^2 */
static double retro(const double *c, double lambda) {
  double square = lambda * lambda;
  double ratio = c[0] + c[1] * square / (square - c[2]) + c[3] * square;
  return (1 + 2 * ratio) / (1 - ratio);
}

/* n^2 */
static double exotic(const double *c, double lambda) {
  double offset = lambda - c[4];
  return c[0] + c[1] / (lambda * lambda - c[2]) + c[3] * offset / (offset * offset + c[5]);
}

double hetab_formula_at(int formula, const double *c, size_t count, double lambda_um) {
  switch (formula) {
  case 1:
    return sqrt(sellmeier(c, count, lambda_um, 2));
  case 2:
    return sqrt(sellmeier(c, count, lambda_um, 1));
  case 3:
    return sqrt(c[0] + powers(c, 1, count, lambda_um));
  case 4:
    return sqrt(refractive_index_info(c, count, lambda_um));
  case 5:
    return c[0] + powers(c, 1, count, lambda_um);
  case 6:
    return gases(c, count, lambda_um);
  case 7:
    return herzberger(c, count, lambda_um);
  case 8:
    return sqrt(retro(c, lambda_um));
  case 9:
    return sqrt(exotic(c, lambda_um));
  default:
    return (double)NAN;
  }
}

bool hetab_formula_takes(int formula, size_t count) {
  switch (formula) {
  case 4:
    return count == 1 || count == 5 || (count >= 9 && count % 2 == 1);
  case 7:
    return count >= 3;
  case 8:
    return count == 4;
  case 9:
    return count == 6;
  default:
    return count % 2 == 1;
  }
}

const char *hetab_formula_counts(int formula) {
  switch (formula) {
  case 4:
    return "1, 5, 9, 11, 13, ... coefficients";
  case 7:
    return "3 or more coefficients";
  case 8:
    return "4 coefficients";
  case 9:
    return "6 coefficients";
  default:
    return "an odd number of coefficients";
  }
}
