/* Speed against error of every method, measured in one run on one device. */
#pragma once

#include <stddef.h>
#include <hetab/surface.h>
#include <hetab/tabulate.h>

HETAB_BEGIN

typedef struct hetab_bench_row {
  const char *method;        /* "literal", "peak", "store", "rows", "series", "delivered" */
  const char *precision;     /* "float", "double" */
  double tolerance;          /* rows only, else 0 */
  double entries_per_second; /* kernel time, median of the repeats; delivered: the whole call's */
  double ratio_to_literal, ratio_to_store;
  double operations_per_entry; /* rows: vector operations of one entry, counted in the source */
  double ratio_to_peak;        /* those per second, over the device's measured multiply-add rate */
  hetab_error_stats error;     /* against the literal reference; all 0 for the baselines */
} hetab_bench_row;

typedef struct hetab_bench_options {
  size_t size;         /* of the struct; 0: of this header's */
  const char *devices; /* as in hetab_engine_options */
  size_t samples;      /* entries compared per row; 0: 20000 */
  unsigned repeats;    /* timed runs of each kernel, the median counts; 0: 5 to 64, for 0.6 s */
} hetab_bench_options;

typedef void (*hetab_bench_fn)(void *user, const char *surface, const hetab_bench_row *row);

/* First the baselines: the literal loop; per precision the device's multiply-add rate ("peak",
 * in operations, not entries) and the store-only kernel. Then every method on the surface over the
 * default grid, and the rows of a finer one as hetab_tabulate delivers them to a sink that does
 * nothing; calls fn once per row as it is measured. */
hetab_status hetab_bench(hetab_context *ctx, const hetab_surface *surface,
                         const hetab_bench_options *options, hetab_bench_fn fn, void *user);

HETAB_END
