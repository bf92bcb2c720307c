/* The kinds of tables; hetab_audit_table tells them apart. */
#pragma once

#include "audit/audit_internal.h"
#include "audit/pairs.h"

hetab_status hetab_audit_merl(hetab_context *ctx, hetab_engine *engine, const char *path,
                              const hetab_audit_options *options, hetab_audit *audit);
hetab_status hetab_audit_h5(hetab_context *ctx, hetab_engine *engine, const char *path,
                            const hetab_audit_options *options, hetab_audit *audit);
/* By <hetab/lookup.h>: RGL tables. */
hetab_status hetab_audit_lookup(hetab_context *ctx, hetab_engine *engine, const char *path,
                                const hetab_audit_options *options, hetab_audit *audit);

/* What was opened, or why not: damage (HETAB_ERR_PARSE) becomes a failed check "structure" and
 * HETAB_OK, with audit->channel_count left 0. */
hetab_status hetab_audit_structure(hetab_context *ctx, hetab_status opened, hetab_audit *audit);

/* Judges audit->against, whose errors are in; specular is that of the model, of every channel. */
void hetab_audit_judge_against(const hetab_audit_options *options, const double *specular,
                               hetab_audit *audit);

/* Compares a table, whose energy is in, with options->against, and fills in the views, from what
 * `table` reads: wavelengths one by one, three channels together. Its progress goes on from `work`
 * to twice that. */
hetab_status hetab_audit_compare(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_audit_options *options, hetab_pair_fn table,
                                 const void *user, double work, hetab_audit *audit);
