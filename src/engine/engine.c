#include "engine/engine_internal.h"

#include <stdio.h>
#include <stdlib.h>

#include "cl/device.h"

#include "core/option_size.h"
#include "engine/borrowed.h"

/* What the rows method can keep at best and keeps by default: float arithmetic rounds the exponent
 * to up to 8e-6, double and its polynomials give out at about 1e-11. */
static const double FLOAT_LEAST = 1e-5, FLOAT_USUAL = 1e-5;
static const double DOUBLE_LEAST = 1e-11, DOUBLE_USUAL = 1e-9;

hetab_precision hetab_engine_precision(const hetab_engine *engine) {
  return engine->precision;
}

hetab_method hetab_engine_method(const hetab_engine *engine) {
  return engine->method;
}

double hetab_engine_tolerance(const hetab_engine *engine) {
  return engine->tolerance;
}

const char *hetab_engine_device(const hetab_engine *engine) {
  return engine->device_text;
}

/* All lanes in words. */
static void describe(hetab_engine *engine) {
  size_t length = 0;
  for (int i = 0; i < engine->lane_count; i++) {
    int written = snprintf(engine->device_text + length, sizeof engine->device_text - length,
                           "%s%s", i ? "; " : "", engine->lanes[i].text);
    if (written < 0 || (length += (size_t)written) >= sizeof engine->device_text)
      return;
  }
}

hetab_report hetab_report_of(const hetab_engine *engine, const char *device) {
  hetab_report report = {
      .method = engine->method, .precision = engine->precision, .tolerance = engine->tolerance};
  snprintf(report.device, sizeof report.device, "%s", device);
  return report;
}

static hetab_status open_lanes(hetab_context *ctx, const char *selector, hetab_engine *engine) {
  cl_device_id *devices;
  size_t count;
  hetab_status status = HETAB_OK;
  HETAB_TRY(hetab_cl_select(ctx, selector, &devices, &count));
  for (size_t i = 0; i < count && i < HETAB_MOST_LANES && status == HETAB_OK; i++)
    status =
        hetab_lane_open(ctx, devices[i], engine->precision, &engine->lanes[engine->lane_count++]);
  free(devices);
  describe(engine);
  return status;
}

hetab_status hetab_check_tolerance(hetab_context *ctx, double tolerance) {
  if (tolerance >= 0.0 && tolerance < 1.0)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "tolerance %g: give a relative error between 0 and 1, for example 1e-5",
                    tolerance);
}

static hetab_status check_rows_tolerance(hetab_context *ctx, const hetab_engine_options *o) {
  double least = o->precision == HETAB_DOUBLE ? DOUBLE_LEAST : FLOAT_LEAST;
  HETAB_TRY(hetab_check_tolerance(ctx, o->tolerance));
  if (o->method != HETAB_METHOD_ROWS || o->tolerance == 0.0 || o->tolerance >= least)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                    "tolerance %g is below %g, what rows in %s can keep; use %s", o->tolerance,
                    least, hetab_precision_name(o->precision),
                    o->precision == HETAB_DOUBLE ? "the series method" : "double precision");
}

hetab_status hetab_engine_create(hetab_context *ctx, const hetab_engine_options *options,
                                 hetab_engine **out) {
  *out = NULL;
  HETAB_OPTIONS(ctx, hetab_engine_options, o, options);
  HETAB_TRY(check_rows_tolerance(ctx, &o));
  hetab_engine *engine = hetab_alloc(ctx, 1, sizeof *engine);
  HETAB_NEED(engine);
  engine->precision = o.method == HETAB_METHOD_LITERAL ? HETAB_DOUBLE : o.precision;
  engine->method = o.method;
  double usual = engine->precision == HETAB_DOUBLE ? DOUBLE_USUAL : FLOAT_USUAL;
  engine->tolerance = o.tolerance > 0.0 ? o.tolerance : usual;
  hetab_status status = HETAB_OK;
  if (o.method == HETAB_METHOD_LITERAL)
    snprintf(engine->device_text, sizeof engine->device_text, "host, 1 core");
  else
    status = open_lanes(ctx, o.devices, engine);
  *out = engine;
  HETAB_MADE(hetab_engine, out, status);
}

void hetab_engine_free(hetab_engine *engine) {
  if (!engine)
    return;
  for (int i = 0; i < engine->lane_count; i++)
    hetab_lane_close(&engine->lanes[i]);
  free(engine);
}

hetab_status hetab_engine_borrow_series(hetab_context *ctx, const hetab_engine *engine,
                                        hetab_engine **out) {
  *out = hetab_alloc(ctx, 1, sizeof **out);
  HETAB_NEED(*out);
  **out = *engine;
  if (engine->method == HETAB_METHOD_ROWS)
    (*out)->method = HETAB_METHOD_SERIES;
  return HETAB_OK;
}

void hetab_engine_return(hetab_engine *borrowed) {
  free(borrowed);
}

double hetab_slab_value(const hetab_engine *engine, const void *values, size_t i) {
  return hetab_real_at(engine, values, i);
}
