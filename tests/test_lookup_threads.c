/* Look-ups from many threads at once; `make tsan` runs it under ThreadSanitizer. No OpenCL: the
 * tables are made here, of the literal model. */
#include "table_support.h"

#include <math.h>
#include <pthread.h>

enum { THREADS = 4, PAIRS = 2000, BANDS = 3, ANGLES = 31 };
static const double bands_um[BANDS] = {0.45, 0.55, 0.65};

/* --- tables ---------------------------------------------------------------------------------- */

static double literal(hetab_context *ctx, double lambda_um, double theta_i, double theta_r,
                      double phi) {
  hetab_point point = {.lambda_um = lambda_um,
                       .theta_i = theta_i,
                       .theta_r = theta_r,
                       .phi = phi,
                       .sigma0_um = 0.13,
                       .tau_um = 5.4,
                       .n = 0.958,
                       .k = 6.69};
  hetab_value value;
  assert_ok(ctx, hetab_evaluate_literal(ctx, &point, 1, &value));
  return value.total;
}

static void save_h5(hetab_context *ctx, const char *path) {
  static float values[ANGLES * ANGLES * ANGLES];
  static double rho[BANDS * ANGLES];
  hetab_surface *surface;
  hetab_grid *grid;
  hetab_table_writer *writer;
  hetab_h5_options options = {.overwrite = 1};
  hetab_report report = {.device = "host"};
  assert_ok(ctx, hetab_surface_create(ctx, 0.13, 5.4, 0.958, 6.69, bands_um, BANDS, &surface));
  assert_ok(ctx, hetab_grid_create(ctx, &grid));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_I, "0:90:31"));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_THETA_R, "0:90:31"));
  assert_ok(ctx, hetab_grid_set_axis(ctx, grid, HETAB_PHI, "0:180:31"));
  assert_ok(ctx, hetab_h5_create(ctx, path, surface, grid, &options, &writer));
  for (size_t b = 0; b < BANDS; b++) {
    for (size_t n = 0; n < ANGLES * ANGLES * ANGLES; n++)
      values[n] = (float)literal(ctx, bands_um[b], M_PI / 60 * (double)(n / ANGLES / ANGLES),
                                 M_PI / 60 * (double)(n / ANGLES % ANGLES),
                                 M_PI / 30 * (double)(n % ANGLES));
    hetab_slab slab = {b, 0, ANGLES, values};
    assert_ok(ctx, hetab_table_write_slab(ctx, writer, &slab));
  }
  assert_ok(ctx, hetab_table_write_specular(ctx, writer, rho));
  assert_ok(ctx, hetab_table_write_report(ctx, writer, &report));
  assert_ok(ctx, hetab_table_commit(ctx, writer));
  hetab_grid_free(grid);
  hetab_surface_free(surface);
}

/* A lobe in theta_h on a plain. */
static void save_merl(hetab_context *ctx, const char *path) {
  hetab_merl *merl;
  assert_ok(ctx, hetab_merl_create(ctx, &merl));
  for (size_t cell = 0; cell < HETAB_MERL_CELLS; cell++)
    for (int c = 0; c < 3; c++) {
      double u = ((double)(cell / 180 / 90) + 0.5) / 90;
      hetab_merl_channel(merl, c)[cell] = 5 * exp(-50 * pow(u, 4)) + 0.1 * (c + 1);
    }
  assert_ok(ctx, hetab_merl_save(ctx, merl, path, 1));
  hetab_merl_free(merl);
}

/* --- work ------------------------------------------------------------------------------------ */

/* All that a table can be asked. */
typedef struct answers {
  float eval[PAIRS][BANDS], batch[PAIRS][BANDS], weight[PAIRS][BANDS];
  float pdf[PAIRS], albedo[PAIRS][BANDS], specular[PAIRS][BANDS];
  hetab_lookup_drawn drawn[PAIRS];
} answers;

typedef struct job {
  const hetab_lookup *table;
  const float (*wi)[3], (*wo)[3], (*u)[2];
  answers *out;
  pthread_t thread;
} job;

