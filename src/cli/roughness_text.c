/* Roughness as text, CSV and YAML. */
#include <math.h>

#include "core/number.h"
#include "options.h"
#include "roughness_command.h"

enum { MOST_ROWS = 24 }; /* of a component, before only the summary is printed */

const roughness_field roughness_fields[ROUGHNESS_FIELDS] = {
    {"sigma_um", "sigma, um", (double)NAN},
    {"tau_um", "tau, um", (double)NAN},
    {"slope", "sigma/tau", (double)NAN},
    {"rms_slope", "rms slope", (double)NAN},
    {"skewness", "skewness", 0},
    {"kurtosis", "kurtosis", 3},
};

hetab_estimate roughness_estimate(const hetab_scan_statistics *s, int field) {
  const hetab_estimate *const fields[ROUGHNESS_FIELDS] = {
      &s->sigma_um, &s->tau_um, &s->slope, &s->rms_slope, &s->skewness, &s->kurtosis};
  return *fields[field];
}

hetab_average roughness_average(const hetab_component *c, int field) {
  const hetab_average *const fields[ROUGHNESS_FIELDS] = {&c->sigma_um,  &c->tau_um,   &c->slope,
                                                         &c->rms_slope, &c->skewness, &c->kurtosis};
  return *fields[field];
}

/* What the model's parameters come from: the small scale if there is one. */
static const hetab_component *main_component(const hetab_roughness *r) {
  return r->small.count ? &r->small : &r->raw;
}

/* ---- text ---------------------------------------------------------------------------------- */

static void print_source(const hetab_roughness *r, size_t i) {
  const hetab_scan_source *s = &r->scans[i];
  printf("%4zu  %s: %zu heights, %.5g um apart", i + 1, s->name, s->points, s->spacing_um);
  if (s->missing || s->outliers)
    printf(", %zu missing, %zu outliers", s->missing, s->outliers);
  putchar('\n');
}

static void print_sources(const hetab_roughness *r) {
  size_t missing = 0, outliers = 0, points = 0;
  puts("Scans");
  for (size_t i = 0; i < r->count; i++) {
    if (r->count <= MOST_ROWS)
      print_source(r, i);
    points += r->scans[i].points;
    missing += r->scans[i].missing;
    outliers += r->scans[i].outliers;
  }
  if (r->count > MOST_ROWS)
    printf("      %zu, with %zu heights, of which %zu are missing and %zu outliers\n", r->count,
           points, missing, outliers);
}

static void print_row(const char *name, const double values[ROUGHNESS_FIELDS]) {
  printf("  %-12s", name);
  for (int f = 0; f < ROUGHNESS_FIELDS; f++)
    if (isnan(values[f]))
      printf(" %11s", "");
    else
      printf(" %11.4g", values[f]);
  putchar('\n');
}

static void print_averages(const hetab_component *c) {
  double rows[5][ROUGHNESS_FIELDS];
  for (int f = 0; f < ROUGHNESS_FIELDS; f++) {
    hetab_average a = roughness_average(c, f);
    rows[0][f] = a.mean;
    rows[1][f] = a.deviation;
    rows[2][f] = a.error;
    rows[3][f] = a.low;
    rows[4][f] = a.high;
  }
  print_row("average", rows[0]);
  if (c->count > 1)
    print_row("deviation", rows[1]);
  print_row("error", rows[2]);
  print_row("95 % from", rows[3]);
  print_row("95 % to", rows[4]);
  if (c->count > 1)
    printf("  non-uniformity (deviation of sigma over its average): %.3f\n", c->non_uniformity);
}

static void print_component(const hetab_component *c) {
  char name[24];
  printf("  %-12s", "scan");
  for (int f = 0; f < ROUGHNESS_FIELDS; f++)
    printf(" %11s", roughness_fields[f].title);
  putchar('\n');
  for (size_t i = 0; i < c->count && c->count <= MOST_ROWS; i++) {
    double values[ROUGHNESS_FIELDS];
    for (int f = 0; f < ROUGHNESS_FIELDS; f++)
      values[f] = roughness_estimate(&c->scans[i], f).value;
    snprintf(name, sizeof name, "%zu", c->scans[i].scan + 1);
    print_row(name, values);
  }
  print_averages(c);
  printf("  heights: distribution off the normal one by %.3f; autocorrelation: rms %.3f off a "
         "Gaussian,\n  %.3f off an exponential\n",
         c->normal_distance, c->misfit_gaussian, c->misfit_exponential);
}

