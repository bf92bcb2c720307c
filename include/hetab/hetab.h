/* hetab: tables of the He-Torrance reflectance model. Includes the whole public interface.
 *
 * Rules that hold in every header:
 * - create makes a handle from values, load reads a file whole, open finds by name or keeps a file
 *   open, free ends the handle (NULL is fine); what counts something ends in _count.
 * - Angles are radians from the normal; degrees are the axes of grids alone (a file's), in names
 *   that end in _deg.
 * - Lengths are um, values BRDFs in 1/sr without a cosine.
 * - Options: NULL, and 0 in a member, stand for the default. The first member is the struct's size,
 *   sizeof options: a library that knows more members then takes them for 0, and one that knows
 *   fewer refuses what it does not know. 0 there is the size that this header has. Where a function
 * writes a file, `overwrite` is in its options, or its last argument if it has none.
 * - Threads: a context, and a handle that a function may change, serve one thread at a time;
 *   handles passed as const may be shared. Headers that promise more say so. */
#pragma once
#include <hetab/status.h>
#include <hetab/types.h>
#include <hetab/output_file.h>
#include <hetab/devices.h>
#include <hetab/host_model.h>
#include <hetab/index.h>
#include <hetab/surface.h>
#include <hetab/grid.h>
#include <hetab/engine.h>
#include <hetab/evaluate.h>
#include <hetab/merl.h>
#include <hetab/rgl.h>
#include <hetab/tabulate.h>
#include <hetab/tabulate_to.h>
#include <hetab/plan.h>
#include <hetab/batch.h>
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
#include <hetab/shader.h>
#include <hetab/stand_in.h>
#include <hetab/convert.h>
#include <hetab/lookup.h>