static void *work(void *user) {
  job *j = user;
  answers *a = j->out;
  hetab_lookup_eval(j->table, NULL, PAIRS, j->wi[0], j->wo[0], a->batch[0], a->pdf);
  for (size_t n = 0; n < PAIRS; n++) {
    hetab_lookup_eval(j->table, NULL, 1, j->wi[n], j->wo[n], a->eval[n], NULL);
    hetab_lookup_sample(j->table, NULL, 1, j->wi[n], &j->u[n][0], j->u[n], &a->drawn[n],
                        a->weight[n]);
    hetab_lookup_albedo(j->table, NULL, 1, j->wi[n], a->albedo[n], a->specular[n]);
  }
  return NULL;
}

static void fill(float (*wi)[3], float (*wo)[3], float (*u)[2]) {
  unsigned random = 1;
  for (size_t n = 0; n < PAIRS; n++) {
    float x[4];
    for (int k = 0; k < 4; k++) {
      random = random * 1664525 + 1013904223;
      x[k] = (float)(random >> 8) * 0x1p-24f;
    }
    for (int side = 0; side < 2; side++) {
      float *w = side ? wo[n] : wi[n], z = x[2 * side], phi = 6.2831853f * x[2 * side + 1];
      w[0] = sqrtf(1 - z * z) * cosf(phi);
      w[1] = sqrtf(1 - z * z) * sinf(phi);
      w[2] = z;
    }
    u[n][0] = x[3];
    u[n][1] = x[0];
  }
}

/* Each thread gets what one thread alone gets, bit for bit. */
static void assert_same_from_threads(hetab_context *ctx, const char *path, hetab_lookup_rule rule) {
  static float wi[PAIRS][3], wo[PAIRS][3], u[PAIRS][2];
  static answers all[THREADS + 1];
  job jobs[THREADS + 1];
  hetab_lookup *table;
  assert_ok(ctx, hetab_lookup_open(ctx, path, rule, &table));
  fill(wi, wo, u);
  for (int t = 0; t <= THREADS; t++)
    jobs[t] = (job){.table = table,
                    .wi = (const float(*)[3])wi,
                    .wo = (const float(*)[3])wo,
                    .u = (const float(*)[2])u,
                    .out = &all[t]};
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_create(&jobs[t].thread, NULL, work, &jobs[t]), 0);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_join(jobs[t].thread, NULL), 0);
  work(&jobs[THREADS]);
  double sum = 0;
  for (size_t n = 0; n < PAIRS; n++)
    sum += (double)all[0].eval[n][1] + (double)all[0].weight[n][2];
  assert_true(sum > 1 && isfinite(sum));
  for (int t = 0; t < THREADS; t++)
    assert_memory_equal(&all[t], &all[THREADS], sizeof all[t]);
  hetab_lookup_free(table);
}

static void threads_share_a_table(void **state) {
  hetab_context *ctx = ((fixture *)*state)->ctx;
  save_merl(ctx, "t.binary");
  save_h5(ctx, "t.h5");
  for (int rule = HETAB_LOOKUP_INTERPOLATE; rule <= HETAB_LOOKUP_NEAREST; rule++) {
    assert_same_from_threads(ctx, "t.binary", (hetab_lookup_rule)rule);
    assert_same_from_threads(ctx, "t.h5", (hetab_lookup_rule)rule);
  }
}

/* --- opening --------------------------------------------------------------------------------- */

static void *open_alone(void *user) {
  float value[BANDS];
  hetab_context *ctx;
  hetab_lookup *table;
  if (hetab_context_create(&ctx) != HETAB_OK)
    return NULL;
  for (int i = 0; i < 10 && hetab_lookup_open(ctx, "t.h5", HETAB_LOOKUP_NEAREST, &table) == 0;
       i++) {
    hetab_lookup_eval(table, NULL, 1, (float[]){0, 0, 1}, (float[]){0, 0, 1}, value, NULL);
    *(double *)user += (double)value[0];
    hetab_lookup_free(table);
  }
  hetab_context_free(ctx);
  return NULL;
}

/* HDF5 files, each thread with a context of its own: the library has a state of its own. */
static void threads_open_tables(void **state) {
  pthread_t threads[THREADS];
  double sums[THREADS + 1] = {0};
  save_h5(((fixture *)*state)->ctx, "t.h5");
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_create(&threads[t], NULL, open_alone, &sums[t]), 0);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_join(threads[t], NULL), 0);
  open_alone(&sums[THREADS]);
  assert_true(sums[THREADS] > 0);
  for (int t = 0; t < THREADS; t++)
    assert_true(sums[t] == sums[THREADS]);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(threads_share_a_table), TEST(threads_open_tables)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
