/* What the parts of an audit share. */
#pragma once

#include <hetab/audit.h>
#include <hetab/reflectance.h>

#include "core/angle.h"
#include "core/context.h"

enum { HETAB_AUDIT_INCIDENCES = 90 }; /* 0, 1 ... 89 degrees */

/* Options with the defaults filled in. */
hetab_status hetab_audit_options_take(hetab_context *ctx, const hetab_audit_options *options,
                                      hetab_audit_options *out);

/* An empty audit of that many channels and incidences; lambda_um and theta_i zeroed. */
hetab_status hetab_audit_new(hetab_context *ctx, hetab_audit_kind kind, const char *name,
                             hetab_audit **out);
hetab_status hetab_audit_size(hetab_context *ctx, hetab_audit *audit, size_t channels,
                              size_t incidences);
/* 0, 1 ... 89 degrees. */
void hetab_audit_whole_degrees(hetab_audit *audit);

hetab_energy *hetab_audit_energy(const hetab_audit *audit, size_t channel, size_t theta);

/* Add a check. The detail is formatted. */
hetab_check *hetab_audit_add(hetab_audit *audit, const char *name, hetab_verdict verdict,
                             double value, double threshold, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

/* "550 nm", or "red". */
const char *hetab_audit_channel(const hetab_audit *audit, size_t channel, char text[24]);

/* The checks that surfaces and tables have in common, from audit->energy. */
void hetab_check_energy(hetab_audit *audit, double max_excess);
void hetab_check_fresnel(hetab_audit *audit, double max_excess);

/* a and b should be equal. */
void hetab_symmetry_add(hetab_symmetry *s, double sums[2], double a, double b, int *is_worst);
/* Means from sums. */
void hetab_symmetry_finish(hetab_symmetry *s, const double sums[2]);

/* The progress of what is called on the way does not show: between the two there is no callback. */
typedef struct hetab_hush {
  hetab_progress_fn fn;
} hetab_hush;
hetab_hush hetab_hush_begin(hetab_context *ctx);
void hetab_hush_end(hetab_context *ctx, hetab_hush hush);
