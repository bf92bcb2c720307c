/* Devices, engines, the kernel cache and bad points. What must be set before OpenCL starts runs in
 * children, as `test_engine NAME`. */
#include "golden_support.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

static const hetab_point good = {.lambda_um = 0.55,
                                 .theta_i = 0.5,
                                 .theta_r = 0.6,
                                 .phi = 3,
                                 .sigma0_um = 0.3,
                                 .tau_um = 4,
                                 .n = 0.958,
                                 .k = 6.69};

/* --- engines --------------------------------------------------------------------------------- */

static void test_list(void **state) {
  hetab_device_info *list;
  size_t count;
  assert_ok(*state, hetab_device_list(*state, &list, &count));
  assert_true(count >= 1);
  for (size_t i = 0; i < count; i++) {
    assert_true(list[i].name[0] && list[i].platform[0] && list[i].driver[0]);
    assert_true(list[i].opencl[0]);
    assert_true(list[i].compute_units >= 1 && list[i].memory_bytes > 1u << 20);
    assert_true(list[i].float_width >= 1);
  }
  free(list);
}

static void test_defaults(void **state) {
  hetab_engine *engine;
  assert_ok(*state, hetab_engine_create(*state, NULL, &engine));
  assert_int_equal(hetab_engine_precision(engine), HETAB_FLOAT);
  assert_int_equal(hetab_engine_method(engine), HETAB_METHOD_ROWS);
  assert_true(hetab_engine_tolerance(engine) == 1e-5);
  assert_non_null(strstr(hetab_engine_device(engine), "compute unit"));
  hetab_engine_free(engine);
  engine = new_engine(*state, HETAB_DOUBLE, HETAB_METHOD_SERIES, 0);
  assert_int_equal(hetab_engine_precision(engine), HETAB_DOUBLE);
  assert_true(hetab_engine_tolerance(engine) == 1e-9);
  hetab_engine_free(engine);
  hetab_engine_free(NULL);
  assert_string_equal(hetab_method_name(HETAB_METHOD_ROWS), "rows");
  assert_string_equal(hetab_method_name(HETAB_METHOD_SERIES), "series");
  assert_string_equal(hetab_method_name(HETAB_METHOD_LITERAL), "literal");
  assert_string_equal(hetab_precision_name(HETAB_FLOAT), "float");
  assert_string_equal(hetab_precision_name(HETAB_DOUBLE), "double");
}

static void test_selectors(void **state) {
  hetab_device_info *list;
  size_t count;
  char part[6] = "";
  assert_ok(*state, hetab_device_list(*state, &list, &count));
  memcpy(part, list[0].name, sizeof part - 1);
  free(list);
  const char *const selectors[] = {"0", "all", part, "0,0", NULL};
  for (size_t i = 0; i < sizeof selectors / sizeof *selectors; i++) {
    hetab_engine *engine;
    hetab_value value;
    hetab_engine_options options = {.devices = selectors[i]};
    assert_ok(*state, hetab_engine_create(*state, &options, &engine));
    assert_ok(*state, hetab_evaluate(*state, engine, &good, 1, &value));
    hetab_engine_free(engine);
  }
}

static void test_selectors_refused(void **state) {
  static const char *const selectors[] = {"99", "no such thing",       "", ",",
                                          "-1", "99999999999999999999"};
  for (size_t i = 0; i < sizeof selectors / sizeof *selectors; i++) {
    hetab_engine *engine = (hetab_engine *)state;
    hetab_engine_options options = {.devices = selectors[i]};
    assert_fails(*state, hetab_engine_create(*state, &options, &engine), HETAB_ERR_DEVICE,
                 (const char *const[]){"matches", selectors[i], NULL});
    assert_null(engine);
  }
  /* every part of a list has to name a device */
  hetab_engine *engine = (hetab_engine *)state;
  hetab_engine_options options = {.devices = "0,7"};
  assert_fails(*state, hetab_engine_create(*state, &options, &engine), HETAB_ERR_DEVICE,
               (const char *const[]){"matches", "'7'", NULL});
  assert_null(engine);
}

