#include "golden_support.h"

#include <sys/wait.h>
#include <unistd.h>

/* --- reference values ------------------------------------------------------------------------ */

enum { MOST_FIELDS = 16 };

/* The rows of a file after its header: name, then `fields` numbers; NULL-terminated lines. */
static double (*read_csv(const char *path, size_t fields, char (**names)[32],
                         size_t *count))[MOST_FIELDS] {
  FILE *file = fopen(path, "r");
  if (!file)
    fail_msg("%s: run the tests from the repository's root", path);
  char line[1024];
  double(*rows)[MOST_FIELDS] = calloc(1000, sizeof *rows);
  *names = calloc(1000, sizeof **names);
  *count = 0;
  assert_non_null(fgets(line, sizeof line, file));
  while (fgets(line, sizeof line, file)) {
    char *rest = line, *field = strsep(&rest, ",");
    assert_true(*count < 1000 && strlen(field) < sizeof **names);
    strcpy((*names)[*count], field);
    for (size_t f = 0; f < fields; f++) {
      char *end;
      field = strsep(&rest, ",");
      assert_non_null(field);
      rows[*count][f] = strtod(field, &end);
      assert_true(end != field && (*end == 0 || *end == '\n' || *end == '\r'));
    }
    ++*count;
  }
  fclose(file);
  return rows;
}

golden_point *golden_points(size_t *count) {
  char(*names)[32];
  double(*rows)[MOST_FIELDS] = read_csv("tests/golden/he_torrance.csv", 15, &names, count);
  golden_point *points = calloc(*count, sizeof *points);
  for (size_t i = 0; i < *count; i++) {
    const double *r = rows[i];
    points[i] = (golden_point){.point = {.lambda_um = r[0],
                                         .sigma0_um = r[1],
                                         .tau_um = r[2],
                                         .n = r[3],
                                         .k = r[4],
                                         .theta_i = r[5],
                                         .theta_r = r[6],
                                         .phi = r[7]},
                               .dd = r[8],
                               .g = r[9],
                               .x = r[10],
                               .fresnel = r[11],
                               .shadow_i = r[12],
                               .shadow_r = r[13],
                               .sigma_ratio = r[14]};
    strcpy(points[i].name, names[i]);
  }
  free(rows);
  free(names);
  return points;
}

golden_reflectance *golden_reflectances(size_t *count) {
  char(*names)[32];
  double(*rows)[MOST_FIELDS] = read_csv("tests/golden/reflectance.csv", 9, &names, count);
  golden_reflectance *points = calloc(*count, sizeof *points);
  for (size_t i = 0; i < *count; i++) {
    const double *r = rows[i];
    double theta = r[5] * M_PI / 180;
    points[i] = (golden_reflectance){.point = {.lambda_um = r[0],
                                               .sigma0_um = r[1],
                                               .tau_um = r[2],
                                               .n = r[3],
                                               .k = r[4],
                                               .theta_i = theta,
                                               .theta_r = theta,
                                               .phi = M_PI},
                                     .rho_dd = r[6],
                                     .rho_s = r[7],
                                     .fresnel = r[8]};
    strcpy(points[i].name, names[i]);
  }
  free(rows);
  free(names);
  return points;
}

/* --- the library ----------------------------------------------------------------------------- */

int context_setup(void **state) {
  hetab_context *ctx;
  hetab_status status = hetab_context_create(&ctx);
  *state = ctx;
  return status != HETAB_OK;
}

int context_teardown(void **state) {
  hetab_context_free(*state);
  return 0;
}

void assert_ok(hetab_context *ctx, hetab_status status) {
  if (status != HETAB_OK)
    fail_msg("%s: %s", hetab_status_name(status), hetab_error_message(ctx));
}

void assert_fails(hetab_context *ctx, hetab_status status, hetab_status expected,
                  const char *const *words) {
  const char *message = hetab_error_message(ctx);
  if (status != expected)
    fail_msg("'%s' instead of '%s': %s", hetab_status_name(status), hetab_status_name(expected),
             message);
  assert_null(strchr(message, '\n'));
  for (; *words; words++)
    if (!strstr(message, *words))
      fail_msg("no '%s' in message '%s'", *words, message);
}

