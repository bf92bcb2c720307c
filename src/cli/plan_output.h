/* A plan as text and as JSON. */
#pragma once

#include <hetab/plan.h>

/* The exit status. */
int plan_print(const hetab_scene *scene, const hetab_plan *plan);
int plan_print_json(const hetab_scene *scene, const hetab_plan *plan);
