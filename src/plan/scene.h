/* A scene, as its file has it. */
#ifndef HETAB_PLAN_SCENE_H
#define HETAB_PLAN_SCENE_H

#include <hetab/plan.h>

struct hetab_scene {
  hetab_surface **surfaces;
  size_t count, room;
  hetab_consumer consumer;
  double table_error, energy_error, max_theta_i; /* radians */
  double memory_bytes;                           /* 0: no budget */
};

#endif
