/* Predictions on the terminal, and as CSV. */
#include <math.h>

#include "core/angle.h"
#include "predict_command.h"

static void print_interval(const char *name, double value, hetab_interval interval) {
  printf("%s %.5g um", name, value);
  if (interval.high > interval.low)
    printf(" (%.5g to %.5g)", interval.low, interval.high);
}

static const hetab_bounds *peak_of(const hetab_prediction *p, const hetab_prediction_curve *curve) {
  size_t i = 0;
  while (p->theta_r[i] < curve->peak)
    i++;
  return &curve->f[i];
}

static void print_count(const char *where, const hetab_prediction_count *count) {
  if (count->points)
    printf("measured, %s: %zu points, %zu (%.1f %%) within the bounds, %zu below, %zu above, sum "
           "%+.1f %%\n",
           where, count->points, count->within, 100 * (double)count->within / (double)count->points,
           count->below, count->above, 100 * count->bias);
}

static void print_skipped(const predict_report *r) {
  hetab_measurements_skipped s = hetab_measurements_skipped_of(r->measurements);
  if (s.below_horizon || s.not_finite)
    printf("not used: %zu rows below the horizon, %zu values not finite\n", s.below_horizon,
           s.not_finite);
}

const char *predict_varied(const hetab_prediction *p) {
  static const char *const words[] = {NULL, "sigma0 at fixed tau", "tau at fixed sigma0",
                                      "sigma0 and tau"};
  return words[(p->bounds.sigma0_um.low < p->bounds.sigma0_um.high) +
               2 * (p->bounds.tau_um.low < p->bounds.tau_um.high)];
}

static void print_with_tau(const hetab_prediction *p) {
  printf("\nthe same slopes by tau, %.5g to %.5g um:\n", p->bounds.tau_um.low,
         p->bounds.tau_um.high);
  for (size_t i = 0; i < p->curve_count; i++) {
    const hetab_bounds *peak = peak_of(p, &p->curves[i]);
    printf("%6.5g %8.4g %8.4g %10.4g %10.4g %10.4g\n", 1000 * p->curves[i].lambda_um,
           hetab_degrees(p->curves[i].theta_i), hetab_degrees(p->curves[i].peak), peak->nominal,
           peak->low, peak->high);
  }
}

void predict_print(const predict_report *r) {
  const hetab_prediction *p = r->prediction;
  printf("%s: ", hetab_surface_name(r->surface));
  print_interval("sigma0", hetab_surface_sigma0_um(r->surface), p->bounds.sigma0_um);
  print_interval(", tau", hetab_surface_tau_um(r->surface), p->bounds.tau_um);
  printf("\n\n%6s %8s %8s %10s %10s %10s %10s %10s %10s\n", "nm", "theta_i", "peak at", "f, 1/sr",
         "low", "high", "rho_s", "low", "high");
  for (size_t i = 0; i < p->curve_count; i++) {
    const hetab_prediction_curve *c = &p->curves[i];
    const hetab_bounds *peak = peak_of(p, c);
    printf("%6.5g %8.4g %8.4g %10.4g %10.4g %10.4g %10.3g %10.3g %10.3g\n", 1000 * c->lambda_um,
           hetab_degrees(c->theta_i), hetab_degrees(c->peak), peak->nominal, peak->low, peak->high,
           predict_shown(c->specular.nominal), predict_shown(c->specular.low),
           predict_shown(c->specular.high));
  }
  if (r->with_tau)
    print_with_tau(r->with_tau);
  if (predict_varied(p))
    printf("\nvaried: %s; the bounds miss less than %.1g of the value\n", predict_varied(p),
           p->error);
  else
    puts("\nno bounds: the surface's file has none; give --slope-spread, --slope, --sigma0 or "
         "--tau");
  if (!r->measurements)
    return;
  print_count("incidence plane", &p->plane);
  print_count("hemisphere", &p->hemisphere);
  print_skipped(r);
}

/* ---- CSV ----------------------------------------------------------------------------------- */

void predict_csv(FILE *out, const predict_report *r) {
  const hetab_prediction *p = r->prediction;
  fputs("wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f,low,high,error,measured,side\n", out);
  for (size_t i = 0; i < p->curve_count; i++)
    for (size_t k = 0; k < p->theta_r_count; k++) {
      const hetab_prediction_curve *c = &p->curves[i];
      double theta_r_deg = hetab_degrees(p->theta_r[k]);
      fprintf(out, "%.9g,%.9g,%.9g,%d,%.9g,%.9g,%.9g,%.3g,,\n", 1000 * c->lambda_um,
              hetab_degrees(c->theta_i), fabs(theta_r_deg), theta_r_deg > 0 ? 180 : 0,
              c->f[k].nominal, c->f[k].low, c->f[k].high, c->f[k].error);
    }
  for (size_t i = 0; i < p->point_count; i++) {
    const hetab_predicted_point *point = &p->points[i];
    const hetab_directions *d = &point->directions;
    fprintf(out, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.3g,%.9g,%d\n",
            1000 * p->curves[point->curve].lambda_um, hetab_degrees(d->theta_i),
            hetab_degrees(d->theta_r), hetab_degrees(d->phi), point->f.nominal, point->f.low,
            point->f.high, point->f.error, point->measured, point->side);
  }
}
