/* hetab eval: the model at the points of a CSV stream. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "options.h"
#include "core/csv.h"
#include "signals.h"

/* A batch ends when it has that many rows, or that much text of passing columns. */
enum { BATCH = 65536, BATCH_TEXT = 16 << 20 };

/* ---- columns ------------------------------------------------------------------------------- */

enum { LAMBDA, THETA_I, THETA_R, PHI, SIGMA0, TAU, INDEX_N, INDEX_K, DIFFUSE, COLUMNS };
enum { ANGLES_END = SIGMA0 }; /* the columns before it have to be there */

static const hetab_csv_wanted wanted[COLUMNS] = {[LAMBDA] = {"lambda|wavelength", HETAB_LENGTH},
                                                 [THETA_I] = {"thetai", HETAB_ANGLE},
                                                 [THETA_R] = {"thetar|thetas", HETAB_ANGLE},
                                                 [PHI] = {"phi", HETAB_ANGLE},
                                                 [SIGMA0] = {"sigma0", HETAB_LENGTH},
                                                 [TAU] = {"tau", HETAB_LENGTH},
                                                 [INDEX_N] = {"n", HETAB_PLAIN},
                                                 [INDEX_K] = {"k", HETAB_PLAIN},
                                                 [DIFFUSE] = {"diffusebrdf", HETAB_PLAIN}};

static const struct {
  const char *name, *unit;
  size_t offset; /* in hetab_point */
} columns[COLUMNS] = {
    [LAMBDA] = {"lambda_um", " um", offsetof(hetab_point, lambda_um)},
    [THETA_I] = {"theta_i_deg", " degrees", offsetof(hetab_point, theta_i)},
    [THETA_R] = {"theta_r_deg", " degrees", offsetof(hetab_point, theta_r)},
    [PHI] = {"phi_deg", " degrees", offsetof(hetab_point, phi)},
    [SIGMA0] = {"sigma0_um", " um", offsetof(hetab_point, sigma0_um)},
    [TAU] = {"tau_um", " um", offsetof(hetab_point, tau_um)},
    [INDEX_N] = {"n", "", offsetof(hetab_point, n)},
    [INDEX_K] = {"k", "", offsetof(hetab_point, k)},
    [DIFFUSE] = {"diffuse_brdf", " / sr", offsetof(hetab_point, diffuse_brdf)},
};

/* What the library takes, and the words for it in the column's own unit. */
static hetab_rule rule_of(int c, char words[64]) {
  hetab_rule rule = {.wanted = words};
  hetab_point_limits(columns[c].offset, &rule.min, &rule.max);
  double size = wanted[c].quantity == HETAB_ANGLE ? 180.0 / M_PI : 1.0;
  snprintf(words, 64, "a value from %.6g to %.6g%s", size * rule.min, size * rule.max,
           columns[c].unit);
  return rule;
}

static const char *const output_names[] = {"dd", "sp_reflectance", "ud", "total", "g", "x"};

/* ---- the stream ---------------------------------------------------------------------------- */

typedef struct evaluation {
  hetab_context *ctx;
  hetab_surface *surface; /* NULL: every row brings its own */
  hetab_engine *engine;   /* NULL: the literal reference */
  int digits;             /* of the values written */
  int extrapolate;
  hetab_csv reader;
  hetab_rule rules[COLUMNS];
  char words[COLUMNS][64];
  size_t position[COLUMNS]; /* the field that holds a column, or HETAB_CSV_ABSENT */
  hetab_band band;          /* the surface at the wavelength last asked for */
  hetab_point points[BATCH];
  hetab_value values[BATCH];
  char *text; /* the batch's input lines, each ending in NUL */
  size_t text_length, text_capacity;
} evaluation;

/* ---- the header ---------------------------------------------------------------------------- */

static int place_column(evaluation *e, int c) {
  if (hetab_csv_find(&e->reader, c, "lambda_um, wavelength_nm, theta_i_deg or theta_i_rad",
                     &e->position[c]) == HETAB_OK)
    return -1;
  return cli_fail_context(e->ctx);
}

static int check_name(const evaluation *e, const char *name) {
  for (size_t i = 0; i < sizeof output_names / sizeof *output_names; i++)
    if (strcmp(name, output_names[i]) == 0)
      return cli_fail("stdin:%zu: column '%s' is one that this command appends: rename it",
                      e->reader.line, name);
  return -1;
}

static int check_columns(const evaluation *e) {
  for (int c = 0; c < DIFFUSE; c++) {
    int needed = c < ANGLES_END || !e->surface;
    if (needed && e->position[c] == HETAB_CSV_ABSENT)
      return cli_fail("stdin:%zu: no column '%s'%s: add it", e->reader.line, columns[c].name,
                      c < ANGLES_END ? "" : ", and no SURFACE given to take it from");
  }
  if ((e->position[INDEX_N] == HETAB_CSV_ABSENT) != (e->position[INDEX_K] == HETAB_CSV_ABSENT))
    return cli_fail("stdin:%zu: columns 'n' and 'k' belong together: give both or none",
                    e->reader.line);
  return -1;
}