static void test_tolerance_refused(void **state) {
  static const double tolerances[] = {-1, -1e-300, 1, 5, INFINITY, NAN};
  for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; i++) {
    hetab_engine *engine = (hetab_engine *)state;
    hetab_engine_options options = {.tolerance = tolerances[i]};
    assert_fails(*state, hetab_engine_create(*state, &options, &engine), HETAB_ERR_ARGUMENT,
                 (const char *const[]){"tolerance", "between 0 and 1", NULL});
    assert_null(engine);
  }
}

/* Tolerances that no arithmetic reaches: refused, for a search for them would not end. */
static void test_unreachable_tolerances(void **state) {
  static const double tolerances[] = {1e-16, 1e-300};
  for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; i++) {
    hetab_engine *engine = (hetab_engine *)state;
    hetab_engine_options options = {.precision = HETAB_DOUBLE, .tolerance = tolerances[i]};
    assert_fails(*state, hetab_engine_create(*state, &options, &engine), HETAB_ERR_ARGUMENT,
                 (const char *const[]){"tolerance", NULL});
    assert_null(engine);
  }
}

/* --- points ---------------------------------------------------------------------------------- */

static void test_bad_points(void **state) {
#define FIELD(name)                                                                                \
  { #name, offsetof(hetab_point, name) }
  static const struct {
    const char *name;
    size_t offset;
  } fields[] = {FIELD(lambda_um), FIELD(theta_i),   FIELD(theta_r),
                FIELD(phi),       FIELD(sigma0_um), FIELD(tau_um),
                FIELD(n),         FIELD(k),         FIELD(diffuse_brdf)};
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_SERIES, 0);
  for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
    const double values[] = {NAN, INFINITY, -INFINITY, -1, 0, 1.6};
    for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
      hetab_point points[] = {good, good, good, good};
      hetab_value out[4];
      memcpy((char *)&points[2] + fields[f].offset, &values[v], sizeof(double));
      const char *name = fields[f].name;
      int angle = strncmp(name, "theta", 5) == 0;
      int zero_is_fine = angle || strchr("pkd", name[0]);
      if ((values[v] == -1 && strcmp(name, "phi") == 0) || (values[v] == 0 && zero_is_fine) ||
          (values[v] == 1.6 && !angle))
        continue;
      memset(out, 0x55, sizeof out);
      const char *const words[] = {"point 2", name, NULL};
      assert_fails(*state, hetab_evaluate(*state, engine, points, 4, out), HETAB_ERR_ARGUMENT,
                   words);
      assert_true(((const unsigned char *)out)[0] == 0x55); /* untouched */
      assert_fails(*state, hetab_evaluate_literal(*state, points, 4, out), HETAB_ERR_ARGUMENT,
                   words);
      assert_true(((const unsigned char *)out)[0] == 0x55);
    }
  }
  hetab_engine_free(engine);
}

/* Any number of points: none, one, a vector's width and its neighbours, several batches. */
static void test_counts(void **state) {
  static const size_t counts[] = {0, 1, 15, 16, 17, 65535, 65536, 65537, 140000};
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_SERIES, 0);
  hetab_point *points = calloc(140000, sizeof *points);
  for (size_t i = 0; i < 140000; i++) {
    points[i] = good;
    points[i].theta_r = 1.5 * (double)i / 140000;
    points[i].diffuse_brdf = 0.001 * (double)(i % 7);
  }
  hetab_value *all = device_values(*state, HETAB_FLOAT, points, 140000);
  for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
    hetab_value *values = calloc(counts[c] + 1, sizeof *values);
    values[counts[c]].dd = -7;
    assert_ok(*state, hetab_evaluate(*state, engine, points, counts[c], values));
    if (counts[c])
      assert_memory_equal(values, all, counts[c] * sizeof *values);
    assert_true(values[counts[c]].dd == -7);
    free(values);
  }
  free(all);
  free(points);
  hetab_engine_free(engine);
}

