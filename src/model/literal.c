/* The He-Torrance model as printed: Eqs. 6-25 of Li & Torrance, TR PCG-05-02 (2005), appendix A,
 * in double, one quantity after the other. This is the executable specification and the baseline
 * of every speed figure; it shares nothing with kernels/. Where the print divides zero by zero the
 * limit is taken, and said.
 *
 *   Eq.     what                                    here            kernels/
 *   6       rho_bd = sp + dd + ud                   hetab_literal   points.cl
 *   7, 11   sp: rho_s / cos(theta_i) in a cone      a delta: its reflectance rho_s stands for it
 *   8       dd = |F|^2 / pi G S D / (mu_i mu_r)     hetab_literal   hetab_dd (he_torrance.h)
 *   9       ud = a                                  hetab_literal   points.cl, dense.cl
 *   10      rho_s = |F|^2 e^-g S                    hetab_literal   hetab_rho_s (he_torrance.h)
 *   12      |F|^2, unpolarised                      fresnel         hetab_fresnel (fresnel.h)
 *   13      G                                       geometry        cos^4(theta_d) of hetab_dd
 *   14-17   S = S_i S_r, and Lambda                 shadowing       hetab_shadow_over_cos
 * (shadowing.h) 18      D, the sum over m                       series          hetab_h (series.h),
 * times g 19      g                                       g_of            hetab_wave_g
 * (he_torrance.h) 20, 21  sigma and z0                            sigma_um hetab_roughness_ratio2
 * (shadowing.h) 22      K_i, K_r                                k_of            hetab_k
 * (shadowing.h) 23      v                                       hetab_literal   hetab_wave_x
 * (he_torrance.h) 24, 25  s and p                                 s_direction     gone: G's
 * brackets cancel
 */
#include <math.h>

#include "model/model.h"

typedef struct vec3 {
  double x, y, z;
} vec3;