/* The names appended are separated as the others are. */
static void print_header(const evaluation *e) {
  fputs(e->reader.content, stdout);
  for (size_t i = 0; i < sizeof output_names / sizeof *output_names; i++)
    printf("%c%s", e->reader.separator, output_names[i]);
  putchar('\n');
}

static int read_header(evaluation *e) {
  CLI_CALL(e->ctx, hetab_csv_header(&e->reader, wanted, COLUMNS));
  if (!e->reader.columns)
    return cli_fail("stdin: no input: give a CSV header line and points");
  int status = -1;
  for (size_t i = 0; i < e->reader.columns && status < 0; i++)
    status = check_name(e, e->reader.column[i].name);
  for (int c = 0; c < COLUMNS && status < 0; c++)
    status = place_column(e, c);
  if (status < 0)
    status = check_columns(e);
  if (status < 0)
    print_header(e);
  return status;
}

/* ---- rows ---------------------------------------------------------------------------------- */

/* Linear between the surface's wavelengths, the end values beyond them. */
static double diffuse_at(const hetab_surface *surface, double lambda_um) {
  const hetab_band *bands = hetab_surface_bands(surface);
  size_t last = hetab_surface_band_count(surface) - 1, i = 0;
  if (lambda_um <= bands[0].lambda_um)
    return bands[0].diffuse_brdf;
  if (lambda_um >= bands[last].lambda_um)
    return bands[last].diffuse_brdf;
  while (bands[i + 1].lambda_um < lambda_um)
    i++;
  double t = (lambda_um - bands[i].lambda_um) / (bands[i + 1].lambda_um - bands[i].lambda_um);
  return (1 - t) * bands[i].diffuse_brdf + t * bands[i + 1].diffuse_brdf;
}

static int update_band(evaluation *e, double lambda_um) {
  if (e->band.lambda_um == lambda_um)
    return -1;
  e->band = (hetab_band){.diffuse_brdf = diffuse_at(e->surface, lambda_um)};
  if (e->position[INDEX_N] == HETAB_CSV_ABSENT &&
      hetab_index_at(e->ctx, hetab_surface_index(e->surface), lambda_um, e->extrapolate, &e->band.n,
                     &e->band.k) != HETAB_OK)
    return cli_fail("stdin:%zu: lambda_um: %s", e->reader.line, hetab_error_message(e->ctx));
  e->band.lambda_um = lambda_um;
  return -1;
}

/* What the row does not say, the surface does. */
static int fill_from_surface(evaluation *e, hetab_point *p) {
  int status = update_band(e, p->lambda_um);
  if (e->position[SIGMA0] == HETAB_CSV_ABSENT)
    p->sigma0_um = hetab_surface_sigma0_um(e->surface);
  if (e->position[TAU] == HETAB_CSV_ABSENT)
    p->tau_um = hetab_surface_tau_um(e->surface);
  if (e->position[INDEX_N] == HETAB_CSV_ABSENT) {
    p->n = e->band.n;
    p->k = e->band.k;
  }
  if (e->position[DIFFUSE] == HETAB_CSV_ABSENT)
    p->diffuse_brdf = e->band.diffuse_brdf;
  return status;
}

/* The row at hand as a point. */
static int parse_row(evaluation *e, hetab_point *p) {
  *p = (hetab_point){0};
  for (int c = 0; c < COLUMNS; c++) {
    double *value = (double *)(void *)((char *)p + columns[c].offset);
    if (e->position[c] != HETAB_CSV_ABSENT &&
        hetab_csv_number(&e->reader, e->position[c], &e->rules[c], value) != HETAB_OK)
      return cli_fail_context(e->ctx);
  }
  int status = e->surface ? fill_from_surface(e, p) : -1;
  if (status < 0 && hetab_check_point(e->ctx, p) != HETAB_OK) /* and what it took from there */
    status = cli_fail("stdin:%zu: %s", e->reader.line, hetab_error_message(e->ctx));
  return status;
}

/* Keeps the current line for the output. */
static int keep_line(evaluation *e) {
  size_t size = strlen(e->reader.content) + 1;
  if (e->text_length + size > e->text_capacity) {
    size_t capacity = 2 * (e->text_capacity + size);
    char *grown = realloc(e->text, capacity);
    if (!grown)
      return cli_fail("out of memory");
    e->text = grown;
    e->text_capacity = capacity;
  }
  memcpy(e->text + e->text_length, e->reader.content, size);
  e->text_length += size;
  return -1;
}

/* The next rows, as many as fit; fewer before the end of the input or a bad row. */
static int read_batch(evaluation *e, size_t *count) {
  e->text_length = 0;
  for (*count = 0; *count < BATCH && e->text_length < BATCH_TEXT; ++*count) {
    CLI_CALL(e->ctx, hetab_csv_row(&e->reader));
    if (!e->reader.count)
      return CLI_OK;
    size_t start = e->text_length;
    int status = keep_line(e);
    if (status < 0)
      status = parse_row(e, &e->points[*count]);
    if (status >= 0) {
      e->text_length = start;
      return status;
    }
  }
  return -1;
}

