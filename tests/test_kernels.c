/* The physics of kernels/ *.h, function by function: the host's double build against values
 * computed with 50 digits (mpmath), and the device's float and double builds against the host's at
 * the same arguments. */
#include "golden_support.h"

#include <CL/cl.h>

#define HETAB_HOST
#include "kernels/he_torrance.h"
#include "kernels/shadowing.h"

/* --- 50 digits ------------------------------------------------------------------------------- */

static const struct {
  double ln_kappa, w;
} lambert[] = {
    {-80.0, 1.8048513878454151723e-35},
    {-40.0, 4.2483542552915889773e-18},
    {-10.0, 0.00004539786874921542957},
    {-1.0, 0.27846454276107379511},
    {-0.25, 0.48128846639758644397},
    {0.0, 0.567143290409783873},
    {1.0, 1.0},
    {3.0, 2.2079400315693229986},
    {20.0, 17.157561046215552932},
    {20.5, 17.63037664022108086},
    {100.0, 95.44148664557583184},
    {700.0, 693.45830887902549834},
    {5000.0, 4991.484511358231794},
};
static const struct {
  double cos2, n, k, f;
} fresnel[] = {
    {1, 1.5, 0.0, 0.04},
    {0.5, 1.5, 0.0, 0.050239911012235940461},
    {0.3076923076923077, 1.5, 0.0, 0.073964497041420114694},
    {1e-06, 1.5, 0.0, 0.99420557250850127679},
    {0, 1.5, 0.0, 1.0},
    {0.25, 0.958, 6.69, 0.9069217187496342333},
    {1, 0.958, 6.69, 0.92113581548612691219},
    {0.0001, 0.958, 6.69, 0.98068445184586524736},
    {0.75, 0.05, 3.3, 0.98320305771050679954},
    {0.9, 3.2, 2.2, 0.43053843878804609838},
    {0.5, 0.5, 0.0, 1.0},
    {0.75, 0.5, 0.0, 1.0},
    {0.8, 0.5, 0.0, 0.17999999999999992006},
    {0.3, 4.0, 0.0, 0.35778503943079808539},
    {0.7, 1.0001, 0.0, 2.9587566232754457365e-9},
    {0.2, 1.0001, 0.0, 4.2455788885926837512e-8},
    {0.6, 1.3, 0.001, 0.020384801141065762671},
    {1, 1.0, 0.0, 0.0},
    {0.5, 1.0, 0.01, 0.000049986257994189102649},
};
static const struct {
  double mu, tau_2sigma, shadow_over_cos, k;
} shadow[] = {
    {1.0, 0.05, 1.0, 0},
    {1.0, 1.0, 1.0, 0},
    {1.0, 6.0, 1.0, 0},
    {1.0, 500.0, 1.0, 0},
    {0.9, 0.05, 0.19010603439676088915, 0.42810294301206397913},
    {0.9, 1.0, 1.1089744004569382328, 0.0016953578179267925636},
    {0.9, 6.0, 1.1111111111111110837, 4.8906286262360503728e-69},
    {0.9, 500.0, 1.1111111111111110837, 0},
    {0.5, 0.05, 0.10044213244315639508, 1.6756475172297720209},
    {0.5, 1.0, 1.3873984553655409205, 0.71744346603305964843},
    {0.5, 6.0, 1.999998999307488847, 1.6685832847974098847e-6},
    {0.5, 500.0, 2.0, 0},
    {0.1, 0.05, 0.08878119498981002337, 9.8934558876148824569},
    {0.1, 1.0, 1.6686482921406527891, 8.8252829751614606858},
    {0.1, 6.0, 7.1178958478311936509, 3.9179484459640432136},
    {0.1, 500.0, 9.9999999999999994449, 0},
    {0.01, 0.05, 0.088598584479398362915, 99.938580921341021611},
    {0.01, 1.0, 1.7611505424279856062, 98.866658323170200189},
    {0.01, 6.0, 10.229700415734655817, 93.232841246424291099},
    {0.01, 500.0, 99.999999999921843154, 1.5334699985737361127e-10},
    {1e-06, 0.05, 0.088622689691338515024, 999999.94358054169048},
    {1e-06, 1.0, 1.7724527093139996298, 999998.87162033295012},
    {1e-06, 6.0, 10.634682008157093043, 999993.22972449755342},
    {1e-06, 500.0, 885.94155866248985109, 999435.81046296808407},
};
static const struct {
  double g, x, ln_h;
} series[] = {
    {0.0, 0.0, 0.0},
    {0.0, 2.5, -2.5},
    {1e-10, 0.0, -7.499999999975694717685751e-11},
    {1e-10, 20.0, -19.99999944943850640087926},
    {0.001, 3.0, -2.999879794794649987872016},
    {0.1, 0.0, -0.07475520697968528867063766},
    {0.1, 30.0, -17.15816050326349282767859},
    {1.0, 5.0, -4.182877273638804624359256},
    {1.0, 60.0, -18.26998294614239633401987},
    {10.0, 0.0, -4.482808513007409082112683},
    {10.0, 100.0, -13.07520557133803046629898},
    {18.5, 148.0, -13.20445447546001733251678},
    {19.999, 50.0, -8.529599512422427816921505},
    {20.001, 50.0, -8.529553538269601918039939},
    {30.0, 0.0, -6.767207506554060919729616},
    {30.0, 1800.0, -48.86059878478322319691445},
    {39.999, 200.0, -12.29767547956394221673567},
    {40.001, 200.0, -12.29754527832433580296033},
    {100.0, 0.0, -9.200185851303020748145602},
    {100.0, 800.0, -17.05469065744283068587281},
    {1000.0, 60000.0, -72.27733207587761858459934},
    {10000.0, 0.0, -18.42058072894803036288802},
    {10000.0, 100000.0, -28.41758475519250617331378},
    {100000.0, 200000.0, -25.02586092985711717357977},
    {1000000.0, 0.0, -27.63102011592704820388255},
    {1000000.0, 3000000.0, -30.63102161592554821400761},
};
static const struct {
  double r, d;
} deviance[] = {
    {-0.98, 0.90175953989143700934},    {-0.9, 0.66974149070059548273},
    {-0.5, 0.15342640972002734529},     {-0.1, 0.0051755359079563294801},
    {-0.001, 5.0016675005003337799e-7}, {-1e-06, 5.000001666667499548e-13},
    {1e-09, 4.999999998333333957e-19},  {0.0001, 4.9998333416661671792e-9},
    {0.05, 0.0012296723779036033541},   {0.3, 0.041073543807738364733},
    {0.66, 0.18131721993163011142},     {0.67, 0.186415456135868465},
    {1.9, 1.1876611372780421006},       {2.1, 1.4073465456224118424},
    {10.0, 16.376848000782075985},      {100.0, 366.12717220096720454},
};
static const struct {
  double m, rest;
} stirling[] = {
    {1.0, 0.08106146679532725822},         {2.0, 0.041340695955409294094},
    {5.0, 0.016644691189821192163},        {10.0, 0.0083305634333628712565},
    {20.0, 0.0041663196919969224575},      {40.0, 0.0020832899383024217487},
    {100.5, 0.00082918465990464866307},    {10000.0, 8.3333333305555555635e-6},
    {1000000.0, 8.3333333333330555556e-8},
};