static int count_calls(void *user, double done, double total) {
  int *calls = user;
  assert_true(done <= total && total == 140000);
  return ++*calls == 2;
}

static void test_cancel(void **state) {
  int calls = 0;
  hetab_engine *engine = new_engine(*state, HETAB_FLOAT, HETAB_METHOD_SERIES, 0);
  hetab_point *points = calloc(140000, sizeof *points);
  hetab_value *values = calloc(140000, sizeof *values);
  for (size_t i = 0; i < 140000; i++)
    points[i] = good;
  hetab_set_progress(*state, count_calls, &calls);
  assert_int_equal(hetab_evaluate(*state, engine, points, 140000, values), HETAB_ERR_CANCELLED);
  assert_int_equal(calls, 2);
  free(points);
  free(values);
  hetab_engine_free(engine);
}

/* --- children -------------------------------------------------------------------------------- */

/* No device: a message that names the package; the literal reference still works. */
static void child_no_device(void **state) {
  hetab_engine *engine = (hetab_engine *)state;
  hetab_device_info *list;
  hetab_value value;
  size_t count = 7;
  assert_ok(*state, hetab_device_list(*state, &list, &count));
  assert_int_equal(count, 0);
  free(list);
  assert_fails(*state, hetab_engine_create(*state, NULL, &engine), HETAB_ERR_DEVICE,
               (const char *const[]){"no OpenCL device", "pocl-opencl-icd", NULL});
  assert_null(engine);
  hetab_engine_options all = {.devices = "all"};
  assert_fails(*state, hetab_engine_create(*state, &all, &engine), HETAB_ERR_DEVICE,
               (const char *const[]){"pocl-opencl-icd", NULL});
  assert_ok(*state, hetab_evaluate_literal(*state, &good, 1, &value));
  assert_true(value.dd > 0);
  hetab_engine_options literal = {.method = HETAB_METHOD_LITERAL};
  assert_ok(*state, hetab_engine_create(*state, &literal, &engine));
  assert_ok(*state, hetab_evaluate(*state, engine, &good, 1, &value));
  hetab_engine_free(engine);
}

/* Prints nothing but evaluates a point; what the cache looks like is the parent's to see. */
static void child_evaluate(void **state) {
  hetab_value *value = device_values(*state, HETAB_FLOAT, &good, 1);
  hetab_value *literal = literal_values(*state, &good, 1);
  assert_true(relative_error(value->dd, literal->dd) < TOL_GOLDEN_FLOAT);
  free(value);
  free(literal);
}

/* --- the cache ------------------------------------------------------------------------------- */

typedef struct folder {
  char path[32], variable[64];
} folder;

static void make_folder(folder *f) {
  strcpy(f->path, "/tmp/hetab-cache-XXXXXX");
  assert_non_null(mkdtemp(f->path));
  snprintf(f->variable, sizeof f->variable, "XDG_CACHE_HOME=%s", f->path);
}

static void remove_folder(const folder *f) {
  char command[160];
  snprintf(command, sizeof command, "chmod -R u+w %s && rm -rf %s", f->path, f->path);
  assert_int_equal(system(command), 0);
}

/* The one cached kernel of a folder; its name. */
static void cached_file(const folder *f, char *path, size_t size, int *count) {
  char directory[64];
  snprintf(directory, sizeof directory, "%s/hetab", f->path);
  DIR *dir = opendir(directory);
  *count = 0;
  for (struct dirent *e; dir && (e = readdir(dir));)
    if (e->d_name[0] != '.') {
      snprintf(path, size, "%s/%s", directory, e->d_name);
      ++*count;
    }
  if (dir)
    closedir(dir);
}

