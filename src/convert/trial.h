/* What a conversion added, at random directions. */
#pragma once

#include "convert/convert_source.h"

/* Fills the report's errors: the file at `path` against the source. Incidences are even over 0 to
 * 80 degrees; viewers are drawn half by the source's lobe and half by the cosine, and weighed. */
hetab_status hetab_convert_trial(hetab_context *ctx, hetab_convert_source *source, const char *path,
                                 size_t pairs, unsigned seed, hetab_convert_report *report);