static void print_cutoffs(const hetab_roughness *r) {
  const hetab_cutoff_scan *s = &r->cutoff_scan;
  if (!s->count)
    return;
  printf("\nCut-offs tried\n  %11s %11s %11s %11s %11s\n", "cut-off, um", "sigma, um", "tau, um",
         "sigma/tau", "smooth");
  for (size_t i = 0; i < s->count; i++) {
    const hetab_cutoff_trial *t = &s->trials[i];
    printf("  %11.4g %11.4g %11.4g %11.4g %11.4g\n", t->cutoff_um, t->sigma_um, t->tau_um, t->slope,
           t->smooth);
  }
  printf("  smooth: two Gaussian scales, sigma %.3g and %.3g um, tau %.3g and %.3g um, %s %% "
         "off;\n",
         s->sigma_um[0], s->sigma_um[1], s->tau_um[0], s->tau_um[1],
         hetab_two_digits(100 * s->misfit).text);
  if (r->small.count)
    printf("  chosen: %.4g um, the largest %s slope\n", r->cutoff_um,
           s->from_fit ? "smooth" : "measured");
  else
    puts("  chosen: none, the scans have one scale");
}

void roughness_print(const hetab_roughness *r) {
  print_sources(r);
  puts("\nUnfiltered, levelled");
  print_component(&r->raw);
  print_cutoffs(r);
  if (r->small.count) {
    printf("\nSmall scale, behind the %s filter with cut-off %.4g um\n",
           hetab_filter_name(r->filter), r->cutoff_um);
    print_component(&r->small);
  }
  printf("\nRadius of curvature, rms, about %.3g um\n", r->curvature_um);
  for (size_t i = 0; i < r->note_count; i++)
    cli_print_wrapped(r->notes[i], 2, printf("- "));
}

/* ---- CSV ----------------------------------------------------------------------------------- */

static void csv_text(FILE *out, const char *text) {
  putc('"', out);
  for (; *text; text++) {
    if (*text == '"')
      putc('"', out);
    putc(*text, out);
  }
  putc('"', out);
}

static void csv_component(FILE *out, const hetab_roughness *r, const hetab_component *c,
                          const char *name) {
  for (size_t i = 0; i < c->count; i++) {
    const hetab_scan_statistics *s = &c->scans[i];
    const hetab_scan_source *source = &r->scans[s->scan];
    csv_text(out, source->name);
    fprintf(out, ",%s,%zu,%.10g,%zu,%zu", name, s->points, s->length_um, source->missing,
            source->outliers);
    for (int f = 0; f < ROUGHNESS_FIELDS; f++) {
      hetab_estimate e = roughness_estimate(s, f);
      fprintf(out, ",%.10g,%.4g", e.value, e.error);
    }
    fprintf(out, ",%.5g,%.5g,%.5g,%.5g,", s->independent, s->normal_distance, s->misfit_gaussian,
            s->misfit_exponential);
    if (c == &r->small)
      fprintf(out, "%s,%.10g\n", hetab_filter_name(r->filter), r->cutoff_um);
    else
      fputs("none,\n", out);
  }
}

void roughness_csv(FILE *out, const hetab_roughness *r) {
  fputs("scan,component,points,length_um,missing,outliers", out);
  for (int f = 0; f < ROUGHNESS_FIELDS; f++)
    fprintf(out, ",%s,%s_error", roughness_fields[f].name, roughness_fields[f].name);
  fputs(",independent,normal_distance,misfit_gaussian,misfit_exponential,filter,cutoff_um\n", out);
  csv_component(out, r, &r->raw, "raw");
  csv_component(out, r, &r->small, "small");
}

