/* Refractive indices n + ik (k >= 0: absorbing) as functions of the vacuum wavelength. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

/* Threads: once made, it does not change and may be shared. */
typedef struct hetab_index hetab_index;

/* The same n and k at every wavelength. n > 0, k >= 0, finite. */
hetab_status hetab_index_constant(hetab_context *ctx, double n, double k, hetab_index **out);

/* A built-in metal, by symbol ("Al", "stainless"); over the
 * range of its source, about 0.2 to 2 um or more, linear between its rows. */
hetab_status hetab_index_metal(hetab_context *ctx, const char *symbol, hetab_index **out);

/* A file: refractiveindex.info YAML (.yml, .yaml: tabulated nk / n / k, formulas 1-9), or CSV of
 * wavelength, n, k whose header names the wavelength's unit (wavelength_nm or wavelength_um).
 * Tables are linear between their nodes. Failures name the file and the line. */
hetab_status hetab_index_load(hetab_context *ctx, const char *path, hetab_index **out);

void hetab_index_free(hetab_index *index);

/* n and k at lambda_um. Outside the data's range: HETAB_ERR_RANGE with a message that names the
 * range, unless extrapolate != 0 (then tables hold their end value, formulas are evaluated). */
hetab_status hetab_index_at(hetab_context *ctx, const hetab_index *index, double lambda_um,
                            int extrapolate, double *n, double *k);

/* The range that the data covers, um; 0 and infinity for a constant. */
void hetab_index_range(const hetab_index *index, double *min_um, double *max_um);

/* Where the values come from: a citation, a file name, or "constant". Owned by index. */
const char *hetab_index_source(const hetab_index *index);

/* The built-in metals; i < hetab_metal_count(). */
size_t hetab_metal_count(void);
const char *hetab_metal_symbol(size_t i);
const char *hetab_metal_name(size_t i);
const char *hetab_metal_citation(size_t i);

HETAB_END
