/* Look-ups on one core: evaluations and samples per second, random directions, beside the error
 * against the literal model; CSV on standard output.
 * usage: lookup_speed FOLDER SURFACE...   (tables are written to FOLDER; .bsdf of the first only)
 */
#include <time.h>

#include "tests/lookup_support.h"

enum { COUNT = 1 << 18, RUNS = 15, PAIRS = 1000, PATH = 4 };

typedef struct load {
  float wi[COUNT][3], wo[COUNT][3], uc[COUNT], u[COUNT][2];
  float lambda_um[COUNT][PATH], value[COUNT * MOST_BANDS];
  hetab_lookup_drawn drawn[COUNT];
} load;

/* This thread's own: what else the machine does does not count. */
static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void random_directions(uint64_t *random, float (*w)[3]) {
  for (size_t n = 0; n < COUNT; n++)
    direction_at(acos(lookup_random(random)), 2 * M_PI * lookup_random(random), w[n]);
}

static load *new_load(void) {
  load *l = calloc(1, sizeof *l);
  uint64_t random = 3;
  if (!l)
    abort();
  random_directions(&random, l->wi);
  random_directions(&random, l->wo);
  for (size_t n = 0; n < COUNT; n++) {
    for (int k = 0; k < 2; k++)
      l->u[n][k] = (float)(lookup_random(&random) * 0.9999999);
    l->uc[n] = (float)(lookup_random(&random) * 0.9999999);
    for (int k = 0; k < PATH; k++)
      l->lambda_um[n][k] = (float)(0.4 + 0.3 * lookup_random(&random));
  }
  return l;
}

typedef void (*work_fn)(const hetab_lookup *table, load *l);

static void evaluate_batch(const hetab_lookup *table, load *l) {
  hetab_lookup_eval(table, NULL, COUNT, l->wi[0], l->wo[0], l->value, NULL);
}

static void evaluate_single(const hetab_lookup *table, load *l) {
  size_t channels = hetab_lookup_channel_count(table);
  for (size_t n = 0; n < COUNT; n++)
    hetab_lookup_eval(table, NULL, 1, l->wi[n], l->wo[n], l->value + n * channels, NULL);
}

/* At each path's own four wavelengths. */
static void evaluate_paths(const hetab_lookup *table, load *l) {
  const hetab_lookup_query query = {.lambda_um = l->lambda_um[0], .lambda_count = PATH};
  hetab_lookup_eval(table, &query, COUNT, l->wi[0], l->wo[0], l->value, NULL);
}

static void sample_paths(const hetab_lookup *table, load *l) {
  const hetab_lookup_query query = {.lambda_um = l->lambda_um[0], .lambda_count = PATH};
  hetab_lookup_sample(table, &query, COUNT, l->wi[0], l->uc, l->u[0], l->drawn, l->value);
}

static void sample_batch(const hetab_lookup *table, load *l) {
  hetab_lookup_sample(table, NULL, COUNT, l->wi[0], l->uc, l->u[0], l->drawn, l->value);
}

/* A second, by the fastest of the runs. */
static double per_second(work_fn work, const hetab_lookup *table, load *l) {
  double best = HUGE_VAL;
  for (int run = 0; run < RUNS; run++) {
    double start = seconds();
    work(table, l);
    best = fmin(best, seconds() - start);
  }
  return COUNT / best;
}

static void fail(hetab_context *ctx) {
  fprintf(stderr, "lookup_speed: %s\n", hetab_error_message(ctx));
  exit(1);
}

