/* The dispersion formulas of the refractiveindex.info database. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

enum { HETAB_FORMULAS = 9, HETAB_FORMULA_COEFFICIENTS = 64 };

/* Whether the formula (1-9) can take that many coefficients, and the counts that it takes in words.
 */
bool hetab_formula_takes(int formula, size_t count);
const char *hetab_formula_counts(int formula);

/* The index n by formula 1-9 with coefficients c[count]: real, or NaN where the formula gives none.
 */
double hetab_formula_at(int formula, const double *c, size_t count, double lambda_um);