static void run_child(const folder *f) {
  assert_int_equal(run_again("evaluate", (const char *const[]){f->variable, NULL}), 0);
}

static void test_cache(void **state) {
  folder f;
  char path[512];
  int count;
  struct stat first, second;
  make_folder(&f);
  run_child(&f);
  cached_file(&f, path, sizeof path, &count);
  assert_int_equal(count, 1);
  assert_int_equal(stat(path, &first), 0);
  assert_true(first.st_size > 1000);
  run_child(&f);
  cached_file(&f, path, sizeof path, &count);
  assert_int_equal(count, 1);
  assert_int_equal(stat(path, &second), 0);
  assert_true(first.st_ino == second.st_ino); /* read, not written again */
  remove_folder(&f);
}

/* Whatever stands in the cache's place: the kernel is compiled anew. */
static void test_corrupt_cache(void **state) {
  for (int damage = 0; damage < 4; damage++) {
    folder f;
    char path[512];
    int count;
    make_folder(&f);
    run_child(&f);
    cached_file(&f, path, sizeof path, &count);
    assert_int_equal(count, 1);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    FILE *file = fopen(path, damage == 3 ? "r+b" : "wb");
    if (damage == 1)
      fputs("not a kernel", file);
    if (damage == 2)
      for (int i = 0; i < 100000; i++)
        fputc(i * 37 & 255, file);
    fclose(file);
    if (damage == 3) /* cut short */
      assert_int_equal(truncate(path, info.st_size / 2), 0);
    print_message("  damage %d\n", damage);
    run_child(&f);
    remove_folder(&f);
  }
}

static void test_unwritable_cache(void **state) {
  folder f;
  char command[256];
  make_folder(&f);
  /* a file where the folder should be: nobody, not even root, can write into it */
  snprintf(command, sizeof command, "touch %s/hetab", f.path);
  assert_int_equal(system(command), 0);
  run_child(&f);
  snprintf(command, sizeof command, "rm %s/hetab && mkdir %s/hetab && chmod 555 %s/hetab", f.path,
           f.path, f.path);
  assert_int_equal(system(command), 0);
  run_child(&f);
  remove_folder(&f);
  /* PoCL, which has a cache of its own, finds no device without one */
  char pocl[64];
  make_folder(&f);
  snprintf(pocl, sizeof pocl, "POCL_CACHE_DIR=%s", f.path);
  assert_int_equal(
      run_again("evaluate", (const char *const[]){"XDG_CACHE_HOME=/proc/nowhere", pocl, NULL}), 0);
  assert_int_equal(
      run_again("evaluate", (const char *const[]){"XDG_CACHE_HOME=relative", "HOME=", pocl, NULL}),
      0);
  remove_folder(&f);
}

static void test_no_device(void **state) {
  folder f;
  char setting[96];
  make_folder(&f);
  snprintf(setting, sizeof setting, "OCL_ICD_VENDORS=%s", f.path);
  assert_int_equal(run_again("no-device", (const char *const[]){setting, NULL}), 0);
  remove_folder(&f);
}

int main(int argc, char **argv) {
  if (argc > 1) {
    const struct CMUnitTest no_device[] = {TEST(child_no_device)};
    const struct CMUnitTest evaluate[] = {TEST(child_evaluate)};
    return strcmp(argv[1], "no-device") == 0 ? cmocka_run_group_tests(no_device, NULL, NULL)
                                             : cmocka_run_group_tests(evaluate, NULL, NULL);
  }
  const struct CMUnitTest tests[] = {
      TEST(test_list),
      TEST(test_defaults),
      TEST(test_selectors),
      TEST(test_selectors_refused),
      TEST(test_tolerance_refused),
      TEST(test_unreachable_tolerances),
      TEST(test_bad_points),
      TEST(test_counts),
      TEST(test_cancel),
      TEST(test_no_device),
      TEST(test_cache),
      TEST(test_corrupt_cache),
      TEST(test_unwritable_cache),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
