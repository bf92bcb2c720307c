/* The model that a table is compared with, in the table's channels. */
#pragma once

#include "audit/audit_internal.h"

typedef struct hetab_model {
  double sigma0_um, tau_um;
  size_t band_count, channel_count;
  hetab_band *bands;
  double *weights; /* [channel][band] */
} hetab_model;

/* For an HDF5 table: a band a channel, of `against` (interpolated to the table's wavelengths), or
 * the file's own parameters where that is NULL. */
hetab_status hetab_model_of_bands(hetab_context *ctx, const hetab_surface *against,
                                  double sigma0_um, double tau_um, const hetab_band *bands,
                                  size_t count, hetab_model *model);
/* For a MERL table: the channels that the options describe. */
hetab_status hetab_model_of_colour(hetab_context *ctx, const hetab_audit_options *options,
                                   hetab_model *model);
void hetab_model_clear(hetab_model *model);

/* The surface of some of the bands; hetab_surface_free() it. */
hetab_status hetab_model_surface(hetab_context *ctx, const hetab_model *model, size_t first,
                                 size_t count, hetab_surface **out);

/* Fills in what the model says of every energy: fresnel, and dd + ud as `model`; and
 * specular[channel], the white-sky reflectance of the specular part. */
hetab_status hetab_model_energy(hetab_context *ctx, hetab_engine *engine, const hetab_model *model,
                                hetab_audit *audit, double *specular);
