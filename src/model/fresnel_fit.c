#include "model/fresnel_fit.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "kernels/tables.h"
#include "model/model.h"
#include "model/polynomial.h"

static double horner(const double *c, double v) {
  double sum = 0.0;
  for (int i = HETAB_FRESNEL_FIT - 1; i >= 0; i--)
    sum = sum * v + c[i];
  return sum;
}

/* The reflectance as the kernel makes it of the fit. */
static double fitted(const double *fit, double cos2) {
  double v = 2.0 * cos2 - 1.0, sin2 = 1.0 - cos2;
  double m = horner(fit + HETAB_FRESNEL_FIT, v), t = 2.0 * horner(fit, v) * sqrt(cos2);
  double u = m * cos2 + sin2 * sin2;
  return (cos2 + m - t) * u / ((cos2 + m + t) * (u + t * sin2));
}

/* a and m through `count` nodes; 1 if the reflectance made of them is good enough everywhere. */
static int fit_with(double n, double k, int count, double tolerance, double *fit) {
  enum { CHECKS = 64 };
  double a[HETAB_FRESNEL_FIT], m[HETAB_FRESNEL_FIT];
  hetab_fitter fitter;
  hetab_fitter_make(count, &fitter);
  memset(fit, 0, 2 * HETAB_FRESNEL_FIT * sizeof *fit);
  for (int i = 0; i < count; i++) {
    double cos2 = 0.5 * (1.0 + fitter.node[i]);
    double re = n * n - k * k - (1.0 - cos2), im = 2.0 * n * k;
    a[i] = creal(csqrt(__builtin_complex(re, im)));
    m[i] = hypot(re, im);
  }
  hetab_chebyshev(&fitter, a, fit);
  hetab_chebyshev(&fitter, m, fit + HETAB_FRESNEL_FIT);
  hetab_to_powers(&fitter, fit);
  hetab_to_powers(&fitter, fit + HETAB_FRESNEL_FIT);
  for (int i = 0; i <= CHECKS; i++) {
    double cos2 = (double)i / CHECKS, exact = hetab_fresnel_at(cos2, n, k);
    if (!(fabs(fitted(fit, cos2) - exact) <= tolerance * exact))
      return 0;
  }
  return 1;
}

int hetab_fresnel_fit(double n, double k, double tolerance, double *fit) {
  /* cos^2 + m - t must not cancel in float either: near-unit indices are left to the other form */
  if (hypot(n * n - k * k - 1.0, 2.0 * n * k) <= 2.0)
    return 0;
  if (fit_with(n, k, HETAB_FRESNEL_SHORT, tolerance, fit))
    return HETAB_FRESNEL_SHORT;
  return fit_with(n, k, HETAB_FRESNEL_FIT, tolerance, fit) ? HETAB_FRESNEL_FIT : 0;
}
