/* The engine's inside: one lane per device, with kernels built when first used. */
#pragma once

#include <stdint.h>

#include <hetab/engine.h>
#include <hetab/tabulate.h>

#include "engine/lane.h"

enum { HETAB_MOST_LANES = 16 };

struct hetab_engine {
  hetab_precision precision;
  hetab_method method;
  double tolerance;
  int lane_count; /* 0 for the literal method */
  hetab_lane lanes[HETAB_MOST_LANES];
  char device_text[512];
};

static inline double hetab_real_at(const hetab_engine *engine, const void *reals, size_t i) {
  return engine->precision == HETAB_DOUBLE ? ((const double *)reals)[i]
                                           : (double)((const float *)reals)[i];
}

/* A report that says how its table is made; everything else 0. */
hetab_report hetab_report_of(const hetab_engine *engine, const char *device);

/* A relative error that can be asked for; 0 stands for the default. */
hetab_status hetab_check_tolerance(hetab_context *ctx, double tolerance);