#define EACH(array) (size_t i = 0; i < sizeof(array) / sizeof *(array); i++)

static void test_lambert(void **state) {
  double error = 0;
  for
    EACH(lambert)
  error = fmax(error, relative_error(hetab_lambert_w(lambert[i].ln_kappa), lambert[i].w));
  assert_below("W", error, TOL_LAMBERT_DOUBLE);
  assert_true(hetab_lambert_w(-1e9) > 0 && hetab_lambert_w(-1e9) < 1e-34);
}

static double e1_of(double n, double k) {
  return (n - 1) * (n + 1) - k * k;
}

static double fresnel_of(double cos2, double n, double k) {
  return hetab_fresnel(cos2, e1_of(n, k), n * k);
}

/* Normal, Brewster's and grazing incidence, metals, total reflection (whose cases beyond the
 * critical angle are 1), and an index of nearly and exactly 1. */
static void test_fresnel(void **state) {
  double error = 0;
  for
    EACH(fresnel) {
      double value = fresnel_of(fresnel[i].cos2, fresnel[i].n, fresnel[i].k);
      assert_true(value >= 0 && value <= 1);
      /* an index of 1.0001 as a double is 1e-16 off: 1e-12 of its difference from 1, squared */
      error = fmax(error, fabs(value - fresnel[i].f) / fmax(fresnel[i].f, 1e-30));
    }
  assert_below("|F|^2", error, TOL_FRESNEL_DOUBLE);
  for (double cos2 = 0; cos2 <= 1; cos2 += 1.0 / 64)
    assert_true(fresnel_of(cos2, 1, 0) >= 0 && fresnel_of(cos2, 1, 0) < 1e-30);
}

