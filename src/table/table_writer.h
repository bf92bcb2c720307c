/* What all writers of dense tables do alike: rows that are counted, and a file that appears whole
 * or not at all. A format is a class of five functions over a structure that begins with this. */
#pragma once

#include <stdbool.h>
#include <hetab/table.h>

#include "core/atomic_file.h"
#include "core/context.h"

typedef struct hetab_table_class {
  hetab_status (*slab)(hetab_context *ctx, hetab_table_writer *writer, const hetab_slab *slab);
  hetab_status (*specular)(hetab_context *ctx, hetab_table_writer *writer, const double *rho_s);
  hetab_status (*report)(hetab_context *ctx, hetab_table_writer *writer,
                         const hetab_report *report);
  hetab_status (*finish)(hetab_context *ctx, hetab_table_writer *writer); /* all in the file */
  void (*clear)(hetab_table_writer *writer); /* at any time; what is not in the file is lost */
} hetab_table_class;

struct hetab_table_writer {
  const hetab_table_class *class;
  hetab_atomic_file *file;
  size_t channels, count[HETAB_AXIS_COUNT];
  unsigned char *written; /* [channel][theta_i]: rows that are in the file */
  size_t rows_left;
  bool specular_written;
  size_t saturated; /* numbers too large for the file, stored as its largest */
};

/* Fills in a zeroed writer; hetab_table_abort() takes what is left of it after a failure. */
hetab_status hetab_table_begin(hetab_context *ctx, hetab_table_writer *writer,
                               const hetab_table_class *class, const char *path, int overwrite,
                               size_t channels, const hetab_grid *grid);