static void report(hetab_context *ctx, const char *format, const char *path, const char *rule,
                   const lookup_model *m, load *l) {
  static const double degrees[] = {0, 30, 60, 75, 85};
  hetab_lookup *table;
  uint64_t random = 1;
  double start = seconds();
  int nearest = strcmp(rule, "nearest") == 0;
  if (hetab_lookup_open(ctx, path, nearest ? HETAB_LOOKUP_NEAREST : HETAB_LOOKUP_INTERPOLATE,
                        &table) != HETAB_OK)
    fail(ctx);
  start = seconds() - start;
  int spectral = hetab_lookup_wavelengths_um(table) != NULL;
  printf("%s,%s,%zu,%s,%.3g,%.4g,%.4g,%.4g,%.4g,%.4g", hetab_surface_name(m->surface), format,
         hetab_lookup_channel_count(table), rule, start, per_second(evaluate_batch, table, l),
         per_second(evaluate_single, table, l), per_second(sample_batch, table, l),
         spectral ? per_second(evaluate_paths, table, l) : (double)NAN,
         spectral ? per_second(sample_paths, table, l) : (double)NAN);
  for (size_t t = 0; t < sizeof degrees / sizeof *degrees; t++)
    printf(",%.2e", error_at(look_up_table, table, m, degrees[t] * M_PI / 180, PAIRS, &random).l1);
  printf("\n");
  fflush(stdout);
  hetab_lookup_free(table);
}

static void measure_bsdf(hetab_context *ctx, const char *folder, const lookup_model *srgb,
                         load *l) {
  char path[4096];
  hetab_rgl *rgl;
  hetab_rgl_report made;
  hetab_rgl_options options = {.bands = HETAB_RGL_RGB};
  snprintf(path, sizeof path, "%s/lookup.bsdf", folder);
  if (hetab_tabulate_rgl(ctx, srgb->surface, &options, &rgl, &made) != HETAB_OK ||
      hetab_rgl_save(ctx, rgl, path, 1) != HETAB_OK)
    fail(ctx);
  hetab_rgl_free(rgl);
  report(ctx, "bsdf", path, "interpolated", srgb, l);
  remove(path);
}

static void measure(hetab_context *ctx, hetab_engine *engine, const char *folder, const char *name,
                    int with_bsdf, load *l) {
  static const double three_um[] = {0.45, 0.55, 0.65};
  hetab_merl_options colour = {.colour = HETAB_MERL_SRGB};
  hetab_surface *full, *three;
  char merl[4096], h5[4096];
  snprintf(merl, sizeof merl, "%s/lookup.binary", folder);
  snprintf(h5, sizeof h5, "%s/lookup.h5", folder);
  if (hetab_surface_open(ctx, name, &full) != HETAB_OK ||
      hetab_surface_open(ctx, name, &three) != HETAB_OK ||
      hetab_surface_set_wavelengths(ctx, three, three_um, 3) != HETAB_OK ||
      save_merl(ctx, engine, full, &colour, merl) != HETAB_OK ||
      save_h5(ctx, engine, three, NULL, h5) != HETAB_OK)
    fail(ctx);
  lookup_model srgb = model_of(ctx, full, 1), bands = model_of(ctx, three, 0);
  lookup_model spectral = model_of(ctx, full, 0);
  report(ctx, "merl", merl, "interpolated", &srgb, l);
  report(ctx, "merl", merl, "nearest", &srgb, l);
  report(ctx, "h5", h5, "interpolated", &bands, l);
  if (save_h5(ctx, engine, full, NULL, h5) != HETAB_OK)
    fail(ctx);
  report(ctx, "h5", h5, "interpolated", &spectral, l);
  report(ctx, "h5", h5, "nearest", &spectral, l);
  if (with_bsdf)
    measure_bsdf(ctx, folder, &srgb, l);
  remove(merl);
  remove(h5);
  hetab_surface_free(full);
  hetab_surface_free(three);
}

int main(int argc, char **argv) {
  hetab_context *ctx;
  hetab_engine *engine;
  if (argc < 3 || hetab_context_create(&ctx) != HETAB_OK)
    return 2;
  if (hetab_engine_create(ctx, NULL, &engine) != HETAB_OK)
    fail(ctx);
  load *l = new_load();
  printf("surface,format,channels,rule,open_s,evaluations_per_s,single_evaluations_per_s,"
         "samples_per_s,evaluations_at_4_per_s,samples_at_4_per_s,l1_0deg,l1_30deg,l1_60deg,l1_"
         "75deg,l1_85deg\n");
  for (int i = 2; i < argc; i++)
    measure(ctx, engine, argv[1], argv[i], i == 2, l);
  free(l);
  hetab_engine_free(engine);
  hetab_context_free(ctx);
  return 0;
}