static void test_shadowing(void **state) {
  double s_error = 0, k_error = 0;
  for
    EACH(shadow) {
      double mu = shadow[i].mu, s = sqrt((1 - mu) * (1 + mu)), t = shadow[i].tau_2sigma;
      s_error =
          fmax(s_error, relative_error(hetab_shadow_over_cos(mu, s, t), shadow[i].shadow_over_cos));
      if (shadow[i].k > 1e-200)
        k_error = fmax(k_error, relative_error(hetab_k(mu, s, t), shadow[i].k));
      else
        assert_true(hetab_k(mu, s, t) >= 0 && hetab_k(mu, s, t) < 1e-200);
    }
  assert_below("S / mu", s_error, TOL_SHADOW_DOUBLE);
  assert_below("K", k_error, TOL_K_DOUBLE);
  /* exactly grazing: sqrt(pi) tau / (2 sigma0) */
  assert_below("S / mu at 90 degrees",
               relative_error(hetab_shadow_over_cos(0, 1, 3), 3 * sqrt(M_PI)), TOL_SHADOW_DOUBLE);
}

static void test_series(void **state) {
  double error = 0;
  for
    EACH(series)
  error = fmax(error, fabs(expm1(log(hetab_h(series[i].g, series[i].x)) - series[i].ln_h)));
  assert_below("h", error, TOL_H_DOUBLE);
}

static void test_deviance(void **state) {
  double error = 0;
  for
    EACH(deviance)
  error = fmax(error, relative_error(hetab_deviance(deviance[i].r), deviance[i].d));
  assert_below("deviance", error, TOL_DEVIANCE_DOUBLE);
}

/* m below 20 is never asked for where the integral is taken. */
static void test_stirling(void **state) {
  double error = 0;
  for
    EACH(stirling)
  if (stirling[i].m >= 10)
    error = fmax(error, fabs(hetab_stirling_rest(stirling[i].m) - stirling[i].rest));
  assert_below("Stirling's remainder", error, TOL_STIRLING_DOUBLE);
}

/* --- the device ------------------------------------------------------------------------------ */

static const char source[] =
    "#define HETAB_CL\n"
    "#include \"he_torrance.h\"\n"
    "#include \"shadowing.h\"\n"
    "__kernel void apply(int which, int count, __global const real *in, __global real *out) {\n"
    "  size_t i = get_global_id(0);\n"
    "  vreal a = V_LOAD(i, in), b = V_LOAD(i, in + count), c = V_LOAD(i, in + 2 * count);\n"
    "  vreal y = RC(0.0);\n"
    "  if (which == 0) y = hetab_lambert_w(a);\n"
    "  if (which == 1) y = hetab_fresnel(a, b, c);\n"
    "  if (which == 2) y = hetab_shadow_over_cos(a, b, V_FIRST(c));\n"
    "  if (which == 3) y = hetab_k(a, b, V_FIRST(c));\n"
    "  if (which == 4) y = hetab_h(a, b);\n"
    "  if (which == 5) y = hetab_deviance(a);\n"
    "  if (which == 6) y = hetab_exp(a);\n"
    "  if (which == 7) y = hetab_roughness_ratio2(a);\n"
    "  V_STORE(y, i, out);\n"
    "}\n";

enum { LAMBERT, FRESNEL, SHADOW, K, H, DEVIANCE, EXP, RATIO2, COUNT = 1 << 16, WIDTH = 8 };

