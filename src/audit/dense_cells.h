/* The entries of a dense table, one by one. */
#pragma once

#include "audit/audit_internal.h"
#include "audit/dense_table.h"

enum { HETAB_DENSE_WHERE = 128 };

/* What has been found in the wavelengths so far. */
typedef struct hetab_dense_survey {
  double reciprocity[2], isotropy[2]; /* sums */
  char finite[HETAB_DENSE_WHERE], negative[HETAB_DENSE_WHERE];
  char non_reciprocal[HETAB_DENSE_WHERE], anisotropic[HETAB_DENSE_WHERE];
} hetab_dense_survey;

/* Take in the wavelength whose values the table holds. */
void hetab_dense_survey_add(const hetab_dense_table *table, size_t wavelength, hetab_audit *audit,
                            hetab_dense_survey *survey);
/* Adds the checks "finite", "negative", "reciprocity", "isotropy" and "bilateral". */
void hetab_dense_survey_judge(const hetab_dense_table *table, double max_asymmetry,
                              hetab_audit *audit, hetab_dense_survey *survey);
