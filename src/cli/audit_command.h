/* The audit command's results, shared by what finds them and what reports them. */
#pragma once

#include <stdio.h>
#include <jansson.h>
#include <hetab/hetab.h>

typedef struct audit_result {
  const char *input;
  hetab_audit *audit;
} audit_result;

typedef struct audit_report {
  audit_result *results;
  size_t count;
  const char *repaired; /* the file written; NULL: none */
  hetab_repair_report repair;
} audit_report;

/* The verdict of all, how many inputs have each, and the exit status that goes with it. A repaired
 * table stands for the one that it was made from. */
hetab_verdict audit_worst(const audit_report *report, size_t counts[3]);
int audit_exit_status(const audit_report *report);

/* A line per check, as they come. */
void audit_print(const audit_result *result);
void audit_print_repair(const audit_report *report);
void audit_print_summary(const audit_report *report);

/* Its keys are those that `hetab audit --help` documents. */
json_t *audit_json(const audit_report *report);

/* One self-contained page. */
void audit_html(FILE *stream, const audit_report *report);
