/* Audits on the terminal. */
#include <stdio.h>
#include <string.h>

#include "audit_command.h"
#include "options.h"

enum { DETAIL_COLUMN = 31 };

hetab_verdict audit_worst(const audit_report *report, size_t counts[3]) {
  hetab_verdict worst = HETAB_PASS;
  memset(counts, 0, 3 * sizeof *counts);
  for (size_t i = report->repaired ? 1 : 0; i < report->count; i++) {
    hetab_verdict verdict = hetab_audit_verdict(report->results[i].audit);
    counts[verdict]++;
    worst = verdict > worst ? verdict : worst;
  }
  return worst;
}

int audit_exit_status(const audit_report *report) {
  size_t counts[3];
  return audit_worst(report, counts) == HETAB_FAIL ? CLI_CHECK_FAILED : 0;
}

static void print_head(const audit_result *result) {
  const hetab_audit *a = result->audit;
  printf("%s: %s", result->input, hetab_audit_kind_name(a->kind));
  if (a->kind != HETAB_AUDIT_SURFACE)
    printf(", lookup %s", hetab_reading_name(a->lookup));
  if (a->channel_count)
    printf(", %zu %s, %zu incidences", a->channel_count, a->lambda_um ? "wavelengths" : "channels",
           a->theta_count);
  printf(": %s\n", hetab_verdict_name(hetab_audit_verdict(a)));
}

void audit_print(const audit_result *result) {
  print_head(result);
  for (size_t i = 0; i < result->audit->check_count; i++) {
    const hetab_check *c = &result->audit->checks[i];
    int column = printf("  %-4s %-12s %10.4g", hetab_verdict_name(c->verdict), c->name, c->value);
    cli_print_wrapped(c->detail, DETAIL_COLUMN, column);
  }
  fflush(stdout);
}

void audit_print_repair(const audit_report *report) {
  const hetab_repair_report *r = &report->repair;
  printf("%s: repaired: of %zu entries %zu replaced, %zu negative ones set to 0, %zu made\n"
         "  reciprocal, changed by at most %.3g / sr and %.3g %%; ",
         report->repaired, r->entries, r->replaced, r->clamped, r->symmetrised, r->max_change_abs,
         100 * r->max_change_rel);
  if (r->scaled_incidences)
    printf("energy brought down at %zu incidences, by a\n  factor of %.6g at most\n",
           r->scaled_incidences, r->smallest_scale);
  else
    puts("energy as it was");
}

void audit_print_summary(const audit_report *report) {
  size_t counts[3];
  hetab_verdict worst = audit_worst(report, counts);
  if (report->count > 1)
    printf("%zu %s: %zu pass, %zu warn, %zu fail: %s\n", report->count - (report->repaired ? 1 : 0),
           report->repaired ? "repaired" : "inputs", counts[HETAB_PASS], counts[HETAB_WARN],
           counts[HETAB_FAIL], hetab_verdict_name(worst));
}
