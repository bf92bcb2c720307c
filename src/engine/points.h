/* The model at many pairs of directions, on the engine's first device. */
#pragma once

#include <hetab/engine.h>
#include <hetab/types.h>

/* The kernel, kept between calls; one thread at a time. */
typedef struct hetab_places hetab_places;

/* HETAB_ERR_UNSUPPORTED for the literal method, which has no device. */
hetab_status hetab_places_create(hetab_context *ctx, const hetab_engine *engine,
                                 hetab_places **out);
void hetab_places_free(hetab_places *places);

/* dd + ud, 1/sr, by the series: values[count][band_count]. With weights[band_count][3] the bands'
 * weighted sums, formed on the device: values[count][3]. Error as of hetab_evaluate. */
hetab_status hetab_places_evaluate(hetab_context *ctx, hetab_places *places, double sigma0_um,
                                   double tau_um, const hetab_band *bands, size_t band_count,
                                   const double (*weights)[3], const hetab_directions *at,
                                   size_t count, double *values);
