/* Lobes and hemisphere maps, for pictures. */
#pragma once

#include "audit/audit_internal.h"

/* The BRDF (1/sr) of one channel as the audited thing gives it; radians, phi in [0, 2 pi). */
typedef double (*hetab_audit_view_fn)(const void *user, double theta_i, double theta_r, double phi);

/* audit->views from a lookup. */
hetab_status hetab_views_of_table(hetab_context *ctx, hetab_audit *audit,
                                  hetab_audit_view_fn lookup, const void *user);
/* audit->views of the surface at band audit->view_channel. */
hetab_status hetab_views_of_surface(hetab_context *ctx, hetab_engine *engine,
                                    const hetab_surface *surface, hetab_audit *audit);
/* What the model gives for the lobes of a table: views[].model, from one or several bands, each
 * with a weight. */
hetab_status hetab_views_of_model(hetab_context *ctx, hetab_engine *engine, double sigma0_um,
                                  double tau_um, const hetab_band *bands, const double *weights,
                                  size_t count, hetab_audit *audit);
