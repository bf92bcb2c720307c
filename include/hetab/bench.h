/* Speed against error of every method, measured in one run on one device. */
#ifndef HETAB_BENCH_H
#define HETAB_BENCH_H

#include <hetab/surface.h>
#include <hetab/tabulate.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hetab_bench_row {
  const char *method;        /* "literal", "series", "rows", "store" */
  const char *precision;     /* "float", "double" */
  double tolerance;          /* rows only, else 0 */
  double entries_per_second; /* kernel time, median of the repeats */
  double ratio_to_literal, ratio_to_store;
  hetab_error_stats error; /* against the literal reference; all 0 for literal and store */
} hetab_bench_row;

typedef struct hetab_bench_options {
  const char *devices; /* as in hetab_engine_options */
  size_t samples;      /* entries compared per row; 0: 20000 */
  unsigned repeats;    /* timed runs of each kernel, the median counts; 0: 5 */
} hetab_bench_options;

typedef void (*hetab_bench_fn)(void *user, const char *surface, const hetab_bench_row *row);

/* Every method on the surface over the default grid; calls fn once per row as it is measured. */
hetab_status hetab_bench(hetab_context *ctx, const hetab_surface *surface,
                         const hetab_bench_options *options, hetab_bench_fn fn, void *user);

#ifdef __cplusplus
}
#endif
#endif