static double dot(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec3 cross(vec3 a, vec3 b) {
  return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vec3 scale(vec3 a, double factor) {
  return (vec3){a.x * factor, a.y * factor, a.z * factor};
}

static vec3 direction(double theta, double phi) {
  return (vec3){sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
}

/* Eqs. 24-25: the unit vector of k x z, the s direction; any tangent where k is the normal (limit).
 */
static vec3 s_direction(vec3 k) {
  vec3 s = cross(k, (vec3){0, 0, 1});
  double length = sqrt(dot(s, s));
  return length > 0 ? scale(s, 1 / length) : (vec3){0, 1, 0};
}

/* tau cot(theta) / (2 sigma0); infinite at normal incidence. */
static double cot_argument(double theta, const hetab_point *p) {
  return theta > 0 ? p->tau_um / (2 * p->sigma0_um * tan(theta)) : HUGE_VAL;
}

/* Eqs. 15-17: S(theta). At normal incidence Lambda = 0. */
static double shadowing(double theta, const hetab_point *p) {
  double u = cot_argument(theta, p);
  double lambda = isinf(u) ? 0 : 0.5 * (exp(-u * u) / (sqrt(M_PI) * u) - erfc(u));
  return (1 - 0.5 * erfc(u)) / (lambda + 1);
}

/* Eq. 22: K(theta). */
static double k_of(double theta, const hetab_point *p) {
  return tan(theta) * erfc(cot_argument(theta, p));
}

/* Eq. 21: z0 / sigma0 = z, sqrt(pi/2) z = (K_i + K_r)/4 exp(-z^2/2), by Newton's method. */
static double z0_over_sigma0(double k_sum) {
  double c = k_sum / (4 * sqrt(M_PI_2));
  double z = c < 1 ? c : sqrt(2 * log(c));
  for (int i = 0; i < 50; i++) {
    double e = c * exp(-0.5 * z * z);
    double step = (z - e) / (1 + z * e);
    z -= step;
    if (fabs(step) <= 1e-16 * z)
      break;
  }
  return z;
}

/* Eq. 20: the effective roughness. */
static double sigma_um(double k_sum, const hetab_point *p) {
  double z = z0_over_sigma0(k_sum);
  return p->sigma0_um / sqrt(1 + z * z);
}

/* Eq. 19. */
static double g_of(double sigma, double mu_sum, double lambda) {
  double phase = 2 * M_PI * sigma / lambda * mu_sum;
  return phase * phase;
}

/* Eq. 12: |F|^2, the mean of the two polarisations, for c = cos(theta) and index n + ik. a + ib =
 * sqrt((n + ik)^2 - sin^2) is the refracted wave's normal component; st = sin tan. */
static double fresnel(double c, double n, double k) {
  double sin2 = 1 - c * c;
  double re = n * n - k * k - sin2, im = 2 * n * k;
  double modulus = hypot(re, im);
  double a2 = 0.5 * (modulus + re), b2 = 0.5 * (modulus - re);
  double a = sqrt(a2 > 0 ? a2 : 0), st = c > 0 ? sin2 / c : HUGE_VAL;
  double fs = ((a - c) * (a - c) + b2) / ((a + c) * (a + c) + b2);
  double ratio = isinf(st) ? 1 : ((a - st) * (a - st) + b2) / ((a + st) * (a + st) + b2);
  return 0.5 * fs * (1 + ratio);
}

/* Eq. 13: G = (v.v / v_z)^2 / |k_r x k_i|^4 [(s_r.k_i)^2 + (p_r.k_i)^2] [(s_i.k_r)^2 +
 * (p_i.k_r)^2]. k_i points to the surface in the print, here both point away: the squares do not
 * notice. At retro-reflection and its neighbourhood both brackets equal |k_r x k_i|^2: the limit
 * is 1. */
static double geometry(vec3 ki, vec3 kr, vec3 v) {
  vec3 si = s_direction(ki), sr = s_direction(kr);
  vec3 pi = cross(si, ki), pr = cross(sr, kr);
  vec3 c = cross(kr, ki);
  double c2 = dot(c, c), vv = dot(v, v) / v.z;
  double bracket_r = dot(sr, ki) * dot(sr, ki) + dot(pr, ki) * dot(pr, ki);
  double bracket_i = dot(si, kr) * dot(si, kr) + dot(pi, kr) * dot(pi, kr);
  double brackets = c2 > 1e-12 ? bracket_r * bracket_i / (c2 * c2) : 1;
  return vv * vv * brackets;
}

/* Where the terms g^m e^-g e^(-x/m) / (m! m) are largest: m^2 ln(m/g) = x, at least 1. */
static double largest_term(double g, double x) {
  double low = g, high = g + x + 2;
  for (int i = 0; i < 200 && high - low > 0.25; i++) {
    double m = 0.5 * (low + high);
    if (m * m * log(m / g) < x)
      low = m;
    else
      high = m;
  }
  return low < 1 ? 1 : floor(low);
}

/* Eq. 18's sum over m of g^m e^-g / (m! m) e^(-x/m), term by term from the largest one both ways
 * until nothing changes: from m = 1 the terms underflow for g > 700. */
static double series(double g, double x) {
  if (g <= 0)
    return 0;
  double peak = largest_term(g, x);
  int sign; /* lgamma() writes it to a global, which threads share */
  double weight = exp(peak * log(g) - g - lgamma_r(peak + 1, &sign)), sum = 0;
  double w = weight;
  for (double m = peak;; m++) {
    double term = w / m * exp(-x / m);
    sum += term;
    if (!(term > 1e-17 * sum))
      break;
    w *= g / (m + 1);
  }
  w = weight * peak / g;
  for (double m = peak - 1; m >= 1; m--) {
    double term = w / m * exp(-x / m);
    sum += term;
    if (!(term > 1e-17 * sum))
      break;
    w *= m / g;
  }
  return sum;
}

hetab_value hetab_literal(const hetab_point *p) {
  vec3 ki = direction(p->theta_i, 0), kr = direction(p->theta_r, p->phi);
  vec3 v = {ki.x + kr.x, ki.y + kr.y, ki.z + kr.z};
  double s_i = shadowing(p->theta_i, p), s_r = shadowing(p->theta_r, p);
  double k_i = k_of(p->theta_i, p), k_r = k_of(p->theta_r, p);
  double wave_number = 2 * M_PI / p->lambda_um;
  double vxy = wave_number * wave_number * (v.x * v.x + v.y * v.y); /* v_xy^2 of Eq. 23, 1/um^2 */
  double cos_d = sqrt(dot(v, v)) / 2;
  hetab_value value = {.ud = p->diffuse_brdf, .x = vxy * p->tau_um * p->tau_um / 4};

  int grazing_i = p->theta_i >= M_PI_2, grazing_r = p->theta_r >= M_PI_2;
  if (!grazing_i) {
    double g_s = g_of(sigma_um(2 * k_i, p), 2 * ki.z, p->lambda_um);
    value.specular = fresnel(ki.z, p->n, p->k) * exp(-g_s) * s_i * s_i; /* Eq. 10 */
  }
  if (!grazing_i && !grazing_r) {
    double sigma = sigma_um(k_i + k_r, p);
    value.g = g_of(sigma, ki.z + kr.z, p->lambda_um);
    double d = M_PI * M_PI * p->tau_um * p->tau_um / (4 * p->lambda_um * p->lambda_um) *
               series(value.g, value.x); /* Eq. 18 */
    value.dd = fresnel(cos_d, p->n, p->k) / M_PI * geometry(ki, kr, v) * s_i * s_r * d /
               (ki.z * kr.z); /* Eq. 8; 0 at exactly 90 degrees, where sigma -> 0 */
  }
  value.total = value.dd + value.ud;
  return value;
}