typedef struct device {
  cl_device_id id;
  cl_context context;
  cl_command_queue queue;
  cl_kernel kernel;
  int is_double;
} device;

static device open_device(int is_double) {
  cl_platform_id platform;
  device d = {.is_double = is_double};
  const char *text = source;
  char options[200], log[4000] = "";
  cl_int error;
  assert_int_equal(clGetPlatformIDs(1, &platform, NULL), CL_SUCCESS);
  assert_int_equal(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &d.id, NULL), CL_SUCCESS);
  d.context = clCreateContext(NULL, 1, &d.id, NULL, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  d.queue = clCreateCommandQueue(d.context, d.id, 0, &error);
  assert_int_equal(error, CL_SUCCESS);
  cl_program program = clCreateProgramWithSource(d.context, 1, &text, NULL, &error);
  snprintf(options, sizeof options, "-cl-std=CL1.2 -I kernels -DHETAB_REAL_BITS=%d -DHETAB_VW=%d",
           is_double ? 64 : 32, WIDTH);
  error = clBuildProgram(program, 1, &d.id, options, NULL, NULL);
  clGetProgramBuildInfo(program, d.id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
  if (error != CL_SUCCESS)
    fail_msg("%s", log);
  d.kernel = clCreateKernel(program, "apply", &error);
  assert_int_equal(error, CL_SUCCESS);
  clReleaseProgram(program);
  return d;
}

static void close_device(device *d) {
  clReleaseKernel(d->kernel);
  clReleaseCommandQueue(d->queue);
  clReleaseContext(d->context);
}

/* out[COUNT] = function(in[0], in[1], in[2]); in is rounded to what the device sees. */
static void apply(const device *d, int which, double (*in)[COUNT], double *out) {
  size_t size = d->is_double ? sizeof(double) : sizeof(float), global = COUNT / WIDTH;
  cl_int error, function = which, count = COUNT;
  float(*narrow)[COUNT] = calloc(3, sizeof *narrow);
  for (int a = 0; a < 3 && !d->is_double; a++)
    for (int i = 0; i < COUNT; i++) {
      narrow[a][i] = (float)in[a][i];
      in[a][i] = (double)narrow[a][i];
    }
  void *values = d->is_double ? (void *)in : (void *)narrow;
  cl_mem input = clCreateBuffer(d->context, CL_MEM_COPY_HOST_PTR, 3 * COUNT * size, values, &error);
  assert_int_equal(error, CL_SUCCESS);
  cl_mem output = clCreateBuffer(d->context, CL_MEM_WRITE_ONLY, COUNT * size, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  clSetKernelArg(d->kernel, 0, sizeof function, &function);
  clSetKernelArg(d->kernel, 1, sizeof count, &count);
  clSetKernelArg(d->kernel, 2, sizeof input, &input);
  clSetKernelArg(d->kernel, 3, sizeof output, &output);
  assert_int_equal(
      clEnqueueNDRangeKernel(d->queue, d->kernel, 1, NULL, &global, NULL, 0, NULL, NULL),
      CL_SUCCESS);
  assert_int_equal(clEnqueueReadBuffer(d->queue, output, CL_TRUE, 0, COUNT * size,
                                       d->is_double ? (void *)out : (void *)narrow, 0, NULL, NULL),
                   CL_SUCCESS);
  for (int i = 0; i < COUNT && !d->is_double; i++)
    out[i] = (double)narrow[0][i];
  clReleaseMemObject(input);
  clReleaseMemObject(output);
  free(narrow);
}

static void arguments(int which, uint64_t *r, double (*in)[COUNT], int i) {
  double a = 0, b = 0, c = 0;
  if (which == LAMBERT) {
    a = i % 2 ? uniform(r, -80, 90) : uniform(r, -5, 5);
  } else if (which == FRESNEL) {
    a = i % 16 ? uniform(r, 0, 1) : i % 32 ? 1 : 0;
    double n = i % 3 ? log_uniform(r, 0.04, 5) : 1 + log_uniform(r, 1e-4, 3);
    double k = i % 3 ? uniform(r, 1, 10) : 0;
    b = e1_of(n, k);
    c = n * k;
  } else if (which == SHADOW || which == K) {
    a = i % 16 ? uniform(r, 1e-3, 1) : 1;
    b = sqrt((1 - a) * (1 + a));
    /* one roughness for a vector, as in the kernels */
    c = i % WIDTH ? in[2][i - 1] : log_uniform(r, 0.05, 500);
  } else if (which == H) {
    a = log_uniform(r, 1e-6, 1e5);
    b = uniform(r, 0, 1) * (20 * fmax(a, 1));
  } else if (which == DEVIANCE) {
    a = i % 2 ? uniform(r, -0.9, 3) : log_uniform(r, 1e-6, 1);
  } else if (which == EXP) {
    a = i % 2 ? uniform(r, -87, 88) : uniform(r, -1, 1);
  } else if (which == RATIO2) {
    a = log_uniform(r, 1e-10, 1e6);
  }
  in[0][i] = a;
  in[1][i] = b;
  in[2][i] = c;
}

static double on_host(int which, double a, double b, double c) {
  switch (which) {
  case LAMBERT:
    return hetab_lambert_w(a);
  case FRESNEL:
    return hetab_fresnel(a, b, c);
  case SHADOW:
    return hetab_shadow_over_cos(a, b, c);
  case K:
    return hetab_k(a, b, c);
  case H:
    return hetab_h(a, b);
  case DEVIANCE:
    return hetab_deviance(a);
  case EXP:
    return exp(a);
  default:
    return hetab_roughness_ratio2(a);
  }
}

static void check_device(int is_double) {
  static const struct {
    const char *name;
    double least; /* smaller values are not compared: they may underflow */
    double bound_float, bound_double;
  } functions[] = {
      {"W", 0, TOL_LAMBERT_FLOAT, TOL_LAMBERT_DOUBLE},
      {"|F|^2", 0, TOL_FRESNEL_FLOAT, TOL_FRESNEL_DOUBLE},
      {"S / mu", 0, TOL_SHADOW_FLOAT, TOL_SHADOW_DOUBLE},
      {"K, over a lower bound of 1e-6", 1e-30, TOL_K_FLOAT, TOL_K_DOUBLE},
      {"h", 1e-25, TOL_H_FLOAT, TOL_H_DOUBLE},
      {"deviance", 0, TOL_DEVIANCE_FLOAT, TOL_DEVIANCE_DOUBLE},
      {"exp", 0, TOL_EXP_FLOAT, TOL_EXP_DOUBLE},
      {"sigma^2 / sigma0^2", 0, TOL_RATIO2_FLOAT, TOL_RATIO2_DOUBLE},
  };
  device d = open_device(is_double);
  double(*in)[COUNT] = calloc(3, sizeof *in), *out = calloc(COUNT, sizeof *out);
  for (int f = LAMBERT; f <= RATIO2; f++) {
    double error = 0, at[3] = {0};
    uint64_t r = 31;
    for (int i = 0; i < COUNT; i++)
      arguments(f, &r, in, i);
    apply(&d, f, in, out);
    for (int i = 0; i < COUNT; i++) {
      double reference = on_host(f, in[0][i], in[1][i], in[2][i]);
      assert_true(isfinite(out[i]) && out[i] >= 0);
      if (reference < functions[f].least)
        continue;
      double e = f == K ? fabs(out[i] - reference) / fmax(reference, 1e-6)
                        : relative_error(out[i], reference);
      if (e > error)
        for (int a = 0; a < 3; a++)
          at[a] = in[a][i];
      error = fmax(error, e);
    }
    print_message("  worst at %.9g %.9g %.9g\n", at[0], at[1], at[2]);
    assert_below(functions[f].name, error,
                 is_double ? functions[f].bound_double : functions[f].bound_float);
  }
  free(in);
  free(out);
  close_device(&d);
}

static void test_float_build(void **state) {
  check_device(0);
}

static void test_double_build(void **state) {
  check_device(1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_lambert),     cmocka_unit_test(test_fresnel),
      cmocka_unit_test(test_shadowing),   cmocka_unit_test(test_series),
      cmocka_unit_test(test_deviance),    cmocka_unit_test(test_stirling),
      cmocka_unit_test(test_float_build), cmocka_unit_test(test_double_build),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