hetab_engine *new_engine(hetab_context *ctx, hetab_precision precision, hetab_method method,
                         double tolerance) {
  hetab_engine *engine;
  hetab_engine_options options = {.precision = precision, .method = method, .tolerance = tolerance};
  assert_ok(ctx, hetab_engine_create(ctx, &options, &engine));
  return engine;
}

hetab_value *device_values(hetab_context *ctx, hetab_precision precision, const hetab_point *points,
                           size_t count) {
  hetab_value *values = calloc(count, sizeof *values);
  hetab_engine *engine = new_engine(ctx, precision, HETAB_METHOD_SERIES, 0);
  assert_ok(ctx, hetab_evaluate(ctx, engine, points, count, values));
  hetab_engine_free(engine);
  return values;
}

hetab_value *literal_values(hetab_context *ctx, const hetab_point *points, size_t count) {
  hetab_value *values = calloc(count, sizeof *values);
  assert_ok(ctx, hetab_evaluate_literal(ctx, points, count, values));
  return values;
}

/* --- points and numbers ---------------------------------------------------------------------- */

hetab_point swapped(hetab_point point) {
  double theta = point.theta_i;
  point.theta_i = point.theta_r;
  point.theta_r = theta;
  return point;
}

double uniform(uint64_t *state, double low, double high) {
  /* Knuth's MMIX generator, the upper bits */
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return low + (high - low) * ((double)(*state >> 11) * 0x1p-53);
}

double log_uniform(uint64_t *state, double low, double high) {
  return exp(uniform(state, log(low), log(high)));
}

/* --- errors ---------------------------------------------------------------------------------- */

void worst_add(worst *w, size_t at, double value, double reference) {
  if (!isfinite(value) || value < 0) {
    w->bad++;
  } else if (reference >= TOL_FLOOR) {
    double relative = fabs(value - reference) / reference;
    w->compared++;
    if (!(relative <= w->relative)) {
      w->relative = relative;
      w->at = at;
    }
  } else {
    w->below++;
    w->absolute_below = fmax(w->absolute_below, fabs(value - reference));
  }
}

void assert_worst(const char *what, const worst *w, double relative, double absolute_below) {
  print_message(
      "  %-34s %.2e relative (%.0e, %zu compared, worst at %zu), %.1e below (%.0e, %zu)\n", what,
      w->relative, relative, w->compared, w->at, w->absolute_below, absolute_below, w->below);
  if (w->bad)
    fail_msg("%s: %zu values are NaN, infinite or negative", what, w->bad);
  if (!(w->relative <= relative))
    fail_msg("%s: relative error %g at %zu", what, w->relative, w->at);
  if (!(w->absolute_below <= absolute_below))
    fail_msg("%s: absolute error %g below the floor", what, w->absolute_below);
}

double relative_error(double value, double reference) {
  return value == reference ? 0 : fabs(value - reference) / fabs(reference);
}

void assert_below(const char *what, double measured, double bound) {
  print_message("  %-34s %.2e (%.0e)\n", what, measured, bound);
  if (!(measured <= bound))
    fail_msg("%s: %g exceeds %g", what, measured, bound);
}

/* --- children -------------------------------------------------------------------------------- */

int run_again(const char *argument, const char *const *settings) {
  char path[] = "/proc/self/exe", text[256];
  int status = 0;
  fflush(NULL);
  pid_t child = fork();
  if (child == 0) {
    snprintf(text, sizeof text, "%s", argument);
    for (; *settings; settings++) {
      char setting[256];
      snprintf(setting, sizeof setting, "%s", *settings);
      char *value = strchr(setting, '=');
      *value = 0;
      setenv(setting, value + 1, 1);
    }
    execv(path, (char *[]){path, text, NULL});
    _exit(127);
  }
  assert_true(child > 0 && waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}
