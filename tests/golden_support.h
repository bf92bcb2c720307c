/* What the numerical tests share: the reference values of tests/golden, a fixture with a context
 * and engines, random points, and the worst error of a comparison. */
#ifndef HETAB_TESTS_GOLDEN_SUPPORT_H
#define HETAB_TESTS_GOLDEN_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <hetab/hetab.h>

#include "tolerances.h"

/* A row of he_torrance.csv. */
typedef struct golden_point {
  char name[32];
  hetab_point point;
  double dd, g, x, fresnel, shadow_i, shadow_r, sigma_ratio;
} golden_point;

/* A row of reflectance.csv; theta_r = theta_i, phi = pi. */
typedef struct golden_reflectance {
  char name[32];
  hetab_point point;
  double rho_dd, rho_s, fresnel;
} golden_reflectance;

/* All rows, from the repository's root; free() them. */
golden_point *golden_points(size_t *count);
golden_reflectance *golden_reflectances(size_t *count);

/* Per-test state: a context. */
int context_setup(void **state);
int context_teardown(void **state);
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)

/* Fails the test, with the context's message, unless ok. */
void assert_ok(hetab_context *ctx, hetab_status status);
/* Fails unless the status is the one expected and the one-line message holds each of the words, up
 * to a NULL. */
void assert_fails(hetab_context *ctx, hetab_status status, hetab_status expected,
                  const char *const *words);

hetab_engine *new_engine(hetab_context *ctx, hetab_precision precision, hetab_method method,
                         double tolerance);
/* Values of the points: by the device, or the literal reference. free() them. */
hetab_value *device_values(hetab_context *ctx, hetab_precision precision, const hetab_point *points,
                           size_t count);
hetab_value *literal_values(hetab_context *ctx, const hetab_point *points, size_t count);

/* The same with the two directions exchanged. */
hetab_point swapped(hetab_point point);

/* Repeatable random numbers: uniform in [low, high), or uniform in the logarithm. */
double uniform(uint64_t *state, double low, double high);
double log_uniform(uint64_t *state, double low, double high);

/* The worst errors of a comparison, design section 6. */
typedef struct worst {
  size_t compared;   /* reference >= TOL_FLOOR */
  size_t below, bad; /* the others; NaN, infinite or negative values */
  double relative, absolute_below;
  size_t at; /* the entry with the worst relative error */
} worst;

void worst_add(worst *w, size_t at, double value, double reference);
/* Prints the errors; fails on a bad value or an error above the bounds. */
void assert_worst(const char *what, const worst *w, double relative, double absolute_below);

/* |value - reference| / |reference|, 0 for equal ones. */
double relative_error(double value, double reference);
/* Prints "what: measured (bound)" and fails above it. */
void assert_below(const char *what, double measured, double bound);

/* Runs this program again as a child with one argument and up to four NAME=VALUE settings, for
 * what must be set before OpenCL starts; its exit status, -1 for a signal. */
int run_again(const char *argument, const char *const *settings);

#endif
