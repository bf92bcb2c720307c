/* The two kinds of tables; hetab_audit_table tells them apart. */
#ifndef HETAB_AUDIT_TABLE_AUDIT_H
#define HETAB_AUDIT_TABLE_AUDIT_H

#include "audit/audit_internal.h"

hetab_status hetab_audit_merl(hetab_context *ctx, hetab_engine *engine, const char *path,
                              const hetab_audit_options *options, hetab_audit *audit);
hetab_status hetab_audit_h5(hetab_context *ctx, hetab_engine *engine, const char *path,
                            const hetab_audit_options *options, hetab_audit *audit);

/* What was opened, or why not: damage (HETAB_ERR_PARSE) becomes a failed check "structure" and
 * HETAB_OK, with audit->channel_count left 0. */
hetab_status hetab_audit_structure(hetab_context *ctx, hetab_status opened, hetab_audit *audit);

/* Judges audit->against, whose errors are in; specular is that of the model, of every channel. */
void hetab_audit_judge_against(const hetab_audit_options *options, const double *specular,
                               hetab_audit *audit);

#endif
