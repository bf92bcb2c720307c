/* What main.xml of an X3P file says. */
#pragma once

#include <stdbool.h>
#include "core/context.h"

typedef struct x3p_axis {
  bool absolute;            /* in the data; else place = offset + index * increment */
  char type;                /* I, L, F, D: int16, int32, float, double */
  double increment, offset; /* metres; of integers: metres per count */
  bool has_increment;
} x3p_axis;

typedef struct x3p_description {
  char feature[8]; /* PRF, SUR, PCL */
  x3p_axis axis[3];
  double size[3]; /* MatrixDimension; 0: not there */
  double list_size;
  char points[256], points_md5[64], valid[256], valid_md5[64]; /* "" : not there */
  double *datum; /* [datum_count][absolute axes], of a DataList; NaN: missing */
  size_t datum_count;
} x3p_description;

/* `path` is for messages. free() description->datum. */
hetab_status hetab_x3p_parse(hetab_context *ctx, const char *path, const char *xml, size_t length,
                             x3p_description *description);