/* In the file's separators and decimals. */
static void print_value(const evaluation *e, double value) {
  char text[32];
  snprintf(text, sizeof text, "%.*g", e->digits, value);
  char *point = e->reader.decimal == ',' ? strchr(text, '.') : NULL;
  if (point)
    *point = ',';
  putchar(e->reader.separator);
  fputs(text, stdout);
}

static int evaluate_batch(evaluation *e, size_t count) {
  hetab_status status = e->engine ? hetab_evaluate(e->ctx, e->engine, e->points, count, e->values)
                                  : hetab_evaluate_literal(e->ctx, e->points, count, e->values);
  CLI_CALL(e->ctx, status);
  const char *line = e->text;
  for (size_t i = 0; i < count; i++) {
    const hetab_value *v = &e->values[i];
    const double values[] = {v->dd, v->specular, v->ud, v->total, v->g, v->x};
    fputs(line, stdout);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++)
      print_value(e, values[k]);
    putchar('\n');
    line += strlen(line) + 1;
  }
  return ferror(stdout) ? CLI_OK : -1; /* main reports what is wrong with standard output */
}

/* Batch by batch; the rows before a bad one are still answered. */
static int evaluate_stream(evaluation *e) {
  int status = read_header(e);
  while (status < 0) {
    size_t count;
    status = read_batch(e, &count);
    int evaluated = count ? evaluate_batch(e, count) : -1;
    if (evaluated >= 0 && status <= CLI_OK)
      status = evaluated;
    if (cli_signal())
      status = cli_fail("stopped");
  }
  return status;
}

/* ---- the command --------------------------------------------------------------------------- */

typedef struct request {
  const char *surface;
  int precision, literal, extrapolate;
  const char *device;
} request;

static int prepare(evaluation *e, const request *r) {
  hetab_engine_options options = {.devices = r->device,
                                  .precision = r->precision ? HETAB_DOUBLE : HETAB_FLOAT,
                                  .method = HETAB_METHOD_SERIES};
  if (r->surface && hetab_surface_open(e->ctx, r->surface, &e->surface) != HETAB_OK)
    return cli_fail_context(e->ctx);
  if (!r->literal && hetab_engine_create(e->ctx, &options, &e->engine) != HETAB_OK)
    return cli_fail_context(e->ctx);
  for (int c = 0; c < COLUMNS; c++)
    e->rules[c] = rule_of(c, e->words[c]);
  e->digits = r->precision || r->literal ? 17 : 9;
  e->extrapolate = r->extrapolate;
  return -1;
}

static int run_request(const request *r) {
  HETAB_FREED evaluation *e = calloc(1, sizeof *e);
  if (!e)
    return cli_fail("out of memory");
  e->ctx = cli_context();
  hetab_csv_of_stream(e->ctx, "stdin", stdin, &e->reader);
  int status = e->ctx ? prepare(e, r) : CLI_FAILURE;
  if (status < 0)
    status = evaluate_stream(e);
  hetab_engine_free(e->engine);
  hetab_surface_free(e->surface);
  hetab_csv_clear(&e->reader);
  hetab_context_free(e->ctx);
  free(e->text);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {0};
  const cli_option options[] = {
      CLI_PRECISION(&r.precision),
      {CLI_CHOICE, "method", 0, "series|literal",
       "the kernels' series, or the printed equations in double on the host (series)", &r.literal,
       0, 0},
      CLI_DEVICE(&r.device),
      {CLI_FLAG, "extrapolate", 0, NULL, "allow wavelengths outside SURFACE's index data",
       &r.extrapolate, 0, 0},
      {0},
  };
  CLI_TRY(cli_parse_operand(self, options, argc, argv, NULL, &r.surface));
  return run_request(&r);
}

const cli_command cli_eval = {
    .name = "eval",
    .arguments = "[SURFACE] < POINTS.csv",
    .summary = "the model at the points of a CSV stream",
    .description =
        "Reads CSV with a header line on standard input, a point a row, and writes it to standard "
        "output with the columns dd, sp_reflectance, ud, total, g and x appended: the "
        "directional-diffuse BRDF (1/sr), the specular reflectance rho_s(theta_i), the "
        "uniform-diffuse BRDF (1/sr), dd + ud (1/sr), and the model's roughness phase and lateral "
        "variables.\n\n"
        "Columns, in any order and separated by commas, semicolons or tabs: lambda_um (or "
        "wavelength_nm), theta_i_deg, theta_r_deg and phi_deg (the viewer's azimuth minus the "
        "light's: 180 is the mirror side; or _rad) have to be there; sigma0_um, tau_um, "
        "n, k and diffuse_brdf (1/sr) are taken from SURFACE (a preset or a YAML file) where a "
        "column is missing. Other columns pass through.",
    .run = run,
};
