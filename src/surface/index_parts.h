/* What a refractive index is made of, for what makes one. */
#pragma once

#include <hetab/index.h>
#include "core/context.h"

/* n or k as a function of the wavelength: a table, linear between its nodes, or a formula. */
typedef struct hetab_curve {
  int formula;           /* 1-9, or 0 for a table */
  size_t count;          /* nodes or coefficients; 0: zero at every wavelength */
  double *lambda_um;     /* [count] ascending; NULL for a formula */
  double *values;        /* [count] values at the nodes, or the coefficients */
  double min_um, max_um; /* where the data holds */
} hetab_curve;

typedef enum hetab_index_origin {
  HETAB_INDEX_CONSTANT,
  HETAB_INDEX_METAL,
  HETAB_INDEX_FILE
} hetab_index_origin;

struct hetab_index {
  hetab_index_origin origin;
  const char *symbol; /* of a metal; else NULL */
  char *source;       /* citation, absolute path of the file, or "constant" */
  hetab_curve n, k;
};

/* An index without data yet, k being zero. */
hetab_status hetab_index_new(hetab_context *ctx, hetab_index_origin origin, const char *source,
                             hetab_index **out);
/* The same index again, without reading its file. */
hetab_status hetab_index_copy(hetab_context *ctx, const hetab_index *index, hetab_index **out);

/* Room for `count` nodes; the range is set by hetab_curve_set_range once they are filled in. */
hetab_status hetab_curve_alloc(hetab_context *ctx, hetab_curve *curve, size_t count);
void hetab_curve_set_range(hetab_curve *curve);

/* The readers behind hetab_index_load: fill in n and k. */
hetab_status hetab_index_read_yaml(hetab_context *ctx, const char *path, hetab_index *index);
hetab_status hetab_index_read_csv(hetab_context *ctx, const char *path, hetab_index *index);