/* ---- YAML ---------------------------------------------------------------------------------- */

static void yaml_bounds(FILE *out, const char *name, const hetab_average *a) {
  fprintf(out, "# %s: [%.4g, %.4g]\n", name, a->low, a->high);
}

void roughness_yaml(FILE *out, const hetab_roughness *r, const char *name, const char *index) {
  const hetab_component *c = main_component(r);
  fprintf(out, "# From %zu scan%s", c->count, c->count == 1 ? "" : "s");
  if (r->small.count)
    fprintf(out, ", small scale behind a %s filter with a cut-off of %.4g um",
            hetab_filter_name(r->filter), r->cutoff_um);
  fprintf(out, ". 95 %% intervals%s:\n",
          r->small.count ? " of what the filter leaves; its own effect is not in them" : "");
  yaml_bounds(out, "sigma0_um", &c->sigma_um);
  yaml_bounds(out, "tau_um", &c->tau_um);
  yaml_bounds(out, "slope", &c->slope);
  fprintf(out, "name: \"%s\"\nsigma0_um: %.5g\ntau_um: %.5g\nindex: %s\n", name, c->sigma_um.mean,
          c->tau_um.mean, index);
  /* The spread that `hetab predict` takes; below 1e-4 rounding would put the value outside. */
  if (c->count > 1 && c->non_uniformity > 1e-4 && c->non_uniformity < 1)
    fprintf(out,
            "# sigma0_um times 1 -+ the non-uniformity, %.3f\nsigma0_bounds_um: [%.6g, %.6g]\n",
            c->non_uniformity, c->sigma_um.mean * (1 - c->non_uniformity),
            c->sigma_um.mean * (1 + c->non_uniformity));
}

/* ---- published rows ------------------------------------------------------------------------ */

int roughness_published_agrees(const hetab_published *p) {
  for (size_t i = 0; i < p->check_count; i++)
    if (p->checks[i].verdict == HETAB_MATCH_NONE)
      return 0;
  return 1;
}

/* With the digits of the rows, the non-uniformity with two. */
static void print_columns(const hetab_published_table *t) {
  for (size_t i = 0; i < t->count; i++) {
    printf("%s, %zu rows\n", t->columns[i].name, t->rows);
    for (int kind = 0; kind < HETAB_SUMMARIES; kind++)
      printf("  %-15s %.*f\n", hetab_summary_name(kind),
             kind == HETAB_NON_UNIFORMITY ? 2 : t->columns[i].decimals,
             hetab_published_summary(t, i, kind));
  }
}

/* What agrees to the digit is counted, the rest is named. */
static void print_check(const hetab_published *p, const hetab_published_check *c) {
  if (c->verdict == HETAB_MATCH_EXACT)
    return;
  printf("  %s, %s: %.*f stated, %.8g", c->row, c->column, c->decimals, c->stated, c->value);
  if (c->against != c->table)
    printf(" in %s", p->tables[c->against].name);
  if (c->verdict == HETAB_MATCH_ROUNDING)
    printf(": within the rounding of the rows, %.6g to %.6g\n", c->low, c->high);
  else
    puts(c->verdict == HETAB_MATCH_OWN_ROW ? ": it is its own row's sigma / tau" : ": DIFFERS");
}

void roughness_print_published(const hetab_published *p) {
  for (size_t i = 0; i < p->count; i++) {
    size_t checks = 0, agree = 0;
    for (size_t k = 0; k < p->check_count; k++) {
      checks += p->checks[k].table == i;
      agree += p->checks[k].table == i && p->checks[k].verdict == HETAB_MATCH_EXACT;
    }
    if (p->count > 1)
      printf("%s%s\n", i ? "\n" : "", p->tables[i].name);
    print_columns(&p->tables[i]);
    if (checks)
      printf("%zu of %zu stated numbers agree to the digit\n", agree, checks);
    for (size_t k = 0; k < p->check_count; k++)
      if (p->checks[k].table == i)
        print_check(p, &p->checks[k]);
  }
}
