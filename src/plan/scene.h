/* A scene, as its file has it. */
#pragma once

#include <stdbool.h>

#include <hetab/exr.h>
#include <hetab/plan.h>
#include <hetab/rgl.h>

struct hetab_scene {
  hetab_surface **surfaces;
  size_t count, room;
  hetab_consumer consumer;
  double table_error, energy_error, max_theta_i; /* radians */
  double max_theta_r;                            /* radians */
  double specular_cone;                          /* radians; 0: the delta is not folded */
  double memory_bytes;                           /* 0: no budget */
  char *output;                                  /* NULL: none */
};

/* The grid of HDF5 and OpenEXR tables: incidences or views up to `most`, and azimuths. */
size_t hetab_scene_thetas(double most, double spacing_deg);
size_t hetab_scene_phis(double spacing_deg);
double hetab_scene_entries(const hetab_scene *scene, double spacing_deg);

/* RGL tables: all but MERL, HDF5 and OpenEXR. Those of spectra among them. */
static inline bool hetab_wants_rgl(const hetab_scene *scene) {
  return scene->consumer <= HETAB_PBRT || scene->consumer == HETAB_CONSUMER_LOOKUP;
}
static inline hetab_rgl_bands hetab_wanted_bands(const hetab_scene *scene) {
  return scene->consumer == HETAB_MITSUBA_SPECTRAL || scene->consumer == HETAB_PBRT
             ? HETAB_RGL_SPECTRAL
             : HETAB_RGL_RGB;
}
/* OpenEXR: half floats, whose steps are 0.05 %, unless the error is of that size. */
static inline hetab_exr_element hetab_wanted_element(double table_error) {
  return table_error >= 0.005 ? HETAB_EXR_HALF : HETAB_EXR_FLOAT;
}
/* Whether the consumer has conductors of its own. */
static inline bool hetab_has_materials(const hetab_scene *scene) {
  return scene->consumer <= HETAB_PBRT;
}
