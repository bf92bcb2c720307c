/* The roughness command's result, shared by what finds it and what reports it. */
#pragma once

#include <stdio.h>
#include <jansson.h>
#include <hetab/hetab.h>

/* The quantities of a scan, in the order of the tables. */
enum { ROUGHNESS_FIELDS = 6 };
typedef struct roughness_field {
  const char *name;  /* "sigma_um" */
  const char *title; /* "sigma, um" */
  double plain;      /* what a Gaussian surface has; NaN: anything */
} roughness_field;
extern const roughness_field roughness_fields[ROUGHNESS_FIELDS];
hetab_estimate roughness_estimate(const hetab_scan_statistics *s, int field);
hetab_average roughness_average(const hetab_component *c, int field);

void roughness_print(const hetab_roughness *r);
void roughness_csv(FILE *stream, const hetab_roughness *r);
/* Its keys are those that `hetab roughness --help` documents. */
json_t *roughness_json(const hetab_roughness *r);
/* One self-contained page. */
void roughness_html(FILE *stream, const hetab_roughness *r);
/* A surface for `hetab tabulate`; `index` is what comes after "index: ". */
void roughness_yaml(FILE *stream, const hetab_roughness *r, const char *name, const char *index);

/* Tables of published rows. */
void roughness_print_published(const hetab_published *p);
json_t *roughness_published_json(const hetab_published *p);
/* Whether all that the table states follows from its rows. */
int roughness_published_agrees(const hetab_published *p);
