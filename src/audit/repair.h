/* The steps of a repair that tables of both kinds share. */
#pragma once

#include "audit/audit_internal.h"

/* Finite and >= 0 along a row of phi: what is no number becomes the mean of the nearest good
 * neighbours, negative values 0. */
void hetab_repair_row(double *row, size_t count, hetab_repair_report *report);
/* Two entries that should be equal take their mean. */
void hetab_repair_pair(double *a, double *b, hetab_repair_report *report);
/* The factor that brings `found` down to `allowed`; 1 if it is not above. */
double hetab_repair_scale(double found, double allowed, hetab_repair_report *report);

hetab_status hetab_repair_merl(hetab_context *ctx, const char *path, const char *out_path,
                               hetab_reading lookup, int scale_energy, int overwrite,
                               hetab_repair_report *report);
hetab_status hetab_repair_h5(hetab_context *ctx, const char *path, const char *out_path,
                             hetab_reading lookup, int scale_energy, int overwrite,
                             hetab_repair_report *report);
