/* hetab: tables of the He-Torrance reflectance model. Includes the whole public interface. */
#ifndef HETAB_H
#define HETAB_H
#include <hetab/status.h>
#include <hetab/index.h>
#include <hetab/surface.h>
#include <hetab/grid.h>
#include <hetab/engine.h>
#include <hetab/evaluate.h>
#include <hetab/merl.h>
#include <hetab/rgl.h>
#include <hetab/tabulate.h>
#include <hetab/table.h>
#include <hetab/exr.h>
#include <hetab/reflectance.h>
#include <hetab/view.h>
#include <hetab/audit.h>
#include <hetab/roughness.h>
#include <hetab/measurements.h>
#include <hetab/fit.h>
#include <hetab/predict.h>
#include <hetab/bench.h>
#include <hetab/sampler.h>
#include <hetab/convert.h>
#include <hetab/lookup.h>
#endif
