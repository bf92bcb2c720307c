/* Sentences about the assumptions of the model that a surface does not keep. */
#pragma once

#include <hetab/roughness.h>
#include "core/context.h"

/* Fills notes, note_count and curvature_um. */
hetab_status hetab_roughness_notes(hetab_context *ctx, hetab_roughness *roughness,
                                   const hetab_heights *const *heights, size_t inputs,
                                   double wavelength_um);
